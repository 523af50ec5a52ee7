"""What a PLC tool calls types, names and values that IEC 61131-3 text calls otherwise."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

from structured_text.export.body import Body, Scope
from structured_text.export.initial import is_scalar, literal, zero
from structured_text.export.parts import Part, Sources
from structured_text.export.words import Words, words
from structured_text.language import syntax as s
from structured_text.language.printer import expression_text, init_text
from structured_text.language.standard import FUNCTIONS, conversion
from structured_text.language.types import ElementaryType, EnumType, Type

__all__ = ["BYTES", "Dialect", "Function", "Names", "dialect_body"]

#: Why a block with a process image of bytes cannot be had.
BYTES = "has an array of BYTE; take the block for words"

#: Comes after a name that the tool refuses.
_SUFFIX = "_X"
_MOMENTS = ("T", "TIME", "D", "DATE", "TOD", "TIME_OF_DAY", "DT", "DATE_AND_TIME")
_BITS = ("BYTE", "WORD", "DWORD", "LWORD")
_ZEROS = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0", "TIME": "T#0s", "STRING": "''"}


@dataclass(frozen=True)
class Dialect:
    """A tool's words.

    Attributes:
        tool: Its name.
        listed: Of its functions and blocks, in the folder `words`.
        types: What its tables call an elementary type; one that is missing it does not have.
        array: How its tables write an array of `{element}` from `{bounds}`.
        words: Types that its statements call otherwise, in typed literals and conversions.
        enumerations: Whether it has them; otherwise members are numbers of type INT.
        bytes: Whether it has BYTE; otherwise a BYTE is a WORD whose upper half is 0.
        refused: Names of variables that it refuses.
        arguments: Conversion of each argument of a standard function; "" for none.
        results: Conversion of a standard function's result.
    """

    tool: str
    listed: str
    types: Mapping[str, str]
    array: str
    refused: re.Pattern[str]
    words: Mapping[str, str] = field(default_factory=dict)
    enumerations: bool = False
    bytes: bool = False
    arguments: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    results: Mapping[str, str] = field(default_factory=dict)

    @property
    def words_of(self) -> Words:
        """Its list of functions and blocks."""
        return words(self.listed)

    def name(self, text: str) -> str:
        """A variable's, pin's or field's name here."""
        return f"{text}{_SUFFIX}" if self.refused.fullmatch(text.upper()) else text

    def word(self, kind: str) -> str:
        """An elementary type's name in statements."""
        found = "WORD" if kind == "BYTE" and not self.bytes else kind
        return self.words.get(found, found)

    def typed(self, text: str) -> str:
        """A typed literal such as `UINT#1`."""
        kind, _, value = text.partition("#")
        return text if kind.upper() in _MOMENTS else f"{self.word(kind.upper())}#{value}"

    @property
    def mask(self) -> str:
        """The lower half of a WORD."""
        return f"{self.word('WORD')}#16#00FF"


@dataclass(frozen=True)
class Function:
    """A function of the sources.

    Attributes:
        defaults: What stands for each parameter that is left out, in order, by upper-case name.
        result: Its type.
    """

    defaults: Mapping[str, str]
    result: s.NamedSpec | None


