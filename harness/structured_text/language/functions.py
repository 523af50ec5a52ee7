"""Calls of the user's functions and of standard functions.

A standard function is overloaded: `MAX` takes any ordered type. Its signature marks the pins that
share one type with `T`. Resolution takes three steps. First, the types of all arguments at such
pins are joined to a common type; an untyped literal has no type yet. Second, the common type must
be in the group that the signature permits. If all arguments are untyped, the context or the kind of
literal decides. Third, every argument is checked against that type, which converts it if it widens.
"""

from __future__ import annotations

from dataclasses import replace

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.calls import function_arguments, standard_arguments
from structured_text.language.checking import Checking
from structured_text.language.function_overloads import chosen_function
from structured_text.language.methods import NOTHING
from structured_text.language.references import PLACES
from structured_text.language.registry import ConsequenceError
from structured_text.language.resolve import fills
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    ANY_STRING,
    BOOL,
    ELEMENTARY,
    LONGEST_STRING,
    SIGNED,
    STRING_MAX,
    WIDTH,
    string_length,
)
from structured_text.language.sizes import block_size, size_of
from structured_text.language.standard import (
    BLOCKS,
    FUNCTIONS,
    MOMENT_OPERATORS,
    Signature,
    bcd,
    conversion,
    convertible,
    overload,
    rare,
    reserved,
    truncation,
)
from structured_text.language.types import (
    ArrayType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    Type,
    type_name,
)
from structured_text.language.values import describe
from structured_text.language.widening import BITS_OF, joined, number_of, same_number, widens

__all__ = ["Functions", "same_text"]

#: Standard functions that do the same as an operator, including the functions of durations.
_OPERATORS = {
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "EXPT": "**",
    "AND": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "GT": ">",
    "GE": ">=",
    "EQ": "=",
    "LE": "<=",
    "LT": "<",
    "NE": "<>",
    "ADD_TIME": "+",
    "SUB_TIME": "-",
    "MULTIME": "*",
    "DIVTIME": "/",
}
_SHIFTS = ("SHL", "SHR", "ROL", "ROR")
_SELECTIONS = ("SEL", "MUX", "MOVE")
_JOINING = ("CONCAT", "INSERT", "REPLACE")
#: Shortest result of the functions in `_JOINING` [characters], for dialects in which a plain STRING
#: has another length than in matiec.
_JOINED = 255
#: In CODESYS and TwinCAT these functions return the time since the start of the PLC.
_CLOCKS = ("TIME", "LTIME")
#: Functions that depend on the declaration of their argument, not on its value.
_SIZES = ("SIZEOF", "XSIZEOF")
_OF_VARIABLES = (*_SIZES, "LOWER_BOUND", "UPPER_BOUND")


