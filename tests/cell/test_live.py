"""In real time over cyclic I/O, events have the right order even on a slow computer."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.cell.clock import Kind, Timing
from rcx_harness.cell.live import RealTimeAgenda, RealTimeLink
from rcx_harness.cli.app import main
from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.trace import Cycle, Scan, read_trace
from structured_text.errors import InputError

Build = Callable[..., Cell]
Captured = pytest.CaptureFixture[str]

DEMO = ("plc", "examples", "01_power_up")
#: The link's time-out. It is so long that a busy computer cannot cause a loss of the link.
PATIENT = "5s"


class Clock:
    """A clock that only `sleep` and `late` advance."""

    def __init__(self) -> None:
        self.now_us = 1_000_000
        self.slept: list[float] = []

    def sleep(self, seconds: float) -> None:
        """Advance the clock by exactly this time, and record the sleep."""
        self.slept.append(seconds)
        self.now_us += round(seconds * 1e6)

    def late(self, us: int) -> None:
        """Simulate a delay by other work on the computer."""
        self.now_us += us


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def agenda(clock: Clock) -> RealTimeAgenda:
    """Return an agenda with ten events, one every 10 ms from 0 on."""
    made = RealTimeAgenda(lambda: clock.now_us, clock.sleep)
    for number in range(10):
        made.add(10_000 * number, Kind.SCAN, lambda now_us: None)
    return made


def test_the_first_event_starts_the_clock(agenda: RealTimeAgenda, clock: Clock) -> None:
    assert [agenda.pop()[0] for _ in range(3)] == [0, 10_000, 20_000]
    assert clock.slept == [0.01, 0.01]
    assert clock.now_us == 1_020_000


def test_a_short_delay_is_made_up_for(agenda: RealTimeAgenda, clock: Clock) -> None:
    agenda.pop()
    clock.late(14_000)
    agenda.pop()
    agenda.pop()
    assert clock.slept == [pytest.approx(0.006)]
    assert (agenda.stalls, agenda.stalled_us) == (0, 0)


def test_a_standstill_causes_no_burst(agenda: RealTimeAgenda, clock: Clock) -> None:
    """After a standstill of the computer, the scans are not made up for.

    The packets of the standstill are already lost, so scans in a burst would not receive them.
    """
    agenda.pop()
    clock.late(60_000)
    agenda.pop()
    assert (agenda.stalls, agenda.stalled_us) == (1, 50_000)
    agenda.pop()
    agenda.pop()
    assert clock.slept == [0.01, 0.01]
    assert clock.now_us == 1_080_000


@pytest.fixture
def links(monkeypatch: pytest.MonkeyPatch) -> list[RealTimeLink]:
    """Return a list of the links that are created during the test."""
    made: list[RealTimeLink] = []

    class Recorded(RealTimeLink):
        def __init__(self, size: int, timing: Timing) -> None:
            super().__init__(size, timing)
            made.append(self)

    monkeypatch.setattr("rcx_harness.cell.live.RealTimeLink", Recorded)
    return made


@pytest.fixture
def cell(build_cell: Build, repository: Path) -> Cell:
    """Return the demo's cell over a real link, which is lost after 640 ms without a packet."""
    demo = repository.joinpath(*DEMO)
    cell = build_cell(
        demo, robot=demo / "robot.toml", link="enip-realtime", rpi="5ms", timeout="640ms"
    )
    cell["Main.CellSafe"] = True
    return cell


@pytest.mark.exhaustive
def test_the_demo_runs_over_cyclic_io_with_its_events_in_order(
    build_cell: Build, repository: Path, tmp_path: Path
) -> None:
    """Power-up, servo ON and program reset occur in the order of the manual's timing charts.

    Source: manual chapter 5, 3.1 and 3.2
    """
    demo, trace = repository.joinpath(*DEMO), tmp_path / "trace.jsonl"
    cell = build_cell(
        demo, robot=demo / "robot.toml", link="enip-realtime", timeout=PATIENT, trace=trace
    )
    cell["Main.CellSafe"] = True
    cell.run_until(lambda: bool(cell["Main.Robot.Connected"]), within="60s")
    cell["Main.Start"] = True
    cell.run_until(lambda: bool(cell["Main.Robot.SO.SO14_ProgramReset"]), within="60s")
    assert cell.violations == []
    cell.close()

    header, records = read_trace(trace)
    assert header["link"] == "enip-realtime"
    entries = list(records)
    expected = ["SO00", "SI00", "SI06", "SI01", "SO02", "SI15", "SO14"]
    scans = [(entry.so, entry.si) for entry in entries if isinstance(entry, Scan)]
    assert rises(scans) == expected
    # The controller's own record must have the same order as the PLC's record.
    cycles = [(entry.rcx_so, entry.rcx_si) for entry in entries if isinstance(entry, Cycle)]
    assert rises(cycles) == expected


