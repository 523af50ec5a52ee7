"""The dialect of a PLC tool: its types, names and values that differ from IEC 61131-3."""

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
from structured_text.language.printer import bounds_text, init_text
from structured_text.language.standard import FUNCTIONS, conversion
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.language.walk import declared

__all__ = ["BYTES", "Dialect", "Function", "Names", "dialect_body"]

#: The reason, for messages, why a block with a process image of bytes is not supported.
BYTES = "has an array of BYTE; take the block for words"

#: Suffix for a name that the tool refuses.
_SUFFIX = "_X"
_MOMENTS = ("T", "TIME", "D", "DATE", "TOD", "TIME_OF_DAY", "DT", "DATE_AND_TIME")
_BITS = ("BYTE", "WORD", "DWORD", "LWORD")
_ZEROS = {"BOOL": "FALSE", "REAL": "0.0", "LREAL": "0.0", "TIME": "T#0s", "STRING": "''"}


@dataclass(frozen=True)
class Dialect:
    """The words of a tool.

    Attributes:
        listed: The name of the tool's list of functions and blocks, in the folder `words`.
        types: Names of elementary types in the tool's tables. The tool does not have the missing
            types.
        array: The form of an array in the tool's tables, with `{element}` and `{bounds}`.
        words: The tool's names of types in statements (typed literals, conversions), if they
            differ.
        enumerations: Whether the tool has enumerations; otherwise their members become INT numbers.
        bytes: Whether the tool has BYTE; otherwise a BYTE becomes a WORD with an upper half of 0.
        refused: Names of variables that the tool refuses.
        arguments: By standard function, the conversion of each argument; "" if none is needed.
        results: By standard function, the conversion of the result.
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
        """Return the tool's list of functions and blocks."""
        return words(self.listed)

    def name(self, text: str) -> str:
        """Return the tool's name for a variable, pin or field."""
        return f"{text}{_SUFFIX}" if self.refused.fullmatch(text.upper()) else text

    def word(self, kind: str) -> str:
        """Return the tool's name for an elementary type in statements."""
        found = "WORD" if kind == "BYTE" and not self.bytes else kind
        return self.words.get(found, found)

    def typed(self, text: str) -> str:
        """Return a typed literal such as `UINT#1`, in the tool's form."""
        kind, _, value = text.partition("#")
        return text if kind.upper() in _MOMENTS else f"{self.word(kind.upper())}#{value}"

    @property
    def mask(self) -> str:
        """Return the tool's literal for the mask of the lower half of a WORD."""
        return f"{self.word('WORD')}#16#00FF"


@dataclass(frozen=True)
class Function:
    """A function that the sources declare.

    Attributes:
        defaults: Values of omitted arguments in the order of the parameters, by upper-case name.
        result: The type of the result.
    """

    defaults: Mapping[str, str]
    result: s.NamedSpec | None


class Names:
    """The names of the sources, their meaning, and their form in a dialect."""

    def __init__(self, sources: Sources, dialect: Dialect) -> None:
        self.dialect = dialect
        self.project = sources.project
        self.types, self.members, self.base = sources.types, sources.members, sources.base
        self.functions = {
            part.name.upper(): Function(self._defaults(part.node), part.node.result)
            for part in sources.of("FUNCTION")
            if isinstance(part.node, s.Pou) and isinstance(part.node.result, s.NamedSpec)
        }

    def spec(self, spec: s.TypeSpec) -> str:
        """Return a type as written in the tool's tables."""
        if isinstance(spec, s.ArraySpec):
            element = self.spec(spec.element)
            return self.dialect.array.format(element=element, bounds=bounds_text(spec))
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
        """Return a scalar's initial value as written in the tool's tables; empty if it is zero."""
        if one.initial is None and value == zero(kind):
            return ""
        if isinstance(kind, EnumType):
            return f"{kind.name}#{kind.members[value]}" if self.dialect.enumerations else str(value)
        assert isinstance(kind, ElementaryType)
        text = literal(value, kind) if one.initial is None else init_text(one.initial)
        word, mark, number = text.partition("#")
        return number if mark and word.isalpha() and word.upper() not in _MOMENTS else text

    def literal(self, value: Any, kind: Type) -> str:
        """Return a scalar's value as written in statements."""
        if isinstance(kind, EnumType):
            member = kind.members[value]
            named = f"{kind.name}#{member}"
            return named if self.dialect.enumerations else f"{value} (* {member} *)"
        assert isinstance(kind, ElementaryType)
        text = literal(value, kind)
        return self.dialect.typed(text) if kind.name in _BITS else text

    def member(self, text: str) -> str:
        """Return a member of an enumeration in the tool's form: its name, or its number."""
        kind, value, name = self.members[text.upper()]
        named = f"{kind.name.text}#{name}"
        return named if self.dialect.enumerations else f"{value} (* {name} *)"

    def zero(self, spec: s.TypeSpec) -> str:
        """Return the default value of an elementary or enumerated type."""
        kind = self.base(spec)
        if isinstance(kind, s.EnumSpec):
            return self.member(kind.members[0].text)
        name = kind.name.key if isinstance(kind, s.NamedSpec) else ""
        return f"{self.dialect.word(name)}#16#0" if name in _BITS else _ZEROS.get(name, "0")

    def start(self, one: s.VarDecl, kind: Type, value: Any) -> str:
        """Return the initial value of a scalar as written in statements."""
        if one.initial is not None:
            return self._literal(one.initial)
        return self.zero(one.spec) if value == zero(kind) else self.literal(value, kind)

    def is_byte(self, spec: s.TypeSpec | None) -> bool:
        """Return whether a type is BYTE and the tool does not have BYTE."""
        kind = self.base(spec)
        named = isinstance(kind, s.NamedSpec) and kind.name.key == "BYTE"
        return named and not self.dialect.bytes

    def trouble(self, part: Part, known: Collection[str]) -> str:
        """Return why the tool does not support a declaration's variables; empty if it does.

        `known` are the upper-case names of all types and blocks that declarations may use.
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
            for section, one, name in declared(node.sections)
            if section.kind == "VAR_INPUT" and is_scalar(symbols[name.key].type)
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
    """Return statements rewritten in a dialect.

    Arguments of functions lose their names, get the order of the parameters, and are written out if
    they are omitted. Members of enumerations, typed literals and conversions get the tool's form.
    If the tool has no BYTE, results that could exceed the lower half of a WORD are masked.
    """
    return _Body(text, scope, names).all()


class _Body(Body):
    """A writer of statements in a dialect."""

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
        """Return an argument; convert it if the tool's standard function needs another type."""
        text = self._run(first, last)
        wanted = self._dialect.arguments.get(key, ())
        plain = last == first + 1 and self._kind(first) == "INTEGER"
        if place >= len(wanted) or not wanted[place] or plain:
            return text
        return f"{wanted[place]}({text})"

    def _primary(self, at: int) -> int:
        """Return the index of the token after an operand.

        An operand is a variable, a literal, a call or an expression in parentheses.
        """
        if self._kind(at) == "LPAR":
            return self._closed(at)
        at += 1
        while self._kind(at) in ("DOT", "LSQB", "LPAR"):
            at = at + 2 if self._kind(at) == "DOT" else self._closed(at)
        return at

    def _byte(self, at: int) -> bool:
        """Return whether an operand is a BYTE and the tool does not have BYTE."""
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
        """Return whether a standard function has a BYTE argument and a result of the same type."""
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
