"""Expressions in the Structured Text of Logix, which cannot call user functions.

Logix computes whole numbers in DINT. If Logix does not allow an operation inside an expression,
statements before it (`before`) compute the result in a temporary tag. No expression of the library
has a side effect. Therefore an earlier computation, or the evaluation of both sides of AND and OR,
does not change a result.
"""

from __future__ import annotations

import re
from collections.abc import Mapping

from structured_text.export.l5x.model import (
    RESULT,
    Images,
    NotCarriedError,
    companion,
    data_of,
    image_element,
    is_whole,
    value_text,
)
from structured_text.language import tree as t
from structured_text.language.scalars import SIGNED, WIDTH
from structured_text.language.standard import conversion
from structured_text.language.types import ArrayType, BlockType, EnumType, Type
from structured_text.projects.rockwell.expression_reader import bare

__all__ = ["ExpressionWriter", "fold", "wrapped"]

_SAME = ("ABS", "SQRT", "LN", "LOG", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "TRUNC")
_CHAINS = {"ADD": "+", "MUL": "*", "AND": "AND", "OR": "OR", "XOR": "XOR"}
_SIMPLE = re.compile(r"(?:16#[0-9A-F]+|[\w.\[\]']+(?:\(\*\w+\*\))?)")
_LETTERS = {"BOOL": "B", "DINT": "D", "REAL": "R", "STRING": "S"}


