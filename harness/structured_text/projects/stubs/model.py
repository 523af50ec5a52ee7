"""The interface of a missing element, inferred from its uses, and the text of the interface."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from structured_text.language.scalars import ANY_BIT, ANY_INT, ANY_REAL, WIDTH
from structured_text.language.types import (
    ArrayType,
    ElementaryType,
    ReferenceType,
    Type,
)

__all__ = [
    "ALIAS",
    "BLOCK",
    "CONSTANT",
    "ENUM",
    "FUNCTION",
    "INTERFACE",
    "LIST",
    "NAMESPACE",
    "STRUCT",
    "Pin",
    "Stub",
    "type_text",
]

BLOCK, FUNCTION, STRUCT, ENUM = "FUNCTION_BLOCK", "FUNCTION", "STRUCT", "ENUM"
INTERFACE, ALIAS, LIST, NAMESPACE = "INTERFACE", "ALIAS", "LIST", "NAMESPACE"
CONSTANT = "CONSTANT"
#: Integer types, and integer and bit string types, from the narrowest to the widest.
_INTEGERS = tuple(sorted(ANY_INT, key=WIDTH.__getitem__))
_NUMBERS = tuple(sorted((*ANY_INT, *ANY_BIT[1:]), key=WIDTH.__getitem__))
#: The key of an argument that a call passes by position, without a name.
_POSITION = re.compile(r"P(\d+)")
#: Types by the prefix of a variable's name, as TwinCAT and CODESYS users write it. The prefix
#: decides if no use shows the type.
_BY_NAME = (
    ("by", "BYTE"),
    ("dw", "DWORD"),
    ("lw", "LWORD"),
    ("udi", "UDINT"),
    ("usi", "USINT"),
    ("uli", "ULINT"),
    ("ui", "UINT"),
    ("ud", "UDINT"),
    ("lr", "LREAL"),
    ("tim", "TIME"),
    ("b", "BOOL"),
    ("x", "BOOL"),
    ("w", "WORD"),
    ("i", "INT"),
    ("n", "DINT"),
    ("u", "UINT"),
    ("r", "REAL"),
    ("f", "LREAL"),
    ("s", "STRING(255)"),
    ("t", "TIME"),
    ("p", "POINTER TO BYTE"),
)
_FLAGS = re.compile(
    r"Execute|Enabled?|Done|Busy|Active|Error|Valid|CommandAborted|Q|In[A-Z]\w+|Is[A-Z]\w+|Has[A-Z]\w+"
)
#: The type of an input that gets values of unrelated types.
ANY = "ANY"
#: The type of a variable if neither its uses nor its prefix show a type.
_UNKNOWN = "DINT"


def type_text(kind: Type | None) -> str:
    """Return a type as it is written in a declaration; empty if it has no such text."""
    if isinstance(kind, ElementaryType):
        length = "" if kind.length is None else f"({kind.length})"
        return f"{kind.name}{length}"
    if isinstance(kind, ReferenceType):
        target = type_text(kind.target)
        return f"{kind.kind} TO {target}" if target else ""
    if isinstance(kind, ArrayType):
        element = type_text(kind.element)
        bounds = ", ".join("*" if kind.open else f"{low}..{high}" for low, high in kind.bounds)
        return f"ARRAY [{bounds}] OF {element}" if element else ""
    name = str(getattr(kind, "name", "") or "")
    return name if re.fullmatch(r"[A-Za-z]\w*", name) else ""


@dataclass
class Pin:
    """A parameter, field or member, with the types of the values that it is used with.

    If a call with unnamed arguments shows the position of the parameter, `place` is this position,
    from 1 on. Otherwise `place` is 0.
    """

    name: str
    place: int = 0
    given: list[str] = field(default_factory=list)
    wanted: list[str] = field(default_factory=list)

    def note(self, kind: str, *, given: bool) -> None:
        """Note the type of a value that the pin gets (`given`), or that an expression needs."""
        known = self.given if given else self.wanted
        if kind and kind not in known:
            known.append(kind)

    @property
    def type(self) -> str:
        """Return the inferred type.

        It is wide enough for all values that the pin gets. Without such values, it is as narrow as
        the uses of the pin require.
        """
        return self._common or (self.given or self.wanted)[0]

    @property
    def input_type(self) -> str:
        """Return the type of an input: ANY if no other type takes all given values."""
        return self._common or (ANY if len(self.given) > 1 else (self.given or self.wanted)[0])

    @property
    def _common(self) -> str:
        """Return the type that all noted values have or convert to; empty if there is none."""
        known = self.given or self.wanted
        for order in (_INTEGERS, ANY_BIT, _NUMBERS, ANY_REAL):
            if known and all(kind in order for kind in known):
                ranked = sorted(known, key=order.index)
                return ranked[-1] if self.given else ranked[0]
        numbers = (*ANY_INT, *ANY_REAL, *ANY_BIT)
        if known and all(kind in numbers for kind in known) and any(k in ANY_REAL for k in known):
            return "LREAL" if self.given else next(k for k in known if k in ANY_REAL)
        if known and all(kind.startswith("POINTER TO ") for kind in known):
            certain = [kind for kind in known if kind != "POINTER TO BYTE"]
            return certain[0] if len(certain) == 1 else "POINTER TO BYTE"
        if known and all(kind.startswith("STRING") for kind in known):
            return "STRING(255)"
        if not known:
            return _by_name(self.name)
        return known[0] if len(known) == 1 else ""


def _number(key: str) -> int:
    """Return the position of an argument from its key, from 1 on; 0 for a named argument."""
    found = _POSITION.fullmatch(key)
    return int(found[1]) if found else 0


def _by_name(name: str) -> str:
    """Return the type that the prefix of a name suggests."""
    if _FLAGS.fullmatch(name):
        return "BOOL"
    for begin, kind in _BY_NAME:
        if re.match(rf"{begin}[A-Z]", name):
            return kind
    return _UNKNOWN


@dataclass
class Stub:
    """An element that is missing.

    Attributes:
        kind: One of the constants of this module, or METHOD.
        inputs: VAR_INPUT of a block, function or method.
        outputs: VAR_OUTPUT of a block, fields of a structure, members of an enumeration or
            variables of a list.
        in_outs: VAR_IN_OUT.
        methods: The methods of a block or interface.
        result: The result of a function or method, or the value of a constant.
        used: Whether the program uses the result.
        base: The type of an alias.
        number: The value of a constant. Constants have different values, because they may be labels
            of one CASE.
    """

    name: str
    kind: str
    inputs: dict[str, Pin] = field(default_factory=dict)
    outputs: dict[str, Pin] = field(default_factory=dict)
    in_outs: dict[str, Pin] = field(default_factory=dict)
    methods: dict[str, Stub] = field(default_factory=dict)
    result: Pin = field(default_factory=lambda: Pin(""))
    used: bool = False
    base: str = ""
    number: int = 0

    def input(self, name: str) -> Pin:
        """Return the input of this name; create it if it is missing.

        An output of this name becomes an input.
        """
        key = name.upper()
        if key in self.in_outs:
            return self.in_outs[key]
        if key in self.outputs:
            self.inputs[key] = self.outputs.pop(key)
        return self.inputs.setdefault(key, Pin(name))

    def output(self, name: str) -> Pin:
        """Return the input of this name if there is one; else return or create the output."""
        for known in (self.inputs, self.in_outs):
            if name.upper() in known:
                return known[name.upper()]
        return self.outputs.setdefault(name.upper(), Pin(name))

    def in_out(self, name: str) -> Pin:
        """Return the VAR_IN_OUT of this name; create it if it is missing."""
        self.inputs.pop(name.upper(), None)
        return self.in_outs.setdefault(name.upper(), Pin(name))

    def method(self, name: str) -> Stub:
        """Return the method of this name; create it if it is missing."""
        return self.methods.setdefault(name.upper(), Stub(name, "METHOD"))

    def text(self) -> str:
        """Return the text of the declaration."""
        return "\n".join((*self.lines(), ""))

    def lines(self) -> Iterator[str]:
        """Yield the lines of the declaration, in Structured Text."""
        pins = list(self.outputs.values())
        if self.kind == NAMESPACE:
            yield from (f"NAMESPACE {self.name}", "END_NAMESPACE")
        elif self.kind == ENUM:
            names = ", ".join(pin.name for pin in pins) or f"{self.name}_None"
            yield f"TYPE {self.name} : ({names}); END_TYPE"
        elif self.kind == ALIAS:
            yield f"TYPE {self.name} : {self.base or self.result.type or _UNKNOWN}; END_TYPE"
        elif self.kind == CONSTANT:
            kind = self.result.type
            value = f" := {self.number}" if kind in (*_NUMBERS, *ANY_REAL) else ""
            yield from ("VAR_GLOBAL CONSTANT", f"  {self.name} : {kind}{value};", "END_VAR")
        elif self.kind == STRUCT:
            yield f"TYPE {self.name} : STRUCT"
            yield from (f"  {pin.name} : {pin.type};" for pin in pins or [Pin("Unknown")])
            yield from ("END_STRUCT;", "END_TYPE")
        elif self.kind == LIST:
            yield from ("{attribute 'qualified_only'}", "VAR_GLOBAL")
            yield from (f"  {pin.name} : {pin.type};" for pin in pins or [Pin("Unknown")])
            yield "END_VAR"
        elif self.kind == INTERFACE:
            yield f"INTERFACE {self.name}"
            for pin in pins:
                yield from (f"PROPERTY {pin.name} : {pin.type}", "GET", "END_GET", "END_PROPERTY")
            for pin in self.inputs.values():
                yield f"PROPERTY {pin.name} : {pin.type}"
                yield from ("GET", "END_GET", "SET", "END_SET", "END_PROPERTY")
            yield from (line for one in self.methods.values() for line in one.lines())
            yield "END_INTERFACE"
        else:
            result = f" : {self.result.type}" if self._has_result else ""
            yield f"{self.kind} {self.name}{result}"
            for section, known in (
                ("VAR_INPUT", self._inputs()),
                ("VAR_OUTPUT", self.outputs),
                ("VAR_IN_OUT", self.in_outs),
            ):
                if known:
                    yield section
                    for pin in known.values():
                        kind = pin.input_type if section == "VAR_INPUT" else pin.type
                        yield f"  {pin.name} : {kind};"
                    yield "END_VAR"
            yield from (line for one in self.methods.values() for line in one.lines())
            yield f"END_{self.kind}"

    def _inputs(self) -> dict[str, Pin]:
        """Return the inputs in order of position.

        An input that is known by its position and by its name is listed once.
        """
        named = [replace(p, given=[*p.given]) for k, p in self.inputs.items() if not _number(k)]
        places = {pin.place: pin for pin in named if pin.place}
        waiting = [pin for pin in named if not pin.place]
        numbers = {_number(key): pin for key, pin in self.inputs.items() if _number(key)}
        merged = []
        for place in range(1, max((*places, *numbers), default=0) + 1):
            pin = places.get(place) or (waiting.pop(0) if waiting else numbers.get(place))
            if pin is None and f"P{place}" in self.in_outs:
                continue
            pin = pin or Pin(f"P{place}")
            for kind in numbers[place].given if place in numbers else ():
                pin.note(kind, given=True)
            merged.append(pin)
        return {pin.name.upper(): pin for pin in (*merged, *waiting)}

    @property
    def _has_result(self) -> bool:
        return self.kind in (FUNCTION, "METHOD") and (self.used or self.kind == FUNCTION)
