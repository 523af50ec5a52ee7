"""With Enable, level blocks show exactly one of Valid, Busy and Error, also during faults."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import pytest

from fault_cell import TIMEOUT_SCANS, CaseFailure, FaultCell, library
from fault_run import FAULTS, Fault
from fault_scenarios import LEVELS

#: Numbers of scans from Enable to the start of a fault.
_MOMENTS = (*range(7), 14)
_STEADY = 150
_ENABLES: dict[str, Callable[[int, int], bool]] = {
    "held": lambda scan, fault: True,
    "one scan": lambda scan, fault: scan == 0,
    "toggled": lambda scan, fault: scan % 2 == 0,
    "dropped with the fault": lambda scan, fault: scan < fault,
    "raised with the fault": lambda scan, fault: scan >= fault,
}


class _Level:
    """A cell with a level block whose preparations are complete."""

    def __init__(self, block: str) -> None:
        self.block, self.scenario = block, LEVELS[block]
        self.cell = FaultCell(
            block, self.scenario.inputs, self.scenario.helpers, self.scenario.robot
        )
        self.scenario.prepare(self.cell)
        for _ in range(13):  # wait for the 100 ms interval after the last change
            self.cell.scan()
        self.start = self.cell.cell.snapshot()

    def run(self, enable: str, fault: Fault, at: int, missing: bool) -> None:
        cell = self.cell
        cell.restore(self.start)
        signal = self.scenario.answers[0]
        if missing:
            cell.cell.robot.force(signal, 0)
        for scan in range(at + (TIMEOUT_SCANS + 5 if missing else 20)):
            if scan == at:
                fault.begin(cell)
            if fault.lasts is not None and scan == at + fault.lasts:
                fault.end(cell)
            self._scan(_ENABLES[enable](scan, at))
        fault.end(cell)
        cell.cell.robot.release(signal)
        self._scan(False)
        cell.quiet = True
        there = "connection and CPU_OK"
        cell.until(lambda: bool(cell["Robot.Connected"]) and cell.on("SO01"), _STEADY, there)
        cell.until(lambda: not cell.requests, _STEADY, "the requests are withdrawn")
        cell.quiet = False
        self.scenario.prepare(cell)
        cell.start(True)
        cell.until(lambda: cell.pins.done, _STEADY, "Valid, after recovery")
        for name, on in self.scenario.means.items():
            if cell.on(name) is not on:
                cell.fail(f"Valid, but {name} is {'OFF' if on else 'ON'} as the PLC reads it")
        if cell.cell.violations:
            cell.fail(cell.cell.violations[0].text)

    def _scan(self, enable: bool) -> None:
        self.cell.start(enable)
        pins = self.cell.scan()
        if sum(pins[:3]) != enable:
            self.cell.fail(f"Enable is {enable}, but the outputs are {pins}")
        if pins.done and not all(
            self.cell.on(name) is on for name, on in self.scenario.means.items()
        ):
            self.cell.fail("Valid, but the controller's outputs do not confirm it")


@cache
def _level(block: str) -> _Level:
    return _Level(block)


def test_every_level_block_has_a_scenario() -> None:
    assert set(library().level) == set(LEVELS)


_BLOCKS = sorted(set(library().level) & set(LEVELS))


@pytest.mark.exhaustive(but=["FB_AutoMode", "FB_Jog", "FB_Override", "FB_ToolPosition"])
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_level_block_recovers_from_each_fault(block: str) -> None:
    """The block recovers from each fault, which begins in scan 3.

    The patterns of Enable and the answers of the controller alternate from fault to fault.

    Source: manual chapter 1, 5; chapter 5, 2.
    """
    patterns = [*_ENABLES]
    turns = enumerate(FAULTS.values())
    _run(block, [(patterns[k % len(patterns)], fault, 3, k % 2 == 0) for k, fault in turns])


@pytest.mark.exhaustive
@pytest.mark.parametrize("enable", _ENABLES)
@pytest.mark.parametrize("block", _BLOCKS)
def test_a_level_block_is_valid_busy_or_in_error_and_recovers(
    block: str, enable: str, record_property: Callable[[str, object], None]
) -> None:
    """With Enable the block is always Valid, Busy or in Error.

    Source: manual chapter 1, 5; chapter 5, 2.
    """
    cases = [
        (enable, fault, at, missing)
        for fault in FAULTS.values()
        for at in _MOMENTS
        for missing in ((False, True) if at in (0, 3) else (False,))
    ]
    record_property("instances", len(cases))
    _run(block, cases)


def _run(block: str, cases: list[tuple[str, Fault, int, bool]]) -> None:
    failures = []
    for enable, fault, at, missing in cases:
        try:
            _level(block).run(enable, fault, at, missing)
        except CaseFailure as failure:
            case = f"Enable {enable}, {fault.name} at scan {at}, answer missing: {missing}"
            failures.append(f"{block}: {case}: {failure}")
    assert not failures, f"{len(failures)} cases:\n" + "\n".join(failures[:3])