class ExpressionWriter:
    """The expressions of one POU.

    Attributes:
        before: Statements that must precede the current statement; `take` returns and removes them.
        temporaries: Names of the temporary tags with their types.
        instances: The called functions, each with the tag of its instruction.
    """

    def __init__(self, functions: Mapping[str, t.Pou], images: Images) -> None:
        self._images = images
        self._functions = functions
        self._used: dict[str, int] = {}
        self._bound: dict[t.Symbol, str] = {}
        self.before: list[str] = []
        self.temporaries: dict[str, str] = {}
        self.instances: dict[str, str] = {}

    def begin(self) -> None:
        """Begin a new statement; it can use all temporary tags again."""
        self._used.clear()

    def take(self) -> list[str]:
        """Return the statements that must precede the current statement, and clear the list."""
        found, self.before = self.before, []
        return found

    def text(self, node: t.Expression) -> str:
        """Return the code of an expression; for a STRING, the name of a tag or a literal."""
        if isinstance(node, t.Constant):
            return value_text(node.value, node.type)
        if isinstance(node, t.Use | t.Member | t.Index):
            return self._read(node)
        if isinstance(node, t.Unary):
            return self._unary(node)
        if isinstance(node, t.Binary):
            return self._binary(node)
        if isinstance(node, t.CallFunction):
            return self._call(node)
        assert isinstance(node, t.Standard)
        return self._standard(node)

    def variable(self, node: t.Variable) -> str:
        """Return the code of a variable, to assign it or to pass it to an instruction."""
        if isinstance(node, t.Use):
            if node.symbol in self._bound:
                return self._bound[node.symbol]
            return RESULT if node.symbol.section == "RESULT" else node.symbol.name
        if isinstance(node, t.Index):
            return f"{self.variable(node.base)}[{self.text(node.indices[0])}]"
        assert isinstance(node, t.Member)
        base = self.variable(node.base)
        if isinstance(node.base.type, BlockType) and is_whole(node.type):
            return companion(base, node.name)
        return f"{base}.{node.name}"

    def tag(self, node: t.Expression) -> str:
        """Return a tag that contains the value of a STRING expression, to pass or copy it."""
        text = self.text(node)
        return self._kept("STRING", text) if isinstance(node, t.Constant) else text

    def kept(self, node: t.Expression) -> str:
        """Return an operand that the code may use twice.

        A complex expression gets a temporary tag.
        """
        text = self.text(node)
        return (
            text
            if _SIMPLE.fullmatch(text)
            else self._kept(data_of(node.type, self._images).type, text)
        )

    def _kept(self, data: str, text: str) -> str:
        name = self.temporary(data)
        self.before.append(f"{name} := {text};")
        return name

    def temporary(self, data: str) -> str:
        """Reserve a temporary tag until the end of the statement, and return its name."""
        self._used[data] = self._used.get(data, 0) + 1
        name = f"Temp_{_LETTERS[data]}{self._used[data]}"
        self.temporaries[name] = data
        return name

    def _operand(self, node: t.Expression) -> str:
        return wrapped(self.text(node))

    def _read(self, node: t.Variable) -> str:
        text = self.variable(node)
        raw = self._raw(node)
        return f"({text} AND 16#{'FF' if raw == 'SINT' else 'FFFF'})" if raw else text

    def _raw(self, node: t.Variable) -> str:
        """Return SINT or INT if the variable is an element of a process image, else ""."""
        if isinstance(node, t.Index) and isinstance(node.base.type, ArrayType):
            return image_element(node.base.type.name, self._images)
        return ""

    def _unary(self, node: t.Unary) -> str:
        if node.op == "-":
            return f"-{self._operand(node.operand)}"
        text = f"NOT {self._operand(node.operand)}"
        return _masked(text, node.type)

    def _binary(self, node: t.Binary) -> str:
        left, right = node.left, node.right
        kind = getattr(left.type, "name", "")
        if node.op in ("=", "<>") and kind == "BOOL":
            text = f"{self._operand(left)} XOR {self._operand(right)}"
            return f"NOT ({text})" if node.op == "=" else text
        if kind == "STRING":
            return f"{self.tag(left)} {node.op} {self.tag(right)}"
        if node.op in ("<", ">", "<=", ">=") and kind == "DWORD":
            raise NotCarriedError("a DWORD cannot be compared by size")
        chained = node.op in ("AND", "OR") and isinstance(left, t.Binary) and left.op == node.op
        first = self.text(left) if chained else self._operand(left)
        text = f"{first} {node.op} {self._operand(right)}"
        if node.op in ("+", "-"):
            return _masked(text, node.type)
        name = getattr(node.type, "name", "")
        if node.op == "*" and name in ("USINT", "UINT", "UDINT"):
            raise NotCarriedError(f"a product of {name} cannot be translated")
        if node.op in ("*", "/") and name == "TIME":
            raise NotCarriedError("a TIME cannot be multiplied or divided")
        return text

    def _call(self, node: t.CallFunction) -> str:
        pou = self._functions[node.function.upper()]
        pins = pou.section("VAR_INPUT")
        inlined = _inlined(pou)
        if inlined is not None:
            given = [self.kept(_given(*one)) for one in zip(pins, node.arguments, strict=True)]
            self._bound.update(zip(pins, given, strict=True))
            text = wrapped(self.text(inlined))
            for pin in pins:
                del self._bound[pin]
            return text
        instance = f"{pou.name}_1"
        self.instances[pou.name] = instance
        tags = []
        setting = []
        for pin, argument in zip(pins, node.arguments, strict=True):
            value = _given(pin, argument)
            if is_whole(pin.type):
                tags.append(self.tag(value))
            else:
                setting.append(f"{instance}.{pin.name} := {self.text(value)};")
        result = self.temporary(data_of(node.type, self._images).type)
        if is_whole(node.type):
            tags.append(result)
        self.before += [*setting, f"{pou.name}({', '.join([instance, *tags])});"]
        if not is_whole(node.type):
            self.before.append(f"{result} := {instance}.{RESULT};")
        return result

    def _standard(self, node: t.Standard) -> str:
        name, arguments = node.name, node.arguments
        if name in _CHAINS:
            chain: t.Expression = arguments[0]
            for one in arguments[1:]:
                chain = t.Binary(_CHAINS[name], chain, one, node.type)
            return self.text(chain)
        if name in ("SHL", "SHR"):
            return self._shift(name, *arguments, kind=node.type)
        if name == "LEN":
            return f"{self.tag(arguments[0])}.LEN"
        if name in ("MID", "LEFT", "CONCAT", "FIND"):
            return self._strings(name, arguments)
        if name in _SAME:
            return f"{name}({self.text(arguments[0])})"
        types = conversion(name)
        if types is None:
            raise NotCarriedError(f"the function {name} has no counterpart here")
        return self._converted(arguments[0], *types)

    def _converted(self, node: t.Expression, source: str, target: str) -> str:
        known = {*WIDTH, "BOOL", "REAL"} - {"LINT", "ULINT", "LWORD"}
        if not {source, target} <= known or (source, target) == ("DINT", "UDINT"):
            raise NotCarriedError(f"the function {source}_TO_{target} has no counterpart here")
        if source == "BOOL":
            name = self.temporary("REAL" if target == "REAL" else "DINT")
            self.before += [
                f"{name} := 0;",
                f"IF {self.text(node)} THEN",
                f"  {name} := 1;",
                "END_IF;",
            ]
            return name
        if target == "BOOL":
            return f"({self._operand(node)} <> 0)"
        if target == "REAL":
            return self._kept("REAL", self.kept(node))
        if source == "REAL":
            return self._kept("DINT", self.text(node))
        bits, signed = WIDTH[target], target in SIGNED
        fits = WIDTH[source] < bits or (WIDTH[source] == bits and signed == (source in SIGNED))
        if bits == 32 or (fits and (signed or source not in SIGNED)):
            return self.text(node)
        if signed:
            return fold(self.kept(node), bits)
        mask = (1 << bits) - 1
        if _is_below(node, mask):
            return self.text(node)
        return f"({self._operand(node)} AND 16#{mask:X})"

    def _shift(self, name: str, value: t.Expression, by: t.Expression, *, kind: Type) -> str:
        bits = WIDTH[getattr(kind, "name", "")]
        if not isinstance(by, t.Constant):
            return self._shifted(name, value, by, bits)
        count = int(by.value)
        if not 0 <= count < bits:
            raise NotCarriedError(f"{bits} bits cannot be shifted by {count}")
        if count == 0:
            return self.text(value)
        factor = 1 << count
        if bits < 32 and name == "SHL":
            return f"(({self._operand(value)} * {factor}) AND 16#{(1 << bits) - 1:X})"
        if bits < 32:
            return f"({self._operand(value)} / {factor})"
        kept = self.kept(value)
        if name == "SHL":
            return f"({fold(kept, bits - count)} * {factor})"
        return f"((({kept} AND 16#7FFFFFFF) / {factor}) - (({kept} AND 16#80000000) / {factor}))"

    def _shifted(self, name: str, value: t.Expression, by: t.Expression, bits: int) -> str:
        """Return a shift by a number known only at run time; a loop shifts by one bit at a time."""
        if bits == 32:
            raise NotCarriedError("a DWORD cannot be shifted by a variable")
        kept, left = self.temporary("DINT"), self.temporary("DINT")
        step = f"({kept} * 2) AND 16#{(1 << bits) - 1:X}" if name == "SHL" else f"{kept} / 2"
        self.before += [
            f"{kept} := {self.text(value)};",
            f"{left} := {self.text(by)};",
            f"WHILE ({left} > 0) AND ({kept} <> 0) DO",
            f"  {kept} := {step};",
            f"  {left} := {left} - 1;",
            "END_WHILE;",
        ]
        return kept

    def _strings(self, name: str, arguments: tuple[t.Expression, ...]) -> str:
        first = self.tag(arguments[0])
        if name in ("CONCAT", "FIND"):
            if len(arguments) != 2:
                raise NotCarriedError(f"{name} cannot take more than two texts")
            second = self.tag(arguments[1])
            if name == "CONCAT":
                result = self.temporary("STRING")
                self.before.append(f"CONCAT({first}, {second}, {result});")
                return result
            found = self.temporary("DINT")
            both = zip(arguments, (first, second), strict=True)
            inside = [f"({tag}.LEN > 0)" for one, tag in both if not _is_positive(one)]
            call = f"FIND({first}, {second}, 1, {found});"
            self._guarded(inside, call, f"{found} := 0;")
            return found
        length = self.kept(arguments[1])
        place = self.kept(arguments[2]) if name == "MID" else "1"
        result = self.temporary("STRING")
        operands = zip(arguments[1:], (length, place), strict=False)
        inside = [f"({text} > 0)" for one, text in operands if not _is_positive(one)]
        inside.append(f"({place} <= {first}.LEN)")
        self._guarded(inside, f"MID({first}, {length}, {place}, {result});", f"{result} := '';")
        return result

    def _guarded(self, conditions: list[str], call: str, otherwise: str) -> None:
        """Add an instruction that runs only under conditions.

        Logix refuses some arguments that the standard allows; for these, `otherwise` sets the
        result.
        """
        if not conditions:
            self.before.append(call)
            return
        condition = " AND ".join(conditions)
        self.before += [f"IF {condition} THEN", f"  {call}", "ELSE", f"  {otherwise}", "END_IF;"]


