"""The translation of a diagram to statements of Structured Text.

A block is executed when its value is used for the first time, and before that its inputs. It is
marked as executed before its inputs are computed, so that a feedback reads the value of the last
scan. If the order is by position, contacts and variables are read by each statement that uses them;
otherwise a contact is read once, at its place.

Source: IEC 61131-3, 4.1 to 4.3; for the order by position the generator of Beremiz
(PLCGenerator.py: GenerateBlock, GeneratePaths, GetUsedEno).
"""

from __future__ import annotations

from collections.abc import Sequence

from structured_text.projects.diagrams.networks.calls import Blocks
from structured_text.projects.diagrams.networks.check import (
    DiagramError,
    check,
    named,
    wrong,
)
from structured_text.projects.diagrams.networks.expressions import (
    FALSE,
    TRUE,
    Expression,
    Text,
    alternatives,
    inverted,
    joined,
)
from structured_text.projects.diagrams.networks.flow import arranged
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
    OutVariable,
    Rail,
    Return,
)
from structured_text.projects.diagrams.networks.order import Graph, executed
from structured_text.projects.diagrams.networks.statements import Statements
from structured_text.projects.diagrams.networks.types import Types
from structured_text.projects.diagrams.sfc.names import Names
from structured_text.projects.model import Lines, made

__all__ = ["translate"]

#: The number of blocks on a line that may read the same connector.
_DEEPEST = 40


def translate(diagram: Diagram, names: Names, types: Types) -> tuple[Lines, Lines]:
    """Return the section with the variables that a diagram needs, and its statements.

    The section is empty if no variable is needed. Raise DiagramError if the diagram is wrong.
    """
    check(diagram)
    made_by = _Translation(diagram, names, types)
    try:
        made_by.run()
    except RecursionError:
        text = "too many elements follow one another in a line"
        hint = "divide the line, with a variable between its parts"
        raise DiagramError(text, min((n.at for n in diagram.networks), default=1), hint) from None
    made_by.statements.check_types()
    lines = arranged(diagram, made_by.statements)
    variables = made_by.statements.variables
    if not variables:
        return (), lines
    at = min((network.at for network in diagram.networks), default=1)
    texts = (f"    {name} : {declared};" for name, declared in variables.items())
    return made(at, "  VAR", *texts, "  END_VAR"), lines


