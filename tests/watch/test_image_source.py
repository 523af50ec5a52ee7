"""A cell finds the variables for a program's own process image, and warns of mistakes.

A few lines replace the blocks and types of the library.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.cli.app import main
from rcx_harness.watch.image_source import image_use

Build = Callable[..., Cell]

_LIBRARY = """TYPE RCX_IMAGE : ARRAY [0..511] OF BYTE; END_TYPE
TYPE RCX_REF : STRUCT Seen : BYTE; END_STRUCT; END_TYPE
FUNCTION_BLOCK FB_ReadArea
  VAR_IN_OUT Robot : RCX_REF; Image : RCX_IMAGE; END_VAR
  Robot.Seen := Image[32];
END_FUNCTION_BLOCK
"""
_PROGRAM = """{before}
PROGRAM Cell
  VAR
    {variables}
    OutputArea : RCX_IMAGE;
    RobotOut AT %QB{out} : ARRAY [0..47] OF BYTE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    k : INT;
  END_VAR
  {body}
  ReadArea(Robot := Robot, Image := {image});
END_PROGRAM
"""
_PLAIN = [f"-pno:{name}" for name in ("cacheprovider", "xdist", "hypothesispytest")]
_COPY = "FOR k := 0 TO 47 DO InputArea[k] := RobotIn[k]; END_FOR;"
_BYTES = "ARRAY [0..47] OF BYTE"
_INPUT = "InputArea : RCX_IMAGE;"
_FB_COPY = f"""FUNCTION_BLOCK FB_Copy
  VAR_INPUT Source : {_BYTES}; END_VAR
  VAR_IN_OUT Target : RCX_IMAGE; END_VAR
  VAR k : INT; END_VAR
  FOR k := 0 TO 47 DO Target[k] := Source[k]; END_FOR;
