"""The most common first mistakes in a program give a warning with its line; correct code does not.

Most cases use a library of stubs, with the pins of plc/lib and empty bodies.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness.cell import Cell, CellTimeout
from rcx_harness.cli.app import main
from rcx_harness.watch.first_mistakes import first_mistakes
from structured_text.language.checked import analysed

TEMPLATE = Path(__file__).parents[2] / "harness" / "rcx_harness" / "new" / "template" / "plc"
READ = "ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);"
WRITE = "WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := Safe, StopOk := Safe);"
SERVO = "Servo(Robot := Robot, Execute := Go);"
MOVE = "Move(Robot := Robot, Execute := Go);"
BIT = "Bit(Robot := Robot, Image := InputArea);"
STATIONS = "Station(Robot := Robot, Image := InputArea, Online := Connected, Go := Go);"
NOT_WIRED = "Connected of ReadArea is not wired and stays FALSE: "

Check = Callable[..., list[str]]


def of(call: str, robot: str) -> str:
    """Return this call with the name of another robot."""
    return call.replace(":= Robot", f":= {robot}")


def _block(name: str, pins: str, image: bool = False) -> str:
    images = "Image : RCX_IMAGE; " if image else ""
    return (
        f"FUNCTION_BLOCK {name}\n  VAR_IN_OUT Robot : RCX_REF; {images}END_VAR\n"
        f"  VAR_INPUT {pins} END_VAR\n  VAR_OUTPUT Done : BOOL; END_VAR\n"
        "  Done := Robot.Connected;\nEND_FUNCTION_BLOCK\n"
    )


STUBS = (
    "TYPE RCX_IMAGE : ARRAY [0..47] OF BYTE; END_TYPE\n"
    "TYPE RCX_REF : STRUCT Connected : BOOL; END_STRUCT; END_TYPE\n"
    + _block("FB_ReadArea", "m : INT; Size : INT; Connected : BOOL;", image=True)
    + _block("FB_WriteArea", "n : INT; EmergencyStopOk, StopOk : BOOL;", image=True)
    + _block("FB_ReadBit", "Port : INT;", image=True)
    + _block("FB_ServoOn", "Execute : BOOL;")
    + _block("FB_MovePtp", "Execute : BOOL;")
    + _block("FB_ReadPoint", "Execute : BOOL;")
)
STATION = """\
FUNCTION_BLOCK FB_Station
  VAR_IN_OUT Robot : RCX_REF; Image : RCX_IMAGE; END_VAR
  VAR_INPUT Online, Go : BOOL; END_VAR
  VAR ReadArea : FB_ReadArea; Move : FB_MovePtp; END_VAR
  ReadArea(Robot := Robot, Image := Image, Connected := Online);
  Move(Robot := Robot, Execute := Go);
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Copy
  VAR_INPUT Robot : RCX_REF; Go : BOOL; END_VAR
  VAR Move : FB_MovePtp; END_VAR
  Move(Robot := Robot, Execute := Go);
END_FUNCTION_BLOCK
TYPE CELL : STRUCT Robot : RCX_REF; Number : INT; END_STRUCT; END_TYPE
TYPE ROBOTS : ARRAY [1..2] OF RCX_REF; END_TYPE
"""
HEAD = """\
PROGRAM Cell1
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Safe, Go : BOOL;
    Robot, Other : RCX_REF;
    Robots : ROBOTS;
    Cell : CELL;
    k : INT;
    ReadArea, ReadOther : FB_ReadArea;
    WriteArea, WriteOther : FB_WriteArea;
    Servo : FB_ServoOn;
    Move : FB_MovePtp;
    Ask : FB_ReadPoint;
    Bit : FB_ReadBit;
    Station : FB_Station;
    Copied : FB_Copy;
  END_VAR
