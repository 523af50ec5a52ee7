"""The model of a ladder routine: rungs of instructions and branches.

Source: Rockwell 1756-RM084, ladder routines: structure of a rung, neutral text.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TypeAlias

__all__ = ["Branch", "Instruction", "LadderError", "Node", "Rung", "Series", "instructions"]


class LadderError(Exception):
    """The error for a rung that cannot be translated: the message, its line and a hint."""

    def __init__(self, message: str, at: int, hint: str = "") -> None:
        super().__init__(message)
        self.message, self.at, self.hint = message, at, hint


@dataclass(frozen=True)
class Instruction:
    """An instruction of a rung, such as `XIC(Start)`.

    Attributes:
        name: The name in upper case.
        operands: The texts of its operands, without outer white space.
        at: Line in the file.
        written: The name as it is written.
    """

    name: str
    operands: tuple[str, ...]
    at: int
    written: str = field(default="", compare=False)


@dataclass(frozen=True)
class Branch:
    """Parallel legs, from top to bottom; an empty leg passes power on.

    Attributes:
        legs: The legs, each from left to right.
        at: Line in the file.
    """

    legs: tuple[Series, ...]
    at: int


Node: TypeAlias = Instruction | Branch
Series: TypeAlias = tuple[Node, ...]


@dataclass(frozen=True)
class Rung:
    """A rung of a ladder routine.

    Attributes:
        number: The number in the file, from 0.
        series: The instructions and branches from left to right; empty for an empty rung.
        comment: The comment; may have several lines and may be empty.
        at: Line in the file.
    """

    number: int
    series: Series
    comment: str = ""
    at: int = 1

    @property
    def title(self) -> str:
        """Return the name of the rung in messages and lists."""
        return f"rung {self.number}"


def instructions(series: Series) -> Iterator[Instruction]:
    """Yield the instructions in the order in which the controller executes them."""
    for node in series:
        if isinstance(node, Instruction):
            yield node
        else:
            for leg in node.legs:
                yield from instructions(leg)
