"""`rcx run --coverage` prints the coverage, writes a report, and sets the exit code."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from plc_bench import ROOT
from progress_lines import without_progress
from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]
Run = Callable[..., int]

_PROGRAM = """\
PROGRAM Lamp
  VAR Count : INT; InputArea, OutputArea : ARRAY [0..47] OF BYTE; Block : FB_Blink; END_VAR
  Count := Count + 1;
  IF Count > 40 AND_THEN Count < 42 THEN
    Count := 100;
  END_IF;
  Block();
END_PROGRAM
"""
_BLOCK = "FUNCTION_BLOCK FB_Blink\n  VAR k : INT; END_VAR\n  k := k + 1;\nEND_FUNCTION_BLOCK\n"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Return a function that runs Lamp.st. The library contains only FB_Blink.st."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    (tmp_path / "Lamp.st").write_text(_PROGRAM)
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib/FB_Blink.st").write_text(_BLOCK)

    def run(*args: str) -> int:
        return main(["run", "Lamp.st", "--lib", "lib", "--scan", "10ms", *args])

    return run


def test_a_run_prints_its_coverage_and_writes_the_report(run: Run, capsys: Captured) -> None:
    """The printed coverage is 66.6 %, because 40 scans never evaluate the second condition."""
    assert run("--for", "400ms", "--coverage") == 0
    out = re.sub(" +", " ", capsys.readouterr().out)
    assert "coverage is counted: running on the built-in engine\n" in out
    assert out.splitlines()[-4:] == [
        "Lamp.st 75.0 % 3/4 50.0 % 1/2 0.0 % 0/2 5",
        "",
        "coverage of statements and branches: 66.6 %",
        "written: out/coverage/index.html, out/coverage/coverage.lcov, out/coverage/coverage.xml",
    ]
    assert "DA:3,40" in Path("out/coverage/coverage.lcov").read_text().splitlines()


def test_the_demanded_coverage_decides_the_exit_code(run: Run, capsys: Captured) -> None:
    assert run("--for", "1s", "--coverage", "--cover-fail-under", "100") == 0
    assert "100.0 %, as at least 100 % is demanded" in capsys.readouterr().out
    assert run("--for", "400ms", "--coverage", "--cover-fail-under", "100") == 1
    assert "66.6 %, FAIL: at least 100 % is demanded" in capsys.readouterr().out


def test_the_library_is_counted_on_request(run: Run, capsys: Captured) -> None:
    assert run("--for", "50ms", "--coverage", "--coverage-out=cov", "--coverage-library") == 0
    assert "lib/FB_Blink.st" in capsys.readouterr().out
    assert Path("cov/lib-FB_Blink.html").is_file()
    assert not Path("out").exists()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--cover-fail-under=90"], "--cover-fail-under: no coverage is counted; add --coverage"),
        (["--coverage-out=x"], "--coverage-out: no coverage is counted; add --coverage"),
        (["--coverage-library"], "--coverage-library: no coverage is counted; add --coverage"),
        (["--coverage", "--cover-fail-under=-1"],
         "--cover-fail-under is -1; give a percentage from 0 to 100"),
        (["--coverage", "--engine=matiec"],
         "coverage is counted by the built-in engine; leave out --engine matiec, or --coverage"),
        (["--coverage", "--coverage-out=Lamp.st"],
         "Lamp.st: is not a folder; name another folder for the coverage report"),
        (["--coverage", "--coverage-out=mine"],
         "mine/coverage.xml: already exists and is not a coverage report; nothing was written; "
         "name another folder, or remove this file"),
    ],
)  # fmt: skip
def test_bad_input_is_one_line_before_the_run(
    run: Run, capsys: Captured, options: list[str], message: str
) -> None:
    Path("mine").mkdir()
    Path("mine/coverage.xml").write_text("<mine/>")
    assert run("--for", "50ms", *options) == 2
    assert without_progress(capsys.readouterr().err) == f"rcx: {message}\n"
    assert Path("mine/coverage.xml").read_text() == "<mine/>"


def test_a_source_changed_during_the_run_is_reported(
    run: Run, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    from rcx_harness.cell import Cell

    close = Cell.close

    def change(cell: Cell) -> None:
        Path("Lamp.st").write_text(_PROGRAM + "(* more *)\n")
        close(cell)

    monkeypatch.setattr(Cell, "close", change)
    assert run("--for", "50ms", "--coverage") == 1
    assert "Lamp.st was changed since it was compiled: run again" in capsys.readouterr().out


def test_robot_programs_are_counted_and_the_trace_does_not_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """The coverage contains the robot program PLACE.PGM, and the trace does not change.

    PLACE.PGM has 24 lines with statements. Lines 12, 29 and 30 are for place 7, which is never
    requested.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    for file in (ROOT / "tests/data/robot_programs").glob("*.*"):
        shutil.copy(file, tmp_path)
    args = ["run", "Supervisor.st", "--robot", "robot.toml", "--stimulus", "stimulus.toml"]
    args += ["--for", "4s", "--engine", "builtin"]
    assert main([*args, "--trace", "plain.jsonl"]) == 0
    capsys.readouterr()
    assert main([*args, "--trace", "counted.jsonl", "--coverage"]) == 0
    table = re.sub(" +", " ", capsys.readouterr().out).splitlines()
    assert "PLACE.PGM 87.5 % 21/24 66.6 % 2/3 - 12, 29-30" in table
    assert Path("plain.jsonl").read_bytes() == Path("counted.jsonl").read_bytes()
    page = Path("out/coverage/PLACE.PGM.html").read_text()
    assert "not executed: GOTO *WRONG" not in page, "the branch reports this line already"
    assert "not taken: CASE ELSE" in page
    assert 'filename="PLACE.PGM"' in Path("out/coverage/coverage.xml").read_text()