class Functions:
    """Checks the function calls in the expressions of one POU, for `expression_checker`."""

    def __init__(self, expressions: Checking) -> None:
        self._expressions = expressions
        self._scope = expressions.scope

    # --- types ---

    def result(self, node: s.Call) -> Type | None:
        """Return the type of a call's result; None if the context determines the type."""
        key = chosen_function(node.function, node.arguments, self._expressions).key
        declared = self._scope.declarations.pous.get(key)
        if declared is not None:
            return None if declared.result is None else declared.result.type
        target = self._target(key)
        if target or key in _CLOCKS:
            return ELEMENTARY[target or key]
        if key in MOMENT_OPERATORS:
            return ELEMENTARY[MOMENT_OPERATORS[key][3]]
        signature = FUNCTIONS.get(key)
        if signature is None or signature.result == "ANY_INT":
            return None
        if signature.result != "T":
            return ELEMENTARY[signature.result]
        return self._result_type(key, self._common_type(node, signature))

    def _target(self, key: str) -> str:
        """Return the target type of a conversion; empty for other functions."""
        pair = conversion(key) or truncation(key)
        if pair is not None:
            return pair[1]
        found = bcd(key)
        return found[2] if found is not None else overload(key)

    def _common_type(self, node: s.Call, signature: Signature) -> Type | None:
        """Return the type that all arguments of type T get; None if all are untyped."""
        found: Type | None = None
        real = False
        for argument, (_, kind) in standard_arguments(node, signature, self._scope):
            if kind == "T":
                one = self._expressions.infer(argument.value)
                if isinstance(one, EnumType) and node.function.key not in _SELECTIONS:
                    one = ELEMENTARY[one.base]
                real = real or (one is None and self._expressions.is_real(argument.value))
                if one is not None:
                    found = one if found is None else self._expressions.operators.common(found, one)
        if real and type_name(found) in (*ANY_INT, *ANY_BIT):
            found = ELEMENTARY["LREAL"]
        number = number_of(type_name(found))
        if type_name(found) not in signature.group and number in signature.group:
            return ELEMENTARY[number]
        if type_name(found) in ANY_INT and signature.group == ANY_REAL:
            return ELEMENTARY["REAL" if WIDTH[type_name(found)] <= 16 else "LREAL"]
        if type_name(found) in ("CHAR", "WCHAR") and signature.group == ANY_STRING:
            return ELEMENTARY["STRING" if type_name(found) == "CHAR" else "WSTRING"]
        return found

    def _result_type(self, key: str, common: Type | None) -> Type | None:
        if isinstance(common, ElementaryType) and common.name in ANY_STRING:
            plain = self._scope.registry.dialect.text
            if key in _JOINING and plain != STRING_MAX:
                longest = max(_JOINED, plain, string_length(common))
                return ElementaryType(common.name, min(longest, LONGEST_STRING))
            return joined([common], longer=key in _JOINING)
        return common

    # --- calls ---

    def call(self, node: s.Call, want: Type | None) -> t.Expression:
        """Check and type a call of a function, or raise InputError."""
        chosen = chosen_function(node.function, node.arguments, self._expressions)
        if chosen is not node.function:
            node = replace(node, function=chosen)
        key, name, at = node.function.key, node.function.text, node.at
        pou = self._scope.declarations.pous.get(key)
        if pou is not None and pou.kind == "FUNCTION":
            if pou.result is not None:
                return self.user(node, pou)
            if key in self._scope.declarations.broken:
                raise ConsequenceError(f"{name} has an error")
            raise self._scope.error(f"{name} has no result", at, "call it as a statement")
        if pou is not None or key in BLOCKS:
            raise self._scope.error(
                f"{name} is a block, not a function", at, "declare an instance and call that"
            )
        known = self._target(key) or key in FUNCTIONS or key in MOMENT_OPERATORS
        if (known or key in _OF_VARIABLES) and not reserved(key):
            construct = "a standard function of dates or BCD"
            if not rare(key):
                construct = "a standard function beyond the second edition"
            self._scope.note(construct, at, key)
        if self._target(key):
            return self._converted(node, want)
        if key in _CLOCKS:
            return self._now(node)
        if key in MOMENT_OPERATORS:
            return self._moment(node, *MOMENT_OPERATORS[key])
        if key in _OF_VARIABLES:
            return self._of_variable(node, want)
        if key not in FUNCTIONS:
            symbol = self._scope.symbol(key)
            if symbol is not None:
                raise self._scope.error(f"{name} is a {describe(symbol.type)}, not a function", at)
            here = self._scope.block
            if here is not None and self._scope.registry.incomplete(here.name.upper()):
                raise ConsequenceError(f"the base of {here.name} is missing")
            raise self._scope.error(
                f"there is no function {name}", at, "name its file, too, or check the spelling"
            )
        if key in _OPERATORS and len(node.arguments) <= 2:
            pairs = standard_arguments(node, FUNCTIONS[key], self._scope)
            left, right = (argument.value for argument, _ in pairs)
            if key in ("ADD_TIME", "SUB_TIME", "MULTIME", "DIVTIME"):
                self._expressions.check(left, ELEMENTARY["TIME"])
            return self._expressions.operators.binary(_OPERATORS[key], left, right, want, at)
        return self._standard(node, FUNCTIONS[key], want)

    def _now(self, node: s.Call) -> t.Standard:
        """Check and type `TIME()`, the time since the start of the PLC."""
        key = node.function.key
        if node.arguments:
            raise self._scope.error(f"{key} takes 0 arguments, not {len(node.arguments)}", node.at)
        self._scope.note("the time as a function", node.at)
        self._scope.pou.clock = True
        return t.Standard("NOW", (), ELEMENTARY[key])

    def user(self, node: s.Call, pou: t.Pou) -> t.CallFunction:
        """Check and type a call of a function of the sources.

        Raises:
            InputError: The arguments do not fit.
        """
        given, sent = function_arguments(node, pou, self._scope)
        self._scope.pou.calls.add(pou.name.upper())
        arguments = tuple(
            self._expressions.check(given[symbol.name.upper()].value, symbol.type)
            if symbol.name.upper() in given
            else None
            for symbol in pou.section("VAR_INPUT")
        )
        in_outs = tuple(
            (symbol.name, self._passed(given[symbol.name.upper()], symbol, pou.name))
            for symbol in pou.section("VAR_IN_OUT")
        )
        outputs = tuple(
            (name, self._passed(argument, pou.symbols[name.upper()], pou.name))
            for name, argument in sent.items()
        )
        kind = NOTHING if pou.result is None else pou.result.type
        return t.CallFunction(pou.name.upper(), arguments, kind, in_outs, outputs)

    def _passed(self, argument: s.Argument, pin: t.Symbol, pou: str) -> t.Variable:
        """Return the variable that is passed to an output or VAR_IN_OUT, or raise InputError."""
        value, kind = argument.value, pin.type
        if not isinstance(value, PLACES):
            raise self._scope.error(f"{pou} needs a variable here", argument.at)
        all_ = self._expressions
        # CODESYS also accepts an input of open length as the argument for a VAR_IN_OUT, because
        # such an input is never copied.
        read = pin.constant or (_is_open(kind) and _is_open(all_.variable(value).type))
        found = all_.variable(value) if read else all_.writable(value)
        if pin.section == "VAR_OUTPUT" and same_number(kind, found.type):
            self._scope.note("an enumeration as a number", argument.at)
            return found
        if pin.section == "VAR_OUTPUT" and widens(kind, found.type):
            self._scope.note("an implicit conversion", argument.at, f"the output {pin.name}")
            return found
        below = self._scope.declarations.derives(found.type, kind)
        if below and pin.section == "VAR_IN_OUT":
            self._scope.note("a structure as its base", argument.at)
            return found
        if self._same_elements(found.type, kind):
            return found
        if found.type != kind and not same_text(found.type, kind) and not fills(found.type, kind):
            raise self._scope.error(
                f"{pou} needs a {describe(kind)} here, not a {describe(found.type)}", argument.at
            )
        return found

    def _same_elements(self, one: Type, other: Type) -> bool:
        """Return whether TIA Portal can copy one array to the other; only the bounds may differ."""
        return (
            self._scope.registry.dialect.name == "tia"
            and isinstance(one, ArrayType)
            and isinstance(other, ArrayType)
            and one.element == other.element
            and [high - low for low, high in one.bounds]
            == [high - low for low, high in other.bounds]
        )

    def _converted(self, node: s.Call, want: Type | None) -> t.Expression:
        """Check and type a conversion.

        The function may name the source type (`INT_TO_REAL`) or take any (`TO_REAL`). `TRUNC_*`
        cuts off the decimals of a real. Conversions from and to BCD are included.
        """
        key = node.function.key
        code, cut, pair = bcd(key), truncation(key), conversion(key)
        if code is not None:
            source, target = code[1:]
        else:
            source, target = pair or cut or ("", overload(key))
        signature = Signature((("IN", source or "T"),), (), target)
        ((argument, _),) = standard_arguments(node, signature, self._scope)
        wanted: Type | None = ELEMENTARY[source] if source else None
        if wanted is None:
            wanted = self._expressions.infer(argument.value)
            if cut is not None and type_name(wanted) not in ANY_REAL:
                wanted = ELEMENTARY["LREAL"]
            elif isinstance(wanted, EnumType):
                if target in ANY_STRING and "to_string" in wanted.attributes:
                    member = self._expressions.check(argument.value, wanted)
                    return t.Standard("MEMBER_TO_STRING", (member,), ELEMENTARY[target])
                wanted = ELEMENTARY[wanted.base]
        value = self._expressions.check(argument.value, wanted)
        result = ELEMENTARY[target]
        have = value.type
        if isinstance(have, ReferenceType) and not isinstance(wanted, EnumType):
            self._scope.note("a pointer as a number", node.at, key)
            value = t.Standard("ADDRESS", (value,), ELEMENTARY["UDINT"])
            have = value.type
        if not isinstance(have, ElementaryType):
            raise self._scope.error(f"{key} is not defined for {describe(have)}", argument.at)
        if cut is not None:
            return t.Standard("TRUNC", (value,), result)
        if code is not None:
            allowed = ANY_BIT[1:] if code[0] == "FROM_BCD" else ANY_INT
            if have.name not in allowed:
                raise self._scope.error(f"{key} is not defined for {describe(have)}", argument.at)
            return t.Standard(code[0], (value,), result)
        if have.name == target:
            return value
        if not convertible(have.name, target):
            raise self._scope.error(f"{key} is not defined for {describe(have)}", argument.at)
        return t.Standard(f"{have.name}_TO_{target}", (value,), result)

    def _moment(self, node: s.Call, op: str, left: str, right: str, result: str) -> t.Expression:
        """Check and type a function for an operation on dates or durations, as `ADD_TOD_TIME`."""
        signature = Signature((("IN1", left), ("IN2", right)), (), result)
        (one, _), (other, _) = standard_arguments(node, signature, self._scope)
        first = self._expressions.check(one.value, ELEMENTARY[left])
        kind = self._number_type(other, ANY_NUM) if right == "ANY_NUM" else ELEMENTARY[right]
        second = self._expressions.check(other.value, kind)
        if op == "/" and isinstance(second, t.Constant) and second.value == 0:
            raise self._scope.error("division by zero", node.at)
        return t.Binary(op, first, second, ELEMENTARY[result])

    def _of_variable(self, node: s.Call, want: Type | None) -> t.Expression:
        """Check and type SIZEOF, XSIZEOF, LOWER_BOUND and UPPER_BOUND.

        The results are constants, because all types are complete. Only the bounds of an ARRAY [*]
        are read at run time.
        """
        key, count = node.function.key, len(node.arguments)
        number = 1 if key in _SIZES else 2
        if count != number:
            raise self._scope.error(f"{key} takes {number} arguments, not {count}", node.at)
        first = node.arguments[0].value
        kind: Type | None = None
        if isinstance(first, s.Name) and self._scope.symbol(first.key) is None:
            declarations = self._scope.declarations
            kind = declarations.types.get(first.key) or ELEMENTARY.get(first.key)
            kind = kind or declarations.blocks.get(first.key)
        if isinstance(first, s.TypeName):
            kind, _ = self._scope.declarations.resolve(first.spec, self._scope.where)
            self._scope.declarations.link()
        if kind is None:
            if not isinstance(first, PLACES):
                raise self._scope.error(f"{key} needs a variable", first.at)
            kind = self._expressions.variable(first).type
        if key in _SIZES:
            size = size_of(kind)
            if size is None:
                self._scope.note("the size of a block", first.at)
                size = block_size(kind)
            if size is None:
                raise self._scope.error(
                    f"{key} is not supported for a {describe(kind)}",
                    first.at,
                    "write the size as a number: the tools differ",
                )
            value, default = size, "UDINT"
        else:
            if not isinstance(kind, ArrayType):
                raise self._scope.error(f"a {describe(kind)} has no bounds", first.at)
            dimension = self._expressions.check(node.arguments[1].value, ELEMENTARY["DINT"])
            most = len(kind.bounds)
            if (
                kind.open
                and isinstance(dimension, t.Constant)
                and 1 <= int(dimension.value) <= most
            ):
                array = self._expressions.variable(first)  # type: ignore[arg-type]
                bound = t.Standard(key, (array, dimension), ELEMENTARY["DINT"])
                wanted = want if type_name(want) in ANY_INT else None
                return self._expressions.converted(bound, wanted or bound.type)  # type: ignore[arg-type]
            if not isinstance(dimension, t.Constant) or not 1 <= int(dimension.value) <= most:
                raise self._scope.error(
                    f"the dimension must be a number from 1 to {most}", node.arguments[1].at
                )
            ends = kind.bounds[int(dimension.value) - 1]
            value, default = ends[key == "UPPER_BOUND"], "DINT"
        result = want if type_name(want) in ANY_INT and want is not None else ELEMENTARY[default]
        return t.Constant(value, result)

    def _standard(self, node: s.Call, signature: Signature, want: Type | None) -> t.Expression:
        name = node.function.key
        pairs = standard_arguments(node, signature, self._scope)
        common = self._common_type(node, signature)
        if common is None and any(kind == "T" for _, (_, kind) in pairs):
            common = self._untyped(pairs, signature, want)
        if type_name(common) in BITS_OF and name in (*_SHIFTS, "AND", "OR", "XOR"):
            return self._bitwise(node, pairs, common)
        whole = isinstance(common, (EnumType, ReferenceType, InterfaceType))
        selects = whole and name in _SELECTIONS
        if selects and not isinstance(common, EnumType):
            self._scope.note("a selection of pointers or interfaces", node.at, name)
        if common is not None and not selects and type_name(common) not in signature.group:
            raise self._scope.error(f"{name} is not defined for {describe(common)}", node.at)
        arguments = []
        for argument, (_, kind) in pairs:
            expected: Type | None
            if kind == "T":
                expected = common
            elif kind in ("ANY_INT", "ANY_NUM"):
                expected = self._number_type(argument, ANY_INT if kind == "ANY_INT" else ANY_NUM)
            else:
                expected = ELEMENTARY[kind]
            arguments.append(self._expressions.check(argument.value, expected))
        return t.Standard(name, tuple(arguments), self._result(node, signature, common, want))

    def _untyped(
        self,
        pairs: list[tuple[s.Argument, tuple[str, str]]],
        signature: Signature,
        want: Type | None,
    ) -> Type:
        """Return the type of untyped numbers: the required type, if the function permits it."""
        wanted = want if type_name(want) in signature.group else None
        if wanted is not None and signature.result == "T":
            return wanted
        values = [argument.value for argument, (_, kind) in pairs if kind == "T"]
        real = next((one for one in values if self._expressions.is_real(one)), values[0])
        found = self._expressions.check(real, None).type
        return ELEMENTARY["LREAL"] if signature.group == ANY_REAL else found

    def _bitwise(
        self, node: s.Call, pairs: list[tuple[s.Argument, tuple[str, str]]], common: Type | None
    ) -> t.Expression:
        """Check and type a shift or bitwise function of integers.

        The integers are converted to bit strings of their width, and the result is converted back.
        """
        name = node.function.key
        assert isinstance(common, ElementaryType)
        detail = f"{name} of a {common.name}"
        self._scope.note("a bitwise operation of integers", node.at, detail)
        bits = ELEMENTARY[BITS_OF[common.name]]
        if name == "SHR" and common.name in SIGNED:
            # SHR of a signed integer must fill with the sign. A conversion to LWORD extends the
            # sign.
            if common.name == "LINT":
                raise self._scope.error("SHR is not defined for LINT", node.at, "use LWORD")
            bits = ELEMENTARY["LWORD"]
        arguments: list[t.Expression] = []
        for argument, (_, kind) in pairs:
            if kind == "T":
                value = self._expressions.check(argument.value, common)
                arguments.append(self._expressions.converted(value, bits))
            else:
                expected = self._number_type(argument, ANY_INT)
                arguments.append(self._expressions.check(argument.value, expected))
        return self._expressions.converted(t.Standard(name, tuple(arguments), bits), common)

    def _number_type(self, argument: s.Argument, allowed: tuple[str, ...]) -> Type:
        found = self._expressions.infer(argument.value)
        if found is None:
            return self._expressions.check(argument.value, None).type
        if isinstance(found, EnumType):
            found = ELEMENTARY[found.base]
        if type_name(found) in ANY_BIT and type_name(found) != "BOOL":
            return ELEMENTARY[number_of(type_name(found))]
        if not isinstance(found, ElementaryType) or found.name not in allowed:
            raise self._scope.error(
                f"a number is expected here, not a {describe(found)}", argument.at
            )
        return found

    def _result(
        self, node: s.Call, signature: Signature, common: Type | None, want: Type | None
    ) -> Type:
        if signature.result == "T":
            return self._result_type(node.function.key, common) or BOOL
        if signature.result != "ANY_INT":
            return ELEMENTARY[signature.result]
        if isinstance(want, ElementaryType) and want.name in ANY_INT:
            return want
        return ELEMENTARY["INT"]


def _is_open(kind: Type) -> bool:
    """Return whether a type is an array of open length."""
    return isinstance(kind, ArrayType) and kind.open


def same_text(one: Type, other: Type) -> bool:
    """Return whether two types are both STRING, or both WSTRING, of any length."""
    return type_name(one) == type_name(other) and type_name(one) in ANY_STRING