END_FUNCTION_BLOCK
"""


class Way(NamedTuple):
    """A path of the data from the scanner to FB_ReadArea, and the declarations that it needs."""

    variables: str
    body: str = ""
    before: str = ""
    image: str = "InputArea"
    out: int = 0
    plain: bool = False
    """The cell fills InputArea and takes OutputArea."""


RUNS = {
    "the array that is called InputArea": Way(_INPUT, plain=True),
    "an array at an address": Way(f"RobotIn AT %IB0 : {_BYTES}; {_INPUT}", _COPY),
    "an address left to the tool": Way(f"RobotIn AT %I* : {_BYTES}; {_INPUT}", _COPY),
    "behind a status whose address is left to the tool, too": Way(
        f"State AT %I* : UINT; RobotIn AT %I* : {_BYTES}; {_INPUT}", _COPY
    ),
    "an array at another address": Way(f"RobotIn AT %IB100 : {_BYTES}; {_INPUT}", _COPY, out=100),
    "words": Way(
        f"In AT %IW0 : ARRAY [0..23] OF WORD; {_INPUT}",
        "FOR k := 0 TO 23 DO InputArea[2 * k] := WORD_TO_BYTE(In[k]); END_FOR;",
    ),
    "single bytes": Way(
        f"Status AT %IW0 : WORD; Dedicated AT %IB32 : BYTE; {_INPUT}",
        "InputArea[32] := Dedicated; InputArea[0] := WORD_TO_BYTE(Status);",
    ),
    "a structure": Way(
        f"In AT %IB0 : AREA; {_INPUT}",
        "InputArea[32] := In.Dedicated;",
        "TYPE AREA : STRUCT Words : ARRAY [0..15] OF WORD; Dedicated : BYTE; Rest : "
        "ARRAY [0..14] OF BYTE; END_STRUCT; END_TYPE",
    ),
    "a list of globals": Way(_INPUT, _COPY, f"VAR_GLOBAL RobotIn AT %IB0 : {_BYTES}; END_VAR"),
    "a block that copies": Way(
        f"RobotIn AT %IB0 : {_BYTES}; Copy : FB_Copy; {_INPUT}",
        "Copy(Source := RobotIn, Target := InputArea);",
        _FB_COPY,
    ),
    "a block with the array inside": Way(
        f"Io : FB_Io; {_INPUT}",
        "FOR k := 0 TO 47 DO InputArea[k] := Io.RobotIn[k]; END_FOR;",
        f"FUNCTION_BLOCK FB_Io VAR RobotIn AT %I* : {_BYTES}; END_VAR END_FUNCTION_BLOCK",
    ),
    "a buffer on the way": Way(
        f"RobotIn AT %IB0 : {_BYTES}; Buffer : {_BYTES}; {_INPUT}",
        f"Buffer := RobotIn; {_COPY.replace('RobotIn', 'Buffer')}",
    ),
    "an image of another name": Way(
        f"RobotIn AT %IB0 : {_BYTES}; Mine : RCX_IMAGE; {_INPUT}",
        _COPY.replace("InputArea", "Mine"),
        image="Mine",
    ),
    "an image at an address": Way(f"Mine AT %IB0 : RCX_IMAGE; {_INPUT}", image="Mine"),
    "an image of another name, filled from InputArea": Way(
        f"Mine : RCX_IMAGE; {_INPUT}", "Mine := InputArea;", image="Mine", plain=True
    ),
}
WARNED = {
    "an array without an address": (
        Way(f"RobotIn : {_BYTES}; {_INPUT}", _COPY),
        "reads what is in RobotIn, which nothing fills; give RobotIn an address",
    ),
    "one that a block copies": (
        Way(
            f"RobotIn : {_BYTES}; Copy : FB_Copy; {_INPUT}",
            "Copy(Source := RobotIn, Target := InputArea);",
            _FB_COPY,
        ),
        "InputArea is overwritten here: rcx fills it before each scan",
    ),
    "one that a pointer leads to": (
        Way(
            f"RobotIn : {_BYTES}; p : POINTER TO BYTE; {_INPUT}",
            "p := ADR(InputArea[32]); p^ := RobotIn[32];",
        ),
        "InputArea is overwritten here",
    ),
    "a number": (
        Way(_INPUT, "InputArea[32] := 0;"),
        "no longer sees what the robot has sent; leave the assignment out",
    ),
    "an array that the scanner fills": (
        Way("Mine AT %IB0 : RCX_IMAGE;", "Mine[32] := 0;", image="Mine"),
        "Mine is at %IB0, so the scanner fills it: this overwrites what the robot has sent",
    ),
    "an image of another name": (
        Way(
            f"RobotIn : {_BYTES}; Mine : RCX_IMAGE; {_INPUT}",
            _COPY.replace("InputArea", "Mine"),
            image="Mine",
        ),
        "Mine is overwritten here: FB_ReadArea reads what is in RobotIn, which nothing fills",
    ),
}


def _written(folder: Path, way: Way) -> Path:
    (folder / "lib").mkdir(exist_ok=True)
    (folder / "lib" / "Library.st").write_text(_LIBRARY)
    file = folder / "Cell.st"
    file.write_text(_PROGRAM.format(**way._asdict()))
    return file


def _cell(build_cell: Build, folder: Path, way: Way) -> Cell:
    cell = build_cell(
        _written(folder, way),
        lib=folder / "lib",
        scan="10ms",
        robot=RobotConfig(boot_time=0.0),
        engine="builtin",
    )
    cell.run("50ms")
    return cell


@pytest.mark.parametrize("way", RUNS.values(), ids=RUNS.keys())
def test_the_image_of_the_robot_is_found_for_any_variable_names(
    build_cell: Build, tmp_path: Path, way: Way
) -> None:
    """The process image of the robot is found, whatever the names of its variables are.

    SO(01) CPU_OK is bit 1 of byte 32. The command code is in bytes 0 and 1.

    Source: manual chapter 5, 1 and 2
    """
    cell = _cell(build_cell, tmp_path, way)
    assert cell["Main.Robot.Seen"] & 2
    assert not cell.mistakes
    cell["Main.OutputArea[0]" if way.plain else "Main.RobotOut[0]"] = 0x12
    cell.run("50ms")
    assert cell.trace.cycles()[-1].rcx_si[0] == 0x12


@pytest.mark.exhaustive(
    but=[
        *("a number", "one that a block copies", "an image of another name"),
        *("one that a pointer leads to", "an array without an address"),
    ]
)
@pytest.mark.parametrize(("way", "text"), WARNED.values(), ids=WARNED.keys())
def test_a_program_that_overwrites_its_image_gets_a_warning_with_its_line(
    build_cell: Build, tmp_path: Path, way: Way, text: str
) -> None:
    """Source: docs/reference/files.md, the process image."""
    cell = _cell(build_cell, tmp_path, way)
    assert cell["Main.Robot.Seen"] == 0
    (said,) = cell.mistakes
    assert text in said
    lines = (tmp_path / "Cell.st").read_text().splitlines()
    place = re.match(rf"{re.escape(str(tmp_path / 'Cell.st'))}:(\d+):\d+: warning: ", said)
    assert place is not None
    assert ":=" in lines[int(place[1]) - 1]
    assert cell.notice.endswith(said)


def test_check_and_run_say_it_and_an_error_of_the_source_comes_alone(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    way, text = WARNED["an array without an address"]
    file = _written(tmp_path, way)
    options = [str(file), "--lib", str(tmp_path / "lib")]
    assert main(["check", *options]) == 0
    assert text in capsys.readouterr().out
    assert main(["run", *options, "--for", "20ms"]) == 0
    assert text in capsys.readouterr().err
    file.write_text(file.read_text().replace("RobotIn[k]", "RobotIn"))
    assert image_use([file], [tmp_path / "lib" / "Library.st"]) == (False, ())


def test_a_test_of_such_a_program_shows_the_warning(
    pytester: pytest.Pytester, tmp_path: Path
) -> None:
    way, text = WARNED["an array without an address"]
    _written(pytester.path, way)
    pytester.makepyfile("def test_nothing(cell):\n    cell.scan()\n")
    pytester.makeini(
        "[pytest]\nrcx_sources = Cell.st\nrcx_lib = lib\nrcx_scan = 10ms\nrcx_engine = builtin\n"
    )
    result = pytester.runpytest_inprocess(*_PLAIN)
    result.assert_outcomes(passed=1, warnings=1)
    assert text in result.stdout.str()
