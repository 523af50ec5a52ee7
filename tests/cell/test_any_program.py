"""The blocks break no rule of the wire, whatever program, operator and network do.

Execute, calls and safety pins change at random in every scan. Random events change the link, the
power, the emergency stop, AUTO mode and the programming box. The network delays and loses packets
within the limits of the margin and the connection.
"""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from both_engines import COMPILED
from plc_bench import BENCH, compiled
from rcx_harness.cell import Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink
from rcx_harness.robot import Controller, RobotConfig
from structured_text.engines.base import Program

SECONDS = 10
BLOCKS = (
    *("First", "Second", "Third", "AlarmReset"),
    *("ServoOn", "ServoAgain", "ProgramReset", "AutoStart"),
)
EVENTS = (
    *("link_down", "link_up", "link_up", "power_cycle", "pendant_on", "pendant_off"),
    *("emergency_stop", "emergency_stop_release", "emergency_stop_release"),
    *("manual_mode", "auto_mode", "auto_mode"),
)


@pytest.fixture(scope="module")
def program() -> Program:
    return compiled(BENCH)


def _cell(program: Program, random: Random, seed: int, trace: Path | None = None) -> Cell:
    rpi_ms, jitter_ms = random.randint(1, 100), random.randint(0, 10)
    timing = Timing.make(scan=random.choice([1, 2, 5, 10, 20, 50]) * 1000, rpi=rpi_ms * 1000,
                         jitter=jitter_ms * 1000, phases="random", seed=seed)  # fmt: skip
    robot = RobotConfig(
        servo_on_delay=(0, 300),
        program_start_delay=(0, 300),
        command_delay=(0, 200),
        command_accept_delay=(0, 50),
        status_reset_delay=(0, 50),
    )
    cell = Cell(program, Controller(robot, seed), DirectLink(48), timing, seed=seed, trace=trace)
    survived_ms = max(4 * rpi_ms, 100)
    cell["Main.WriteArea.Margin"] = f"T#{survived_ms + jitter_ms + 5}ms"
    for block, code in (("First", 0x0501), ("Second", 0x0001), ("Third", 0x0505)):
        cell[f"Main.{block}.Code"] = code
        cell[f"Main.{block}.Timeout"] = "T#1s"
    return cell


def _flip(cell: Cell, random: Random) -> None:
    """Change inputs of the blocks at random. An arbitrary program could do this in one scan."""
    for path in [f"Main.{block}.Execute" for block in BLOCKS]:
        if random.random() < 0.05:
            cell[path] = not cell[path]
    for path in ("Main.CallFirst", "Main.CallSecond", "Main.CallServoOn"):
        if random.random() < 0.02:
            cell[path] = not cell[path]
    for path in ("Main.EmergencyStopOk", "Main.StopOk"):
        if random.random() < (0.005 if cell[path] else 0.1):
            cell[path] = not cell[path]
    if random.random() < 0.01:
        cell.inject(random.choice(EVENTS))


@pytest.mark.exhaustive(but=["5", "12", "13", "14", "3", "11", "15", "6"])
@pytest.mark.parametrize("seed", range(16))
def test_no_program_can_break_the_interval_or_the_handshake(program: Program, seed: int) -> None:
    """Source: manual chapter 5, 3, caution; guide chapter 1, 1.1, note."""
    random = Random(seed)
    fresh = program.snapshot()
    cell = _cell(program, random, seed)
    while cell.now_us < SECONDS * 1_000_000:
        _flip(cell, random)
        cell.scan()
    program.restore(fresh)
    assert not cell.violations
    assert cell.commands, "the program must execute commands"


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("native", COMPILED)
def test_engines_give_the_same_trace(native: str, seed: int, tmp_path: Path) -> None:
    for engine in (native, "builtin"):
        random = Random(seed)
        program = compiled(BENCH, engine)
        with _cell(program, random, seed, tmp_path / engine) as cell:
            while cell.now_us < SECONDS * 1_000_000:
                _flip(cell, random)
                cell.scan()
    one, two = ((tmp_path / engine).read_bytes() for engine in (native, "builtin"))
    assert one.partition(b"\n")[2] == two.partition(b"\n")[2]