class Names:
    """What the names of the sources mean, and what they are in a dialect."""

    def __init__(self, sources: Sources, dialect: Dialect) -> None:
        self.dialect = dialect
        self.project = sources.project
        self.types = {
            part.name.upper(): part.node
            for part in sources.parts
            if isinstance(part.node, s.TypeDecl)
        }
        self.members = {
            member.key: (node.name.text, value, member.text)
            for node in self.types.values()
            if isinstance(node.spec, s.EnumSpec)
            for value, member in enumerate(node.spec.members)
        }
        self.functions = {
            part.name.upper(): Function(self._defaults(part.node), part.node.result)
            for part in sources.of("FUNCTION")
            if isinstance(part.node, s.Pou) and isinstance(part.node.result, s.NamedSpec)
        }

    def spec(self, spec: s.TypeSpec) -> str:
        """A type as the tool's tables have it."""
        if isinstance(spec, s.ArraySpec):
            bounds = ", ".join(
                f"{expression_text(one.low)}..{expression_text(one.high)}"
                for one in spec.dimensions
            )
            return self.dialect.array.format(element=self.spec(spec.element), bounds=bounds)
        if isinstance(spec, s.NamedSpec):
            declared = self.types.get(spec.name.key)
            if declared is None:
                return self.dialect.types.get(spec.name.key, spec.name.text)
            if isinstance(declared.spec, s.StructSpec):
                return declared.name.text
            if not isinstance(declared.spec, s.EnumSpec) or not self.dialect.enumerations:
                return self.spec(declared.spec)
            return declared.name.text
        return self.dialect.types["INT"]

    def cell(self, one: s.VarDecl, kind: Type, value: Any) -> str:
        """The initial value of a scalar as the tool's tables have it; empty where it is zero."""
        if one.initial is None and value == zero(kind):
            return ""
        if isinstance(kind, EnumType):
            return f"{kind.name}#{kind.members[value]}" if self.dialect.enumerations else str(value)
        assert isinstance(kind, ElementaryType)
        text = literal(value, kind) if one.initial is None else init_text(one.initial)
        word, mark, number = text.partition("#")
        return number if mark and word.isalpha() and word.upper() not in _MOMENTS else text

    def literal(self, value: Any, kind: Type) -> str:
        """A scalar's value as statements have it."""
        if isinstance(kind, EnumType):
            member = kind.members[value]
            named = f"{kind.name}#{member}"
            return named if self.dialect.enumerations else f"{value} (* {member} *)"
        assert isinstance(kind, ElementaryType)
        text = literal(value, kind)
        return self.dialect.typed(text) if kind.name in _BITS else text

    def member(self, text: str) -> str:
        """A member of an enumeration."""
        kind, value, name = self.members[text.upper()]
        return f"{kind}#{name}" if self.dialect.enumerations else f"{value} (* {name} *)"

    def zero(self, spec: s.TypeSpec) -> str:
        """What a variable of an elementary or enumerated type begins with."""
        kind = self.base(spec)
        if isinstance(kind, s.EnumSpec):
            return self.member(kind.members[0].text)
        name = kind.name.key if isinstance(kind, s.NamedSpec) else ""
        return f"{self.dialect.word(name)}#16#0" if name in _BITS else _ZEROS.get(name, "0")

    def start(self, one: s.VarDecl, kind: Type, value: Any) -> str:
        """What a scalar begins with, as statements have it."""
        if one.initial is not None:
            return self._literal(one.initial)
        return self.zero(one.spec) if value == zero(kind) else self.literal(value, kind)

    def base(self, spec: s.TypeSpec | None) -> s.TypeSpec | None:
        """What a named type stands for."""
        while isinstance(spec, s.NamedSpec) and spec.name.key in self.types:
            spec = self.types[spec.name.key].spec
        return spec

    def is_byte(self, spec: s.TypeSpec | None) -> bool:
        """Whether that is a BYTE which the tool does not have."""
        kind = self.base(spec)
        named = isinstance(kind, s.NamedSpec) and kind.name.key == "BYTE"
        return named and not self.dialect.bytes

    def trouble(self, part: Part, known: Collection[str]) -> str:
        """Why the tool cannot have the variables of a part; empty if it can.

        Args:
            part: A type, function, block or program.
            known: Types and blocks that are not elementary, in upper case.
        """
        for one in _variables(part):
            kind = self.base(one.spec)
            array = isinstance(kind, s.ArraySpec)
            while isinstance(kind, s.ArraySpec):
                kind = self.base(kind.element)
            if array and self.is_byte(kind):
                return BYTES
            if isinstance(kind, s.NamedSpec):
                name = kind.name.key
                if name not in self.dialect.types and name not in known:
                    return f"{self.dialect.tool} has no {name}"
        return ""

    def _defaults(self, node: s.Pou) -> dict[str, str]:
        symbols = self.project.pous[node.name.key].symbols
        return {
            name.key: self.start(one, symbols[name.key].type, symbols[name.key].initial)
            for section in node.sections
            if section.kind == "VAR_INPUT"
            for one in section.variables
            for name in one.names
            if is_scalar(symbols[name.key].type)
        }

    def _literal(self, init: s.Init) -> str:
        if isinstance(init, s.Name) and init.key in self.members:
            return self.member(init.text)
        if isinstance(init, s.Literal) and init.kind == "TYPED":
            return self.dialect.typed(init.text)
        return init_text(init)


def _variables(part: Part) -> list[s.VarDecl]:
    node = part.node
    if isinstance(node, s.Pou):
        return [one for section in node.sections for one in section.variables]
    if isinstance(node, s.TypeDecl) and isinstance(node.spec, s.StructSpec):
        return list(node.spec.fields)
    if isinstance(node, s.TypeDecl):
        return [s.VarDecl((node.name,), node.spec, None, None, node.at)]
    return []


_COMPARED = ("EQ", "NE", "LT", "GT", "LE", "GE")
_SHIFTS = ("SHL", "SHR", "ROL", "ROR")


