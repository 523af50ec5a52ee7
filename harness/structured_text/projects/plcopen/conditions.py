"""Diagrams in a chart of PLCopen XML: actions and conditions in LD and FBD.

The value of a condition is assigned to a variable before the transitions are evaluated. Blocks of
conditions, also functions that are drawn as blocks, are executed as Beremiz does it: in an action
that is always active, after the evaluation of the transitions. The conditions use their outputs of
the last scan.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.check import inputs_of, wrong
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Contact,
    Diagram,
    Element,
    Input,
    InVariable,
    OutVariable,
)
from structured_text.projects.diagrams.sfc.check import ChartError
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.model import Lines, made, without_comments
from structured_text.projects.plcopen.networks import read_diagram
from structured_text.projects.xml import Element as Xml

__all__ = ["Diagrams", "statements_of"]

_OPENS = re.compile(r"\b(?:IF|WHILE)\b", re.IGNORECASE)
_CLOSES = re.compile(r"\b(?:END_IF|END_WHILE)\b", re.IGNORECASE)


class Diagrams:
    """The diagrams of a chart, and their translations.

    Attributes:
        section: The variables of conditions.
        before: The statements that compute the conditions.
        blocks: The statements that execute the blocks of conditions.
    """

    def __init__(
        self,
        chart: Xml,
        dialect: str,
        sorting: str,
        names: Names,
        translate: Callable[[Diagram], Lines],
    ) -> None:
        self._chart, self._names = chart, names
        self._dialect, self._sorting = dialect, sorting
        self._translate = translate
        self._count = 0
        self._ends: dict[str, Xml] = {}
        self._results: dict[str, str] = {}
        self.section: list[Line] = []
        self.before: list[Line] = []
        self.blocks: list[Line] = []

    def statements(self, body: Xml) -> Lines:
        """Return the statements of an action in LD or FBD."""
        return self._translate(read_diagram(body, self._dialect, self._sorting))

    def read(self, body: Xml) -> Diagram:
        """Return the diagram of an `<LD>` or `<FBD>`."""
        return read_diagram(body, self._dialect, self._sorting)

    def connected(self, transition: Xml, condition: Xml) -> str:
        """Return the variable of a condition to which networks of the chart are connected."""
        variable = self._variable(condition.at)
        # An output stands for the transition, so that its lines are read like all others.
        text = Xml("expression", {}, condition.at, [Line(variable, condition.at)])
        points = [*transition.all("position"), *condition.all("connectionPointIn"), text]
        self._ends[variable] = Xml("outVariable", {"localId": variable}, condition.at, [*points])
        return variable

    def finish(self) -> None:
        """Translate the networks of all connected conditions, which may share blocks."""
        if not self._ends:
            return
        chart = replace(self._chart, content=[*self._chart.content, *self._ends.values()])
        whole = read_diagram(chart, self._dialect, self._sorting)
        known = {one.id: one for one in whole.elements}
        used = {one.id for name in self._ends for one in _needed(known[name], known)}
        elements = tuple(one for one in whole.elements if one.id in used)
        numbers = {one.network for one in elements}
        networks = tuple(one for one in whole.networks if one.number in numbers)
        self._compute(replace(whole, networks=networks, elements=elements), *self._ends)

    def result(self, diagram: Diagram, name: str, at: int) -> str:
        """Return the variable of a transition that is assigned in its own diagram."""
        if name.upper() in self._results:
            return self._results[name.upper()]
        variable = self._variable(at)
        self._results[name.upper()] = variable
        elements: list[Element] = []
        for one in diagram.elements:
            if isinstance(one, OutVariable) and one.expression.upper() == name.upper():
                elements.append(replace(one, expression=variable))
            elif isinstance(one, Coil) and one.variable.upper() == name.upper():
                elements.append(replace(one, variable=variable))
            else:
                elements.append(one)
        if tuple(elements) == diagram.elements:
            text = f"the transition {name} is in {diagram.language}, and nothing assigns {name}"
            raise ChartError(text, at, f"end it with a coil or variable {name}")
        self._compute(replace(diagram, elements=tuple(elements)), variable)
        return variable

    def _variable(self, at: int, word: str = "Condition") -> str:
        self._count += 1
        variable = self._names.of(word, str(self._count))
        self.section += made(at, "  VAR", f"    {variable} : BOOL;", "  END_VAR")
        return variable

    def _compute(self, diagram: Diagram, *variables: str) -> None:
        if not diagram.by_position:
            lines = self._translate(diagram)
            _check_memory(diagram)
            self.before += lines
            return
        lines = self._translate(self._stored(diagram, variables))
        own = re.compile(rf"\b({'|'.join(variables)})\s*:=")
        for statement in statements_of(lines):
            is_condition = own.search("\n".join(line.text for line in statement))
            (self.before if is_condition else self.blocks).extend(statement)

    def _stored(self, diagram: Diagram, variables: Sequence[str]) -> Diagram:
        """Return a diagram in which conditions read the results of functions from variables.

        Another output assigns such a variable, so that the function is executed with the blocks.
        """
        known = {one.id: one for one in diagram.elements}
        made: dict[Connection, tuple[Element, Element]] = {}
        changed: dict[str, Element] = {}
        waiting = [one for one in diagram.elements if _written(one) in variables]
        for one in waiting:  # grows
            if not isinstance(one, (Contact, Coil, OutVariable)) or one.id in changed:
                continue
            lines = []
            for line in one.input.connections:
                source = known.get(line.source)
                if isinstance(source, Block):
                    if not source.instance and line not in made:
                        made[line] = self._store(source, line, one)
                    lines.append(Connection(made[line][1].id) if line in made else line)
                else:
                    lines.append(line)
                    waiting += [source] if source is not None else []
            changed[one.id] = replace(one, input=replace(one.input, connections=tuple(lines)))
        own = [changed.get(one.id, one) for one in diagram.elements]
        added = [element for pair in made.values() for element in pair]
        return replace(diagram, elements=(*added, *own))

    def _store(self, block: Block, line: Connection, end: Element) -> tuple[Element, Element]:
        """Return the output that stores the result of a function, and the input that reads it."""
        variable = self._variable(block.at, "Result")
        given = Input(connections=(line,))
        stores = OutVariable(
            f"{variable} :=",
            block.network,
            position=end.position,
            at=block.at,
            expression=variable,
            input=given,
        )
        return stores, InVariable(variable, block.network, at=block.at, expression=variable)


def _written(element: Element) -> str:
    """Return the variable that an element writes; empty for other elements."""
    if isinstance(element, OutVariable):
        return element.expression
    return element.variable if isinstance(element, Coil) else ""


def statements_of(lines: Lines) -> Iterator[Lines]:
    """Yield the lines of each statement, without comments between statements."""
    plain = without_comments("\n".join(line.text for line in lines)).split("\n")
    found: list[Line] = []
    depth = 0
    for line, text in zip(lines, plain, strict=True):
        if not found and not text.strip():
            continue
        found.append(line)
        depth += len(_OPENS.findall(text)) - len(_CLOSES.findall(text))
        if depth == 0 and text.rstrip().endswith(";"):
            yield tuple(found)
            found = []
    if found:
        yield tuple(found)


def _needed(end: Element, known: dict[str, Element]) -> Iterator[Element]:
    """Yield an element and the elements that lead to it."""
    yield end
    waiting: list[Element] = [end]
    seen = {end.id}
    while waiting:
        for pin in inputs_of(waiting.pop()):
            for line in pin.connections:
                if line.source in known and line.source not in seen:
                    seen.add(line.source)
                    waiting.append(known[line.source])
                    yield known[line.source]


def _check_memory(diagram: Diagram) -> None:
    """Raise DiagramError if a condition has a memory; CODESYS evaluates it only at its step."""
    for one in diagram.elements:
        edges = [pin.edge for pin in inputs_of(one)]
        edges += [one.edge] if isinstance(one, Contact | Coil | OutVariable) else []
        if any(edges) or (isinstance(one, Block) and one.instance):
            text = "a condition with a block or an edge is not supported"
            raise wrong(one, text, "call the block in an action, and use its output here")
