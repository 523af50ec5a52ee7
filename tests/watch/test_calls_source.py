"""The source is checked for each kind of misuse of a robot's blocks."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

from rcx_harness.cli.app import main
from rcx_harness.watch import calls_source
from rcx_harness.watch.calls_source import call_findings, call_plan, steady_instances
from structured_text.language import cache

LIBRARY = Path(__file__).resolve().parents[2] / "plc" / "lib"
READ = "ReadArea(Robot := Robot, Image := InputArea);"
WRITE = "WriteArea(Robot := Robot, Image := OutputArea);"
MOVE = "Step1(Robot := Robot, Execute := Go);"
ORIGIN = "Origin(Robot := Robot, Execute := Go);"
GATE = "IF Gate THEN {} END_IF;"
STATIONS = "Station(Robot := Robot);"
RECORD = "Recorder(Robot := Robot);"
IF_GATE, IF_GO = "IF Gate THEN", "IF Go THEN"
#: Texts of findings, in which `@2` is line 2 of the body.
SECOND = "is called a second time in a scan (first in line"
LOOPED = "Step1 is called inside a loop; "
GATED = "Step1 is called only under a condition: "
RETURNED = "is called after a RETURN that may come first: "
EARLY = "is called before the area of Robot is read: "
ENDS = "it ends with 16#8017 "

Check = Callable[..., list[str]]

HEAD = """PROGRAM CELL1
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Robot, Other : RCX_REF;
    Robots : RCX_ROBOTS;
    Gate, Go : BOOL;
    Choice, k : INT;
    ReadArea, ReadAgain : FB_ReadArea;
    WriteArea, WriteAgain : FB_WriteArea;
    Step1 : FB_MovePtp;
    Origin : FB_ReturnToOrigin;
    Bit : FB_ReadBit;
    Recorder : FB_CommandRecorder;
    Station : FB_Station;
    Halt : FB_EmergencyStop;
    Mode : FB_AutoMode;
  END_VAR
"""
STATION = """FUNCTION_BLOCK FB_Station
  VAR_IN_OUT Robot : RCX_REF; END_VAR
  VAR_INPUT Go : BOOL; END_VAR
  VAR Step1 : FB_MovePtp; END_VAR
  Step1(Robot := Robot, Execute := Go);
END_FUNCTION_BLOCK
TYPE
  RCX_ROBOTS : ARRAY [1..2] OF RCX_REF;
