"""Diagrams that tests draw in Python, and their translations on the engines.

A source of a value is the `id` of an element, `id.PIN` for an output of a block, or several of them
separated by blanks for parallel lines.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.language.load import load
from structured_text.projects.diagrams.networks.model import (
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
    Network,
    Output,
    OutVariable,
    Position,
    Rail,
    Return,
)
from structured_text.projects.diagrams.networks.translate import translate
from structured_text.projects.diagrams.networks.types import Declarations
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.model import Lines, Piece, Unit, made

__all__ = ["Drawing", "lines_from", "matiec_rows", "rows_of", "scanned"]


def lines_from(sources: str) -> tuple[Connection, ...]:
    """Return the connections to some sources."""
    return tuple(Connection(*one.split(".", 1)) for one in sources.split())


@dataclass
class Drawing:
    """A diagram of a program `Main`, and other declarations beside it."""

    variables: str
    others: str = ""
    by_position: bool = True
    sorting: str = "position"
    language: str = "LD"
    networks: list[Network] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Draw the power rail, which has the `id` 0."""
        self.elements.append(Rail("0", 0))

    def network(self, title: str = "", comment: str = "", label: str = "") -> None:
        """Begin a network."""
        number = len(self.networks) + 1
        self.networks.append(Network(number, title, comment, label, 100 * number))

    def add(self, element: Element) -> str:
        """Add an element to the network and return its `id`; it stands below the others."""
        if not self.networks:
            self.network()
        number = len(self.elements)
        place = element.position
        if place == Position():
            place = Position(0, 20 * number)
        element = replace(
            element,
            id=element.id or str(number),
            network=len(self.networks),
            position=place,
            at=100 * len(self.networks) + number,
        )
        self.elements.append(element)
        return element.id

    def contact(self, variable: str, source: str = "0", **more: Any) -> str:
        """Add a contact."""
        return self.add(Contact("", variable=variable, input=Input("", lines_from(source)), **more))

    def coil(self, variable: str, source: str = "0", **more: Any) -> str:
        """Add a coil."""
        return self.add(Coil("", variable=variable, input=Input("", lines_from(source)), **more))

    def read(self, expression: str) -> str:
        """Add a variable that is read."""
        return self.add(InVariable("", expression=expression))

    def write(self, expression: str, source: str, **more: Any) -> str:
        """Add a variable that is written."""
        pin = Input("", lines_from(source))
        return self.add(OutVariable("", expression=expression, input=pin, **more))

    def jump(self, label: str, source: str = "0") -> str:
        """Add a jump to a label."""
        return self.add(Jump("", label=label, input=Input("", lines_from(source))))

    def leave(self, source: str = "0") -> str:
        """Add a return."""
        return self.add(Return("", input=Input("", lines_from(source))))

    def connector(self, name: str, source: str) -> str:
        """Add a connector."""
        return self.add(Connector("", name=name, input=Input("", lines_from(source))))

    def continued(self, name: str) -> str:
        """Add a continuation."""
        return self.add(Continuation("", name=name))

    def block(
        self,
        kind: str,
        inputs: Mapping[str, str | Input],
        outputs: Iterable[str | Output] = ("OUT",),
        instance: str = "",
        **more: Any,
    ) -> str:
        """Add a block; an input is a source, or `=` and a value at the pin."""
        pins = []
        for name, given in inputs.items():
            if isinstance(given, Input):
                pins.append(replace(given, name=name))
            elif given.startswith("="):
                pins.append(Input(name, value=given[1:]))
            else:
                pins.append(Input(name, lines_from(given)))
        outs = tuple(one if isinstance(one, Output) else Output(one) for one in outputs)
        return self.add(
            Block("", type=kind, instance=instance, inputs=tuple(pins), outputs=outs, **more)
        )

    def diagram(self) -> Diagram:
        """Return the diagram."""
        return Diagram(
            self.language,
            tuple(self.networks),
            tuple(self.elements),
            self.by_position,
            self.sorting,
        )

    def translated(self) -> tuple[Lines, Lines]:
        """Return the added section and the statements."""
        head = made(1, "PROGRAM Main", f"VAR {self.variables} END_VAR")
        units = [_unit(text) for text in self.others.split("END_POU") if text.strip()]
        units.append(Unit("PROGRAM", Piece("Main", head), Path("plc.xml")))
        types = Declarations(units).types("Main", head)
        return translate(self.diagram(), Names(self.variables + self.others), types)

    def text(self) -> list[str]:
        """Return the statements as text."""
        return [line.text for line in self.translated()[1]]

    def source(self, folder: Path) -> Path:
        """Write the program with its translation and return the file."""
        section, body = self.translated()
        file = folder / "main.st"
        lines = [f"PROGRAM Main VAR {self.variables} END_VAR"]
        lines += [line.text for line in (*section, *body)]
        others = self.others.replace("END_POU", "\n")
        file.write_text("\n".join((others, *lines, "END_PROGRAM\n")))
        return file


def _unit(text: str) -> Unit:
    words = text.split()
    kind = words[0]
    lines = made(1, *text.strip().splitlines())
    return Unit(kind, Piece(words[1].rstrip(":"), lines), Path("plc.xml"))


Row = Mapping[str, Any]


def rows_of(
    program: BuiltinProgram | MatiecProgram, given: Sequence[Row], shown: Sequence[str]
) -> list[tuple[Any, ...]]:
    """Return the values of variables behind each scan of 10 ms."""
    found = []
    for scan, row in enumerate(given):
        for name, value in row.items():
            program.write(f"Main.{name}", value)
        program.scan(scan * 10_000)
        found.append(tuple(program.read(f"Main.{name}") for name in shown))
    return found


def scanned(
    drawing: Drawing, folder: Path, given: Sequence[Row], shown: str
) -> list[tuple[Any, ...]]:
    """Return the values of variables behind each scan on the built-in engine."""
    program = BuiltinProgram.build(load([drawing.source(folder)]))
    return rows_of(program, given, shown.split())


def matiec_rows(
    drawing: Drawing, folder: Path, given: Sequence[Row], shown: str, matiec: Matiec
) -> list[tuple[Any, ...]]:
    """Return the values of variables behind each scan on matiec."""
    compiler = find_c_compiler()
    assert compiler is not None
    program = MatiecProgram.build(load([drawing.source(folder)]), matiec, compiler)
    try:
        return rows_of(program, given, shown.split())
    finally:
        program.close()
