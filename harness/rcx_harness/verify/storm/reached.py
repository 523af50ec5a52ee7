"""The lines of robot programs that the runs of a campaign have reached."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.cell import Cell
from rcx_harness.verify.storm.sweep import ranges

__all__ = ["Line", "follow_lines", "reached_lines", "unreached_lines"]

#: Number of the controller, name of the program, and line.
Line = tuple[int, str, int]
#: Kinds of instructions that are no statement of their own.
_SILENT = ("label", "declare", "jump", "leave")


def follow_lines(cell: Cell) -> None:
    """Record from now on which lines of robot programs are reached."""
    for robot in cell.robots:
        robot.machine.reached = set()


def reached_lines(cell: Cell) -> tuple[Line, ...]:
    """Return the lines that have been reached since `follow_lines`, of programs that are texts."""
    texts = set(_lines(cell))
    found = {
        (number, *one)
        for number, robot in enumerate(cell.robots, 1)
        for one in robot.machine.reached or ()
    }
    return tuple(sorted(found & texts))


def unreached_lines(cell: Cell, reached: Collection[Line]) -> Iterator[str]:
    """Yield for each program with lines that were not reached its name and these lines."""
    left: dict[tuple[int, str], list[int]] = {}
    for number, name, line in sorted(set(_lines(cell)).difference(reached)):
        left.setdefault((number, name), []).append(line)
    for (number, name), lines in left.items():
        shown = ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in ranges(lines, 1))
        which = f" of controller {number}" if len(cell.robots) > 1 else ""
        word = "line" if len(lines) == 1 else "lines"
        yield f"robot program {name}{which}: {word} {shown} not reached"


def _lines(cell: Cell) -> Iterator[Line]:
    """Yield all lines with a statement, of programs that are texts."""
    for number, robot in enumerate(cell.robots, 1):
        for task in robot.program.tasks:
            for one in task.code.code if task.program.text else ():
                if one.kind not in _SILENT:
                    yield number, task.program.name, one.line
