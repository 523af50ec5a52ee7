"""The lines of robot programs that the runs of a campaign have reached."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.cell import Cell
from rcx_harness.robot.program.syntax import SILENT
from rcx_harness.robot.program.task import RobotTask
from rcx_harness.verify.storm.sweep import ranges

__all__ = ["Line", "Reached", "unreached_lines"]

#: A line of a robot program: number of the controller, name of the program, and line.
Line = tuple[int, str, int]


class Reached:
    """An observer of all robot programs of a cell that records the lines that they reach."""

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._found: set[Line] = set()
        for number, robot in enumerate(cell.robots, 1):
            robot.program.observers.append(_Observer(number, self._found))

    def forget(self) -> None:
        """Forget all lines, because another run begins."""
        self._found.clear()

    @property
    def lines(self) -> tuple[Line, ...]:
        """Return the reached lines of all programs with source text."""
        return tuple(sorted(self._found.intersection(_lines(self._cell))))


class _Observer:
    """The observer that reports the instructions of a controller to a `Reached`."""

    def __init__(self, number: int, found: set[Line]) -> None:
        self._number, self._found = number, found

    def begins(self, task: RobotTask, at: int) -> None:
        """Record the line of an instruction."""
        self._found.add((self._number, task.program.name, task.code.line(at)))

    def ends(self, task: RobotTask, at: int, to: int) -> None:
        """Do nothing, because the line was recorded when the instruction began."""


def unreached_lines(cell: Cell, reached: Collection[Line]) -> Iterator[str]:
    """Yield the name and the unreached lines of each program that has unreached lines."""
    left: dict[tuple[int, str], list[int]] = {}
    for number, name, line in sorted(set(_lines(cell)).difference(reached)):
        left.setdefault((number, name), []).append(line)
    for (number, name), lines in left.items():
        shown = ", ".join(f"{a}" if a == b else f"{a} to {b}" for a, b in ranges(lines, 1))
        which = f" of controller {number}" if len(cell.robots) > 1 else ""
        word = "line" if len(lines) == 1 else "lines"
        yield f"robot program {name}{which}: {word} {shown} not reached"


def _lines(cell: Cell) -> Iterator[Line]:
    """Yield all lines with a statement in programs with source text."""
    for number, robot in enumerate(cell.robots, 1):
        for task in robot.program.tasks:
            for one in task.code.code if task.program.text else ():
                if one.kind not in SILENT:
                    yield number, task.program.name, one.line
