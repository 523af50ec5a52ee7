"""The diagram of a ladder routine, for drawings: contacts, coils, and boxes for all others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Contact,
    Diagram,
    Element,
    Input,
    Network,
    Output,
    Rail,
)
from structured_text.projects.rockwell.ladder.call import Body
from structured_text.projects.rockwell.ladder.model import Instruction, Rung, Series
from structured_text.projects.rockwell.ladder.table import TABLE

__all__ = ["diagram_of"]

#: The `id` of the left rail, which all rungs have in common.
_RAIL = "left"
_STORAGES = {"OTE": "", "OTL": "set", "OTU": "reset"}
#: Operands that only show values of a structure, and are not complete without it.
_UNKNOWN = ("", "?")

_Ends = tuple[Connection, ...]


def diagram_of(rungs: Sequence[Rung], body: Body) -> Diagram:
    """Return the diagram of rungs that were translated."""
    made = _Maker(body)
    for number, rung in enumerate(rungs):
        made.add(rung, body.traces.get(number, ()))
    return Diagram("RLL", tuple(made.networks), (Rail(_RAIL, network=0), *made.elements), False)


@dataclass
class _Maker:
    """Makes the elements of all rungs.

    Attributes:
        body: The routine.
        networks: The rungs so far.
        elements: Their elements so far.
        number: The number of the last rung.
        label: Its label; may be empty.
    """

    body: Body
    networks: list[Network] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    number: int = 0
    label: str = ""

    def add(self, rung: Rung, traces: Sequence[str]) -> None:
        """Add a rung; `traces` has what its instructions became."""
        self.number, self.label = rung.number, ""
        self._series(rung.series, (Connection(_RAIL),), iter(traces))
        comment = rung.comment.strip()
        network = Network(rung.number, comment=comment, label=self.label, at=rung.at)
        self.networks.append(network)

    def _series(self, series: Series, power: _Ends, traces: Iterator[str]) -> _Ends:
        """Add a series, and return the places that have its power at its end."""
        for node in series:
            if isinstance(node, Instruction):
                power = self._instruction(node, power, next(traces, ""))
            else:
                legs = [self._series(leg, power, traces) for leg in node.legs]
                power = tuple(dict.fromkeys(end for leg in legs for end in leg))
        return power

    def _instruction(self, instruction: Instruction, power: _Ends, trace: str) -> _Ends:
        name, operands = instruction.name, instruction.operands
        first = operands[0] if operands else ""
        if name == "LBL":
            self.label = first
            return power
        number, network, at = f"e{len(self.elements)}", self.number, instruction.at
        given = Input(connections=power)
        element: Element
        if name in ("XIC", "XIO"):
            element = Contact(
                number,
                network,
                at=at,
                variable=first,
                input=given,
                negated=name == "XIO",
                translation=trace.removeprefix("NOT ") if name == "XIO" else trace,
            )
        elif name in _STORAGES:
            element = Coil(
                number,
                network,
                at=at,
                variable=first,
                input=given,
                storage=_STORAGES[name],
                translation=trace,
            )
        else:
            element = Block(
                number,
                network,
                at=at,
                type=instruction.written if self._calls(name) else name,
                instance=first if self._calls(name) else "",
                inputs=(given,),
                outputs=(Output(),),
                operands=tuple(self._operands(instruction)),
                translation=trace,
            )
        self.elements.append(element)
        return (Connection(number),)

    def _calls(self, name: str) -> bool:
        """Return whether an instruction is an Add-On Instruction."""
        return name not in TABLE and name in self.body.routine.types.instructions

    def _operands(self, instruction: Instruction) -> Iterator[tuple[str, str]]:
        """Yield the operands with their names, except those that are not shown."""
        name, operands = instruction.name, instruction.operands
        names: list[str] = []
        if self._calls(name):
            names = [pin for pin, _ in self.body.routine.types.instructions[name].parameters]
            operands = operands[1:]
        elif name in TABLE:
            names = list(TABLE[name].operands)
        for number, text in enumerate(operands):
            if text not in _UNKNOWN:
                yield (names[number] if number < len(names) else "", text)