def dialect_body(text: str, scope: Scope, names: Names) -> str:
    """Rewrite statements.

    Arguments of functions lose their names and stand in the order of the parameters, left-out
    ones are written out; members of enumerations, typed literals and conversions are the
    tool's; where it has no BYTE, what could leave the lower half of a WORD is masked.

    Args:
        text: The statements.
        scope: What the POU's names mean.
        names: What the other names are here.
    """
    return _Body(text, scope, names).all()


class _Body(Body):
    def __init__(self, text: str, scope: Scope, names: Names) -> None:
        super().__init__(text, scope, names.dialect.words_of)
        self._names = names
        self._dialect = names.dialect

    def _plain(self, text: str) -> str:
        return self._dialect.name(text)

    def _typed(self, text: str) -> str:
        return self._dialect.typed(text)

    def _word(self, at: int) -> str:
        token = self._found[at]
        key = token.upper()
        if key in self._names.members:
            return self._names.member(key)
        return str(token) if key in self._names.functions else self._dialect.name(str(token))

    def _piece(self, at: int) -> tuple[str, int]:
        if self._kind(at) == "NOT" and self._byte(at + 1):
            end = self._primary(at + 1)
            return f"(NOT {self._run(at + 1, end)} AND {self._dialect.mask})", end
        return super()._piece(at)

    def _own(self, at: int, given: list[tuple[str, int, int]], end: int) -> str:
        key = self._found[at].upper()
        defaults = self._names.functions[key].defaults
        pins = self._scope.pins[key]
        return self._listed(at, given, end, pins, named=False, defaults=defaults)

    def _standard(self, key: str, given: list[tuple[str, int, int]]) -> str:
        call = super()._standard(key, given)
        if key in self._dialect.results:
            call = f"{self._dialect.results[key]}({call})"
        shifted = next((first for name, first, _ in given if name in ("", "IN")), 0)
        if key in _SHIFTS and self._byte(shifted):
            return f"({call} AND {self._dialect.mask})"
        return call

    def _converted(self, source: str, target: str, value: tuple[int, int]) -> str:
        first, last = self._dialect.word(source), self._dialect.word(target)
        text = self._run(*value)
        if first != last:
            text = f"{first}_TO_{last}({text})"
        elif self._compound(*value):
            text = f"({text})"
        narrowed = target == "BYTE" and not self._dialect.bytes
        return f"({text} AND {self._dialect.mask})" if narrowed else text

    def _argument(self, key: str, place: int, first: int, last: int) -> str:
        """An argument, converted where the tool's standard function wants another type."""
        text = self._run(first, last)
        wanted = self._dialect.arguments.get(key, ())
        plain = last == first + 1 and self._kind(first) == "INTEGER"
        if place >= len(wanted) or not wanted[place] or plain:
            return text
        return f"{wanted[place]}({text})"

    def _primary(self, at: int) -> int:
        """Behind a variable, a literal, a call or what is in parentheses."""
        if self._kind(at) == "LPAR":
            return self._closed(at)
        at += 1
        while self._kind(at) in ("DOT", "LSQB", "LPAR"):
            at = at + 2 if self._kind(at) == "DOT" else self._closed(at)
        return at

    def _byte(self, at: int) -> bool:
        """Whether an operand is a BYTE that the tool does not have."""
        token, kind = self._found[at], self._kind(at)
        if self._dialect.bytes:
            return False
        if kind == "NOT":
            return self._byte(at + 1)
        if kind == "LPAR":
            inside = range(at + 1, self._closed(at) - 1)
            return self._byte(at + 1) and not any(self._kind(k) in _COMPARED for k in inside)
        if kind == "TYPED":
            return str(token).upper().startswith("BYTE#")
        if self._kind(at + 1) == "LPAR" and (kind == "IDENT" or kind in FUNCTIONS):
            own, types = self._names.functions.get(token.upper()), conversion(token.upper())
            if own is not None:
                return self._names.is_byte(own.result)
            if types is not None:
                return types[1] == "BYTE"
            return self._byte_of_standard(at)
        return kind == "IDENT" and self._names.is_byte(self._type(at))

    def _byte_of_standard(self, at: int) -> bool:
        """Whether a standard function's result is: one of its values is a BYTE."""
        key = self._found[at].upper()
        if key not in FUNCTIONS or FUNCTIONS[key].result != "T":
            return False
        pins = [name for name, kind in FUNCTIONS[key].pins if kind == "T"]
        given = self._arguments(at + 2, self._closed(at + 1) - 1)
        skipped = len(FUNCTIONS[key].pins) - len(pins) if key in ("SEL", "MUX") else 0
        values = [
            first
            for place, (name, first, _) in enumerate(given)
            if (name in pins if name else place >= skipped)
        ]
        return any(self._byte(first) for first in values[: len(values) if skipped else 1])
