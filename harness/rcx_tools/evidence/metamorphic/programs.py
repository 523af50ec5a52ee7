"""The subjects: examples of one robot, timing charts, and a program of every command block."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.robot import RobotConfig
from rcx_tools.docs.examples import examples
from rcx_tools.docs.processes import processes
from rcx_tools.evidence.results import ROOT
from rcx_tools.library.tables import Block, library
from structured_text.output.units import parse_us

__all__ = ["EVERY_COMMAND", "Subject", "every_command", "subjects"]

#: Name of the generated program.
EVERY_COMMAND = "every command"

#: Examples with areas at fixed addresses: located variables.
_LOCATED = ("09_openplc",)


@dataclass(frozen=True)
class Subject:
    """One program, with the options of its run.

    Attributes:
        name: Its name.
        files: Its sources by file name; those of the library are added.
        length_us: Duration of the run.
        stimulus: Events during the run, if any.
        robot: The virtual controller.
        size: Bytes of an area.
        m: Offset of the area from the robot.
        n: Offset of the area to the robot.
    """

    name: str
    files: Mapping[str, str]
    length_us: int
    stimulus: Stimulus | None
    robot: RobotConfig
    size: int = 48
    m: int = 0
    n: int = 0

    @property
    def words(self) -> bool:
        """Return whether its images are arrays of WORD."""
        return any("RCX_IMAGE_WORDS" in text for text in self.files.values())

    @property
    def cuts(self) -> bool:
        """Return whether the connection is lost during the run."""
        entries = self.stimulus.entries if self.stimulus else []
        lost = {"link_down", "power_off", "power_cycle"}
        return any(name in lost for entry in entries for name, _ in entry.events)


def subjects() -> list[Subject]:
    """Return all subjects."""
    charts = [
        Subject(
            f"chart {name}",
            {process.program.name: process.program.read_text(encoding="utf-8")},
            process.end_us,
            Stimulus.load(process.stimulus),
            RobotConfig(),
        )
        for name, process in processes().items()
    ]
    return [*_examples(), *charts, every_command()]


def _examples() -> list[Subject]:
    """Return the examples, with the options of the commands in their README."""
    found = []
    for one in examples().values():
        options = {name: values[0] for name, values in one.options.items()}
        if len(one.options.get("robot", [])) > 1 or one.name in _LOCATED:
            continue
        robot = RobotConfig.load(ROOT / options["robot"]) if "robot" in options else None
        size = robot.size if robot else int(options.get("size", 48))
        found.append(
            Subject(
                f"example {one.name}",
                {file.name: file.read_text(encoding="utf-8") for file in one.folder.glob("*.st")},
                parse_us(one.duration),
                Stimulus.load(one.folder / "stimulus.toml"),
                robot or RobotConfig(size=size),
                size,
                int(options.get("m", 0)),
                int(options.get("n", 0)),
            )
        )
    return found


# --- every command block, one after the other -------------------------------------------------

#: Values for pins, so that telegrams carry more than zeros.
_VALUES = {
    "Point": "19",
    "Variable1": "5",
    "ValueInteger": "-123456",
    "ValueReal": "1.5",
    "Comment": "'NOTHING MATTERS'",
    "ProgramName": "'MAIN'",
    "Pattern": "WORD#16#00A5",
    "SpeedMode": "SPEED_PERCENT",
    "Speed": "50.0",
}
#: Arrays that the program fills.
_ARRAYS = {"RCX_PULSES": "Pulses", "RCX_POSITION": "Millimetres", "RCX_SHIFT": "Shift"}
#: Number of scans for which a block with Enable is on, and in total.
_ENABLED, _LEVEL = 60, 120
#: Average time allowed for a block, in virtual time [us].
_EACH_US = 150_000


def every_command(names: tuple[str, ...] = ()) -> Subject:
    """Return a program that runs every command block once, one after the other.

    Args:
        names: Only these blocks; empty: all.
    """
    blocks = [block for name, block in library().blocks.items() if not names or name in names]
    declared = "".join(f"    B{k} : {block.name};\n" for k, block in enumerate(blocks, 1))
    calls = "".join(_call(k, block) for k, block in enumerate(blocks, 1))
    source = f"""PROGRAM EveryCommand
  VAR
    InputArea   : RCX_IMAGE;
    OutputArea  : RCX_IMAGE;
    Connected   : BOOL;
    Turn        : INT;
    Scans       : INT;
    Ended       : BOOL;
    Pulses      : RCX_PULSES;
    Millimetres : RCX_POSITION;
    Shift       : RCX_SHIFT;
    Robot       : RCX_REF;
    ReadArea    : FB_ReadArea;
    WriteArea   : FB_WriteArea;
    PowerUp     : FB_PowerUp;
{declared}  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Pulses[1] := 12000;
  Pulses[2] := -34000;
  Millimetres[1] := 12.5;
  Millimetres[2] := -3.25;
  Shift[1] := 1.5;
  PowerUp(Robot := Robot, Execute := TRUE, StartProgram := FALSE);
  Ended := Turn = 0 AND PowerUp.Done;
{calls}  IF Ended THEN
    Turn := Turn + 1;
    Scans := 0;
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms, EmergencyStopOk := TRUE,
            StopOk := TRUE);
END_PROGRAM
"""
    length_us = 2_000_000 + len(blocks) * _EACH_US
    return Subject(EVERY_COMMAND, {"EveryCommand.st": source}, length_us, None, RobotConfig())


def _call(k: int, block: Block) -> str:
    if block.handwritten:
        return (
            f"  IF Turn = {k} THEN\n    Scans := Scans + 1;\n  END_IF;\n"
            f"  B{k}(Robot := Robot, Enable := Turn = {k} AND Scans < {_ENABLED});\n"
            f"  Ended := Ended OR (Turn = {k} AND Scans >= {_LEVEL});\n"
        )
    pins = ""
    for pin in block.inputs:
        value = _ARRAYS.get(pin.type) or _VALUES.get(pin.pin)
        if value is not None:
            pins += f", {pin.pin} := {value}"
    return (
        f"  B{k}(Robot := Robot, Execute := Turn = {k}{pins});\n"
        f"  Ended := Ended OR (Turn = {k} AND (B{k}.Done OR B{k}.Error));\n"
    )
