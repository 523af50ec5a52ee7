"""Runs with every pattern of Execute, every course of an answer, and faults at each scan.

A case has four parts. First, the block is started and disturbed until it has ended. Second, the
block withdraws its requests while the cause is still present. Third, the cause is removed, and
nothing
starts by itself. Last, the documented recovery restores the cell, and the block does its work.

With normal answers, a fault comes at each scan of the sequence, under each pattern (in a long
sequence the patterns alternate). With a missing, late or withdrawn answer, it comes around each
change on the wire; of these cases at most 24 are run for a block and a fault (160 without a fault).
The option --every-case runs all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

from fault_cell import TIMEOUT_SCANS, CaseFailure, FaultCell, Pins
from fault_kinds import FAULTS, NONE, Fault
from fault_scenarios import SCENARIOS, Scenario

__all__ = ["FAULTS", "Answer", "Case", "Fault", "Pattern", "Rig", "rig"]

#: Longest time from a block's last wait to its end, with the interval of input changes [scans].
_MOST_END_SCANS = 60
#: Longest time until requests are withdrawn and no block uses a channel [scans].
_MOST_RELEASE_SCANS = 45
#: Longest time until the cell is stable after the causes are removed [scans].
_STEADY = 150
#: Delay of an answer that is late but still within Timeout [scans].
_LATE = 8
#: In a sequence of this length or more, the patterns alternate [scans].
_LONG = 20
#: Largest number of cases with a disturbed answer, for each block and each fault.
_MOST_SHAPED = 24


class Pattern(NamedTuple):
    """A pattern of Execute: TRUE for `scans` scans, or TRUE in every other scan."""

    name: str
    scans: int
    toggles: bool = False

    def execute(self, scan: int) -> bool:
        """Return the value of Execute in this scan, counted from the start of the block."""
        return scan % 2 == 0 if self.toggles else scan < self.scans


HELD = Pattern("held", 1 << 30)
ONE_SCAN = Pattern("one scan", 1)
RETRIGGERED = Pattern("re-triggered", 0, toggles=True)
_BASIC = (HELD, ONE_SCAN, RETRIGGERED)


def _dropped(scan: int) -> Pattern:
    return Pattern(f"dropped at scan {scan}", scan)


class Answer(NamedTuple):
    """One of the controller's answers, and how it is disturbed."""

    fate: str = "normal"
    signal: str = ""

    def __str__(self) -> str:
        return f"{self.signal} {self.fate}".strip()


NORMAL = Answer()
_FATES = ("missing", "late", "too late", "withdrawn", "flickering")


class Case(NamedTuple):
    """A run with a fault in scan `scan`, counted from the rising edge of Execute."""

    pattern: Pattern
    answer: Answer
    fault: Fault
    scan: int

    def __str__(self) -> str:
        fault = "no fault" if self.fault is NONE else f"{self.fault.name} at scan {self.scan}"
        return f"Execute {self.pattern.name}, answer {self.answer}, {fault}"