END_TYPE
"""


def _write(folder: Path, body: tuple[str, ...]) -> Path:
    file = folder / "program.st"
    file.write_text(HEAD + "".join(f"{line}\n" for line in body) + "END_PROGRAM\n" + STATION)
    return file


FIRST = len(HEAD.splitlines()) + 1


@pytest.fixture
def check(tmp_path: Path) -> Check:
    """Return the findings in a body as `line text`.

    Lines count from 1; `?` marks a possible finding.
    """

    def findings(*body: str) -> list[str]:
        library = sorted(LIBRARY.rglob("*.st"))
        return [
            f"{one.at.line - FIRST + 1}{'' if one.certain else '?'}: {one.text}"
            for one in call_findings([_write(tmp_path, body)], library)
        ]

    return findings


@pytest.mark.parametrize(
    "body",
    [
        (READ, MOVE, ORIGIN, WRITE),
        (READ, "IF Gate THEN k := 1; ELSE k := 2; END_IF;", MOVE, WRITE),
        (READ, "Station(Robot := Robot, Go := Go);", WRITE, RECORD),
        (READ, WRITE, "Mode(Robot := Robot, Enable := Go);"),
        (
            *(READ, "Bit(Robot := Robot, Image := InputArea, Port := 20);"),
            "IF Bit.Value THEN Bit(Robot := Robot, Image := InputArea, Port := 21); END_IF;",
            WRITE,
        ),
        (
            *(READ, "ReadAgain(Robot := Other, Image := InputArea, m := 48);"),
            *(MOVE, "Origin(Robot := Other, Execute := Go);"),
            *(WRITE, "WriteAgain(Robot := Other, Image := OutputArea, n := 48);"),
        ),
        (MOVE, "step1.Execute := FALSE;"),
        (READ, "Step1(Robot := ROBOT, Execute := Go);", WRITE, "IF Gate THEN RETURN; END_IF;"),
    ],
)
def test_legal_calls_are_not_reported(check: Check, body: tuple[str, ...]) -> None:
    assert check(*body) == []


@pytest.mark.parametrize(
    ("body", "findings"),
    [
        ((READ, MOVE, MOVE, WRITE), [f"3: Step1 {SECOND} @2); "]),
        ((READ, STATIONS, STATIONS, WRITE), [f"3: Station {SECOND} @2); "]),
        ((READ, RECORD, RECORD, WRITE), [f"3: Recorder {SECOND} @2); "]),
        ((READ, READ, MOVE, WRITE), [f"2: ReadArea {SECOND} @1); "]),
        ((READ, MOVE, WRITE, WRITE), [f"4: WriteArea {SECOND} @3); "]),
        (
            (READ, "ReadAgain(Robot := Robot, Image := InputArea);", MOVE, WRITE),
            [
                "2: ReadAgain is a second block that reads the area of Robot in a scan "
                "(the first is ReadArea in line @1); "
            ],
        ),
        (
            (READ, MOVE, WRITE, "WriteAgain(Robot := robot, Image := OutputArea);"),
            [
                "4: WriteAgain is a second block that writes the area of robot in a scan "
                "(the first is WriteArea in line @3); "
            ],
        ),
        ((READ, "FOR k := 1 TO 2 DO", MOVE, "END_FOR;", WRITE), [f"3: {LOOPED}"]),
        (
            (READ, "WHILE Gate DO", IF_GO, MOVE, "EXIT;", "END_IF;", "END_WHILE;", WRITE),
            [f"4: {LOOPED}"],
        ),
        (
            (READ, "WHILE Gate DO", IF_GO, MOVE, "EXIT;", "END_IF;", "END_WHILE;", MOVE),
            [f"4: {LOOPED}", f"8: Step1 {SECOND} @4); "],
        ),
        (
            (IF_GATE, MOVE, "ELSE", MOVE.replace(":= Robot", ":= ROBOT"), "END_IF;"),
            [f"2?: {GATED}", f"4?: {GATED}"],
        ),
        ((READ, "REPEAT", MOVE, "UNTIL Gate", "END_REPEAT;", WRITE), [f"3: {LOOPED}"]),
        (
            (MOVE, "Step1(Robot := Other, Execute := Go);"),
            [
                f"2: Step1 {SECOND} @1); ",
                "2: Step1 is used for Other here and for Robot in line @1; "
                "declare an instance for each robot",
            ],
        ),
        (
            (MOVE, READ, ORIGIN, WRITE),
            [
                f"1: Step1 {EARLY}{ENDS}(Called out of place) and nothing is executed; "
                "move the call behind ReadArea in line @2"
            ],
        ),
        (
            (READ, WRITE, MOVE),
            [
                f"3: Step1 is called after WriteArea in line @2: {ENDS}(Called out of place) "
                "and nothing is executed; move the call in front of that line"
            ],
        ),
        (
            (READ, WRITE, IF_GATE, MOVE, "END_IF;"),
            [f"4: Step1 is called after WriteArea in line @2: {ENDS}", f"4?: {GATED}"],
        ),
        ((STATIONS, READ, WRITE), [f"1: Station {EARLY}{ENDS}"]),
        (
            (READ, WRITE, "Halt(Robot := Robot, Execute := Go);"),
            [
                f"3: Halt is called after WriteArea in line @2: {ENDS}"
                "(Called out of place), although it stops the robot; "
            ],
        ),
        (
            ("Mode(Robot := Robot, Enable := Go);", READ, WRITE),
            [f"1: Mode {EARLY}it sees the scan before; "],
        ),
        (
            (MOVE, WRITE, READ),
            [
                f"1: Step1 {EARLY}it sees the scan before; ",
                f"2: WriteArea {EARLY}",
                "3: ReadArea is called after WriteArea in line @2: ",
            ],
        ),
        (
            (WRITE, MOVE, READ),
            [
                f"1: WriteArea {EARLY}",
                f"2: Step1 is called after WriteArea in line @1: {ENDS}",
                "3: ReadArea is called after WriteArea in line @1: ",
            ],
        ),
        (
            (WRITE, READ),
            [f"1: WriteArea {EARLY}", "2: ReadArea is called after WriteArea in line @1: "],
        ),
        ((READ, IF_GATE, MOVE, "END_IF;", WRITE), [f"3?: {GATED}"]),
        ((READ, "CASE Choice OF", "1:", MOVE, "ELSE k := 1; END_CASE;", WRITE), [f"4?: {GATED}"]),
        (
            (READ, "IF Gate THEN RETURN; END_IF;", MOVE, WRITE),
            [f"3?: Step1 {RETURNED}", f"4?: WriteArea {RETURNED}"],
        ),
        ((READ, IF_GATE, MOVE, "ELSE", MOVE, "END_IF;", WRITE), [f"3?: {GATED}", f"5?: {GATED}"]),
        (
            (READ, IF_GATE, MOVE, WRITE, "RETURN;", "END_IF;", MOVE, WRITE),
            [
                *(f"3?: {GATED}", "4?: WriteArea is called only under a condition: "),
                *(f"7?: Step1 {RETURNED}", f"8?: WriteArea {RETURNED}"),
            ],
        ),
        (
            (READ, IF_GATE, MOVE, "END_IF;", IF_GO, MOVE, "END_IF;", WRITE),
            [f"3?: {GATED}", f"6?: Step1 {SECOND} @3); ", f"6?: {GATED}"],
        ),
        (
            (READ, IF_GATE, MOVE, "END_IF;", MOVE, WRITE),
            [f"3?: {GATED}", f"5: Step1 {SECOND} @3); "],
        ),
        (
            (READ, "CASE Choice OF", "1:", MOVE, "2:", MOVE, "END_CASE;", WRITE, "k := 1;"),
            [f"4?: {GATED}", f"6?: {GATED}"],
        ),
        (
            (READ, IF_GATE, MOVE, "END_IF;", "CASE Choice OF", "1:", MOVE, "END_CASE;"),
            [f"3?: {GATED}", f"7?: Step1 {SECOND} @3); ", f"7?: {GATED}"],
        ),
    ],
)
def test_each_misuse_is_found_alone(
    check: Check, body: tuple[str, ...], findings: list[str]
) -> None:
    found = check(*body)
    expected = [re.sub(r"@(\d)", lambda line: str(FIRST + int(line[1]) - 1), f) for f in findings]
    assert [text[: len(begin)] for text, begin in zip(found, expected, strict=True)] == expected


def test_calls_in_a_block_of_the_user_are_checked_too(tmp_path: Path) -> None:
    file = tmp_path / "block.st"
    file.write_text(STATION.replace("Execute := Go);\n", f"Execute := Go);\n  {MOVE}\n"))
    found = call_findings([file], sorted(LIBRARY.rglob("*.st")))
    assert [(one.at.line, one.certain) for one in found] == [(6, True)]


@pytest.mark.parametrize(
    ("body", "watched"),
    [
        ((READ, MOVE, WRITE), False),
        ((READ, "IF Gate THEN", MOVE, "END_IF;", WRITE), True),
        ((READ, MOVE, MOVE, WRITE), True),
        ((READ, "Step1(Robot := Robots[k], Execute := Go);", WRITE), True),
        ((READ, "Step1(Robot := Robots[1], Execute := Go);", WRITE), False),
    ],
)
def test_only_what_the_source_leaves_open_is_watched(
    tmp_path: Path, body: tuple[str, ...], watched: bool
) -> None:
    plan = call_plan([_write(tmp_path, body)], sorted(LIBRARY.rglob("*.st")))
    assert bool(plan.blocks) is watched
    if watched:
        assert plan.owners["CELL1"] == {"READAREA", "STEP1", "WRITEAREA"}
        assert plan.blocks == {"FB_READAREA": 0, "FB_MOVEPTP": 0, "FB_WRITEAREA": 0}


def test_the_check_depends_on_which_files_belong_to_the_user(tmp_path: Path) -> None:
    """Files of the library are not checked, even if the user's files are the same files."""
    file = _write(tmp_path, (READ, MOVE, MOVE, WRITE))
    library = sorted(LIBRARY.rglob("*.st"))
    assert call_plan([file], library).blocks
    assert not call_plan([], [file, *library]).blocks


