"""Structured Text of Logix as Structured Text of IEC 61131-3: the statements of a routine."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from ctypes import c_float
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.export.l5x.model import Data
from structured_text.export.words import words
from structured_text.language import syntax as s
from structured_text.language.parser import parse_text
from structured_text.language.scalars import number

__all__ = ["Scope", "iec_statements", "iec_type", "single"]

_STORED = {"SINT": "BYTE", "INT": "WORD", "FBD_TIMER": "RCX_TONR"}
_COMMENT = re.compile(r"\(\*.*?\*\)")
_LIST = words("logix")
_FUNCTIONS = ("ABS", "SQRT", "LN", "LOG", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN")
_BOOL, _DINT, _REAL, _STRING = "BOOL", "DINT", "REAL", "STRING"


@dataclass(frozen=True)
class Scope:
    """What names mean in a routine, in upper case.

    Attributes:
        name: Of the instruction or program, for messages.
        tags: Parameters and tags.
        members: Members of structures, and parameters of instructions that have a value.
        calls: Names of the parameters that are arguments of a call, by instruction.
    """

    name: str
    tags: Mapping[str, Data]
    members: Mapping[str, Mapping[str, Data]]
    calls: Mapping[str, tuple[str, ...]]


def iec_type(data: Data) -> str:
    """The type of a tag; that of an array is declared by the reader."""
    if data.size:
        return f"L5X_{data.type}_{data.size}"
    return _STORED.get(data.type, data.type)


def single(text: str) -> str:
    """The REAL of single precision that a literal stands for."""
    return repr(c_float(float(text)).value)


def iec_statements(text: str, scope: Scope) -> list[str]:
    """Translate the statements of a routine.

    Raises:
        InputError: something that this reader does not know, or that Logix would refuse.
    """
    for place, line in enumerate(text.splitlines(), 1):
        if "S:FS" in _COMMENT.sub(" ", line):
            raise InputError(f"{scope.name}, line {place}: {_refusal('S:FS')}")
    wrapped = f"FUNCTION_BLOCK It\n{text}\nEND_FUNCTION_BLOCK\n"
    (pou,) = parse_text(wrapped, Path(scope.name)).declarations
    assert isinstance(pou, s.Pou)
    return _Translation(scope).block(pou.body, "  ")


class _Translation:
    def __init__(self, scope: Scope) -> None:
        self._scope = scope

    def _error(self, message: str, at: s.Position) -> InputError:
        return InputError(f"{self._scope.name}, line {at.line - 1}: {message}")

    # --- statements -----------------------------------------------------------------------

    def block(self, body: Iterable[s.Statement], indent: str) -> list[str]:
        return [line for one in body for line in self._statement(one, indent)]

    def _statement(self, one: s.Statement, indent: str) -> list[str]:
        deeper = indent + "  "
        if isinstance(one, s.Assign):
            return [f"{indent}{self._assign(one)}"]
        if isinstance(one, s.CallStatement):
            return [f"{indent}{self._call(one)}"]
        if isinstance(one, s.If):
            lines = []
            for word, (condition, body) in zip(
                ["IF", *["ELSIF"] * len(one.branches)], one.branches, strict=False
            ):
                lines.append(f"{indent}{word} {self._bool(condition)} THEN")
                lines += self.block(body, deeper)
            if one.otherwise:
                lines += [f"{indent}ELSE", *self.block(one.otherwise, deeper)]
            return [*lines, f"{indent}END_IF;"]
        if isinstance(one, s.Case):
            return self._case(one, indent)
        if isinstance(one, s.While):
            head = f"{indent}WHILE {self._bool(one.condition)} DO"
            return [head, *self.block(one.body, deeper), f"{indent}END_WHILE;"]
        if isinstance(one, s.Repeat):
            until = f"{indent}UNTIL {self._bool(one.condition)}"
            return [f"{indent}REPEAT", *self.block(one.body, deeper), until, f"{indent}END_REPEAT;"]
        if isinstance(one, s.Exit):
            return [f"{indent}EXIT;"]
        raise self._error(f"{type(one).__name__} is not read", one.at)

    def _case(self, one: s.Case, indent: str) -> list[str]:
        lines = [f"{indent}CASE {self._number(one.selector)} OF"]
        for branch in one.branches:
            labels = []
            for label in branch.labels:
                ends = (label.low, label.high) if isinstance(label, s.Range) else (label,)
                if not all(isinstance(end, s.Literal) for end in ends):
                    raise self._error("a label of CASE must be a number", branch.at)
                labels.append("..".join(self._number(end) for end in ends))
            lines.append(f"{indent}  {', '.join(labels)}:")
            lines += self.block(branch.body, indent + "    ")
        if one.otherwise:
            lines += [f"{indent}ELSE", *self.block(one.otherwise, indent + "  ")]
        return [*lines, f"{indent}END_CASE;"]

    def _assign(self, one: s.Assign) -> str:
        target, data = self._variable(one.target)
        value, kind = self._value(one.value)
        if data.size or data.type not in (_BOOL, _DINT, _REAL, _STRING, "SINT", "INT"):
            raise self._error(f"{target} is copied by COP, not assigned", one.at)
        if data.type == _BOOL and isinstance(one.value, s.Literal) and value in ("0", "1"):
            return f"{target} := {'TRUE' if value == '1' else 'FALSE'};"
        if (data.type in (_BOOL, _STRING) or kind in (_BOOL, _STRING)) and data.type != kind:
            raise self._error(f"{target} is {data.type}, the value {kind}", one.at)
        if data.type == _REAL and kind == _DINT:
            return f"{target} := DINT_TO_REAL({value});"
        if data.type != _REAL and kind == _REAL:
            value = f"REAL_TO_DINT({value})"
        if data.type in ("SINT", "INT"):
            value = f"{data.type}_TO_{_STORED[data.type]}(DINT_TO_{data.type}({value}))"
        return f"{target} := {value};"

    def _call(self, one: s.CallStatement) -> str:
        name = one.callee.text if isinstance(one.callee, s.Name) else ""
        given = [argument.value for argument in one.arguments]
        if any(argument.name is not None for argument in one.arguments):
            raise self._error("arguments have no names here", one.at)
        if name in self._scope.calls:
            return self._instruction(name, given, one.at)
        if name not in _LIST.instructions:
            raise self._error(_refusal(name), one.at)
        if name == "TONR" and len(given) == 1:
            return f"{self._tag(given[0])[0]}();"
        if name == "COP" and len(given) == 3:
            return self._copied(given, one.at)
        if name == "MID" and len(given) == 4:
            text, length, place = self._string(given[0]), *map(self._number, given[1:3])
            return f"{self._tag(given[3])[0]} := MID(IN := {text}, L := {length}, P := {place});"
        if name == "CONCAT" and len(given) == 3:
            first, second = map(self._string, given[:2])
            return f"{self._tag(given[2])[0]} := CONCAT(IN1 := {first}, IN2 := {second});"
        if name == "FIND" and len(given) == 4 and self._number(given[2]) == "1":
            first, second = map(self._string, given[:2])
            return f"{self._tag(given[3])[0]} := FIND(IN1 := {first}, IN2 := {second});"
        raise self._error(f"{name} is not read", one.at)

    def _instruction(self, name: str, given: list[s.Expression], at: s.Position) -> str:
        pins = self._scope.calls[name]
        instance, data = self._tag(given[0]) if given else ("", Data(""))
        if data != Data(name) or len(given) != len(pins) + 1:
            raise self._error(f"{name} takes a tag of its type and {', '.join(pins)}", at)
        tags = (self._tag(value)[0] for value in given[1:])
        arguments = (f"{pin} := {tag}" for pin, tag in zip(pins, tags, strict=True))
        return f"{instance}({', '.join(arguments)});"

    def _copied(self, given: list[s.Expression], at: s.Position) -> str:
        """COP of a whole tag, or of one structure."""
        count = self._number(given[2])
        target, data = self._whole(given[1], count)
        source, other = self._whole(given[0], count)
        if other != data:
            raise self._error(f"{source} and {target} are of different types", at)
        return f"{target} := {source};"

    def _whole(self, node: s.Expression, count: str) -> tuple[str, Data]:
        """A structure or STRING, of which one is copied; or an array by its first element."""
        if isinstance(node, s.Index):
            (index,) = node.indices
            text, data = self._variable(node.base)
            if count == str(data.size) and self._number(index) == "0":
                return text, data
        text, data = self._tag(node)
        if count != "1" or data.size or not data.is_aggregate:
            raise self._error(f"{count} of {text} are copied, which is no whole tag", node.at)
        return text, data

    # --- expressions ----------------------------------------------------------------------

    def _bool(self, node: s.Expression) -> str:
        text, kind = self._value(node)
        if kind != _BOOL:
            raise self._error(f"a condition must be BOOL, not {kind}", node.at)
        return text

    def _number(self, node: s.Expression) -> str:
        text, kind = self._value(node)
        if kind != _DINT:
            raise self._error(f"a whole number is needed, not {kind}", node.at)
        return text

    def _string(self, node: s.Expression) -> str:
        text, data = self._tag(node)
        if data != Data(_STRING):
            raise self._error("a tag of type STRING is needed", node.at)
        return text

    def _tag(self, node: s.Expression) -> tuple[str, Data]:
        if not isinstance(node, s.Name | s.Field | s.Index):
            raise self._error("a tag is needed here", node.at)
        return self._variable(node)

    def _variable(self, node: s.Variable) -> tuple[str, Data]:
        if isinstance(node, s.Name):
            found = self._scope.tags.get(node.key)
            if found is None:
                raise self._error(f"there is no tag {node.text}", node.at)
            return node.text, found
        assert not isinstance(node, s.This)
        base, data = self._variable(node.base)
        if isinstance(node, s.Index):
            if not data.size or len(node.indices) != 1:
                raise self._error(f"{base} is no array", node.at)
            return f"{base}[{self._number(node.indices[0])}]", Data(data.type)
        assert isinstance(node, s.Field)
        members = self._scope.members.get(data.type, {})
        member = members.get(node.name.key)
        if data.size or member is None:
            raise self._error(f"{base} has no member {node.name.text}", node.at)
        return f"{base}.{node.name.text}", member

    def _value(self, node: s.Expression) -> tuple[str, str]:
        """An expression, and BOOL, DINT, REAL or STRING."""
        if isinstance(node, s.Literal):
            return self._literal(node)
        if isinstance(node, s.Field) and node.name.key == "LEN":
            text, data = self._variable(node.base)
            if data == Data(_STRING):
                return f"LEN(IN := {text})", _DINT
        if isinstance(node, s.Name | s.Field | s.Index):
            text, data = self._variable(node)
            if data.type in ("SINT", "INT") and not data.size:
                return f"{data.type}_TO_DINT({_STORED[data.type]}_TO_{data.type}({text}))", _DINT
            return text, iec_type(data)
        if isinstance(node, s.Unary):
            text, kind = self._value(node.operand)
            if node.op == "NOT" and kind == _DINT:
                return f"DWORD_TO_DINT(NOT DINT_TO_DWORD({text}))", _DINT
            if (node.op == "NOT") != (kind == _BOOL):
                raise self._error(f"{node.op} of {kind}", node.at)
            return f"{node.op} ({text})" if node.op == "NOT" else f"(-{text})", kind
        if isinstance(node, s.Binary):
            return self._binary(node)
        assert isinstance(node, s.Call)
        name = node.function.key
        if name == "TRUNC" and len(node.arguments) == 1:
            return f"TRUNC({self._real(node.arguments[0].value)})", _DINT
        if name in _FUNCTIONS and len(node.arguments) == 1:
            text, kind = self._value(node.arguments[0].value)
            return f"{name}({text})", kind
        raise self._error(f"{_refusal(name)}; it is no function of an expression", node.at)

    def _literal(self, node: s.Literal) -> tuple[str, str]:
        if node.kind == "INTEGER":
            value = number(node.text)
            if value >= 1 << 31:
                return f"DWORD_TO_DINT(DWORD#16#{value:X})", _DINT
            return str(value), _DINT
        if node.kind == "REALNUM":
            return single(node.text), _REAL
        if node.kind == "STRING":
            return node.text, _STRING
        raise self._error(f"{node.text} is no literal of Logix", node.at)

    def _real(self, node: s.Expression) -> str:
        text, kind = self._value(node)
        return f"DINT_TO_REAL({text})" if kind == _DINT else text

    def _binary(self, node: s.Binary) -> tuple[str, str]:
        (left, first), (right, second) = self._value(node.left), self._value(node.right)
        kinds = {first, second}
        if node.op in ("AND", "OR", "XOR"):
            if kinds == {_BOOL}:
                return f"({left} {node.op} {right})", _BOOL
            if kinds == {_DINT}:
                return f"DWORD_TO_DINT({_bits(left)} {node.op} {_bits(right)})", _DINT
        elif node.op in ("=", "<>", "<", ">", "<=", ">="):
            if kinds in ({_DINT}, {_REAL}, {_STRING}):
                return f"({left} {node.op} {right})", _BOOL
            if kinds == {_DINT, _REAL}:
                return f"({self._real(node.left)} {node.op} {self._real(node.right)})", _BOOL
        elif node.op == "**" and first == _REAL and second in (_REAL, _DINT):
            return f"({left} ** {right})", _REAL
        elif kinds == {_DINT} and node.op != "**":
            return f"({left} {node.op} {right})", _DINT
        elif kinds <= {_DINT, _REAL} and node.op not in ("MOD", "**"):
            return f"({self._real(node.left)} {node.op} {self._real(node.right)})", _REAL
        raise self._error(f"{first} {node.op} {second}", node.at)


def _refusal(name: str) -> str:
    """That something is not on the list of Structured Text, and what to write."""
    instead = _LIST.instead.get(name)
    return f"{name} is not read: {_LIST.tool} has none{f'; write {instead}' if instead else ''}"


def _bits(text: str) -> str:
    return f"DWORD#16#{int(text):X}" if text.isdigit() else f"DINT_TO_DWORD({text})"
