"""The syntax of a robot program: expressions as nodes, and statements as a flat list of code.

Positions in the code are list indices. Blocks such as IF ... ENDIF become jumps in the code.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

__all__ = [
    "COORDINATES",
    "MOVES",
    "NEXT",
    "OPTIONS",
    "SIGNATURES",
    "SILENT",
    "STAY",
    "Instruction",
    "Node",
    "Program",
    "Subroutine",
]

#: The kinds of instructions that start a movement.
MOVES = ("move", "movei", "movet", "drive", "drivei", "pmove", "push", "path_start")
#: Results of an instruction that does not jump. NEXT: continue with the following instruction.
#: STAY: continue in this instruction in the next cycle.
NEXT, STAY = -1, -2
#: The options of movements that have a name before `=`, as they are written.
OPTIONS = (
    "S",
    "SPEED",
    "DSPEED",
    "VEL",
    "ACC",
    "DEC",
    "A1",
    "A2",
    "A3",
    "A4",
    "A5",
    "A6",
    "F",
    "TIM",
)
#: The kinds of instructions that are not statements: labels, and jumps. A jump leads over a SUB, or
#: from the end of a branch to the end of its block.
SILENT = ("label", "declare", "leave")

#: Maps each function that returns a coordinate to the index of the coordinate. LOCX is the same as
#: LOC1.
COORDINATES = {
    f"LOC{name}": place for names in ("XYZRAB", "123456") for place, name in enumerate(names)
}
#: Letters for the arguments and the result of each function: n number, t text, p point, e point,
#: shift or hand. Capital letters are optional arguments.
SIGNATURES = {
    **dict.fromkeys(("ABS", "INT", "SQR", "SIN", "COS", "TAN", "ATN", "RADDEG", "DEGRAD"), "n:n"),
    **dict.fromkeys(("ERR", "ERL"), "N:n"),
    **dict.fromkeys(("TIMER", "TCOUNTER"), ":n"),
    **dict.fromkeys(("TIME$", "DATE$"), ":t"),
    **dict.fromkeys(("WHERE", "WHRXY"), ":p"),
    **dict.fromkeys(("LEFT$", "RIGHT$"), "tn:t"),
    **dict.fromkeys(COORDINATES, "e:n"),
    "ATN2": "nn:n",
    "LEN": "t:n",
    "VAL": "t:n",
    "ORD": "t:n",
    "STR$": "n:t",
    "CHR$": "n:t",
    "MID$": "tnn:t",
    "DIST": "pp:n",
}


@dataclass(frozen=True)
class Node:
    """An expression, a target or a part of a statement; `kind` is its rule in grammar.lark.

    Attributes:
        kind: Name of the rule, such as `add` or `variable`.
        args: The parts of the node: nodes, numbers and texts; None for a missing optional part.
    """

    kind: str
    args: tuple[Any, ...] = ()

    def walk(self) -> Iterator[Node]:
        """Yield this node and all nodes in it."""
        yield self
        for part in self.args:
            if isinstance(part, Node):
                yield from part.walk()


@dataclass(frozen=True)
class Instruction:
    """One instruction in the code of a program.

    Attributes:
        kind: Name of the rule in grammar.lark, or name of a jump that blocks.py adds.
        args: The parts of the statement: nodes, numbers and texts.
        line: Number of the instruction's line in the file, from 1.
        jump: Position in the code to which the instruction may jump; -1 if it does not jump.
        behind: Position after the last instruction of the statement if the statement has several
            instructions; else -1.
    """

    kind: str
    args: tuple[Any, ...]
    line: int
    jump: int = -1
    behind: int = -1

    def nodes(self) -> Iterator[Node]:
        """Yield all nodes in the parts of the instruction."""
        for part in self.args:
            if isinstance(part, Node):
                yield from part.walk()


@dataclass(frozen=True)
class Subroutine:
    """A SUB: position of its first instruction, and the names of its parameters."""

    at: int
    parameters: tuple[str, ...]


@dataclass(frozen=True)
class Program:
    """A robot program that can be executed; it never changes.

    Attributes:
        code: The instructions of the program.
        labels: Positions of the labels, by name with the asterisk.
        subs: The subroutines by name.
        texts: The lines of the program as written; the first is line 1.
        integers: Whether variables without %, ! or $ are integers; otherwise they are real numbers.
        shared: Whether the program shares its variables with all programs, as the steps of a robot
            file do.
    """

    code: tuple[Instruction, ...]
    labels: Mapping[str, int] = field(default_factory=dict)
    subs: Mapping[str, Subroutine] = field(default_factory=dict)
    texts: tuple[str, ...] = ()
    integers: bool = False
    shared: bool = False

    def __deepcopy__(self, memo: object) -> Program:
        """Return the program itself, because programs never change."""
        return self

    @cached_property
    def begins(self) -> Mapping[int, int]:
        """Return the positions at which lines with statements begin, and their lines.

        A line with several statements begins at its first statement. Each iteration of a FOR loop
        ends at NEXT, but the FOR statement begins only once.
        """
        first: dict[int, int] = {}
        for at, one in enumerate(self.code):
            if one.kind not in SILENT:
                first.setdefault(one.line, at)
        return {at: line for line, at in first.items()}

    def line(self, at: int) -> int:
        """Return the line number of a position; after the end of the code, the last line number."""
        if at < len(self.code):
            return self.code[at].line
        return max(len(self.texts), 1)

    def behind(self, line: int) -> int:
        """Return the position of the first instruction after a line."""
        return next((k for k, one in enumerate(self.code) if one.line > line), len(self.code))