def test_check_ends_with_1_for_a_misuse_and_with_0_for_what_only_may_go_wrong(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _write(tmp_path, (READ, MOVE, MOVE, WRITE))
    assert main(["check", str(file)]) == 1
    out = capsys.readouterr().out
    assert f"{file}:{FIRST + 2}:1: rule: Step1 is called a second time in a scan" in out
    assert "1 broken rule" in out
    file = _write(tmp_path, (READ, GATE.format(MOVE), WRITE))
    assert main(["check", str(file)]) == 0
    assert f"{file}:{FIRST + 1}:14: warning: Step1 is called only under" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_the_shipped_examples_call_their_blocks_well() -> None:
    library = sorted(LIBRARY.rglob("*.st"))
    for folder in sorted((LIBRARY.parent / "examples").glob("*/")):
        files = sorted(folder.glob("*.st"))
        assert call_findings(files, library) == []
        assert call_plan(files, library).blocks == {}


@pytest.mark.parametrize("made", [call_plan, steady_instances])
def test_cached_results_of_other_code_are_not_used(
    made: Callable[[Sequence[Path]], object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Source: language/cache.py: its key contains only the code of the engine."""
    file = tmp_path / "Main.st"
    file.write_text("PROGRAM Main VAR X : INT; END_VAR X := 1; END_PROGRAM", encoding="utf-8")
    asked: list[Path] = []
    real = cache.sources_key

    def noted(files: Sequence[Path]) -> str:
        asked.extend(files)
        return real(files)

    monkeypatch.setattr(cache, "sources_key", noted)
    made([file])
    assert Path(calls_source.__file__) in asked
