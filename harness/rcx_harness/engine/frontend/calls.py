"""Checks calls of functions, user-defined and standard."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.scalars import ANY_INT, ANY_NUM, BOOL, ELEMENTARY
from rcx_harness.engine.frontend.standard import BLOCKS, FUNCTIONS, Signature, conversion
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import ElementaryType, EnumType, Type

if TYPE_CHECKING:
    from rcx_harness.engine.frontend.expressions import Expressions

__all__ = ["Calls"]

#: Standard functions that are operators, and the time functions written as such.
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


class Calls:
    """The function calls of one POU; shares its expressions."""

    def __init__(self, expressions: Expressions) -> None:
        self._expressions = expressions
        self._scope = expressions.scope

    def infer(self, node: s.Call) -> Type | None:
        """Type of the result; None where it is what the context asks for."""
        key = node.function.key
        declared = self._scope.declarations.pous.get(key)
        if declared is not None and declared.result is not None:
            return declared.result.type
        pair = conversion(key)
        if pair is not None:
            return ELEMENTARY[pair[1]]
        signature = FUNCTIONS.get(key)
        if signature is None or signature.result == "ANY_INT":
            return None
        if signature.result != "T":
            return ELEMENTARY[signature.result]
        return self._common_type(node, signature)

    def _common_type(self, node: s.Call, signature: Signature) -> Type | None:
        for argument, (_, kind) in self._pins(node, signature):
            found = self._expressions.infer(argument.value) if kind == "T" else None
            if found is not None:
                return found
        return None

    def check(self, node: s.Call, want: Type | None) -> t.Expression:
        """Type a call.

        Raises:
            InputError: no such function, or arguments that do not fit.
        """
        key, name, at = node.function.key, node.function.text, node.at
        pou = self._scope.declarations.pous.get(key)
        if pou is not None and pou.kind == "FUNCTION" and pou.result is not None:
            return self._user(node, pou)
        if pou is not None or key in BLOCKS:
            raise self._scope.error(
                f"{name} is a block, not a function", at, "declare an instance and call that"
            )
        if conversion(key) is not None:
            return self._conversion(node)
        if key not in FUNCTIONS:
            symbol = self._scope.symbol(key)
            if symbol is not None:
                raise self._scope.error(f"{name} is a {describe(symbol.type)}, not a function", at)
            raise self._scope.error(
                f"there is no function {name}", at, "name its file too, or look at the spelling"
            )
        if key in _OPERATORS and len(node.arguments) <= 2:
            pairs = self._pins(node, FUNCTIONS[key])
            left, right = (argument.value for argument, _ in pairs)
            if key in ("ADD_TIME", "SUB_TIME", "MULTIME", "DIVTIME"):
                self._expressions.check(left, ELEMENTARY["TIME"])
            return self._expressions.binary(_OPERATORS[key], left, right, want, at)
        return self._standard(node, FUNCTIONS[key], want)

    def _user(self, node: s.Call, pou: t.Pou) -> t.Expression:
        inputs = pou.section("VAR_INPUT")
        given: dict[str, s.Argument] = {}
        named = [argument for argument in node.arguments if argument.name is not None]
        if named and len(named) != len(node.arguments):
            raise self._scope.error("named and positional arguments are mixed", node.at)
        if not named and len(node.arguments) != len(inputs):
            raise self._scope.error(
                f"{pou.name} takes {len(inputs)} arguments, not {len(node.arguments)}", node.at
            )
        for position, argument in enumerate(node.arguments):
            key = argument.name.key if argument.name else inputs[position].name.upper()
            if key not in (symbol.name.upper() for symbol in inputs) or argument.output:
                raise self._scope.error(
                    f"{pou.name} has no input {key}",
                    argument.at,
                    f"it has {', '.join(symbol.name for symbol in inputs)}",
                )
            if key in given:
                raise self._scope.error(f"{_symbol_name(argument)} is given twice", argument.at)
            given[key] = argument
        for symbol in inputs:
            scalar = isinstance(symbol.type, (ElementaryType, EnumType))
            if not scalar and symbol.name.upper() not in given:
                message = f"the input {symbol.name} of {pou.name} is missing"
                raise self._scope.error(message, node.at)
        arguments = tuple(
            self._expressions.check(given[symbol.name.upper()].value, symbol.type)
            if symbol.name.upper() in given
            else None
            for symbol in inputs
        )
        assert pou.result is not None
        return t.CallFunction(pou.name.upper(), arguments, pou.result.type)

    def _conversion(self, node: s.Call) -> t.Expression:
        pair = conversion(node.function.key)
        assert pair is not None
        signature = Signature((("IN", pair[0]),), (), pair[1])
        ((argument, _),) = self._pins(node, signature)
        value = self._expressions.check(argument.value, ELEMENTARY[pair[0]])
        return t.Standard(f"{pair[0]}_TO_{pair[1]}", (value,), ELEMENTARY[pair[1]])

    def _pins(self, node: s.Call, signature: Signature) -> list[tuple[s.Argument, tuple[str, str]]]:
        """The arguments in the order of the pins, each with its (name, type)."""
        pins = list(signature.pins)
        if signature.extensible:
            name, kind = pins[-1]
            first = int(name[2:])
            extra = len(node.arguments) - len(pins)
            pins += [(f"IN{first + 1 + more}", kind) for more in range(extra)]
        if len(node.arguments) != len(pins):
            least = "at least " if signature.extensible else ""
            raise self._scope.error(
                f"{node.function.text} takes {least}{len(pins)} arguments,"
                f" not {len(node.arguments)}",
                node.at,
            )
        named = [argument for argument in node.arguments if argument.name is not None]
        if not named:
            return list(zip(node.arguments, pins, strict=True))
        given = {argument.name.key: argument for argument in named if argument.name}
        if len(given) != len(pins) or set(given) != {name for name, _ in pins}:
            raise self._scope.error(
                f"{node.function.text} needs {', '.join(name for name, _ in pins)}", node.at
            )
        return [(given[name], (name, kind)) for name, kind in pins]

    def _standard(self, node: s.Call, signature: Signature, want: Type | None) -> t.Expression:
        name = node.function.key
        pairs = self._pins(node, signature)
        common = self._common_type(node, signature)
        if common is None and any(kind == "T" for _, (_, kind) in pairs):
            wanted = (
                want if isinstance(want, ElementaryType) and want.name in signature.group else None
            )
            first = next(argument.value for argument, (_, kind) in pairs if kind == "T")
            common = (wanted if signature.result == "T" else None) or self._expressions.check(
                first, None
            ).type
        if common is not None and (
            not isinstance(common, ElementaryType) or common.name not in signature.group
        ):
            raise self._scope.error(f"{name} is not defined for {describe(common)}", node.at)
        arguments = []
        for argument, (_, kind) in pairs:
            expected: Type | None
            if kind == "T":
                expected = common
            elif kind in ("ANY_INT", "ANY_NUM"):
                expected = self._number(argument, ANY_INT if kind == "ANY_INT" else ANY_NUM)
            else:
                expected = ELEMENTARY[kind]
            arguments.append(self._expressions.check(argument.value, expected))
        return t.Standard(name, tuple(arguments), self._result(signature, common, want))

    def _number(self, argument: s.Argument, allowed: tuple[str, ...]) -> Type:
        found = self._expressions.infer(argument.value)
        if found is None:
            return self._expressions.check(argument.value, None).type
        if not isinstance(found, ElementaryType) or found.name not in allowed:
            raise self._scope.error(
                f"a number is expected here, not a {describe(found)}", argument.at
            )
        return found

    def _result(self, signature: Signature, common: Type | None, want: Type | None) -> Type:
        if signature.result == "T":
            return common or BOOL
        if signature.result != "ANY_INT":
            return ELEMENTARY[signature.result]
        if isinstance(want, ElementaryType) and want.name in ANY_INT:
            return want
        return ELEMENTARY["INT"]


def _symbol_name(argument: s.Argument) -> str:
    """The name an argument is given by, for messages."""
    return argument.name.text if argument.name is not None else "the argument"
