"""The program of example 01 works in 1,000 cells with random scan, RPI, phases, jitter and delays.

In any network, two dedicated inputs must not change within 100 ms in the controller, the handshake
must be correct, and the program must complete its work.
"""

from __future__ import annotations

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path
from random import Random
from typing import NamedTuple

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink
from rcx_harness.cell.sources import source_files
from rcx_harness.robot import Controller, Point, RobotProgram
from structured_text.engines.base import Program
from structured_text.engines.load import build

RUNS, BATCH = 1000, 50


class Compiled(NamedTuple):
    """A compiled program that can start at its first scan repeatedly."""

    program: Program
    initial: object


@pytest.fixture(scope="module")
def compiled() -> Iterator[Compiled]:
    """Return the program of example 01, compiled once for all tests of this file."""
    demo = Path(__file__).resolve().parents[2] / "plc" / "examples" / "01_power_up"
    program = build(source_files(sorted(demo.glob("*.st"))).all).program
    program.write("Main.CellSafe", True)
    yield Compiled(program, program.snapshot())
    program.close()


def drawn_robot(random: Random) -> RobotConfig:
    """Return a robot configuration with random delays for its answers."""

    def delay(longest: float) -> tuple[float, float]:
        return 0.0, random.uniform(0.0, longest)

    return RobotConfig(
        boot_time=delay(400.0),
        servo_on_delay=delay(300.0),
        program_reset_delay=delay(300.0),
        program_start_delay=delay(300.0),
        command_accept_delay=delay(60.0),
        command_delay=delay(300.0),
        status_reset_delay=delay(60.0),
        skip_run_status=random.choice(("never", "short", "always")),
        # The program must run longer than scan, RPI, jitter and cycle together, or the PLC may miss
        # the run.
        programs=(RobotProgram(duration=random.uniform(200.0, 600.0), loop=False),),
        points={19: Point((20_000, -10_000, 5_000, 0, 0, 0))},
    )


class Draw(NamedTuple):
    """The random properties of one run. `scan`, `rpi` and `jitter` are in ms."""

    seed: int
    scan: int
    rpi: int
    jitter: int
    robot: RobotConfig

    def __str__(self) -> str:
        return f"seed {self.seed}: scan {self.scan}, RPI {self.rpi}, jitter {self.jitter} ms"


def draw(seed: int) -> Draw:
    random = Random(f"run {seed}")
    scan, rpi, jitter = (random.randint(*ms) for ms in ((1, 50), (1, 100), (0, 30)))
    return Draw(seed, scan, rpi, jitter, drawn_robot(random))


def cell_of(compiled: Compiled, run: Draw, margin_ms: int | None = None) -> Cell:
    """Return a cell with these random properties in which Start is pressed.

    If `margin_ms` is None, the margin is the library's default.
    """
    timing = Timing.make(scan=f"{run.scan}ms", rpi=f"{run.rpi}ms", jitter=f"{run.jitter}ms",
                         phases="random", seed=run.seed)  # fmt: skip
    compiled.program.restore(compiled.initial)
    robot = Controller(run.robot, seed=run.seed)
    cell = Cell(compiled.program, robot, DirectLink(48), timing, seed=run.seed)
    if margin_ms is not None:
        cell["Main.WriteArea.Margin"] = timedelta(milliseconds=margin_ms)
    cell.run("1500ms")
    cell["Main.Start"] = True
    return cell


def complete(cell: Cell) -> None:
    """Run the cell until the program has completed its work."""
    cell.run_until(lambda: cell["Main.Stage"] == "STAGE_COMPLETE", within="30s")


@pytest.mark.exhaustive
@pytest.mark.parametrize("first", range(0, RUNS, BATCH))
def test_no_rule_is_broken_in_any_network(compiled: Compiled, first: int) -> None:
    """Each run ends without a violation.

    Source: manual chapter 5, 3, caution; guide chapters 1 and 2.
    """
    for seed in range(first, first + BATCH):
        run = draw(seed)
        cell = cell_of(compiled, run)
        complete(cell)
        assert not cell.violations, f"{run}: {cell.violations[0].text}"
        assert cell.commands == 2, run


def test_without_a_margin_for_the_network_the_interval_is_broken(compiled: Compiled) -> None:
    """Without the margin, the same cells break the 100 ms interval, so the test can fail."""
    rules = set()
    for seed in range(20):
        cell = cell_of(compiled, draw(seed), margin_ms=0)
        cell.run("5s")
        rules |= {(one.rule, one.text.split(",")[0]) for one in cell.violations}
    assert rules == {("interval", "robot")}
