"""Ladder Diagrams and Function Block Diagrams of PLCopen XML.

The file is a flat list of elements. There are two forms:

- Beremiz, OpenPLC Editor and others write the positions of the elements. The networks are the
  connected parts of the drawing, from the top to the bottom.
- CODESYS, TwinCAT and tools that are derived from CODESYS write no positions. In ladder, all
  networks share the left rail, and an element of the tool with the title opens each network. In
  FBD, the number of an element contains the number of its network. A box of an operator has pins
  with the names In1, In2 and Out1, or In2, In3 and Out2 behind EN and ENO.

Source: PLCopen TC6 XML 2.01, chapters 5 and 6; exports of the tools.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TypeVar

from structured_text.projects.diagrams.networks.check import DiagramError, wrong
from structured_text.projects.diagrams.networks.model import (
    EDGES,
    STORAGES,
    Block,
    Coil,
    Connection,
    Connector,
    Contact,
    Continuation,
    Diagram,
    Element,
    Input,
    InVariable,
    Jump,
    Output,
    OutVariable,
    Position,
    Rail,
    Return,
)
from structured_text.projects.model import Foreign
from structured_text.projects.plcopen.branches import Branch, with_bypasses, with_power
from structured_text.projects.plcopen.numbering import Note, numbered
from structured_text.projects.xml import Element as Xml

__all__ = ["DRAWN", "Drawn", "read_diagram"]

#: Languages that are read here.
DRAWN = ("LD", "FBD")
#: Dialects of the tools that write no positions.
_UNPLACED = ("codesys", "twincat")
#: Data that these tools add; a derived tool may have another address before the last word.
_MARKS = ("fbdelementtype", "implementationattributes", "fbdcalltype", "ldparallelbranch")
#: What CODESYS writes for a pin without a variable.
_UNSET = "???"
#: Objects of charts among the objects of a network.
_OF_CHARTS = (
    *("step", "macroStep", "jumpStep", "transition", "actionBlock"),
    *("selectionDivergence", "selectionConvergence"),
    *("simultaneousDivergence", "simultaneousConvergence"),
)


@dataclass(frozen=True)
class Drawn(Foreign):
    """A body in LD or FBD before its translation."""

    diagram: Diagram = field(default_factory=lambda: Diagram("LD"))


def read_diagram(body: Xml, file_dialect: str, sorting: str = "file") -> Diagram:
    """Return the diagram of an `<LD>` or `<FBD>`, or of the networks of an `<SFC>`.

    `file_dialect` is the dialect of the tool that has written the file; empty if it is unknown.
    `sorting` is how elements without a number are ordered if the file has their positions.

    Raises:
        DiagramError: The diagram has a part that is not supported.
    """
    return replace(_Reader(body, file_dialect).diagram(), sorting=sorting)


class _Reader:
    def __init__(self, body: Xml, dialect: str) -> None:
        self._body, self._dialect = body, dialect
        self._objects = [one for one in body.children if one.get("localId")]
        marks = [mark for one in self._objects for mark in _data(one, *_MARKS)]
        self._unplaced = dialect in _UNPLACED or bool(marks)
        self._branches: list[Branch] = []

    def diagram(self) -> Diagram:
        elements: list[Element] = []
        notes: list[Note] = []
        seen: dict[str, int] = {}
        for one in self._objects:
            if self._body.name == "SFC" and one.name in _OF_CHARTS:
                continue
            name = one.get("localId")
            if seen.setdefault(name, one.at) != one.at:
                text = f"two elements have the number {name}"
                raise DiagramError(text, one.at, "export the project again from its tool")
            if one.name in ("comment", "label", "vendorElement"):
                notes += (replace(note, before=len(elements)) for note in self._note(one))
            elif one.name != "rightPowerRail":  # it has no effect
                elements.append(self._element(one))
        language = self._body.name
        if language not in DRAWN:
            ladder = any(isinstance(one, Rail | Contact | Coil) for one in elements)
            language = "LD" if ladder else "FBD"
        placed = any(one.position != Position() for one in elements) and not self._unplaced
        networks, made = numbered(elements, notes, placed=placed)
        known = {one.id: one for one in made}
        made = [self._resolved(one, known) for one in made]
        if self._unplaced:
            made = with_power(with_bypasses(made, self._branches))
        return Diagram(language, networks, tuple(made), by_position=placed)

    # --- what is no element ---

    def _note(self, one: Xml) -> Iterator[Note]:
        """Yield the comment, label or title of an object; remember a parallel branch."""
        kind, text = one.name, ""
        if kind == "comment":
            text = "\n".join(line.text.strip() for line in one.lines()).strip()
        elif kind == "label":
            text = one.get("label")
        else:
            parallel = next((data for data in _data(one, "ldparallelbranch")), None)
            if parallel is not None:
                self._branches.append(self._branch(one, parallel))
                return
            types = [word.text() for data in _data(one, "fbdelementtype") for word in data.children]
            if any(word != "networktitle" for word in types):
                text = f"the element {types[0]} of the tool is not supported"
                raise DiagramError(text, one.at, "remove it, or write the body in Structured Text")
            if not types:
                return
            kind = "title"
            text = " ".join(
                line for part in one.all("alternativeText") for line in part.text().split()
            )
        corner, size = _position(one), Position(_number(one, "width"), _number(one, "height"))
        yield Note(kind, text, one.get("localId"), corner, size, one.at)

    def _branch(self, one: Xml, data: Xml) -> Branch:
        def lines(element: Xml) -> tuple[Connection, ...]:
            return tuple(
                Connection(found.get("refLocalId"), found.get("formalParameter"))
                for found in element.below("connection")
            )

        starts = tuple(line for found in data.below("BranchInput") for line in lines(found))
        ends = tuple(lines(tree) for tree in data.below("Tree"))
        short = any(found.get("mode") == "sce" for found in data.below("ParallelBranch"))
        return Branch(one.get("localId"), starts, ends, short)

    # --- elements ---

    def _element(self, one: Xml) -> Element:
        order = one.get("executionOrderId")
        number = int(order) if order.isdecimal() and len(order) < 10 else 0
        try:
            made = self._made(one)
        except DiagramError as error:  # the number of the network is not known yet
            text = f"element {one.get('localId')}: {error.message}"
            raise DiagramError(text, error.at, error.hint) from None
        return replace(made, order=number, position=_position(one), at=one.at)

    def _made(self, one: Xml) -> Element:
        name = one.get("localId")
        if one.name == "leftPowerRail":
            return Rail(name)
        if one.name == "contact":
            return self._contact(one)
        if one.name == "coil":
            return self._coil(one)
        if one.name == "inVariable":
            return InVariable(name, expression=_expression([one]), negated=_is_true(one, "negated"))
        if one.name in ("outVariable", "inOutVariable"):
            return self._out_variable(one)
        if one.name == "block":
            return self._block(one)
        if one.name == "connector":
            return Connector(name, name=one.get("name"), input=self._input(one))
        if one.name == "continuation":
            return Continuation(name, name=one.get("name"))
        if one.name == "jump":
            return Jump(name, label=one.get("label"), input=self._exit(one))
        if one.name == "return":
            return Return(name, input=self._exit(one))
        text = f"the element <{one.name}> is not supported"
        raise DiagramError(text, one.at, "write this part in Structured Text")

    def _contact(self, one: Xml) -> Contact:
        variable = self._text(one, "variable", "a contact")
        if _word(one, "storage", STORAGES):
            text = f"the contact {variable} sets or resets"
            raise DiagramError(text, one.at, "only a coil can do this")
        edge = _word(one, "edge", EDGES)
        return Contact(
            one.get("localId"),
            variable=variable,
            input=self._input(one),
            negated=_is_true(one, "negated"),
            edge=edge,
        )

    def _coil(self, one: Xml) -> Coil:
        return Coil(
            one.get("localId"),
            variable=self._text(one, "variable", "a coil"),
            input=self._input(one),
            negated=_is_true(one, "negated"),
            edge=_word(one, "edge", EDGES),
            storage=_word(one, "storage", STORAGES),
        )

    def _out_variable(self, one: Xml) -> OutVariable:
        return OutVariable(
            one.get("localId"),
            expression=self._text(one, "expression", "a variable at the end of a line"),
            input=self._input(one),
            negated=_is_true(one, "negated") or _is_true(one, "negatedIn"),
            edge=_word(one, "edge", EDGES),
            storage=_word(one, "storage", STORAGES),
            read=one.name == "inOutVariable",
        )

    def _text(self, one: Xml, part: str, what: str) -> str:
        found = "\n".join(element.text() for element in one.all(part)).strip()
        if not found or found == _UNSET:
            raise DiagramError(f"{what} has no variable", one.at, "write a variable at it")
        return found

    def _input(self, one: Xml) -> Input:
        """Return the only input of an element."""
        points = one.all("connectionPointIn")
        lines = tuple(line for point in points for line in self._lines(point))
        return Input(connections=lines, value=_expression(points))

    def _exit(self, one: Xml) -> Input:
        """Return the input of a jump or return; without a line it is always done in CODESYS."""
        found = replace(self._input(one), negated=_is_true(one, "negated"))
        if self._unplaced and not found.connections and not found.value:
            return replace(found, value="TRUE")
        return found

    def _lines(self, point: Xml) -> Iterator[Connection]:
        for line in point.all("connection"):
            yield Connection(line.get("refLocalId"), line.get("formalParameter"))

    def _block(self, one: Xml) -> Block:
        kind = one.get("typeName")
        if not kind:
            raise DiagramError("a block has no type", one.at, "name its function or block")
        call = next((data.text() for data in _data(one, "fbdcalltype")), "").lower()
        inputs = [self._pin(pin, kind) for pin in one.all("inputVariables", "variable")]
        inputs += [self._pin(pin, kind, True) for pin in one.all("inOutVariables", "variable")]
        outputs = [_output(pin) for pin in one.all("outputVariables", "variable")]
        if call == "operator":
            inputs = _by_place(inputs, "EN", "IN")
            outputs = _by_place(outputs, "ENO", "OUT")
        statements: tuple[str, ...] = ()
        if call == "execute":
            code = [line for data in _data(one, "stcode") for line in data.lines()]
            statements = tuple(line.text.rstrip() for line in code) or (";",)
        instance = one.get("instanceName").strip()
        if call == "functionblock" and instance in ("", _UNSET):
            text = f"a block {kind} has no instance"
            raise DiagramError(text, one.at, "write the name of a variable above it")
        return Block(
            one.get("localId"),
            type=kind,
            instance=instance,
            inputs=tuple(inputs),
            outputs=tuple(outputs),
            statements=statements,
        )

    def _pin(self, pin: Xml, kind: str, in_out: bool = False) -> Input:
        name = pin.get("formalParameter")
        if _word(pin, "storage", STORAGES):
            text = f"the input {name} of {kind} sets or resets"
            raise DiagramError(text, pin.at, "only an output can do this")
        return replace(
            self._input(pin),
            name=name,
            negated=_is_true(pin, "negated"),
            edge=_word(pin, "edge", EDGES),
            in_out=in_out,
        )

    # --- connections ---

    def _resolved(self, element: Element, known: dict[str, Element]) -> Element:
        """Return an element whose connections name elements and existing pins."""
        ends = {branch.id: branch.ends for branch in self._branches}

        def input_of(given: Input, where: str) -> Input:
            lines: list[Connection] = []
            for line in given.connections:
                # A line from a parallel branch comes from the ends of its lines.
                for real in (end for tree in ends.get(line.source, ((line,),)) for end in tree):
                    found = self._source(real, known, element, where)
                    lines += [found] if found is not None and found not in lines else []
            return replace(given, connections=tuple(lines))

        if isinstance(element, Block):
            pins = (input_of(one, f"{one.name} of {element.type}") for one in element.inputs)
            return replace(element, inputs=tuple(pins))
        if isinstance(element, Rail | InVariable | Continuation):
            return element
        return replace(element, input=input_of(element.input, f"of a {_what(element)}"))

    def _source(
        self, line: Connection, known: dict[str, Element], element: Element, where: str
    ) -> Connection | None:
        source = known.get(line.source)
        if source is None:
            if not self._unplaced:
                return None  # Beremiz itself takes such an input as not connected
            text = f"the input {where} is connected to element {line.source}, which does not exist"
            raise wrong(element, text, "connect it again")
        if isinstance(source, InVariable) and source.expression in ("", _UNSET):
            if source.expression:
                text = f"the input {where} has no value"
                raise wrong(source, text, "write a value at it")
            return None  # CODESYS writes an empty variable for an input that is left out
        if not isinstance(source, Block):
            return Connection(source.id)
        pins = [one.name for one in source.outputs]
        pins += [one.name for one in source.inputs if one.in_out]
        for name in pins:
            if line.pin.upper() == name.upper():
                return Connection(source.id, name)
        values = [name for name in pins if name.upper() != "ENO"]
        # CODESYS writes other names for the output of an operator, and for its only output.
        if len(values) == 1:
            return Connection(source.id, values[0])
        text = f"the input {where} is connected to {source.type}, which has no output {line.pin}"
        raise wrong(element, text, "connect it again")


def _what(element: Element) -> str:
    return type(element).__name__.lower()


def _output(pin: Xml) -> Output:
    target = _expression(pin.all("connectionPointOut"))
    return Output(
        pin.get("formalParameter"),
        "" if target == _UNSET else target,
        negated=_is_true(pin, "negated"),
        storage=_word(pin, "storage", STORAGES),
    )


_Pin = TypeVar("_Pin", Input, Output)


def _by_place(pins: list[_Pin], enable: str, name: str) -> list[_Pin]:
    """Return the pins of an operator with the names that the standard has for their places."""
    others = [pin for pin in pins if pin.name.upper() != enable]
    made, number = [], 0
    for pin in pins:
        if pin.name.upper() != enable:
            number += 1
            pin = replace(pin, name=f"{name}{number}" if len(others) > 1 else name)
        made.append(pin)
    return made


def _expression(points: list[Xml]) -> str:
    return "\n".join(one.text() for point in points for one in point.all("expression")).strip()


def _data(one: Xml, *names: str) -> Iterator[Xml]:
    """Yield the data of a tool with one of these names as the last word of its address."""
    for data in one.all("addData", "data"):
        if data.get("name").rpartition("/")[2] in names:
            yield data


def _position(one: Xml) -> Position:
    found = one.first("position")
    if found is None:
        return Position()
    return Position(_number(found, "x"), _number(found, "y"))


def _number(one: Xml, name: str) -> float:
    try:
        return float(one.get(name, "0"))
    except ValueError:
        return 0.0


def _is_true(one: Xml, name: str) -> bool:
    return one.get(name).lower() in ("true", "1")


def _word(one: Xml, name: str, words: tuple[str, ...]) -> str:
    """Return an attribute that is one of the words; empty for `none`."""
    found = one.get(name).lower()
    if found == "none":
        return ""
    if found not in words:
        text = f"{found!r} is not a value of {name}"
        raise DiagramError(text, one.at, f"it can be {', '.join(word for word in words if word)}")
    return found
