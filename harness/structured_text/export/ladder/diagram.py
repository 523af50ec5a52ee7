"""The diagram of a POU: a rung for each operation.

Tools execute the numbered elements in the order of their numbers, and coils afterwards, because
Beremiz and OpenPLC Editor do not number coils. So a coil is only drawn if its operation may be
executed after all numbered elements. Otherwise a variable with a number ends the rung.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from structured_text.export.ladder.operations import Call, Operation, Put, Send, Store
from structured_text.export.ladder.power import (
    FALSE,
    TRUE,
    Leaf,
    Parallel,
    Power,
    Series,
    leaves,
    negated,
    parallel,
    series,
)
from structured_text.projects.diagrams.networks import model as m

__all__ = ["Rung", "diagram_of"]


@dataclass(frozen=True)
class Rung:
    """The operations of a statement with its comment.

    Attributes:
        operations: The operations.
        comment: The comment above the rung.
        line: Line in the user's file.
    """

    operations: tuple[Operation, ...]
    comment: str = ""
    line: int = 1


def diagram_of(rungs: Sequence[Rung], *, ordered: bool = True) -> m.Diagram:
    """Return the diagram of rungs.

    Args:
        rungs: The rungs from top to bottom.
        ordered: Number the elements, so that every tool executes them in the order of the rungs.
            Without numbers every Boolean assignment is a coil.
    """
    late = _late([one for rung in rungs for one in rung.operations]) if ordered else None
    builder = _Builder(late)
    for rung in rungs:
        builder.rung(rung)
    return m.Diagram("LD", tuple(builder.networks), tuple(builder.elements))


def _late(operations: Sequence[Operation]) -> set[int]:
    """Return the `id` of each Boolean assignment that may follow all numbered elements."""
    late: set[int] = set()
    numbered_reads: set[str] = set()
    numbered_writes: set[str] = set()
    for operation in reversed(operations):
        is_boolean = isinstance(operation, Put) or (
            isinstance(operation, Send) and operation.boolean
        )
        touched = operation.reads | operation.writes
        if is_boolean and not (touched & numbered_writes or operation.writes & numbered_reads):
            late.add(id(operation))
        else:
            numbered_reads |= operation.reads
            numbered_writes |= operation.writes
    return late


class _Builder:
    """Builds the elements of all rungs."""

    def __init__(self, late: set[int] | None) -> None:
        self._late = late
        self.elements: list[m.Element] = []
        self.networks: list[m.Network] = []
        self._rail, self._number, self._order, self._line = "", 0, 0, 1
        self._block: m.Block | None = None

    def rung(self, rung: Rung) -> None:
        """Add the rungs of a statement; the comment stands at the first of them."""
        comment = rung.comment
        self._line = rung.line
        for operation in rung.operations:
            if not isinstance(operation, Send):
                self._open(comment)
                comment = ""
            if isinstance(operation, Call):
                self._call(operation)
            elif isinstance(operation, Send):
                self._send(operation)
            elif isinstance(operation, Put):
                self._put(operation)
            elif isinstance(operation, Store):
                self._store(operation)

    def _open(self, comment: str) -> None:
        self._number = len(self.networks) + 1
        self.networks.append(m.Network(self._number, comment=comment, at=self._line))
        self._rail = ""

    # --- elements ---

    def _id(self) -> str:
        return str(len(self.elements) + 1)

    def _numbered(self) -> int:
        """Return the next number of the order of execution; 0 in a diagram without numbers."""
        if self._late is None:
            return 0
        self._order += 1
        return self._order

    def _add(self, element: m.Element) -> m.Connection:
        placed = replace(element, id=self._id(), network=self._number, at=self._line)
        self.elements.append(placed)
        return m.Connection(placed.id)

    def _source(self) -> m.Connection:
        """Return the line from the left rail of the rung."""
        if not self._rail:
            self._rail = self._add(m.Rail("")).source
        return m.Connection(self._rail)

    def _variable(self, text: str) -> m.Connection:
        return self._add(m.InVariable("", expression=text))

    def _power(
        self, power: Power, before: tuple[m.Connection, ...] = ()
    ) -> tuple[m.Connection, ...]:
        """Add contacts behind some lines, and return the lines behind the contacts.

        Without lines the contacts begin at the left rail. Only there an expression may stand.
        """
        if isinstance(power, Leaf):
            if not power.is_contact:
                assert not before, power
                return (self._variable(power.text),)
            given = m.Input(connections=before or (self._source(),))
            return (
                self._add(m.Contact("", variable=power.text, input=given, negated=power.negated)),
            )
        if power == TRUE:
            return before or (self._source(),)
        if power == FALSE:
            return (self._variable("FALSE"),)
        if isinstance(power, Parallel):
            lines = [line for item in power.items for line in self._power(item, before)]
            return tuple(dict.fromkeys(lines))
        for item in _expression_first(power.items):
            before = self._power(item, before)
        return before

    # --- operations ---

    def _call(self, call: Call) -> None:
        inputs = []
        for given in call.pins:
            if given.pin.section == "VAR_OUTPUT":
                continue
            lines: tuple[m.Connection, ...] = ()
            if isinstance(given.value, str):
                lines = (self._variable(given.value),)
            elif given.value is not None:
                lines = self._power(given.value)
            in_out = given.pin.section == "VAR_IN_OUT"
            inputs.append(m.Input(given.pin.name, lines, in_out=in_out))
        # Beremiz and OpenPLC Editor show a VAR_IN_OUT on both sides of a block.
        shown = ("VAR_OUTPUT",) if self._late is None else ("VAR_OUTPUT", "VAR_IN_OUT")
        outputs = tuple(
            m.Output(given.pin.name) for given in call.pins if given.pin.section in shown
        )
        self._add(
            m.Block(
                "",
                order=self._numbered(),
                type=call.block,
                instance=call.instance,
                inputs=tuple(inputs),
                outputs=outputs,
            )
        )
        block = self.elements[-1]
        assert isinstance(block, m.Block)
        self._block = block

    def _send(self, send: Send) -> None:
        assert self._block is not None
        given = m.Input(connections=(m.Connection(self._block.id, send.pin),))
        self._end(send, send.target, given, is_coil=send.boolean)

    def _put(self, put: Put) -> None:
        power = put.power
        is_coil = self._late is None or id(put) in self._late
        if not is_coil and put.storage:
            held = Leaf(put.target)
            power = parallel(power, held) if put.storage == "set" else series(negated(power), held)
        if is_coil and power == FALSE and not put.storage:
            line = m.Input(connections=(self._source(),))
            self._add(m.Coil("", variable=put.target, input=line, negated=True))
            self._close()
            return
        given = m.Input(connections=self._power(power))
        self._end(put, put.target, given, is_coil=True, storage=put.storage)

    def _store(self, store: Store) -> None:
        if store.enable == TRUE:
            line = self._variable(store.value)
        else:
            enable = m.Input("EN", self._power(store.enable))
            value = m.Input("IN", (self._variable(store.value),))
            outputs = (m.Output("ENO"), m.Output("OUT"))
            line = self._add(
                m.Block(
                    "", order=self._numbered(), type="MOVE", inputs=(enable, value), outputs=outputs
                )
            )
            line = m.Connection(line.source, "OUT")
        self._end(store, store.target, m.Input(connections=(line,)), is_coil=False)

    def _end(
        self,
        operation: Operation,
        target: str,
        given: m.Input,
        *,
        is_coil: bool,
        storage: str = "",
    ) -> None:
        """Add the coil or variable at the end of a rung."""
        if is_coil and (self._late is None or id(operation) in self._late):
            self._add(m.Coil("", variable=target, input=given, storage=storage))
            self._close()
        else:
            order = self._numbered()
            self._add(m.OutVariable("", order=order, expression=target, input=given))

    def _close(self) -> None:
        """Add the right rail behind a coil."""
        self._add(m.Rail("", left=False))


def _expression_first(items: Sequence[Power]) -> list[Power]:
    """Return the items of a series so that an expression stands only at the left rail.

    AND does not depend on the order. If several items have expressions, these items become one
    expression.
    """
    mixed = [item for item in items if not all(leaf.is_contact for leaf in leaves(item))]
    rest = [item for item in items if item not in mixed]
    if len(mixed) > 1:
        text = " AND ".join(_text(item) for item in mixed)
        other = " OR ".join(_text(negated(item)) for item in mixed)
        mixed = [Leaf(text, opposite=other)]
    return [*mixed, *rest]


def _text(power: Power) -> str:
    """Return contacts as an expression; an expression with OR stands in parentheses."""
    if isinstance(power, Leaf):
        return f"NOT {power.text}" if power.negated else power.text
    if isinstance(power, Series):
        return " AND ".join(map(_text, power.items)) if power.items else "TRUE"
    inner = " OR ".join(map(_text, power.items))
    return f"({inner})" if power.items else "FALSE"
