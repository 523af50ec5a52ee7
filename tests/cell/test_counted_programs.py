"""The coverage of robot programs counts lines and branches, and is exported for other tools."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.cell.counted_programs import count_programs
from rcx_harness.robot import Controller, RobotConfig, RobotProgram
from robot_master import Master
from structured_text.coverage.formats import tracefile
from structured_text.coverage.measure import FileResult, measure
from structured_text.coverage.parts import merge, part_of
from structured_text.coverage.report import missing
from structured_text.engines.builtin.collector import Collector, counting


def _run(folder: Path, text: str, name: str = "MAIN", collector: Collector | None = None) -> Master:
    """Start a robot program with AUTO start, and count its coverage while it runs."""
    file = folder / f"{name}.PGM"
    file.write_text(text)
    program = RobotProgram(name, text=text, path=str(file))
    master = Master(programs=(program,), program_start_delay=5.0)
    with counting(collector or Collector()):
        count_programs([master.robot])
    master.servo_on()
    master.turn("SI12", True)
    master.run(120)
    master.turn("SI12", False)
    master.run(100)
    return master


def _result(folder: Path, text: str) -> FileResult:
    collector = Collector()
    _run(folder, text, collector=collector)
    (result,) = measure(merge([part_of(collector)]), folder)
    return result


@pytest.mark.parametrize(
    ("text", "lines", "branches"),
    [
        (
            "A%=2\nIF A%=1 THEN\nSGI0=1\nELSE\nSGI0=2\nENDIF",
            {1: 1, 2: 1, 3: 0, 5: 1},  # ELSE and ENDIF are not statements
            {"IF A%=1 THEN: true": 0, "IF A%=1 THEN: false": 1},
        ),
        (
            "A%=2\nIF A%=1 THEN\nSGI0=1\nELSEIF A%=2 THEN\nSGI0=2\nENDIF\nSGI0=3",
            {1: 1, 2: 1, 3: 0, 4: 1, 5: 1, 7: 1},
            {
                "IF A%=1 THEN: true": 0,
                "IF A%=1 THEN: false": 1,
                "ELSEIF A%=2 THEN: true": 1,
                "ELSEIF A%=2 THEN: false": 0,
            },
        ),
        (
            "IF 1=2 THEN SGI0=1 ELSE SGI0=2",
            {1: 1},
            {"IF 1=2 THEN SGI0=1 ELSE SGI0=2: true": 0, "IF 1=2 THEN SGI0=1 ELSE SGI0=2: false": 1},
        ),
        (
            "WHILE SGI0<3 ' counts\nSGI0=SGI0+1\nWEND",
            {1: 4, 2: 3, 3: 3},
            {"WHILE SGI0<3: true": 3, "WHILE SGI0<3: false": 1},
        ),
        ("FOR I%=1 TO 3\nSGI0=I%\nNEXT\nSGI0=9", {1: 1, 2: 3, 3: 3, 4: 1}, {}),
        ("FOR I%=3 TO 1 STEP -1\nSGI0=I%\nNEXT", {1: 1, 2: 3, 3: 3}, {}),
        (
            "A%=3\nFOR I%=1 TO A%\nSGI0=I%\nNEXT\nSGI0=9",
            {1: 1, 2: 1, 3: 3, 4: 3, 5: 1},
            {"FOR I%=1 TO A%: a round": 3, "FOR I%=1 TO A%: no round": 0},
        ),
        (
            "FOR J%=1 TO 2\nFOR I%=J% TO 1\nSGI0=I%\nNEXT\nNEXT",
            {1: 1, 2: 2, 3: 1, 4: 1, 5: 2},
            {"FOR I%=J% TO 1: a round": 1, "FOR I%=J% TO 1: no round": 1},
        ),
        (
            "A%=8\nSELECT A%\nCASE 1\nSGI0=1\nCASE 8,9\nSGI0=2\nCASE ELSE\nSGI0=3\nEND SELECT",
            {1: 1, 2: 1, 3: 1, 4: 0, 5: 1, 6: 1, 8: 0},
            {"CASE 1": 0, "CASE 8,9": 1, "CASE ELSE": 0},
        ),
        (
            "SELECT SGI0\nCASE 1\nSGI1=1\nEND SELECT\nSGI1=2",
            {1: 1, 2: 1, 3: 0, 5: 1},
            {"CASE 1": 0, "SELECT without a CASE that fits": 1},
        ),
        (
            "WAIT SI(20)=1,20\nWAIT SI(20)=0,20\nSGI0=1",
            {1: 1, 2: 1, 3: 1},
            {
                "WAIT SI(20)=1,20: in time": 0,
                "WAIT SI(20)=1,20: time-out": 1,
                "WAIT SI(20)=0,20: in time": 1,
                "WAIT SI(20)=0,20: time-out": 0,
            },
        ),
        # A WAIT that lasts many cycles counts as one hit. The statements after the WAIT are not
        # reached.
        ("WAIT SI(20)=1\nSGI0=1", {1: 1, 2: 0}, {}),
        ("*L:\nCALL S\nEND\nSUB S\nSGI0=1\nEND SUB", {2: 1, 3: 1, 5: 1, 6: 1}, {}),
        (
            "ON ERROR GOTO *E\nIF P900=P901 THEN\nSGI0=1\nENDIF\nEND\n*E:\nSGI0=2",
            {1: 1, 2: 1, 3: 0, 5: 0, 7: 1},
            {"IF P900=P901 THEN: true": 0, "IF P900=P901 THEN: false": 0},
        ),
        (
            "ON ERROR GOTO *E\nWAIT P900=P901,20\nEND\n*E:\nSGI0=2",
            {1: 1, 2: 1, 3: 0, 5: 1},
            {"WAIT P900=P901,20: in time": 0, "WAIT P900=P901,20: time-out": 0},
        ),
    ],
)
def test_lines_and_branches_are_counted(
    tmp_path: Path, text: str, lines: dict[int, int], branches: dict[str, int]
) -> None:
    """Each line and each branch has the number of hits that was determined by hand.

    The points P900 and P901 are not defined, so their use is a run-time error.
    """
    result = _result(tmp_path, text)
    assert {item.line: item.hits for item in result.statements} == lines
    assert {item.text: item.hits for item in result.branches} == branches


def test_missing_lines_and_branches_are_listed(tmp_path: Path) -> None:
    """Lines 2 and 3 are not executed, so the report lists them.

    The report lists the FALSE branch of line 5 separately, because this branch has no line.
    """
    text = "IF SI(20)=1 THEN\nSGI0=0\nSGI0=1\nENDIF\nIF SI(20)=0 THEN\nSGI0=2\nENDIF\nSGI0=3"
    result = _result(tmp_path, text)
    assert missing(result) == "2-3; branches 5"
    assert result.statement_share.shown == "66.6 %", "4 of 6"
    records = tracefile([result]).splitlines()
    assert records[1:4] == ["SF:MAIN.PGM", "FN:1,MAIN", "FNDA:1,MAIN"]
    assert [one for one in records if one.startswith("DA:")] == [
        "DA:1,1", "DA:2,0", "DA:3,0", "DA:5,1", "DA:6,1", "DA:8,1",
    ]  # fmt: skip
    assert "BRDA:5,1,3,0" in records


def test_lines_with_a_reason_are_excluded(tmp_path: Path) -> None:
    """A comment `unreachable: reason` excludes its line, or the next line, from the report."""
    text = "END\nSGI0=1 ' unreachable: for later\n' unreachable: by hand only\n\nSGI0=2\nSGI0=3"
    result = _result(tmp_path, text)
    reasons = {item.line: item.reason for item in result.statements}
    assert reasons == {1: "", 2: "for later", 5: "by hand only", 6: ""}
    assert missing(result) == "6"


def test_cells_with_the_same_program_count_together(tmp_path: Path) -> None:
    collector = Collector()
    for _ in range(2):
        _run(tmp_path, "SGI0=1", collector=collector)
    _run(tmp_path, "SGI0=2", "OTHER", collector=collector)
    main, other = measure(merge([part_of(collector)]), tmp_path)
    assert [main.statements[0].hits, other.statements[0].hits] == [2, 1]


def test_a_changed_file_is_reported(tmp_path: Path) -> None:
    collector = Collector()
    _run(tmp_path, "SGI0=1", collector=collector)
    (tmp_path / "MAIN.PGM").write_text("SGI0=2")
    (result,) = measure(merge([part_of(collector)]), tmp_path)
    assert result.changed


def test_only_programs_in_files_below_the_folder_count(tmp_path: Path) -> None:
    collector = Collector(tmp_path / "other")
    _run(tmp_path, "SGI0=1", collector=collector)
    assert collector.texts == []
    with counting(Collector()) as collector:
        count_programs([Controller(RobotConfig(programs=(RobotProgram(text="SGI0=1"),)))])
    assert collector.texts == []


def test_a_restored_program_is_counted_as_well(tmp_path: Path) -> None:
    """A restored task executes line 2 a second time, and coverage counts both executions."""
    collector = Collector()
    master = _run(tmp_path, "WAIT SI(20)=1\nSGI0=1", collector=collector)
    before = master.robot.snapshot()
    for _ in range(2):
        master.robot.restore(before)
        master.si[34] = 1
        master.run(50)
    (result,) = measure(merge([part_of(collector)]), tmp_path)
    assert [item.hits for item in result.statements] == [1, 2]


def test_programs_of_an_all_file_have_the_lines_of_the_file(tmp_path: Path) -> None:
    """Line numbers are those of the .ALL file. The text of the program MAIN begins in line 3."""
    (tmp_path / "CELL.ALL").write_text("[PGM]\nNAME=MAIN\nSGI0=1\nSGI0=2\n\n[END]\n")
    (tmp_path / "robot.toml").write_text('data_file = "CELL.ALL"\n')
    config = RobotConfig.load(tmp_path / "robot.toml")
    with counting(Collector()) as collector:
        count_programs([Controller(config)])
    (result,) = measure(merge([part_of(collector)]), tmp_path)
    assert (result.path, result.pous) == ("CELL.ALL", [("MAIN", 3, 0)])
    assert [item.line for item in result.statements] == [3, 4]