def wrapped(text: str) -> str:
    """Return an operand, in parentheses if it needs them."""
    enclosed = bare(text) != text and not text.startswith("(*")
    return text if _SIMPLE.fullmatch(text) or enclosed else f"({text})"


def fold(text: str, bits: int) -> str:
    """Return code that reads the lowest bits of a number as a signed number.

    The code contains `text`, the code of the number, twice.
    """
    low, sign = (1 << bits - 1) - 1, 1 << bits - 1
    return f"(({text} AND 16#{low:X}) - ({text} AND 16#{sign:X}))"


def _masked(text: str, kind: Type) -> str:
    masks = {"BYTE": "FF", "USINT": "FF", "WORD": "FFFF", "UINT": "FFFF", "UDINT": "7FFFFFFF"}
    mask = None if isinstance(kind, EnumType) else masks.get(getattr(kind, "name", ""))
    return f"(({text}) AND 16#{mask})" if mask else text


def _is_positive(node: t.Expression) -> bool:
    """Return whether a constant is a number above 0 or a text that is not empty."""
    value = node.value if isinstance(node, t.Constant) else 0
    return bool(value) if isinstance(value, str) else value > 0


def _is_below(node: t.Expression, mask: int) -> bool:
    """Return whether all bits of an expression are within a mask."""
    if not isinstance(node, t.Binary) or node.op != "AND" or not isinstance(node.right, t.Constant):
        return False
    return int(node.right.value) & ~mask == 0


def _given(pin: t.Symbol, argument: t.Expression | None) -> t.Expression:
    return t.Constant(pin.initial, pin.type) if argument is None else argument


def _inlined(pou: t.Pou) -> t.Expression | None:
    """Return the expression of a function that consists of one assignment, else None."""
    if len(pou.body) != 1 or any(is_whole(one.type) for one in pou.symbols.values()):
        return None
    (only,) = pou.body
    return only.value if isinstance(only, t.Assign) else None
