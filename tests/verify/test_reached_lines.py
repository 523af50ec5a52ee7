"""A campaign records the lines of robot programs that it has reached."""

from __future__ import annotations

from pathlib import Path

from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import RobotProgram
from rcx_harness.verify.storm.reached import Reached, unreached_lines

_PROGRAM = """PROGRAM Wire
  VAR
    InputArea, OutputArea : RCX_IMAGE;
  END_VAR
  OutputArea[32] := OutputArea[32];
END_PROGRAM
"""
#: Without remote commands the servos stay OFF, which this program does not need.
_TEXT = """SO(20)=1
*LOOP:
  IF SI(20)=0 THEN
    SO(21)=1
  ELSE
    SO(22)=1
  ENDIF
DELAY 10
HALT
"""


def _run(cell: Cell) -> None:
    """Run the robot program from its first line, with SI(06) and SI(00) ON."""
    for inputs in (0x40, 0x41):
        cell["Main.OutputArea[32]"] = inputs
        cell.run("150ms")
    for task in cell.robot.program.tasks:
        task.reset()
        task.go(cell.now_us)
    cell.robot.write_port("SO(77)", 0)
    cell.run("100ms")


def test_lines_are_recorded_before_and_after_a_power_cycle(tmp_path: Path) -> None:
    """Executed lines are recorded before and after a power cycle.

    Before it, the branch of lines 3 and 4 is taken. After it, SI(20) is ON.
    """
    (tmp_path / "Wire.st").write_text(_PROGRAM, encoding="utf-8")
    config = RobotConfig(
        booted=True, boot_time=0, programs=(RobotProgram(name="MAIN", text=_TEXT),)
    )
    with Cell.build(tmp_path / "Wire.st", engine="builtin", robot=config) as cell:
        reached = Reached(cell)
        assert list(unreached_lines(cell, reached.lines)) == [
            "robot program MAIN: lines 1, 3 to 4, 6, 8 to 9 not reached"
        ]
        _run(cell)
        assert list(unreached_lines(cell, reached.lines)) == [
            "robot program MAIN: line 6 not reached"
        ]
        cell["Main.OutputArea[34]"] = 1
        cell.inject("power_cycle")
        cell.run("1s")
        _run(cell)
        assert list(unreached_lines(cell, reached.lines)) == []
