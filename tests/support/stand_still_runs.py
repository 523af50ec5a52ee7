"""Run the cells of the planted stand-stills, and record their traces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.robot import RobotConfig
from stand_stills import StandStill
from structured_text.output.toml_files import toml_value

__all__ = ["record"]

_EXAMPLES = Path(__file__).parents[2] / "plc" / "examples"


def record(planted: StandStill, folder: Path) -> Path:
    """Run the cell of a stand-still, and return its trace."""
    trace = folder / "trace.jsonl"
    stimulus = folder / "stimulus.toml"
    stimulus.write_text(
        "at = [\n" + "".join(f"  {_inline(at)},\n" for at in planted.moments()) + "]"
    )
    files, robots = _cell(planted, folder)
    cell = Cell.build(
        files,
        robot=robots,
        engine="builtin",
        trace=trace,
        watch=planted.watch.split(",") if planted.watch else (),
    )
    try:
        Stimulus.load(stimulus).schedule(cell)
        cell.run(planted.length)
    finally:
        cell.close()
    return trace


def _cell(planted: StandStill, folder: Path) -> tuple[list[Path], Any]:
    if "PROGRAM" in planted.program:
        program = folder / "Cell.st"
        program.write_text(planted.program)
        return [program], _robot(planted, folder)
    example = _EXAMPLES / planted.program
    if planted.robot is not None:
        robots: Any = _robot(planted, folder)
    elif planted.robot_program is not None:
        for file in (*example.glob("*.PGM"), *example.glob("robot.toml")):
            text = file.read_text().replace(*planted.robot_program)
            (folder / file.name).write_text(text)
        robots = RobotConfig.load(folder / "robot.toml")
    else:
        robots = [RobotConfig.load(file) for file in sorted(example.glob("robot*.toml"))]
    return sorted(example.glob("*.st")), robots


def _robot(planted: StandStill, folder: Path) -> RobotConfig | None:
    if planted.robot is None:
        return None
    file = folder / "robot.toml"
    file.write_text(planted.robot)
    return RobotConfig.load(file)


def _inline(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f'"{key}" = {_inline(one)}' for key, one in value.items()) + " }"
    return toml_value(value)
