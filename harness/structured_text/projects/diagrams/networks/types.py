"""The types of variables, functions and blocks that a project declares.

A diagram needs them for the variables that its translation adds, and for the pins of its blocks.
Declarations are read with regular expressions and are not checked: an unknown type is empty.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from structured_text.language.standard import BLOCKS
from structured_text.language.types import Variable
from structured_text.projects.model import Lines, Unit, without_comments

__all__ = ["ANY_INTEGER", "ANY_NUMBER", "Callee", "Declarations", "Pin", "Types"]

#: The types of literals without a type of their own.
ANY_INTEGER, ANY_NUMBER = "ANY_INT", "ANY_REAL"

_TEXT = re.compile(r"'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"")
_SECTION = re.compile(r"\b(VAR(?:_[A-Z_]+)?)\b(.*?)\bEND_VAR\b", re.DOTALL | re.IGNORECASE)
_QUALIFIERS = re.compile(r"\s*(?:\b(?:CONSTANT|RETAIN|NON_RETAIN|PERSISTENT)\b\s*)+", re.IGNORECASE)
_DECLARED = re.compile(
    r"([^\W\d]\w*(?:\s*,\s*[^\W\d]\w*)*)\s*(?:\bAT\b[^:]*)?:(?!=)\s*(.*)", re.DOTALL
)
_POU = re.compile(
    r"\s*(FUNCTION_BLOCK|FUNCTION|PROGRAM)\b([^:;\n]*)"
    r"(?::\s*(ARRAY\s*\[[^\]]*\]\s*OF\s+[\w.]+|[\w.]+(?:\s*\[[^\]]*\]|\s*\([^)]*\))?))?",
    re.IGNORECASE,
)
_BASE = re.compile(r"\bEXTENDS\s+([\w.]+)", re.IGNORECASE)
_TYPE = re.compile(
    r"([^\W\d]\w*)\s*(?:EXTENDS\s+([\w.]+)\s*)?:\s*"
    r"(?:(STRUCT|UNION)\b(.*?)\bEND_\3\b|(\([^;]*?\))|([^;]*))[^;]*;?",
    re.DOTALL | re.IGNORECASE,
)
_ARRAY = re.compile(r"ARRAY\s*\[[^\]]*\]\s*OF\s+(.*)", re.DOTALL | re.IGNORECASE)
_POINTER = re.compile(r"(?:POINTER\s+TO|REFERENCE\s+TO|REF_TO)\s+(.*)", re.DOTALL | re.IGNORECASE)
_PATH = re.compile(r"\s*([^\W\d]\w*)|\s*(\[)|\s*(\^)|\s*\.\s*([^\W\d]\w*)|\s*\.\s*(%?\w+)")
_INTEGER = re.compile(r"[+-]?(?:\d[\d_]*|(?:2|8|10|16)#[\dA-Fa-f_]+)")
_REAL = re.compile(r"[+-]?\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][+-]?\d+)?")
_TYPED = re.compile(r"([^\W\d]\w*)#")
_SHORT = {"T": "TIME", "D": "DATE", "LT": "LTIME", "LD": "LDATE"}
_LONG = {"TIME_OF_DAY": "TOD", "DATE_AND_TIME": "DT", "LTIME_OF_DAY": "LTOD"}
_SECTIONS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


@dataclass(frozen=True)
class Pin:
    """A pin of a function or block: its name, its type, and its section such as VAR_INPUT."""

    name: str
    type: str
    section: str


@dataclass(frozen=True)
class Callee:
    """A function, block or program that a diagram can call.

    Attributes:
        name: Its name.
        kind: FUNCTION, FUNCTION_BLOCK, PROGRAM or ACTION.
        result: The type of a function's result; may be empty.
        pins: The pins in the order of the declaration, those of a base first.
        standard: Whether the standard declares it, so that it does not use global variables.
    """

    name: str
    kind: str
    result: str = ""
    pins: tuple[Pin, ...] = ()
    standard: bool = False

    def pin(self, name: str) -> Pin | None:
        """Return the pin with a name; None if there is none."""
        return next((pin for pin in self.pins if pin.name.upper() == name.upper()), None)


class Declarations:
    """The declarations of a project, made from all units after they were read."""

    def __init__(self, units: Iterable[Unit]) -> None:
        self._globals: dict[str, str] = {}
        self._lists: dict[str, dict[str, str]] = {}
        self._fields: dict[str, tuple[str, dict[str, str]]] = {}
        self._members: dict[str, str] = {}
        self._aliases: dict[str, str] = {}
        self._callees: dict[str, tuple[Callee, str]] = {}
        for unit in units:
            self._add(unit)

    def _add(self, unit: Unit) -> None:
        text = _plain(unit.piece.head)
        if unit.kind == "TYPE":
            self._add_types(text)
        elif unit.kind in ("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
            self._add_pou(unit, text)
        for section, names in _variables(text):
            if section == "VAR_GLOBAL":
                self._globals.update((name.upper(), kind) for name, kind in names)
                own = self._lists.setdefault(unit.name.upper(), {})
                own.update((name.upper(), kind) for name, kind in names)

    def _add_types(self, text: str) -> None:
        inner = re.sub(r"^\s*TYPE\b|\bEND_TYPE\b", " ", text, flags=re.IGNORECASE)
        for found in _TYPE.finditer(inner):
            name, base, struct, fields, members, other = found.groups()
            if struct:
                pairs = {n.upper(): kind for n, kind in _declarations(fields)}
                self._fields[name.upper()] = (base or "").upper(), pairs
            elif members:
                for member in re.finditer(r"[(,]\s*([^\W\d]\w*)", members):
                    self._members.setdefault(member[1].upper(), name)
            elif other:
                self._aliases[name.upper()] = _kind(other)

    def _add_pou(self, unit: Unit, text: str) -> None:
        found = _POU.match(text)
        result = _kind(found[3]) if found and found[3] and unit.kind == "FUNCTION" else ""
        base = _BASE.search(found[2]) if found else None
        pins = tuple(
            Pin(name, kind, section)
            for section, names in _variables(text)
            if section in _SECTIONS
            for name, kind in names
        )
        callee = Callee(unit.name, unit.kind, result, pins)
        self._callees[unit.name.upper()] = callee, base[1] if base else ""
        for part in unit.piece.parts:
            if part.is_action:
                self._callees[part.name.upper()] = Callee(part.name, "ACTION"), ""

    def types(self, name: str, head: Lines) -> Types:
        """Return the types as a POU with a name and a head sees them."""
        return Types(self, name, head)

    def callee(self, name: str) -> Callee | None:
        """Return the function, block or program of a name; None if the project has none."""
        found = self._callees.get(name.upper())
        if found is None:
            standard = BLOCKS.get(name.upper())
            if standard is None:
                return None
            pins = tuple(_standard_pin(variable) for variable in standard.variables)
            return Callee(standard.name, "FUNCTION_BLOCK", "", pins, standard=True)
        callee, base = found
        seen = {name.upper()}
        while base and base.upper() not in seen:
            seen.add(base.upper())
            above, base = self._callees.get(base.upper(), (None, ""))
            if above is not None:
                pins = (*above.pins, *callee.pins)
                callee = Callee(callee.name, callee.kind, callee.result, pins)
        return callee

    def global_type(self, name: str) -> str:
        """Return the type of a global variable or member of an enumeration; else empty."""
        return self._globals.get(name.upper(), "") or self._members.get(name.upper(), "")

    def listed(self, name: str) -> bool:
        """Return whether a list of global variables has this name."""
        return name.upper() in self._lists

    def field(self, kind: str, name: str) -> str:
        """Return the type of a field of a structure, list or block; empty if it is unknown."""
        key, name = kind.upper(), name.upper()
        for _ in range(20):  # a chain of bases or names; a longer one is a circle
            if key in self._lists and name in self._lists[key]:
                return self._lists[key][name]
            if key in self._fields:
                base, fields = self._fields[key]
                if name in fields:
                    return fields[name]
                key = base
            elif key in self._aliases:
                key = self._aliases[key].upper()
            else:
                break
        callee = self.callee(key)
        pin = callee.pin(name) if callee is not None else None
        return pin.type if pin is not None else ""

    def base_type(self, kind: str) -> str:
        """Return a type with the names of other types replaced by what they stand for."""
        for _ in range(20):
            if kind.upper() not in self._aliases:
                break
            kind = self._aliases[kind.upper()]
        return kind


class Types:
    """The types as a POU sees them: its own variables come before those of the project."""

    def __init__(self, declared: Declarations, name: str, head: Lines) -> None:
        text = _plain(head)
        self._declared, self._name = declared, name
        self._types: dict[str, str] = {}
        self._own: set[str] = set()
        found = _POU.match(text)
        if found and found[3]:
            self._types[name.upper()] = _kind(found[3])
            self._own.add(name.upper())
        for section, names in _variables(text):
            for variable, kind in names:
                self._types[variable.upper()] = kind
                # Other POUs can change the others while a block is called.
                if section not in ("VAR_EXTERNAL", "VAR_IN_OUT", "VAR_GLOBAL"):
                    self._own.add(variable.upper())

    def callee(self, name: str) -> Callee | None:
        """Return the function, block, program or own action of a name; None if there is none."""
        return self._declared.callee(f"{self._name}.{name}") or self._declared.callee(name)

    def is_own(self, name: str) -> bool:
        """Return whether a variable belongs to the POU alone."""
        return name.upper() in self._own

    def is_list(self, name: str) -> bool:
        """Return whether a name is that of a list of global variables."""
        return not self.is_own(name) and self._declared.listed(name)

    def of(self, expression: str) -> str:
        """Return the type of a variable or literal; empty if it is unknown."""
        text = expression.strip()
        if text.upper() in ("TRUE", "FALSE"):
            return "BOOL"
        if _INTEGER.fullmatch(text):
            return ANY_INTEGER
        if _REAL.fullmatch(text):
            return ANY_NUMBER
        if text[:1] in ("'", '"'):
            return "STRING" if text[0] == "'" else "WSTRING"
        typed = _TYPED.match(text)
        if typed:
            name = typed[1].upper()
            return _SHORT.get(name) or _LONG.get(name) or typed[1]
        return self._of_path(text)

    def base(self, kind: str) -> str:
        """Return a type in upper case with aliases replaced."""
        found = self._declared.base_type(kind).upper()
        return _LONG.get(found, found)

    def _of_path(self, text: str) -> str:
        kind, behind = "", 0
        while behind < len(text):
            found = _PATH.match(text, behind)
            if found is None or not found[0]:
                return ""
            root, index, pointer, field, bit = found.groups()
            behind = found.end()
            if root is not None:
                if found.start():
                    return ""
                kind = self._types.get(root.upper()) or self._declared.global_type(root)
                if not kind and self._declared.listed(root):
                    kind = root
            elif index:
                behind = _closing(text, behind)
                array = _ARRAY.fullmatch(self._declared.base_type(kind))
                kind = array[1].strip() if array else ""
            elif pointer:
                target = _POINTER.fullmatch(self._declared.base_type(kind))
                kind = target[1].strip() if target else ""
            elif field is not None:
                kind = self._declared.field(kind, field)
            elif bit is not None:
                kind = "BOOL"
            if not kind:
                return ""
        return kind


def _plain(lines: Lines) -> str:
    """Return the text of a head without comments and without the contents of texts."""
    text = _TEXT.sub(lambda found: found[0][0] * 2, "\n".join(line.text for line in lines))
    return without_comments(text)


def _kind(text: str) -> str:
    """Return a type as it is written, without its initial value."""
    kind = text.split(":=")[0].strip()
    if not _ARRAY.match(kind):
        kind = re.sub(r"\(.*\)$", "", kind, flags=re.DOTALL).strip()
    return re.sub(r"\s+", " ", kind)


def _variables(text: str) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    """Yield each section of variables with its names and types."""
    for found in _SECTION.finditer(text):
        inner = _QUALIFIERS.sub("", found[2], count=1) if found[2] else ""
        yield found[1].upper(), list(_declarations(inner))


def _declarations(text: str) -> Iterator[tuple[str, str]]:
    for part in text.split(";"):
        found = _DECLARED.match(part.strip())
        if found:
            for name in found[1].split(","):
                yield name.strip(), _kind(found[2])


def _closing(text: str, behind: int) -> int:
    """Return the position behind the bracket that closes the one before `behind`."""
    depth = 1
    while behind < len(text) and depth:
        depth += {"[": 1, "]": -1}.get(text[behind], 0)
        behind += 1
    return behind


def _standard_pin(variable: Variable) -> Pin:
    return Pin(variable.name, variable.type.name, variable.section)