class _Translation:
    def __init__(self, diagram: Diagram, names: Names, types: Types) -> None:
        self._diagram, self._types = diagram, types
        self._graph = Graph(diagram, contacts=diagram.by_position)
        self.statements = Statements(names, types, self._graph.user_ids)
        self._blocks = Blocks(self, self.statements, self._graph, types, diagram.by_position)
        self._connected: dict[str, Expression | None] = {}
        self._reached: set[str] = set()
        self._open: list[str] = []

    def run(self) -> None:
        if self._diagram.by_position:
            for element in self._diagram.elements:
                if isinstance(element, (Jump, Return)):
                    what = "a jump" if isinstance(element, Jump) else "a return"
                    text = f"{what} is not supported by tools that order a diagram by position"
                    raise wrong(element, text, "write the condition at the outputs instead")
        before = -1
        for element in executed(self._diagram):
            if not self._diagram.by_position and element.network != before:
                self.statements.keep_all()
                before = element.network
            self._execute(element)
        self.statements.keep_all()
        if self._diagram.by_position:
            for element in self._diagram.elements:
                if isinstance(element, Contact) and not self._graph.users((element.id, "")):
                    self._without_effect(element, "leads nowhere")

    def _execute(self, element: Element) -> None:
        if isinstance(element, Block):
            self._blocks.execute(element, ordered=False)
        elif isinstance(element, (Coil, OutVariable)):
            self._output(element)
        elif isinstance(element, Connector):
            self._connector(element, ordered=False)
        elif isinstance(element, Contact) and not self._diagram.by_position:
            self._source(Connection(element.id), ordered=False)
        elif isinstance(element, (Jump, Return)):
            self._leave(element)

    # --- values ---

    def value(
        self, element: Element, pin: Input, *, ordered: bool = False, passed: bool = False
    ) -> Expression | None:
        """Return the value at an input with its modifiers; None if nothing is connected.

        With `ordered`, blocks that are not executed yet are not executed now. With `passed`, the
        value is passed to a VAR_IN_OUT.
        """
        found: Expression | None
        if pin.value.strip():
            found = Text(pin.value.strip(), self._types.of(pin.value))
        else:
            found = self._power(pin.connections, ordered=ordered)
        if found is None or passed:
            return found
        if pin.negated:
            found = inverted(found)
        if pin.edge and not (pin.negated and self._diagram.by_position):
            name = pin.name or _title(element)
            found = self.statements.edge(element, pin.edge, name, found, "")
        return found

    def _power(self, lines: Sequence[Connection], *, ordered: bool) -> Expression | None:
        """Return the value of lines that end at one input, joined by OR; None without a value."""
        found = [self._source(line, ordered=ordered) for line in lines]
        values = [value for value in found if value is not None]
        if not values:
            return None
        return values[0] if len(values) == 1 else alternatives(values)

    def _source(self, line: Connection, *, ordered: bool) -> Expression | None:
        element = self._graph.elements[line.source]
        if isinstance(element, Rail):
            return TRUE
        if isinstance(element, InVariable):
            found: Expression = Text(element.expression, self._types.of(element.expression))
            return inverted(found) if element.negated else found
        if isinstance(element, OutVariable):
            return Text(element.expression, self._types.of(element.expression))
        if isinstance(element, Contact):
            return self._contact(element, ordered=ordered)
        if isinstance(element, Coil):
            return self._passed_on(element, ordered=ordered)
        if isinstance(element, Continuation):
            source = self._graph.connectors[element.name.upper()]
            return self._connector(source, ordered=ordered)
        if isinstance(element, Block):
            return self._blocks.output(element, self._graph.key(line)[1], ordered=ordered)
        return None

    def _contact(self, element: Contact, *, ordered: bool) -> Expression:
        key = element.id, ""
        if not self._diagram.by_position:
            if element.id in self._reached:
                if not self.statements.is_bound(key):
                    raise _loop(element)
                return self.statements.use(key, "BOOL")
            self._reached.add(element.id)
        own: Expression = Text(element.variable, "BOOL")
        if element.edge and not (element.negated and self._diagram.by_position):
            share = "" if element.negated else element.id
            own = self.statements.edge(element, element.edge, element.variable, own, share)
        if element.negated:
            own = inverted(own)
        before = self._power(element.input.connections, ordered=ordered)
        if before is None:
            text = f"{named(element)} is not connected on its left side"
            raise wrong(element, text, "connect it, or remove it")
        found = joined((before, own))
        if self._diagram.by_position:
            return found
        self.statements.released(element)
        self.statements.bind(key, element, found)
        return self.statements.use(key, "BOOL")

    def _passed_on(self, element: Coil, *, ordered: bool) -> Expression | None:
        """Return the power behind a coil, which is the power before it."""
        lines = element.input.connections
        found = [self._source(line, ordered=ordered) for line in lines]
        values = [value for value in found if value is not None]
        if self._diagram.by_position and self._diagram.sorting != "together":
            # The generator of Beremiz joins parallel lines before a coil by AND for what follows.
            return joined(values) if values else None
        return alternatives(values) if values else None

    def _connector(self, element: Connector, *, ordered: bool) -> Expression | None:
        if element.id not in self._connected:
            # A block on the way may read the connector again. As it is marked as executed, this
            # ends, unless the line leads back without a block.
            self._open.append(element.id)
            if self._open.count(element.id) > _DEEPEST:
                raise _loop(element)
            value = self.value(element, element.input, ordered=ordered)
            self._open.pop()
            self._connected[element.id] = value
            self.statements.released(element)
        return self._connected[element.id]

    # --- statements ---

    def _output(self, element: Coil | OutVariable) -> None:
        is_coil = isinstance(element, Coil)
        target = element.variable if isinstance(element, Coil) else element.expression
        value = self.value(element, element.input)
        if value is None:
            if isinstance(element, OutVariable) and element.read:
                return  # an inOutVariable that is only read
            if not self._diagram.by_position:
                raise wrong(element, f"{named(element)} is not connected", "connect or remove it")
            self._without_effect(element, "is not connected")
            return
        storage, edge = element.storage, element.edge
        if self._diagram.by_position:  # the generator of Beremiz uses only one of them
            storage = "" if element.negated else storage
            edge = "" if element.negated or storage else edge
        if edge:
            value = self.statements.edge(element, edge, target, value, "")
        if element.negated:
            value = inverted(value)
        guard = None if is_coil else self._blocks.guard(element.input.connections)
        self.assign(element, target, value, storage, guard)

    def _without_effect(self, element: Element, why: str) -> None:
        """Add a comment for an element that the tools ignore, because it may be a mistake."""
        title = named(element)
        text = f"(* {title[0].upper()}{title[1:]} {why}: it has no effect. *)"
        self.statements.add(element, text, (), ())

    def assign(
        self,
        element: Element,
        target: str,
        value: Expression,
        storage: str,
        guard: Expression | None = None,
    ) -> None:
        """Add the assignment of a value to a variable, or its set or reset."""
        writes = self.statements.target(target)
        condition = guard
        if storage:
            condition = value if guard is None else joined((guard, value))
            value = TRUE if storage == "set" else FALSE
        self.statements.add(element, f"{target} := {{0}};", writes, (value,), condition)

    def _leave(self, element: Jump | Return) -> None:
        value = self.value(element, element.input)
        if value is None:
            raise wrong(element, f"{named(element)} is not connected", "connect it, or remove it")
        label = element.label if isinstance(element, Jump) else ""
        self.statements.jump(element, label, value, inverted(value))


def _title(element: Element) -> str:
    if isinstance(element, Block):
        return element.instance or element.type
    return ""


def _loop(element: Element) -> Exception:
    text = f"{named(element)} depends on itself"
    return wrong(element, text, "use a variable for the value of the last scan")
