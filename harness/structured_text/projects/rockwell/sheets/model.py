"""The model of a routine in Function Block Diagram: sheets with elements and wires.

Source: Rockwell 1756-RM084, function block diagram routines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["BLOCKS", "Node", "Routine", "Sheet", "Wire", "title_of"]

#: Elements that are executed, in distinction to references and connectors.
BLOCKS = ("Block", "Function", "AddOnInstruction", "JSR", "SBR", "RET")


@dataclass(frozen=True)
class Node:
    """An element of a sheet.

    Attributes:
        id: The number by which wires name it; unique in the routine.
        kind: IRef, ORef, ICon, OCon, or one of `BLOCKS`.
        name: The instruction, the name of the connector, or the routine that JSR calls.
        operand: The tag of a block; the tag or number of a reference.
        sheet: The number of the sheet.
        x: The place on the sheet, to the right.
        y: The place on the sheet, downwards.
        pins: The visible pins of a block.
        arguments: Tags for arrays and for in-out parameters, by the name of the parameter.
        at: Line in the file.
    """

    id: str
    kind: str
    name: str
    operand: str
    sheet: int
    x: float = 0.0
    y: float = 0.0
    pins: tuple[str, ...] = ()
    arguments: Mapping[str, str] = field(default_factory=dict)
    at: int = 1

    @property
    def title(self) -> str:
        """Return the words for the element in a message."""
        if self.kind in ("IRef", "ORef"):
            way = "input" if self.kind == "IRef" else "output"
            return f"the {way} reference {self.operand}".rstrip()
        if self.kind in ("ICon", "OCon"):
            return f"the {'input' if self.kind == 'ICon' else 'output'} wire connector {self.name}"
        if self.kind == "Block":
            return f"the block {self.operand} ({self.name})"
        if self.kind == "AddOnInstruction":
            return f"the instruction {self.operand} ({self.name})"
        return (
            f"the function {self.name}" if self.kind == "Function" else f"{self.kind} {self.name}"
        )


@dataclass(frozen=True)
class Wire:
    """A wire from an output to an input.

    Attributes:
        source: The `id` of the element at its left end.
        output: The output pin; empty for elements with one output.
        target: The `id` of the element at its right end.
        input: The input pin; empty for elements with one input.
        feedback: Whether it has the mark Assume Data Available, so that it passes the value of the
            last scan.
        at: Line in the file.
    """

    source: str
    output: str
    target: str
    input: str
    feedback: bool = False
    at: int = 1


@dataclass(frozen=True)
class Sheet:
    """A sheet with its number and description."""

    number: int
    description: str = ""
    at: int = 1


@dataclass(frozen=True)
class Routine:
    """The sheets of a routine, their elements in the order of the file, and their wires."""

    sheets: tuple[Sheet, ...]
    nodes: tuple[Node, ...]
    wires: tuple[Wire, ...]


def title_of(number: int) -> str:
    """Return the name of a sheet in messages and lists."""
    return f"sheet {number}"
