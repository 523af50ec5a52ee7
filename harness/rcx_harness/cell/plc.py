"""The PLC of a cell besides its scans: STOP and RUN, its power, and what a start leaves."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import Any

from rcx_harness.robot import Violation
from rcx_harness.watch.calls import CallMonitor
from rcx_harness.watch.calls_source import CallPlan
from rcx_harness.watch.contract import ContractMonitor
from structured_text.engines.base import Program, Value

__all__ = ["Plc"]


class Plc:
    """A program with what a PLC does to it, and the monitors that watch its blocks.

    Args:
        program: Before its first scan.
        steady: As at `ContractMonitor`.
        calls: As at `CallMonitor`.
        retained: Paths of the variables that a warm start keeps.
    """

    def __init__(
        self, program: Program, steady: Collection[str], calls: CallPlan, retained: Sequence[str]
    ) -> None:
        self.runs = True
        """It has power and is in RUN."""
        self.powered = True
        self.inputs_stay = True
        """What was set from outside is there after a start, too."""
        self.beginning = program.snapshot()
        """The program as a cold start leaves it."""
        self.on_start: list[Callable[[], None]] = []
        """Called after a start."""
        self._program, self._retained = program, retained
        self._contract, self._calls = ContractMonitor(program, steady), CallMonitor(program, calls)
        self._quiet: tuple[Any, Any] = (self._contract.snapshot(), self._calls.snapshot())
        self._outside: dict[str, Value] = {}

    def note(self, path: str) -> None:
        """A variable was set from outside."""
        self._outside.pop(path, None)
        self._outside[path] = self._program.read(path)

    def judge(self, now_us: int, scan: int) -> list[Violation]:
        """What the blocks, and the calls of them, broke in a scan."""
        return self._contract.scan(now_us, scan) + self._calls.scan(now_us, scan)

    def stop(self, *, power: bool) -> None:
        """Go into STOP, or lose the power."""
        self.runs, self.powered = False, self.powered and not power

    def start(self, start: str) -> None:
        """Go into RUN, by a start that is `warm`, `cold`, or `continue`.

        What was set from outside and still has that value is an input of the program: it has it
        after the start, too.
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
        self._contract.restore(self._quiet[0])
        self._calls.restore(self._quiet[1])

    def snapshot(self) -> object:
        """The state of monitors and PLC, the program's apart."""
        monitors = self._contract.snapshot(), self._calls.snapshot()
        return monitors, self.runs, self.powered, dict(self._outside)

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        (contract, calls), self.runs, self.powered, outside = snapshot
        self._contract.restore(contract)
        self._calls.restore(calls)
        self._outside = dict(outside)
