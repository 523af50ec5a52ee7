"""A command that is shorter than a controller cycle may skip status 0x0100 (guide, 1.2)."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import groupby, pairwise
from pathlib import Path

import pytest

from both_engines import ENGINES
from rcx_harness import Cell, RobotConfig
from robot_master import NORMAL_END, Master, abnormal_end, powered_up

READY, RUN, NORMAL, ABNORMAL = 0x0000, 0x0100, 0x0200, 0x4000
#: Telegrams of commands: for each category that writes data, one command.
COMMANDS = [
    (0x0027, 0, 100),
    (0x0100, 0, 5, 0, 1),
    (0x0200, 0, 1, 0, 12),
    (0x0300, 0, 0x1020, 1),
    (0x0401, 1, 1, 1, 32),
    (0x0602, 0, 24, 2, 29),
    (0x0701, 0, 24, 0, 13, 1, 1),
]

PROGRAM = """PROGRAM Main
  VAR
    InputArea  : RCX_IMAGE;
    OutputArea : RCX_IMAGE;
    Robot      : RCX_REF;
    ReadArea   : FB_ReadArea;
    WriteArea  : FB_WriteArea;
    Raw        : FB_RemoteCommand;
    Amount     : FB_SetInchingAmount;
    Reading    : FB_ReadInchingAmount;
  END_VAR

  ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  Raw(Robot := Robot);
  Amount(Robot := Robot);
  Reading(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


def _statuses(master: Master, words: tuple[int, ...]) -> list[int]:
    """Return the statuses from a command to its end, without repetitions."""
    master.send(*words)
    seen = []
    while master.status not in (NORMAL, ABNORMAL):
        master.run(5)
        seen.append(master.status)
    assert master.words == NORMAL_END
    master.send()
    master.run(10)
    assert master.words == (0,) * 16
    return [status for status, _ in groupby(seen)]


@pytest.mark.parametrize("words", COMMANDS, ids=lambda words: f"0x{words[0]:04X}")
@pytest.mark.parametrize(
    ("knob", "delay", "expected"),
    [
        ("short", 0.0, [NORMAL]),
        ("short", 4.9, [NORMAL]),
        ("short", 5.0, [RUN, NORMAL]),
        ("short", 10.0, [RUN, NORMAL]),
        ("never", 0.0, [RUN, NORMAL]),
        ("never", 10.0, [RUN, NORMAL]),
        ("always", 0.0, [NORMAL]),
        ("always", 10.0, [READY, NORMAL]),
    ],
)
def test_a_key_decides_whether_the_run_status_is_shown(
    words: tuple[int, ...], knob: str, delay: float, expected: list[int]
) -> None:
    """If skipping is configured, only a command shorter than a cycle of 5 ms skips the status.

    Rule: run-status, command-times.
    Source: remote command guide 1.2, code 0x0100
    """
    master = powered_up(skip_run_status=knob, command_delay=delay)
    assert _statuses(master, words) == expected


def test_with_random_times_the_run_status_is_sometimes_skipped() -> None:
    """Command times are random between 0 and 12 ms.

    A command that is shorter than a cycle ends in the cycle that accepts it, without status 0x0100.

    Rule: run-status, command-times.
    Source: remote command guide 2, step 3
    """
    master = powered_up(command_delay=(0.0, 12.0), seed=7)
    seen = [tuple(_statuses(master, words)) for words in COMMANDS * 12]
    assert set(seen) == {(NORMAL,), (RUN, NORMAL)}


@pytest.mark.parametrize("knob", ["never", "short", "always"])
def test_a_refused_command_ends_abnormally_with_or_without_the_run_status(knob: str) -> None:
    """Source: remote command guide 1.2, code 0x4000."""
    master = powered_up(skip_run_status=knob)
    master.send(0x0100, 0, 30000)
    master.run(5)
    assert (master.status == RUN) == (knob == "never")
    assert master.finish() == abnormal_end("4.2")


def _shown(cell: Cell) -> Iterable[list[int]]:
    """Return the sequence of statuses of each command in the trace, without repetitions."""
    statuses = [int.from_bytes(cycle.rcx_so[:2], "little") for cycle in cell.trace.cycles()]
    shown = [status for status, _ in groupby(statuses)]
    at_rest = [at for at, status in enumerate(shown) if status == READY]
    return [shown[at + 1 : until] for at, until in pairwise(at_rest)]


def _execute(cell: Cell, block: str) -> None:
    """Give Execute a rising edge, wait for Done, and reset Execute."""
    cell[f"Main.{block}.Execute"] = True
    cell.run_until(lambda: bool(cell[f"Main.{block}.Done"]), within="1s")
    assert not cell[f"Main.{block}.Error"]
    cell[f"Main.{block}.Execute"] = False
    cell.scan()
    assert not cell[f"Main.{block}.Busy"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("delay", "knob", "expected"),
    [
        pytest.param((0.0, 12.0), "short", {(NORMAL,), (RUN, NORMAL)}, id="both"),
        pytest.param(0.0, "short", {(NORMAL,)}, id="always skipped, short"),
        pytest.param(40.0, "always", {(NORMAL,)}, id="always skipped, long"),
        pytest.param(0.0, "never", {(RUN, NORMAL)}, id="never skipped, one cycle"),
        pytest.param(40.0, "short", {(RUN, NORMAL)}, id="never skipped, long"),
    ],
)
def test_command_blocks_work_with_and_without_the_run_status(
    build_cell: Callable[..., Cell],
    tmp_path: Path,
    engine: str,
    delay: float | tuple[float, float],
    knob: str,
    expected: set[tuple[int, ...]],
) -> None:
    """FB_RemoteCommand and two generated blocks (a writing and a reading one) work in both cases.

    Source: remote command guide 1.2, code 0x0100; 2, step 3
    """
    file = tmp_path / "Main.st"
    file.write_text(PROGRAM, encoding="utf-8")
    robot = RobotConfig(boot_time=0.0, command_delay=delay, skip_run_status=knob)
    cell = build_cell(file, scan="10ms", robot=robot, engine=engine, phases="random", seed=3)
    cell.run_until(lambda: bool(cell["Main.Robot.Settled"]), within="2s")
    before = cell.commands
    for amount in range(1, 21):
        cell["Main.Amount.Amount"] = amount
        _execute(cell, "Amount")
        _execute(cell, "Reading")
        assert cell["Main.Reading.InchingAmount"] == amount
        cell["Main.Raw.Code"] = 0x0514
        _execute(cell, "Raw")
        assert cell["Main.Raw.Response"] == [0, amount] + [0] * 13
    assert cell.commands - before == 60
    shown = [tuple(statuses) for statuses in _shown(cell)]
    assert len(shown) in (59, 60), "the last status reset may not be complete"
    assert set(shown) == expected
    assert not cell.violations
