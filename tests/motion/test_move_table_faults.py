"""FB_MoveTable survives every fault in every scan of a table, on the virtual controller.

The table must show the row of the telegram on the wire, which the test decodes.

After a fault the table waits for a new start. Then it runs to its end, and each row has been done
once and in order.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig
from rcx_tools.evidence.broken import broken_library

_TABLE: list[dict[str, Any]] = [
    {"Kind": "MOVE_PTP", "Point": 1, "AtArrival": "ARRIVE_SET", "Number": 20, "State": True},
    {"Kind": "MOVE_LINEAR", "Point": 2, "AtArrival": "ARRIVE_PAUSE", "Duration": "T#50ms"},
    {"Kind": "MOVE_PALLET", "WorkPosition": 3},
    {"Kind": "MOVE_PTP", "Point": 4, "AtArrival": "ARRIVE_SET", "Number": 20},
]
#: Maps code and words of a telegram to the row, and to whether its movement has ended.
_ROWS: dict[tuple[int, ...], tuple[int, bool]] = {
    (0x0001, 1): (1, False),
    (0x0301, 0x1020, 1): (1, True),
    (0x0003, 2): (2, False),
    (0x0018, 0, 3): (3, False),
    (0x0001, 4): (4, False),
    (0x0301, 0x1020, 0): (4, True),
}
_ALL = list(_ROWS.values())
#: Maps an injected fault to the event that ends the fault.
_FAULTS = {
    "emergency stop": ("emergency_stop", "emergency_stop_release"),
    "stop": ("StopOk", "StopOk"),
    "alarm": ("alarm", ""),
    "link": ("link_down", "link_up"),
    "controller": ("power_cycle", ""),
    "motor power": ("main_power_off", "main_power_on"),
    "PLC restart": ("plc_power_off", "plc_power_on"),
}


class _Watched:
    """A cell that runs scan by scan, and records the rows that have ended normally."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.done: list[tuple[int, bool]] = []
        self.out: tuple[int, bool] | None = None
        self.started = False
        self.judged = 0

    def scan(self) -> None:
        """Run one scan and check it."""
        before = self.cell.scans
        self.cell.run("10ms")
        if self.cell.scans == before:
            self.out = None  # the PLC is stopped
            return
        so, si = (self._words(f"Main.{name}Area") for name in ("Input", "Output"))
        if self.out and so[0] == 0x0200 and self.cell["Main.Robot.Connected"]:
            self.done.append(self.out)
        self.out = _row(si) if si[0] else None
        data = any(si[1:16])
        assert not (si[0] or data) or self.started, "a movement begins by itself"
        if self.out:
            self.judged += 1
            shown = (self.cell["Main.Table.Row"], self.cell["Main.Table.Arrived"])
            assert shown == self.out, "the shown row is not the row on the wire"
            kept = (self.cell["Main.KeptRow"], self.cell["Main.KeptArrived"])
            assert kept == self.out
        if not self.cell["Main.Table.Busy"]:
            self.started = False

    def scan_until(self, name: str, most: int, *, value: bool = True) -> None:
        """Run scans until this variable is TRUE."""
        for _ in range(most):
            if self.cell[f"Main.{name}"] is value:
                return
            self.scan()
        raise AssertionError(f"{name} is not {value} within {most} scans")

    def go(self) -> None:
        """Give Execute a rising edge."""
        self.cell["Main.Go"] = False
        self.scan()
        self.started = True
        self.cell["Main.Go"] = True
        self.scan()

    def recover(self) -> None:
        """Recover after the causes are removed: reset the alarm, then switch the servos on."""
        self.cell["Main.Recover"] = self.cell["Main.Go"] = False
        self.scan()
        self.cell["Main.Recover"] = True
        self.scan()
        self.scan_until("PowerUp.Busy", 400, value=False)
        assert self.cell["Main.PowerUp.Done"], hex(int(str(self.cell["Main.PowerUp.ErrorID"])))
        self.scan_until("Robot.Settled", 60)

    def _words(self, path: str) -> list[int]:
        area = self.cell.program.read_bytes(path)[:48]
        return [area[k] | area[k + 1] << 8 for k in range(0, 48, 2)]


def _row(words: list[int]) -> tuple[int, bool]:
    """Return the row of the table that has sent this telegram.

    Source: guide 4.2.1: point at n + 8; 4.2.5: pallet at n + 8, work position at n + 10; 4.5.1:
    port and bit at n + 4, value at n + 6.
    """
    code = words[0]
    places: dict[int, tuple[int, ...]] = {
        0x0001: (4,),
        0x0003: (4,),
        0x0018: (4, 5),
        0x0301: (2, 3),
    }
    at = places[code]
    key = (code, *(words[k] for k in at))
    return _ROWS[key]


