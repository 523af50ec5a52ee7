"""Diagrams and charts of a project, which are translated when all its declarations are known.

The translation of a diagram needs the types of variables and the pins of blocks, which other files
of the project may declare.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.check import DiagramError, inputs_of, wrong
from structured_text.projects.diagrams.networks.model import Coil, Contact, Diagram, OutVariable
from structured_text.projects.diagrams.networks.translate import translate
from structured_text.projects.diagrams.networks.types import Declarations, Types
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.diagrams.sfc.translate import translate as translate_chart
from structured_text.projects.model import Foreign, Lines, Piece, Project, Unit, trimmed
from structured_text.projects.plcopen.charts import read_chart
from structured_text.projects.plcopen.conditions import Diagrams
from structured_text.projects.plcopen.networks import Drawn, read_diagram
from structured_text.projects.plcopen.sortings import order_note
from structured_text.projects.xml import Element

__all__ = ["Charted", "drawn", "text_of", "translated"]


@dataclass(frozen=True)
class Charted(Foreign):
    """A chart before its translation.

    Attributes:
        chart: The `<SFC>`.
        transitions: The bodies of the transitions that the POU declares, by name in upper case.
        dialect: The dialect of the tool that has written the file; empty if it is unknown.
        sorting: How elements of its diagrams are ordered.
    """

    chart: Element = field(default_factory=lambda: Element("SFC", {}, 1))
    transitions: Mapping[str, Lines | Foreign] = field(default_factory=dict)
    dialect: str = ""
    sorting: str = "file"


def text_of(element: Element) -> Lines:
    """Return the text of an element, which is inside one or more elements of XHTML."""
    parts = element.children or [element]
    return trimmed(line for part in parts for line in part.lines())


def drawn(body: Element, dialect: str, sorting: str) -> Foreign:
    """Return the body of an `<LD>` or `<FBD>`: a `Drawn`, or the reason why it is not read."""
    try:
        return Drawn(body.name, body.at, "", read_diagram(body, dialect, sorting))
    except DiagramError as error:
        return _reason(body.name, error)


def _reason(language: str, error: DiagramError) -> Foreign:
    hint = f" ({error.hint})" if error.hint else ""
    return Foreign(language, error.at, f"{error.message}{hint}")


def translated(project: Project, known: Iterable[Unit]) -> Project:
    """Return the project with translations of its diagrams and charts, and notes about them.

    `known` has all declarations that a diagram may use.
    """
    waiting = [
        unit for unit in project.units if any(_waits(body) for _, body in unit.piece.foreign())
    ]
    if not waiting:
        return project
    declared = Declarations(known)
    units: list[Unit] = []
    notes = list(project.notes)
    for unit in project.units:
        if unit in waiting:
            made = _Translation(unit, declared)
            unit = replace(unit, piece=made.piece())
            notes += made.notes
        units.append(unit)
    return replace(project, units=tuple(units), notes=tuple(notes))


def _waits(body: Foreign) -> bool:
    return isinstance(body, Drawn | Charted)


class _Translation:
    """The translation of the bodies of a POU."""

    def __init__(self, unit: Unit, declared: Declarations) -> None:
        self._unit, self._declared = unit, declared
        self._piece = unit.piece
        self._sections: list[Line] = []
        self.notes: list[str] = []

    def piece(self) -> Piece:
        parts = tuple(self._part(part) for part in self._piece.parts)
        self._piece = replace(self._piece, parts=parts)
        body = self._piece.body
        diagram = body.diagram if isinstance(body, Drawn) else None
        if isinstance(body, Drawn):
            function = self._unit.kind == "FUNCTION"
            body = self._body(body, self._piece, self._piece.head, function, self._sections)
        elif isinstance(body, Charted):
            body = self._chart(body)
        head = (*self._piece.head, *self._sections)
        return replace(self._piece, head=head, body=body, diagram=diagram)

    def _part(self, part: Piece) -> Piece:
        """Return a method, property or action; the variables of an action are in its POU."""
        parts = tuple(self._part(one) for one in part.parts)
        if not isinstance(part.body, Drawn):
            return replace(part, parts=parts)
        own: list[Line] = []
        sections = self._sections if part.is_action else own
        head = self._piece.head if part.is_action else (*self._piece.head, *part.head)
        body = self._body(part.body, part, head, not part.is_action, sections)
        head = (*part.head, *own)
        return replace(part, head=head, body=body, parts=parts, diagram=part.body.diagram)

    def _body(
        self, body: Drawn, piece: Piece, head: Lines, forgets: bool, sections: list[Line]
    ) -> Lines | Foreign:
        """Return the statements of a diagram, and add its variables to the sections."""
        try:
            if forgets:
                _check_edges(body.diagram)
            note = self._note(body.diagram, head, sections)
            lines = self._translated(body.diagram, head, sections)
        except DiagramError as error:
            return _reason(body.language, error)
        if note:
            self.notes.append(f"{self._unit.file}:{body.at}: {piece.name}: {note}")
        return lines

    def _note(self, diagram: Diagram, head: Lines, sections: list[Line]) -> str:
        """Return a note if the version of the editor matters for the diagram."""

        def types(section: Lines) -> Types:
            return self._declared.types(self._piece.name, (*head, *section))

        def made(other: Diagram) -> tuple[Lines, Lines]:
            return translate(other, Names(self._words(other, sections)), types(()))

        return order_note(diagram, made, types)

    def _translated(self, diagram: Diagram, head: Lines, sections: list[Line]) -> Lines:
        types = self._declared.types(self._piece.name, head)
        section, lines = translate(diagram, Names(self._words(diagram, sections)), types)
        sections += section
        return lines

    def _statements(self, diagram: Diagram) -> Lines:
        """Return the statements of a diagram in the chart of the POU."""
        return self._translated(diagram, self._piece.head, self._sections)

    def _words(self, diagram: object, sections: Iterable[Line]) -> str:
        """Return a text with all words that a new variable must not have as its name."""
        lines = [*self._piece.lines(), *self._sections, *sections]
        return "\n".join((*(line.text for line in lines), repr(diagram)))

    def _chart(self, body: Charted) -> Lines | Foreign:
        """Return the statements of a chart; actions of the chart are no longer parts of the POU."""
        parts = {part.name.rpartition(".")[2].upper(): part for part in self._piece.parts}
        actions = {name: part.body for name, part in parts.items() if part.is_action}
        text = "\n".join(line.text for part in body.chart.children for line in part.lines())
        words = f"{text}\n{self._words(body.transitions, ())}"
        diagrams = Diagrams(body.chart, body.dialect, body.sorting, Names(words), self._statements)
        chart = read_chart(body.chart, actions, body.transitions, text_of, diagrams)
        if isinstance(chart, Foreign):
            return chart
        self._sections += diagrams.section
        names = Names("\n".join((words, *(line.text for line in self._sections))))
        # matiec, with which Beremiz and OpenPLC compile, has no final scan of actions.
        section, lines = translate_chart(chart, names, final_scan=body.dialect != "openplc")
        used = {one.name.upper() for one in chart.actions}
        left = tuple(part for name, part in parts.items() if not (part.is_action and name in used))
        self._piece = replace(self._piece, parts=left)
        self._sections += section
        return lines


def _check_edges(diagram: Diagram) -> None:
    """Raise DiagramError for an edge in a function or method, which has no memory."""
    for element in diagram.elements:
        edges: list[str] = [pin.edge for pin in inputs_of(element)]
        if isinstance(element, Contact | Coil | OutVariable):
            edges.append(element.edge)
        if any(edges):
            text = "an edge needs a memory, which a function or method does not have"
            raise wrong(element, text, "use a function block")