class _Course(NamedTuple):
    """A run without a fault: the signals in each scan, and the scan in which the block ended."""

    wires: list[bytes]
    ended: int
    pins: Pins

    def moments(self) -> list[int]:
        """Return the scans around each signal change, and a scan in the middle of each wait."""
        last = [0]
        found = {0, 1, self.ended, self.ended + 1}
        for scan in range(1, self.ended + 1):
            if self.wires[scan] != self.wires[scan - 1]:
                found |= {scan - 1, scan, scan + 1, (last[-1] + scan) // 2}
                last.append(scan)
        found.add((last[-1] + self.ended) // 2)
        return sorted(found)


class Rig:
    """A block in its cell, ready to start, with the record of its run without faults.

    Args:
        block: Type of the block.
        lib: Folder of the library; None for plc/lib.
    """

    def __init__(self, block: str, lib: Path | None = None) -> None:
        self.block = block
        self.scenario: Scenario = SCENARIOS[block]
        self.cell = FaultCell(
            block, self.scenario.inputs, self.scenario.helpers, self.scenario.robot, lib
        )
        self.scenario.prepare(self.cell)
        assert not self.cell.cell.violations, self.cell.cell.violations[0].text
        self._start = self.cell.cell.snapshot()
        self._at_start = {
            signal: signal != "Status" and self.cell.on(signal) for signal in self.scenario.answers
        }
        self._answered: dict[str, int] = {}
        self._courses: dict[Answer, _Course] = {}
        self._end_causes: list[Callable[[], None]] = []
        self._seen: list[bytes] = []

    def cases(self, fault: Fault, *, every: bool = False) -> list[Case]:
        """Return the cases with this fault.

        With `every`, also return the cases that are normally left out.
        """
        answers = [Answer(fate, name) for name in self.scenario.answers for fate in _FATES]
        if fault is NONE:
            return list(self._without_fault(answers, every))
        shaped = list(self._around_changes(fault, answers))
        return [*self._at_each_scan(fault, every), *_thinned(shaped, _MOST_SHAPED, every)]

    def one_of_each(self) -> list[Case]:
        """Return a case for each fault in the middle of the work, and one for each bad answer."""
        middle = self._course(NORMAL).ended // 2
        faults = (fault for fault in FAULTS.values() if fault is not NONE)
        found = [Case(_BASIC[turn % 3], NORMAL, fault, middle) for turn, fault in enumerate(faults)]
        answers = [Answer(fate, name) for name in self.scenario.answers for fate in _FATES]
        return [
            *found,
            *(Case(_BASIC[turn % 3], answer, NONE, 0) for turn, answer in enumerate(answers)),
        ]

    def _without_fault(self, answers: list[Answer], every: bool) -> Iterator[Case]:
        ended = self._course(NORMAL).ended
        for pattern in (*_BASIC, *map(_dropped, range(2, ended + 2))):
            yield Case(pattern, NORMAL, NONE, 0)
        shaped = [
            Case(pattern, answer, NONE, 0)
            for answer in answers
            for pattern in (*_BASIC, *map(_dropped, self._course(answer).moments()[2:]))
        ]
        yield from _thinned(shaped, 4 * _MOST_SHAPED, every)

    def _at_each_scan(self, fault: Fault, every: bool) -> Iterator[Case]:
        ended = self._course(NORMAL).ended
        for scan in range(ended + 2):
            patterns = [HELD, ONE_SCAN, RETRIGGERED]
            if scan > 1:
                patterns.append(_dropped(scan))
            if ended > _LONG and not every:
                patterns = [patterns[scan % len(patterns)]]
            yield from (Case(pattern, NORMAL, fault, scan) for pattern in patterns)

    def _around_changes(self, fault: Fault, answers: list[Answer]) -> Iterator[Case]:
        turn = 0
        for answer in answers:
            for scan in self._course(answer).moments():
                yield Case(_BASIC[turn % 3], answer, fault, scan)
                turn += 1

    def run(self, case: Case) -> None:
        """Run one case.

        Raises:
            CaseFailure: the case failed; the message has the case and the last events.
        """
        try:
            self._run(case)
        except CaseFailure as failure:
            raise CaseFailure(f"{self.block}: {case}: {failure}") from None

    def _run(self, case: Case) -> None:
        cell = self.cell
        self._restart()
        _, pins = self._disturb(case)
        self._expect(case, pins)
        cell.start(False)
        self._lets_go(case)
        cell.quiet = True
        self._remove_causes(case)
        self._stays_quiet()
        cell.quiet = False
        self.scenario.prepare(cell)
        self._works_again()
        if cell.cell.violations:
            cell.fail(cell.cell.violations[0].text)

    def _restart(self) -> None:
        self.cell.restore(self._start)
        self._seen = []

    # --- the disturbed run -------------------------------------------------------------------

    def _disturb(self, case: Case) -> tuple[int, Pins]:
        """Start the block with the disturbance of the case; return the scan and kind of its end."""
        cell, fault = self.cell, case.fault
        limit = (
            self.scenario.waits * TIMEOUT_SCANS
            + _MOST_END_SCANS
            + case.answer.fate.count("late") * _LATE
        )
        ended: int | None = None
        end = pins = cell.pins
        scan = 0
        while ended is None or scan <= max(ended + 2, case.scan):
            self._shape(case.answer, scan, ended)
            if scan == case.scan:
                fault.begin(cell)
            if fault.lasts is not None and scan == case.scan + fault.lasts:
                fault.end(cell)
            if ended is None:
                cell.start(case.pattern.execute(scan))
            elif case.pattern.toggles or ended < case.pattern.scans <= scan:
                cell.start(False)
            pins = cell.scan()
            self._seen.append(cell.wire())
            if ended is None and not pins.busy:
                ended, end = scan, pins
                self._check_end(pins)
            elif ended is None and scan > limit:
                cell.fail(f"the block hangs: Busy for {scan} scans, expected at most {limit}")
            scan += 1
        assert ended is not None
        return ended, end

    def _check_end(self, pins: Pins) -> None:
        cell = self.cell
        if not (pins.done or pins.error or pins.aborted):
            cell.fail("Busy is FALSE, but there is no Done and no error")
        if not pins.done:
            return
        for name, on in self.scenario.means.items():
            if cell.on(name) is not on:
                cell.fail(f"Done, but {name} is {'OFF' if on else 'ON'} as the PLC reads it")
        if "Status" in self.scenario.answers and cell.status != 0x0200:
            cell.fail(f"Done with status 0x{cell.status:04X}")

    def _shape(self, answer: Answer, scan: int, ended: int | None) -> None:
        """Before a scan, delay, suppress or interrupt the controller's answer as the case says."""
        if answer.fate == "normal":
            return
        due = self._due(answer.signal)
        if answer.fate in ("missing", "late", "too late"):
            if scan == 0:
                self._force(answer.signal)
            late = answer.fate == "late" and scan == due + _LATE
            if late or (answer.fate == "too late" and ended is not None and scan == ended + 2):
                self.cell.cell.robot.release(answer.signal)
        elif scan == due + 1:
            self._force(answer.signal)
        elif answer.fate == "flickering" and scan == due + 3:
            self.cell.cell.robot.release(answer.signal)

    def _force(self, signal: str) -> None:
        robot = self.cell.cell.robot
        if signal == "Status":
            robot.force("Status", 0)
        else:
            robot.force(signal, int(self._at_start[signal]))

    def _due(self, signal: str) -> int:
        """Return the scan in which the answer arrives in a run without faults."""
        if signal not in self._answered:
            wires = self._course(NORMAL).wires
            scans = [k for k, wire in enumerate(wires) if self._is_answer(signal, wire)]
            if not scans:
                self.cell.fail(f"{self.block}: {signal} never comes, although there is no fault")
            self._answered[signal] = scans[0]
            self._restart()
        return self._answered[signal]

    def _is_answer(self, signal: str, wire: bytes) -> bool:
        if signal == "Status":
            return wire[:2] == b"\x00\x02"
        return bool(wire[2 + int(signal[2])] >> int(signal[3]) & 1) is not self._at_start[signal]

    def _course(self, answer: Answer) -> _Course:
        if answer not in self._courses:
            if answer.signal:
                self._due(answer.signal)
            self._restart()
            ended, pins = self._disturb(Case(HELD, answer, NONE, 0))
            self._courses[answer] = _Course(self._seen, ended, pins)
        return self._courses[answer]

    def _expect(self, case: Case, pins: Pins) -> None:
        """Check Done or Error at the end of a case without a fault."""
        if case.fault is not NONE:
            return
        if case.answer.fate in ("normal", "late") and not pins.done:
            self.cell.fail(f"16#{pins.error_id:04X} instead of Done")
        if case.answer.fate in ("missing", "too late") and not pins.error:
            self.cell.fail("Done without the answer")

    # --- the rules after the disturbance -----------------------------------------------------

    def _lets_go(self, case: Case) -> None:
        """Check that outputs clear at once, and that channels become free despite the fault."""
        cell = self.cell
        pins = cell.scan()
        if any(pins):
            cell.fail("the outputs stay although Execute is FALSE and the end was shown")
        cell.until(lambda: not cell.requests, _MOST_RELEASE_SCANS, "the requests are withdrawn")
        cell.until(
            lambda: cell.free("Sequence"), _MOST_RELEASE_SCANS, "the turn for sequences is free"
        )
        if "Status" not in (case.answer.signal, *self.scenario.answers):
            cell.until(
                lambda: cell.free("Command"), _MOST_RELEASE_SCANS, "the turn for commands is free"
            )

    def _remove_causes(self, case: Case) -> None:
        case.fault.end(self.cell)
        if case.answer.signal:
            self.cell.cell.robot.release(case.answer.signal)

    def _stays_quiet(self) -> None:
        """Check that the cell becomes idle and nothing starts by itself."""
        cell = self.cell
        there = "connection and CPU_OK"
        cell.until(lambda: bool(cell["Robot.Connected"]) and cell.on("SO01"), _STEADY, there)
        cell.until(lambda: cell.free("Command"), _STEADY, "the turn for commands is free")
        cell.until(
            lambda: cell.free("Sequence"), _MOST_RELEASE_SCANS, "the turn for sequences is free"
        )
        for _ in range(6):
            cell.scan()

    def _works_again(self) -> None:
        cell = self.cell
        limit = self.scenario.waits * TIMEOUT_SCANS + _MOST_END_SCANS
        cell.start(True)
        if not cell.scan().busy:
            cell.fail("after recovery, no Busy in the scan of the edge")
        cell.until(lambda: not cell.pins.busy, limit, "the block ends, after recovery")
        if not cell.pins.done:
            cell.fail(f"16#{cell.pins.error_id:04X} instead of Done, after recovery")
        self._check_end(cell.pins)
        cell.start(False)
        if any(cell.scan()):
            cell.fail("the outputs stay although Execute is FALSE, after recovery")


def _thinned(cases: list[Case], most: int, every: bool) -> list[Case]:
    """Return every n-th case, with n chosen for about `most` cases.

    n is not a multiple of 3, because the three patterns alternate.
    """
    step = 1 if every else max(1, -(-len(cases) // most))
    return cases[:: step + (step > 1 and step % 3 == 0)]


@cache
def rig(block: str) -> Rig:
    """Return the rig of a block. Each process makes it once."""
    return Rig(block)
