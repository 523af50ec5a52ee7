"""Programs that write the area without the library break each rule of the wire."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.watch.wire import WireMonitor

Build = Callable[..., Cell]
#: Variables to set in the program, and the time to run afterwards.
Steps = list[tuple[dict[str, int], str]]

#: SI(00), SI(01), SI(06) in byte n+32; SI(15) in byte n+33.
SI00, SI01, SI06, SI15 = 0x01, 0x02, 0x40, 0x20
MOVE, REFERENCE = 0x0001, 0x0101
SLOW = RobotConfig(boot_time=0.0, command_delay=500.0, skip_run_status="never")


@pytest.fixture
def cell(raw_cell: Build) -> Cell:
    """Return a connected cell with the inputs OFF and no broken rule."""
    cell = raw_cell(scan="10ms", rpi="10ms", robot=RobotConfig(boot_time=0.0))
    cell.run("100ms")
    assert not cell.violations
    return cell


def found(cell: Cell, side: str) -> list[str]:
    """Return the broken rules that PLC or controller has reported, in order."""
    return [one.rule for one in cell.violations if one.text.startswith(side)]


def test_changes_100_ms_apart_break_no_rule(cell: Cell) -> None:
    """Source: manual chapter 5, 3.1, caution."""
    for bits in (SI00, SI00 | SI06, SI00 | SI06 | SI01, SI00 | SI06):
        cell["Main.Bits0"] = bits
        cell.run("100ms")
    assert not cell.violations


HELD = "while the status read was 16#0100; held until 16#0200 or 16#4000 is read"


@pytest.mark.parametrize(
    ("steps", "plc", "robot"),
    [
        pytest.param(
            [({"Bits0": SI00}, "90ms"), ({"Bits0": SI00 | SI06}, "100ms")],
            ["scan 19: interval: SI(06) ON only 90 ms after SI(00) ON; at least 100 ms"],
            ["interval"],
            id="90 ms between different dedicated inputs",
        ),
        pytest.param(
            [({"Bits0": SI00, "Bits1": SI15}, "50ms")],
            [
                "scan 10: interval: SI(00) ON and SI(15) ON in one scan; "
                "one change at a time, 100 ms apart"
            ],
            ["interval"],
            id="two changes in one scan",
        ),
        pytest.param(
            [({"Bits0": 0x04, "Reserved": 0x80}, "100ms")],
            [
                "scan 10: reserved: the reserved bit (n+32) 2 was set; it must stay OFF",
                "scan 10: reserved: the reserved bytes n+46, n+47 became 80 00",
            ],
            ["reserved"],
            id="reserved bits and bytes, once per change",
        ),
        pytest.param(
            [({"Data": 4, "Code": MOVE}, "20ms")],
            [
                "scan 10: data before code: n+2 changed together with the code 16#0001; "
                "data must be there one scan before"
            ],
            [],
            id="data that comes with the code",
        ),
        pytest.param(
            [({"Code": REFERENCE}, "100ms"), ({"Code": 0}, "50ms")],
            [f"scan 20: command held: the code changed from 16#0101 to 16#0000 {HELD}"],
            ["hold-command"],
            id="a code cleared before its end",
        ),
        pytest.param(
            [({"Code": REFERENCE}, "100ms"), ({"Data": 1}, "50ms")],
            [f"scan 20: command held: n+2 changed with the code 16#0101 out {HELD}"],
            ["hold-command"],
            id="data changed while the command runs",
        ),
    ],
)
def test_a_broken_rule_is_reported_by_both_sides(
    raw_cell: Build, steps: Steps, plc: list[str], robot: list[str]
) -> None:
    """Both monitors, of PLC and controller, report each broken rule.

    Dedicated inputs need 100 ms between changes; code and data are held until the end.

    Source: manual chapter 5, 1, note 1; 3.1, caution; guide chapter 1, 1.1, note; chapter 2,
    steps 1 and 2.
    """
    cell = raw_cell(scan="10ms", rpi="10ms", robot=SLOW)
    cell.run("100ms")
    for values, duration in steps:
        for name, value in values.items():
            cell[f"Main.{name}"] = value
        cell.run(duration)
    assert [one.text for one in cell.violations if one.text.startswith("plc")] == [
        f"plc, {text}" for text in plc
    ]
    assert found(cell, "robot") == robot


def test_a_code_without_ready_status_is_reported_by_both_sides(cell: Cell) -> None:
    """A code without the ready status is reported by the monitors of PLC and controller.

    Source: guide chapter 1, 1.2, code 0x0000.
    """
    cell["Main.Code"] = REFERENCE
    cell.run_until(lambda: cell["Main.Status"] == 0x40, within="200ms")
    cell["Main.Code"] = MOVE
    cell.run("50ms")
    assert found(cell, "plc") == ["ready before code"]
    assert cell.violations[0].text.endswith(
        "the code 16#0001 went out while the status read was 16#4000; expected 16#0000"
    )
    assert len(found(cell, "robot")) == 1


def test_a_whole_handshake_breaks_no_rule(cell: Cell) -> None:
    """Source: guide chapter 2, steps 1 to 6."""
    cell["Main.Data"] = 0
    cell.scan()
    cell["Main.Code"] = REFERENCE
    cell.run_until(lambda: cell["Main.Status"] in (0x02, 0x40), within="200ms")
    cell["Main.Code"] = 0
    cell.run_until(lambda: cell["Main.Status"] == 0, within="200ms")
    cell.run("50ms")
    assert not cell.violations
    assert cell.commands == 1


def test_a_continuous_output_may_be_ended_by_the_status_reset(cell: Cell) -> None:
    """A continuous output may be ended by the status reset, while its status is 0x0100.

    Source: guide 4.7.4.
    """
    cell["Main.Data"] = 1
    cell.scan()
    cell["Main.Code"] = 0x0505
    cell.run("100ms")
    assert cell["Main.Status"] == 0x01
    cell["Main.Code"] = 0
    cell.run("50ms")
    assert not cell.violations


def test_writes_without_a_link_are_not_judged(cell: Cell) -> None:
    """Writes without a link are not judged.

    After recovery, the first image is accepted as it is.
    """
    cell["Main.Bits0"] = SI00
    cell.run("100ms")
    cell.inject("link_down")
    cell.run_until(lambda: not cell["Main.Connected"], within="1s")
    cell["Main.Bits0"] = SI00 | SI06 | SI01
    cell.scan()
    cell["Main.Bits0"] = SI00
    cell.scan()
    cell.inject("link_up")
    cell.run("200ms")
    assert not cell.violations


def test_a_code_sent_before_the_loss_of_the_link_is_not_judged_after_it() -> None:
    """A code sent before a loss of the link is not judged after it.

    The controller may have executed it or not.
    """
    ready, rest = bytearray(48), bytes(48)
    ready[32] = 0x02  # SO(01)
    move = MOVE.to_bytes(2, "little") + bytes(46)
    monitor = WireMonitor()
    scans = [(rest, True), (move, True), (move, False), (move, True), (rest, True)]
    found = [
        monitor.scan(10_000 * scan, scan, bytes(ready), area, connected)
        for scan, (area, connected) in enumerate(scans)
    ]
    assert found == [[]] * len(scans)
    assert [one.rule for one in monitor.scan(60_000, 6, bytes(ready), move, True)] == []
    assert [one.rule for one in monitor.scan(70_000, 7, bytes(ready), rest, True)] == [
        "command held"
    ]