@contextmanager
def _started(
    rows: list[dict[str, Any]] = _TABLE, lib: Path | None = None, **knobs: Any
) -> Iterator[_Watched]:
    """Return a cell with the servos on and a table that has just been started."""
    config = RobotConfig.load(ROOT / "tests/data/library/table_run.toml")
    config = replace(config, **knobs)
    with Cell.build(
        ROOT / "tests/data/library/TableRun.st", lib=lib, engine="builtin", robot=config
    ) as cell:
        for number, row in enumerate(rows, 1):
            for field, value in row.items():
                cell[f"Main.Moves[{number}].{field}"] = value
        watched = _Watched(cell)
        cell.run("200ms")
        watched.recover()
        watched.go()
        yield watched


def _inject(cell: Cell, event: str, *, there: bool) -> None:
    if event == "StopOk":
        cell["Main.StopOk"] = not there
    elif event:
        cell.inject(event)


def _survives(watched: _Watched, fault: str, lasts: int) -> None:
    """Check that a fault starts no movement, and that all rows are done after recovery."""
    cell = watched.cell
    come, go = _FAULTS[fault]
    _inject(cell, come, there=True)
    for _ in range(lasts):
        watched.scan()
    _inject(cell, go, there=False)
    for _ in range(75):
        watched.scan()
    assert cell["Main.Table.Busy"] is False
    if cell["Main.KeptRow"]:
        watched.recover()
        for _ in range(5):
            watched.scan()
        watched.go()
        watched.scan_until("Table.Busy", 600, value=False)
        assert cell["Main.Table.Done"], hex(int(str(cell["Main.Table.ErrorID"])))
    assert watched.done == _ALL


def test_undisturbed_every_row_is_done_once() -> None:
    with _started() as watched:
        watched.scan_until("Table.Done", 600)
        assert watched.done == _ALL


@pytest.mark.exhaustive
@pytest.mark.parametrize("lasts", [1, 15])
@pytest.mark.parametrize("fault", _FAULTS)
def test_the_shown_row_is_the_row_on_the_wire_despite_faults(fault: str, lasts: int) -> None:
    """In every scan, the shown row is the row on the wire, and a fault does not change this.

    A fault of some scans begins before each scan of the run in turn.

    Source: manual chapter 1, 5.2; chapter 5, 3.1 and 3.3; guide 2.
    """
    with _started() as watched:
        tried = _before_each_scan(watched, fault, lasts)
    assert tried > 50


def _before_each_scan(watched: _Watched, fault: str, lasts: int) -> int:
    """Inject a fault before each scan of a run in turn, and return the number of scans."""
    tried = 0
    while watched.cell["Main.Table.Busy"]:
        tried += 1
        snapshot = watched.cell.snapshot()
        kept = (list(watched.done), watched.out, watched.started)
        scan = watched.cell.scans
        try:
            _survives(watched, fault, lasts)
        except AssertionError as failure:
            raise AssertionError(f"{fault} before scan {scan}: {failure}") from failure
        watched.cell.restore(snapshot)
        watched.done, watched.out, watched.started = kept
        watched.scan()
    return tried


@pytest.mark.exhaustive
def test_a_table_that_shows_another_row_at_a_fault_is_noticed() -> None:
    text = "  Answer := Run.ErrorID;\n"
    wrong = f"{text}  IF Out AND Failure <> WORD#16#0000 THEN\n    Row := Last;\n  END_IF;\n"
    with (
        broken_library("motion/FB_MoveTable.st", text, wrong) as lib,
        pytest.raises(AssertionError, match="the shown row is not the row on the wire"),
        _started(lib=lib) as watched,
    ):
        _before_each_scan(watched, "stop", 1)


@pytest.mark.parametrize(("start", "travels"), [("keep", True), ("reset", False)])
def test_a_stopped_relative_row_continues_as_configured(start: str, travels: bool) -> None:
    """A stopped relative row continues as the controller is configured.

    With the setting Keep, it ends at its original target. With Reset, it repeats its distance.

    Source: guide 4.2.2, notes.
    """
    rows = [{"Kind": "MOVE_BY_PTP", "Point": 5}]
    with _started(rows, movei_start_position=start) as watched:
        cell = watched.cell
        cell.run_until(lambda: cell["Main.Robot.Inner.Phase"] == "PHASE_COMMAND_RUN", "1s")
        cell.run("150ms")
        cell["Main.StopOk"] = False
        cell.run("300ms")
        assert (cell["Main.Table.ErrorID"], cell["Main.Table.Row"]) == (0x8020, 1)
        assert (cell["Main.Table.AlarmGroup"], cell["Main.Table.AlarmCategory"]) == (12, 400)
        stopped = cell.robot.positions[0]
        assert 0 < stopped < 80000
        cell["Main.StopOk"] = True
        cell.run("300ms")
        cell["Main.Go"] = False
        cell.run("10ms")
        cell["Main.Go"] = True
        cell.run_until(lambda: bool(cell["Main.Table.Done"]), "5s")
        assert cell.robot.positions[0] == (80000 if travels else stopped + 80000)
