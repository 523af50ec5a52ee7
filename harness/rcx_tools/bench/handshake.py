"""Handshake and dedicated inputs compared with their theoretical minimum (timing.md).

Every combination of a grid is simulated on the built-in engine. Each scan above the minimum counts
as an extra scan.
"""

from __future__ import annotations

import itertools
import tempfile
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple
from datetime import timedelta
from functools import cache, partial
from math import lcm
from pathlib import Path
from random import Random
from typing import NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink
from rcx_harness.cell.sources import default_lib, source_files
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import Scan
from rcx_tools.bench.figure import Figure, Options, at_most, shown
from rcx_tools.bench.minimum import Clocks, Command, command, sequence
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.farm import Farm
from structured_text.language.load import load

__all__ = ["Case", "Simulated", "grid", "measure", "simulate_command", "simulate_sequence"]

#: Interval between two changes of dedicated inputs, without the margin [us].
_INTERVAL_US = 100_000
#: Response times of the controller [ms]: to a code, until the end of a command, and to a reset.
_RESPONSES_MS = (0, 7, 20)
#: Margins that are added to the delay of the network [ms].
_MARGINS_MS = (0, 45)
_MOST_SCANS = 10_000

_HEAD = """
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Go : BOOL;
    Margin : TIME := T#0s;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    {blocks}
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  {calls}
  WriteArea(Robot := Robot, Image := OutputArea, Margin := Margin,
            EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""
#: A program with two commands that read positions. The end of the first command starts the second
#: command.
_COMMANDS = "PROGRAM Commands" + _HEAD.format(
    blocks="First, Second : FB_RemoteCommand;",
    calls="""First(Robot := Robot, Execute := Go, Code := WORD#16#0505);
  Second(Robot := Robot, Execute := First.Done, Code := WORD#16#0505);""",
)
#: A program with four blocks that each set a dedicated input. The end of a block starts the next
#: block.
_SEQUENCES = "PROGRAM Sequences" + _HEAD.format(
    blocks="Reset : FB_AlarmReset; Servo : FB_ServoOn; Rewind : FB_ProgramReset;\n"
    "    Auto : FB_AutoStart;",
    calls="""Reset(Robot := Robot, Execute := Go);
  Servo(Robot := Robot, Execute := Reset.Done);
  Rewind(Robot := Robot, Execute := Servo.Done);
  Auto(Robot := Robot, Execute := Rewind.Done);""",
)
#: Maps each block to the bit of its dedicated input in bytes n + 32 and n + 33.
_STEPS = (("Reset", 14), ("Servo", 1), ("Rewind", 13), ("Auto", 10))
#: Response time of the controller [ms] for alarm reset, servo ON, program reset and start.
_ANSWERS_MS = (20.0, 50.0, 20.0, 20.0)


class Case(NamedTuple):
    """One combination of the grid: periods, response times, and phases of the clocks."""

    scan_us: int
    rpi_us: int
    response_us: int
    phases: tuple[int, int, int, int] = (0, 0, 0, 0)

    @property
    def timing(self) -> Timing:
        """Return the clocks of a cell, with a time-out that never expires."""
        return Timing(self.scan_us, self.rpi_us, 0, 10 * self.rpi_us + 500_000, self.phases)


class Simulated(NamedTuple):
    """The simulated times of one combination, and their theoretical minimum."""

    case: Case
    took: tuple[int, ...]
    minimum: tuple[int, ...]

    @property
    def extra(self) -> int:
        """Return the largest difference between a time and its minimum, in scans.

        A negative number means that the calculated minimum is wrong.
        """
        late = [a - b for a, b in zip(self.took, self.minimum, strict=True)]
        return max(late, key=abs) // self.case.scan_us


def grid(
    scans_ms: Iterable[int], rpis_ms: Iterable[int], responses_ms: Iterable[int]
) -> list[Case]:
    """Return every combination twice: with all clocks at phase 0, and with random phases."""
    cases = []
    for scan, rpi, response in itertools.product(scans_ms, rpis_ms, responses_ms):
        random = Random(f"{scan} {rpi} {response}")
        periods = (CYCLE_US, rpi * 1000, rpi * 1000, scan * 1000)
        drawn = tuple(random.randrange(period) for period in periods)
        cases.append(Case(scan * 1000, rpi * 1000, response * 1000))
        cases.append(Case(scan * 1000, rpi * 1000, response * 1000, drawn))  # type: ignore[arg-type]
    return cases


def simulate_command(case: Case, *, together: bool = False) -> Simulated:
    """Simulate two commands in a row, from `Execute` to the code of the second.

    Args:
        case: The combination.
        together: Whether `Execute` rises in a scan in which all clocks tick. All phases must be 0.

    Returns:
        The times of four scans, counted from the scan of the rising edge [us]. In these scans the
        code is written, the command is done, the next data are possible, and the next code is
        written.
    """
    config = RobotConfig(
        command_accept_delay=case.response_us / 1000, status_reset_delay=case.response_us / 1000,
        command_delay=case.response_us / 1000,
    )  # fmt: skip
    with _cell(_COMMANDS, case, config) as cell:
        _settle(cell)
        if together:
            period = lcm(case.scan_us, case.rpi_us, CYCLE_US)
            cell.run(period - cell.now_us % period)
        cell["Main.Go"] = True
        cell.scan()
        start = cell.now_us
        code = _until(cell, lambda scan: scan.si[:2] != b"\0\0")
        done = _until(cell, partial(_is_true, cell, "Main.First.Done"))
        ready = _until(cell, lambda scan: scan.so[:2] == b"\0\0")
        following = _until(cell, lambda scan: scan.si[:2] != b"\0\0")
    clocks = Clocks(case.timing)
    least = command(
        clocks, start, accept_us=case.response_us, run_us=case.response_us,
        reset_us=case.response_us,
    )  # fmt: skip
    return _simulated(case, start, Command(code, done, ready, following), least)


def simulate_sequence(case: Case) -> Simulated:
    """Simulate alarm reset, servo ON, program reset and start in a row.

    The margin is the delay of the network (RPI + 5 ms) plus `response_us`. The result contains
    three times for each input: the input goes ON, the block is done, the input goes OFF. Times are
    counted from the scan of the rising edge [us].
    """
    config = RobotConfig(power_on_alarm="17.401", program_is_reset=False)
    margin_us = case.rpi_us + CYCLE_US + case.response_us
    with _cell(_SEQUENCES, case, config) as cell:
        cell["Main.Margin"] = timedelta(microseconds=margin_us)
        _settle(cell)
        cell["Main.Go"] = True
        cell.scan()
        start = cell.now_us
        took: list[int] = []
        for name, bit in _STEPS:
            took.append(_until(cell, partial(_is_on, bit)))
            took.append(_until(cell, partial(_is_true, cell, f"Main.{name}.Done")))
            took.append(_until(cell, partial(_is_off, bit)))
    answers = tuple(round(answer * 1000) for answer in _ANSWERS_MS)
    steps = sequence(Clocks(case.timing), start, answers, _INTERVAL_US + margin_us)
    least = [time for step in steps for time in (step.on, step.done, step.off)]
    return Simulated(case, _from(start, took), _from(start, least))


def measure(options: Options) -> dict[str, Figure]:
    """Measure the whole grid on all processors: scan times, packet intervals and response times."""
    step = 7 if options.quick else 1
    cases = grid(range(1, 21, step), range(1, 101, step), _RESPONSES_MS)
    margins = grid(range(1, 21, 3 * step), range(1, 101, 9 * step), _MARGINS_MS)
    commands = [one for _, one in Farm().run(simulate_command, cases)]
    sequences = [one for _, one in Farm().run(simulate_sequence, margins)]
    return {
        "handshake_combinations": shown(len(commands), "cells", "scan x RPI x response"),
        "handshake_extra_scans": at_most(_most(commands), "scans", 0, "docs/explanation/timing.md"),
        "sequence_combinations": shown(len(sequences), "cells", "scan x RPI x margin"),
        "sequence_extra_scans": at_most(_most(sequences), "scans", 0, "docs/explanation/timing.md"),
    }


def _most(found: Sequence[Simulated]) -> int:
    """Return the difference in scans with the greatest absolute value."""
    return max(abs(one.extra) for one in found)


def _simulated(case: Case, start: int, took: Command, least: Command) -> Simulated:
    return Simulated(case, _from(start, astuple(took)), _from(start, astuple(least)))


def _is_on(bit: int, scan: Scan) -> bool:
    """Return whether a dedicated input is ON after this scan."""
    return bool(int.from_bytes(scan.si[32:34], "little") >> bit & 1)


def _is_off(bit: int, scan: Scan) -> bool:
    return not _is_on(bit, scan)


def _is_true(cell: Cell, path: str, _: Scan) -> bool:
    return bool(cell[path])


def _from(start: int, times: Sequence[int]) -> tuple[int, ...]:
    return tuple(time - start for time in times)


@cache
def _program(text: str, library: Path) -> BuiltinProgram:
    """Return a program with the library, compiled once per process."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Main.st"
        file.write_text(text, encoding="utf-8")
        return BuiltinProgram.build(load(source_files(file, library).all))


def _cell(text: str, case: Case, config: RobotConfig) -> Cell:
    program = _program(text, default_lib()).instance()
    return Cell(program, Controller(config), DirectLink(48), case.timing)


def _settle(cell: Cell) -> None:
    """Scan until the interval after the link's start is over, so that requests are sent at once."""

    def ready() -> bool:
        robot = cell["Main.Robot"]
        return bool(robot["Inner"]["Phase"] == "PHASE_READY" and robot["Settled"])

    cell.run_until(ready, within="60s")


def _until(cell: Cell, condition: Callable[[Scan], object]) -> int:
    """Scan until `condition` holds for a scan. Return the time of this scan [us].

    Raises:
        InputError: the condition did not hold in time, so the bench cannot measure.
    """
    for _ in range(_MOST_SCANS):
        last = next(one for one in reversed(list(cell.trace)) if isinstance(one, Scan))
        if condition(last):
            return last.t_us
        cell.scan()
    raise InputError(f"the condition did not become true, {cell.timing}")