"""
FIRST = len((STATION + HEAD).splitlines()) + 1


@pytest.fixture
def check(tmp_path: Path) -> Check:
    """Return the warnings of a body as `line text`; lines of the body count from 1.

    For a line before the body, its text replaces the number.
    """
    stubs = tmp_path / "stubs.st"
    stubs.write_text(STUBS)
    program = tmp_path / "program.st"

    def findings(*body: str) -> list[str]:
        text = STATION + HEAD + "".join(f"{one}\n" for one in body) + "END_PROGRAM\n"
        program.write_text(text)
        found = first_mistakes([program], [stubs])
        assert all(one.file == program for one in found)
        lines = ["", *text.splitlines()]
        return [
            f"{max(one.at.line - FIRST + 1, 0) or lines[one.at.line].strip()}: {one.text}"
            for one in found
        ]

    return findings


@pytest.mark.exhaustive(but=["body0", "body3", "body6", "body9"])
@pytest.mark.parametrize(
    "body",
    [
        (READ, SERVO, MOVE, WRITE),
        (READ, SERVO, MOVE.replace("Go", "Servo.Done"), WRITE),
        (READ, BIT),  # the block only reads
        (READ, "Ask(Robot := Robot, Execute := Go);", WRITE.split(", Em")[0] + ");"),
        (
            "ReadArea.Connected := Connected;",
            "WriteArea.EmergencyStopOk := Safe;",
            "WriteArea.StopOk := TRUE;",
            "ReadArea(Robot := Robot, Image := InputArea);",
            MOVE,
            "WriteArea(Robot := Robot, Image := OutputArea);",
        ),
        (STATIONS, WRITE),
        (of(READ, "Cell.Robot"), of(MOVE, "CELL.ROBOT"), of(WRITE, "Cell.robot")),
        # The index is a variable, so the robot is unknown.
        ("k := 1;", of(READ, "Robots[k]"), of(MOVE, "Robots[2]"), of(WRITE, "Robots[k]")),
        # With a copy of an RCX_REF, it is unknown which requests are sent.
        (READ, "Other := Robot;", of(MOVE, "Other"), "Robot := Other;", WRITE),
        ("IF Go THEN", READ, "END_IF;", MOVE, WRITE),
        ("Go := Connected;",),
    ],
)
def test_a_program_that_works_is_not_warned(check: Check, body: tuple[str, ...]) -> None:
    """Source: docs/how-to/first-mistakes.md."""
    assert check(*body) == []


@pytest.mark.parametrize(
    ("body", "findings"),
    [
        (
            (MOVE, WRITE),
            [
                "1: Move is called for Robot, but FB_ReadArea is not: its blocks never see the "
                "controller, and nothing goes out; call FB_ReadArea(Robot := Robot, "
            ],
        ),
        ((BIT,), ["1: Bit is called for Robot, but FB_ReadArea is not: "]),
        (
            (READ, BIT, MOVE),
            [
                "3: Move is called for Robot, but FB_WriteArea is not: nothing that its blocks ask "
                "for reaches the controller; call FB_WriteArea(Robot := Robot, "
            ],
        ),
        (
            (READ, of(MOVE, "Other"), SERVO, WRITE),
            [
                "2: Move is called for Other, but neither FB_ReadArea nor FB_WriteArea is: "
                "its blocks receive nothing and nothing goes out; "
            ],
        ),
        (
            (READ, SERVO, of(WRITE, "Other")),
            [
                "2: Servo is called for Robot, but FB_WriteArea is not: ",
                "3: WriteArea is called for Other, but FB_ReadArea is not: ",
            ],
        ),
        (
            (of(READ, "Robots[1]"), of(MOVE, "Robots[2]"), of(WRITE, "Robots[1]")),
            ["2: Move is called for Robots[2], but neither FB_ReadArea nor FB_WriteArea is: "],
        ),
        (
            (READ.replace(", Connected := Connected", ""), MOVE, WRITE),
            [
                f"1: {NOT_WIRED}the data from the controller is ignored, and every block of "
                "Robot ends in error 16#8001 (Not connected); "
            ],
        ),
        ((READ.replace(":= Connected", ":= FALSE"), WRITE), [f"1: {NOT_WIRED}"]),
        (
            (READ, SERVO, WRITE.replace("EmergencyStopOk := Safe, ", "")),
            [
                "3: EmergencyStopOk of WriteArea is not wired and stays FALSE: SI(00) stays OFF, "
                "the controller stays in emergency stop, and Servo (line {2}) ends in error; "
            ],
        ),
        (
            (READ, SERVO, MOVE, WRITE.replace(", StopOk := Safe", "")),
            [
                "4: StopOk of WriteArea is not wired and stays FALSE: SI(06) stays OFF, the "
                "controller does not move and starts no program, and Move (line {3}) ends in "
                "error; "
            ],
        ),
        (
            (STATIONS.replace("Online := Connected, ", ""), WRITE),
            [f"ReadArea(Robot := Robot, Image := Image, Connected := Online);: {NOT_WIRED}"],
        ),
        (
            (STATIONS.replace(", Go := Go", ""),),
            [f"{MOVE}: Move is called for Robot, but FB_WriteArea is not: "],
        ),
        (
            (READ, "Copied(Robot := Robot, Go := Go);", WRITE),
            [
                "VAR_INPUT Robot : RCX_REF; Go : BOOL; END_VAR: "
                "Robot is a VAR_INPUT, so FB_Copy works on a copy of the robot: the "
                "requests of its blocks never reach FB_WriteArea; declare it in VAR_IN_OUT"
            ],
        ),
        (
            (READ, "Servo.Execute := Go;", "IF Servo.Done THEN k := 1; END_IF;", WRITE),
            [
                "Servo : FB_ServoOn;: Servo is never called: it does nothing, and its outputs stay "
                "as they are; call Servo(Robot := ...) in every scan, "
            ],
        ),
        (
            (READ.replace("InputArea", "OutputArea"), WRITE.replace("OutputArea", "InputArea")),
            [
                "1: ReadArea reads OutputArea, which is the area to the controller: it never sees "
                "the controller; give it InputArea",
                "2: WriteArea writes into InputArea, which is the area from the controller: "
                "nothing reaches the controller; give it OutputArea",
            ],
        ),
    ],
)
def test_a_first_mistake_is_reported_with_its_line(
    check: Check, body: tuple[str, ...], findings: list[str]
) -> None:
    """Source: docs/how-to/first-mistakes.md."""
    found = check(*body)
    expected = [one.format(*range(FIRST - 1, FIRST + 9)) for one in findings]
    assert [one[: len(begin)] for one, begin in zip(found, expected, strict=True)] == expected


def test_a_declared_block_and_a_likely_name_are_suggested(check: Check) -> None:
    """Source: CONTRIBUTING.md, a message says what to do."""
    [found] = check(MOVE, WRITE)
    assert found.endswith(f"; ReadArea is declared in line {FIRST - 9}, but not called")
    [found] = check(READ, of(MOVE, "Other"), WRITE)
    assert found.endswith(", or use Robot")


VARS = """VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, Safe, Go : BOOL;
    k : INT;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Move : FB_MovePtp;
