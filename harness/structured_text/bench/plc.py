"""The state of a PLC apart from its scans: STOP and RUN, power, and the effects of a start."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Protocol

from structured_text.engines.base import Program, Value
from structured_text.errors import Violation

__all__ = ["Monitor", "Plc"]


class Monitor(Protocol):
    """A monitor that watches a program and reports broken rules."""

    def scan(self, now_us: int, scan: int) -> list[Violation]:
        """Return the rules that were broken in a scan."""

    def snapshot(self) -> Any:
        """Return the state of the monitor."""

    def restore(self, snapshot: Any) -> None:
        """Restore the state from `snapshot`."""

    def begin(self) -> None:
        """Begin the watch anew with the current variables.

        After a warm start, retained variables have their old values.
        """


class Plc:
    """A program with the state of its PLC and the monitors that watch it.

    `program` has not run its first scan. `monitors` begin anew when the program restarts.
    """

    def __init__(
        self, program: Program, retained: Sequence[str], monitors: Sequence[Monitor] = ()
    ) -> None:
        self.runs = True
        """Whether the PLC has power and is in RUN."""
        self.powered = True
        self.inputs_stay = True
        """Whether values that were set from outside survive a start."""
        self.beginning = program.snapshot()
        """The state of the program after a cold start."""
        self.on_start: list[Callable[[], None]] = []
        """The functions that are called after each start of the PLC."""
        self._program, self._retained = program, retained
        self._monitors = [(one, one.snapshot()) for one in monitors]
        self._outside: dict[str, Value] = {}

    def note(self, path: str) -> None:
        """Record that a variable was set from outside the program."""
        self._outside.pop(path, None)
        self._outside[path] = self._program.read(path)

    def judge(self, now_us: int, scan: int) -> list[Violation]:
        """Return the broken rules that the monitors have found in a scan."""
        return [found for one, _ in self._monitors for found in one.scan(now_us, scan)]

    def stop(self, *, power: bool) -> None:
        """Go into STOP, or lose the power."""
        self.runs, self.powered = False, self.powered and not power

    def start(self, start: str) -> None:
        """Go into RUN; `start` is `warm`, `cold` or `continue`.

        A variable that was set from outside and still has this value is an input of the program. An
        input has the same value after the start.
        """
        if start != "continue" or not self.powered:
            self._begin_anew(retain=start != "cold")
        self.runs = self.powered = True
        for listener in self.on_start:
            listener()

    def _begin_anew(self, *, retain: bool) -> None:
        program = self._program
        kept = {path: program.read(path) for path in self._retained} if retain else {}
        if self.inputs_stay:
            kept |= {
                path: value for path, value in self._outside.items() if program.read(path) == value
            }
        program.restore(self.beginning)
        for path, value in kept.items():
            program.write(path, value)
        for monitor, quiet in self._monitors:
            monitor.restore(quiet)
            monitor.begin()

    def snapshot(self) -> object:
        """Return the state of monitors and PLC, without the program's state."""
        monitors = [one.snapshot() for one, _ in self._monitors]
        return monitors, self.runs, self.powered, dict(self._outside)

    def restore(self, snapshot: Any) -> None:
        """Restore the state from `snapshot`."""
        monitors, self.runs, self.powered, outside = snapshot
        for (one, _), state in zip(self._monitors, monitors, strict=True):
            one.restore(state)
        self._outside = dict(outside)
