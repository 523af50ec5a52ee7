"""Comparison of the speed of movements by a robot program and by remote commands.

Both cells have the same PLC program, robot and path: to and fro between two points. The cells run
alternately, because the speed of a machine changes. The medians of their CPU times are compared.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.robot import Point, RobotConfig, RobotProgram
from rcx_tools.bench.figure import Figure, Options, at_most, shown

__all__ = ["Measured", "measure", "simulated"]

#: Simulated time of each run [s], and number of runs of each cell.
_SECONDS, _RUNS, _QUICK_RUNS = 10, 15, 1
#: How often per second the direction of movement is sampled.
_STEPS_IN_S = 50
#: Target: greatest CPU time of a movement by a program, as a share of that of a commanded movement.
_MOST = 1.0
_PLC = """
PROGRAM Shuttle
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, CellSafe, Start, Commands, Back : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    PowerUp : FB_PowerUp;
    MoveThere, MoveBack : FB_MovePtp;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  PowerUp(Robot := Robot, Execute := Start, StartProgram := NOT Commands);
  MoveThere(Robot := Robot, Execute := Commands AND PowerUp.Done AND NOT Back, Point := 1);
  MoveBack(Robot := Robot, Execute := Commands AND PowerUp.Done AND Back, Point := 2);
  IF MoveThere.Done THEN
    Back := TRUE;
  ELSIF MoveBack.Done THEN
    Back := FALSE;
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := CellSafe, StopOk := CellSafe);
END_PROGRAM
"""
_PROGRAM = "*LOOP:\nMOVE P,P1\nWAIT ARM\nMOVE P,P2\nWAIT ARM\nGOTO *LOOP"
_POINTS = {
    1: Point((100_000, 50_000, 0, 0, 0, 0), mm=True),
    2: Point((0, 0, 0, 0, 0, 0), mm=True),
}


class Measured(NamedTuple):
    """The result of one run: its CPU time [s], and its number of movements."""

    cpu_s: float
    movements: int

    @property
    def of_movement(self) -> float:
        """Return the CPU time of one movement [s]."""
        return self.cpu_s / max(self.movements, 1)


def measure(options: Options) -> dict[str, Figure]:
    """Measure both cells alternately. Return their speeds and the ratio of their CPU times."""
    runs = _QUICK_RUNS if options.quick else _RUNS
    seconds = 1 if options.quick else _SECONDS
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Shuttle.st"
        file.write_text(_PLC, encoding="utf-8")
        robot = RobotConfig(points=_POINTS, programs=(RobotProgram("SHUTTLE", text=_PROGRAM),))
        with Cell.build(file, engine="builtin", scan="10ms", robot=robot) as cell:
            taken: dict[bool, list[Measured]] = {True: [], False: []}
            for _ in range(runs):
                for commands, every in taken.items():
                    every.append(simulated(cell, seconds, commands=commands))
    speeds = {key: median(seconds / one.cpu_s for one in every) for key, every in taken.items()}
    counts = {key: every[0].movements for key, every in taken.items()}
    ratio = median(
        own.of_movement / other.of_movement
        for own, other in zip(taken[False], taken[True], strict=True)
    )
    return {
        "commands_speed": shown(speeds[True], "x real time", f"{counts[True]} movements"),
        "program_speed": shown(speeds[False], "x real time", f"{counts[False]} movements"),
        "program_cpu": at_most(ratio, "of commands", _MOST, "CPU time of a movement"),
    }


def simulated(cell: Cell, seconds: int, *, commands: bool) -> Measured:
    """Run a cell after power-up, with remote commands or with the robot program."""
    start = cell.snapshot()
    try:
        cell["Main.CellSafe"], cell["Main.Commands"] = True, commands
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run_until(lambda: cell["Main.PowerUp.Done"], within="5s")
        turns, before, forward = 0, cell.robot.positions[0], False
        began = time.process_time()
        for _ in range(seconds * _STEPS_IN_S):
            cell.run(1_000_000 // _STEPS_IN_S)
            now = cell.robot.positions[0]
            if now != before:
                turns += forward != (now > before)
                forward = now > before
            before = now
        return Measured(time.process_time() - began, turns)
    finally:
        cell.restore(start)