def test_the_command_runs_in_real_time_for_a_given_time(
    repository: Path, tmp_path: Path, capsys: Captured
) -> None:
    """A run of 0.2 s has 20 scans and 40 cycles even if the computer needs more than 0.2 s."""
    demo, trace = repository.joinpath(*DEMO), tmp_path / "trace.jsonl"
    options = ["--link", "enip", "--realtime", "--for", "200ms", "--trace", str(trace)]
    assert main(["run", str(demo), "--engine", "builtin", *options]) == 0
    out = capsys.readouterr().out
    assert "0.2 s on the builtin engine: 20 scans, 40 controller cycles" in out
    assert read_trace(trace)[0]["link"] == "enip-realtime"


def rises(areas: list[tuple[bytes, bytes]]) -> list[str]:
    """Return the names of dedicated bits in the order of their rising edges.

    Args:
        areas: Pairs of the controller's output area and input area, in the order of time.
    """
    outputs = {"SO00": 0, "SO02": 2, "SO14": 12}
    inputs = {"SI00": 0, "SI01": 1, "SI06": 6, "SI15": 13}
    found, before = [], (0, 0)
    for pair in areas:
        after = (dedicated(pair[0]), dedicated(pair[1]))
        for side, names in enumerate((outputs, inputs)):
            risen = after[side] & ~before[side]
            found += [name for name, bit in names.items() if risen >> bit & 1]
        before = after
    return found


def dedicated(area: bytes) -> int:
    """Return the 16 dedicated bits in bytes 32 and 33, or 0 if the area is empty."""
    return int.from_bytes(area[32:34], "little")


@pytest.mark.exhaustive
def test_an_unplugged_cable_is_a_loss_of_the_link(cell: Cell) -> None:
    """If the cable is unplugged, the PLC and the controller each detect the loss by a time-out.

    Source: manual chapter 1, 5.2
    """
    cell.run_until(lambda: cell.connected and cell.robot.machine.si00, within="20s")
    cell.inject("link_down")
    cell.run_until(lambda: not cell.connected, within="20s")
    cell.run_until(lambda: cell.robot.machine.link == "lost", within="20s")
    assert not cell.robot.machine.si00
    assert not cell.robot.machine.si06
    assert "12.552" in [alarm.number for alarm in cell.robot.alarms.active]
    cell.inject("link_up")
    cell.run_until(lambda: cell.connected and cell.robot.machine.link == "normal", within="20s")


@pytest.mark.exhaustive
def test_a_power_cycle_of_the_controller_interrupts_the_connection(cell: Cell) -> None:
    cell.run_until(lambda: cell.connected and cell.robot.machine.link == "normal", within="20s")
    # A power cycle might be over before a busy computer checks, so the power stays off
    cell.inject("power_off")
    cell.run_until(lambda: not cell.connected, within="20s")
    cell.inject("power_on")
    cell.run_until(lambda: cell.connected and cell.robot.machine.link == "normal", within="20s")


@pytest.mark.exhaustive
def test_sizes_that_differ_make_no_connection(build_cell: Build, repository: Path) -> None:
    """A PLC with 48 bytes cannot connect to 256 bytes. Source: manual chapter 3, 1."""
    demo = repository.joinpath(*DEMO)
    cell = build_cell(demo, robot=RobotConfig(size=256), size=48, link="enip-realtime")
    cell.run("200ms")
    assert not cell.matched
    assert not cell.connected


@pytest.mark.exhaustive(but=["adapter"])
@pytest.mark.parametrize("part", ["adapter", "its cyclic part", "scanner"])
def test_a_dead_process_is_reported(links: list[RealTimeLink], cell: Cell, part: str) -> None:
    cell.run_until(lambda: cell.connected, within="20s")
    (link,) = links
    adapter = link.adapter.pid
    if part == "scanner":
        os.kill(link.scanner.pid, signal.SIGKILL)
    elif part == "adapter":
        os.kill(adapter, signal.SIGKILL)
    else:
        (cyclic,) = Path(f"/proc/{adapter}/task/{adapter}/children").read_text().split()
        os.kill(int(cyclic), signal.SIGKILL)
    with pytest.raises(ProcessDiedError, match="killed by SIGKILL"):
        cell.run("20s")


@pytest.mark.exhaustive
def test_there_is_no_snapshot_of_a_real_network(cell: Cell) -> None:
    with pytest.raises(InputError, match="no snapshot"):
        cell.snapshot()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--realtime"], "--realtime needs a real network; add --link enip"),
        (["--realtime", "--link", "enip", "--jitter", "2ms"], "--jitter is for virtual time"),
        (["--realtime", "--link", "enip", "--timeout", "1m"], "cannot be requested"),
    ],
)
def test_wrong_options_in_real_time_are_bad_input(
    repository: Path, capsys: Captured, options: list[str], message: str
) -> None:
    assert main(["run", str(repository.joinpath(*DEMO)), *options]) == 2
    assert message in capsys.readouterr().err