"""
OWN = f"{VARS} Robot : RCX_REF; END_VAR"
READ_OPEN = "ReadArea(Robot := Robot, Image := InputArea);"
IN_OUTS = "VAR_IN_OUT Robot : RCX_REF; InputArea : RCX_IMAGE; END_VAR"
INNER = f"FUNCTION_BLOCK FB_In {IN_OUTS} VAR_INPUT Connected : BOOL; END_VAR"
INNER += f" VAR ReadArea : FB_ReadArea; END_VAR {READ} END_FUNCTION_BLOCK\n"
#: Whole programs whose sources are unclear, or which use the language of other tools.
OTHERS = {
    "a pointer": f"PROGRAM Main {OWN} VAR P : POINTER TO RCX_REF; END_VAR P := ADR(Robot);"
    f"{of(READ, 'P^')} {MOVE} {of(WRITE, 'P^')} END_PROGRAM",
    "a reference": f"PROGRAM Main {OWN} VAR Ref : REFERENCE TO RCX_REF; END_VAR Ref REF= Robot;"
    f"{of(READ, 'Ref')} {MOVE} {of(WRITE, 'Ref')} END_PROGRAM",
    "a method": f"FUNCTION_BLOCK FB_Cell {OWN} METHOD Run : BOOL {READ} {MOVE} {WRITE} END_METHOD\n"
    "END_FUNCTION_BLOCK PROGRAM Main VAR Cell : FB_Cell; END_VAR Cell.Run(); END_PROGRAM",
    "a block that extends another": "FUNCTION_BLOCK FB_Mine EXTENDS FB_In VAR Move : FB_MovePtp;"
    f" Go : BOOL; END_VAR SUPER^(); {MOVE} END_FUNCTION_BLOCK\n{INNER}"
    f"PROGRAM Main {OWN} VAR Mine : FB_Mine; END_VAR"
    f" Mine(Robot := Robot, InputArea := InputArea, Connected := Connected); {WRITE} END_PROGRAM",
    "a block that extends one of the library": "FUNCTION_BLOCK FB_Mine EXTENDS FB_MovePtp SUPER^();"
    f" END_FUNCTION_BLOCK PROGRAM Main {OWN} VAR Mine : FB_Mine; END_VAR {READ}"
    f" Mine(Robot := Robot, Execute := Go); {WRITE} END_PROGRAM",
    "initial values of blocks": f"PROGRAM Main {OWN}"
    " VAR Reads : FB_ReadArea := (Connected := TRUE);"
    " Writes : FB_WriteArea := (EmergencyStopOk := TRUE, StopOk := TRUE); END_VAR"
    f" Reads(Robot := Robot, Image := InputArea); {MOVE}"
    " Writes(Robot := Robot, Image := OutputArea); END_PROGRAM",
    "arguments without names": f"PROGRAM Main {OWN} ReadArea(Robot, InputArea, 0, 48, Connected);"
    f" {MOVE} WriteArea(Robot, OutputArea, 0, Safe, Safe); END_PROGRAM",
    "a block that another one calls": "FUNCTION_BLOCK FB_Do VAR_IN_OUT Robot : RCX_REF;"
    f" Move : FB_MovePtp; END_VAR VAR Go : BOOL; END_VAR {MOVE} END_FUNCTION_BLOCK"
    f" PROGRAM Main {OWN} VAR Does : FB_Do; END_VAR {READ} Does(Robot := Robot, Move := Move);"
    f" IF Move.Done THEN k := 1; END_IF; {WRITE} END_PROGRAM",
    "a pin that is assigned": f"{INNER} PROGRAM Main {OWN} VAR In : FB_In; END_VAR"
    f" In.Connected := Go; In(Robot := Robot, InputArea := InputArea); {MOVE} {WRITE} END_PROGRAM",
    "two programs with a global robot": f"PROGRAM One VAR_EXTERNAL Robot : RCX_REF; END_VAR {VARS}"
    f" END_VAR {READ} END_PROGRAM PROGRAM Two VAR_EXTERNAL Robot : RCX_REF; END_VAR {VARS} END_VAR"
    f" {MOVE} {WRITE} END_PROGRAM CONFIGURATION C VAR_GLOBAL Robot : RCX_REF; END_VAR"
    " RESOURCE R ON PLC TASK T1(INTERVAL := T#10ms, PRIORITY := 0); PROGRAM A WITH T1 : One;"
    " PROGRAM B WITH T1 : Two; END_RESOURCE END_CONFIGURATION",
}


def _whole(folder: Path, text: str) -> list[str]:
    stubs, program = folder / "stubs.st", folder / "program.st"
    stubs.write_text(STUBS)
    program.write_text(text)
    assert analysed([program, stubs])[1] == []
    return [one.text for one in first_mistakes([program], [stubs])]


@pytest.mark.parametrize("text", OTHERS.values(), ids=OTHERS)
def test_unclear_sources_are_not_reported(tmp_path: Path, text: str) -> None:
    """Source: docs/how-to/first-mistakes.md."""
    assert _whole(tmp_path, text) == []


@pytest.mark.parametrize(
    ("name", "old", "new", "finding"),
    [
        ("a method", WRITE, "", "Move is called for Cell.Robot, but FB_WriteArea is not: "),
        ("a method", READ, READ_OPEN, "Connected of ReadArea is not wired"),
        ("a pin that is assigned", "In.Connected := Go;", "", "Connected of ReadArea is not wired"),
        ("two programs with a global robot", WRITE, "", "Move is called for Robot, but FB_WriteA"),
        ("a block that extends another", WRITE, "", "Move is called for Robot, but FB_WriteArea"),
    ],
)
def test_mistakes_in_such_programs_are_found_if_the_source_is_clear(
    tmp_path: Path, name: str, old: str, new: str, finding: str
) -> None:
    """Source: docs/how-to/first-mistakes.md."""
    [found] = _whole(tmp_path, OTHERS[name].replace(old, new))
    assert found.startswith(finding)


@pytest.fixture(scope="module")
def cell_of_template(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, str], Path]:
    """Return a function that writes the program of `rcx new` with a part of its text replaced."""
    folder = tmp_path_factory.mktemp("template")

    def write(old: str, new: str) -> Path:
        for file in TEMPLATE.glob("*.st"):
            text = file.read_text(encoding="utf-8").replace("@SIZE@", "48")
            if file.name == "PickAndPlace.st":
                assert old in text
                text = text.replace(old, new)
            (folder / file.name).write_text(text, encoding="utf-8")
        return folder

    return write


def test_check_run_and_a_timeout_of_a_test_print_the_warning(
    cell_of_template: Callable[[str, str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """`rcx check`, `rcx run` and the time-out of a test print the warning.

    Warnings do not change the exit code.

    Source: docs/how-to/first-mistakes.md.
    """
    folder = cell_of_template(", Connected := Connected", "")
    said = f"{folder / 'PickAndPlace.st'}:33:3: warning: Connected of ReadArea is not wired "
    assert main(["check", str(folder)]) == 0
    out = capsys.readouterr().out
    assert said in out
    assert "no broken rules, 1 warning" in out
    assert main(["run", str(folder), "--for", "10ms", "--engine", "builtin"]) == 0
    assert capsys.readouterr().err.count(said) == 1
    with Cell.build(folder, engine="builtin") as cell, pytest.raises(CellTimeout) as failed:
        cell.run_until(lambda: False, within="20ms")
    first, *warned = str(failed.value).splitlines()
    assert first == "not within 20 ms (scan 3, 20 ms)"
    assert [one.startswith(said) for one in warned] == [True]


def test_the_program_of_the_template_has_no_first_mistake(
    cell_of_template: Callable[[str, str], Path],
) -> None:
    """Source: docs/how-to/first-mistakes.md."""
    folder = cell_of_template("PickAndPlace", "PickAndPlace")
    with Cell.build(folder, engine="builtin") as cell, pytest.raises(CellTimeout) as failed:
        cell.run_until(lambda: False, within="20ms")
    assert "warning" not in str(failed.value)
