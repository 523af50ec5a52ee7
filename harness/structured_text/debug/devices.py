"""The interface of the programs of devices around the PLC, which are in languages of their own.

The debugger does not know these languages. An object of `Devices` gives files, lines and tasks to
the debugger, and calls the debugger before each line that a task begins.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple, Protocol

from structured_text.debug.breakpoints import Breakpoint
from structured_text.debug.values import Item

__all__ = ["DeviceBreakpoint", "DeviceFrame", "DeviceStep", "Devices", "next_line"]


class DeviceFrame(NamedTuple):
    """A call in the stack of a task.

    Attributes:
        title: Name of the call in the stack.
        file: The file; empty if the program is not in a file.
        line: Current line of the file.
        scopes: The values to show, by the names of their groups.
    """

    title: str
    file: str
    line: int
    scopes: Sequence[tuple[str, Callable[[], list[Item]]]]


class DeviceStep(NamedTuple):
    """A line that a task of a device is about to begin.

    Attributes:
        task: Number of the task, from 1.
        file: Canonical path of the file (`places.real_path`).
        depth: Number of calls in the stack of the task, from 1.
    """

    task: int
    file: str
    line: int
    depth: int


class Devices(Protocol):
    """The programs of all devices of a machine."""

    @property
    def files(self) -> Sequence[str]:
        """Return the files of the programs."""

    def lines(self, file: str) -> Sequence[int]:
        """Return the sorted lines of a file at which statements begin; empty for other files."""

    @property
    def tasks(self) -> Sequence[tuple[int, str]]:
        """Return number and name of each task that is in use."""

    def stack(self, task: int) -> list[DeviceFrame]:
        """Return the calls of a task, the innermost first."""

    @property
    def positions(self) -> list[str]:
        """Return one line for each task in use: its program, line, state and statement."""

    def condition(self, text: str) -> Callable[[int], bool]:
        """Return a function that evaluates a condition in the task with the given number.

        Raise InputError if the text is not an expression of the language. The function raises
        InputError if the expression has no value.
        """

    def watch(self, look: Callable[[DeviceStep], None] | None) -> None:
        """Call `look` before each line that a task begins, from now on; None ends these calls."""


@dataclass(eq=False)
class DeviceBreakpoint(Breakpoint):
    """A breakpoint before a line of a device's program, or before each line of a task.

    Attributes:
        file: Canonical path of the file. If it is empty, the breakpoint is before each line of
            `task`.
        depth: Greatest number of calls in the stack, for a breakpoint on a task.
        holds: A function that evaluates the condition in the task with this number; None without a
            condition.
    """

    file: str = ""
    line: int = 0
    task: int = 0
    depth: int = 0
    holds: Callable[[int], bool] | None = None

    def fits(self, step: DeviceStep) -> bool:
        """Return whether a step is at the breakpoint; conditions are not evaluated."""
        if self.file:
            return (step.file, step.line) == (self.file, self.line)
        return step.task == self.task and step.depth <= self.depth

    def hit_at(self, step: DeviceStep) -> bool:
        """Count a hit, and return whether the run stops.

        Raise InputError if the condition has no value.
        """
        return (self.holds is None or self.holds(step.task)) and self.hit("", {})


def next_line(devices: Devices, file: str, line: int) -> int | None:
    """Return the first line from `line` on at which a statement of a device's program begins.

    The result is None if there is no such line.
    """
    lines = devices.lines(file)
    place = bisect_left(lines, line)
    return lines[place] if place < len(lines) else None
