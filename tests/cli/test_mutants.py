"""`rcx mutants` reports which mutants a user's tests detect, and saves the outcomes."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from junit_files import junit_root
from rcx_harness.cell.sources import source_files
from rcx_harness.cli.app import main
from rcx_harness.cli.start import INTERRUPTED
from structured_text.mutants.sessions import Judge, PytestCommand
from structured_text.mutants.user import UserMutants
from structured_text.output.results import Results

Captured = pytest.CaptureFixture[str]

_LAMP = """PROGRAM Lamp
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Button, Key, Green, Red : BOOL;
    Count : INT;
  END_VAR
  Green := Button AND Key;
  IF Button THEN
    Count := FC_Next(Count);
  END_IF;
  IF Count > 5 THEN
    Red := TRUE;
  END_IF;
END_PROGRAM
"""
_NEXT = """FUNCTION FC_Next : INT
  VAR_INPUT
    Old : INT;
  END_VAR
  FC_Next := Old + 1; // user's Structured Text, not the library's
END_FUNCTION
"""
_TESTS = """
def test_it_is_green_with_button_and_key(cell):
    cell["Main.Key"] = True
    cell.scan()
    assert not cell["Main.Green"]
    cell["Main.Button"] = True
    cell.scan()
    assert cell["Main.Green"]


def test_it_counts(cell):
    cell["Main.Button"] = True
    cell.scan(3)
    assert cell["Main.Count"] == 3
    cell["Main.Button"] = False
    cell.scan()
    assert cell["Main.Count"] == 3
"""
_DARK = """

def test_it_is_dark_at_first(cell):
    cell.scan()
    assert not cell["Main.Green"]
"""
_KEY = """
def test_it_is_not_green_without_a_key(cell):
    cell["Main.Button"] = True
    cell.scan()
    assert not cell["Main.Green"]
"""

#: Survivors by line. The tests never set Button without Key, so mutants of line 7 survive. They use
#: only counts 0 to 3 in line 11, and never execute line 12.
_SURVIVORS = {(7, "Green := Button;"), (11, "IF Count >= 5 THEN"), (11, "IF Count > 6 THEN"),
              (11, "IF Count > 4 THEN"), (11, "IF FALSE THEN")}  # fmt: skip


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    files = {
        "plc/Lamp.st": _LAMP,
        "plc/FC_Next.st": _NEXT,
        "tests/test_lamp.py": _TESTS + _DARK,
        "pytest.ini": "[pytest]\nrcx_sources = plc\ntestpaths = tests\n",
    }
    for name, text in files.items():
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    yield tmp_path
    for name, text in files.items():  # the command never changes files of the user
        if name.endswith(".st"):
            assert (tmp_path / name).read_text(encoding="utf-8") == text


def _found(file: str = "found.json") -> dict[str, object]:
    found: dict[str, object] = json.loads(Path(file).read_text(encoding="utf-8"))["mutants"]
    return found


def _survivors() -> set[tuple[int, str]]:
    rows = _found()["survivors"]
    assert isinstance(rows, list)
    return {(row["line"], row["after"]) for row in rows}


def _failing() -> set[tuple[int, str]]:
    """Return line and new text of the failed cases in the JUnit file."""
    cases = [
        one
        for one in junit_root(Path("it.xml")).iter("testcase")
        if one.find("failure") is not None
    ]
    return {(int(one.get("line", "")), str(one.get("name")).split(": ")[2]) for one in cases}


@pytest.mark.exhaustive
def test_survivors_are_listed_until_a_better_test_finds_them(
    project: Path, capsys: Captured
) -> None:
    command = ["mutants", "plc", "--json", "found.json", "--junit", "it.xml", "--", "pytest", "-q"]
    before = {path for path in project.rglob("*") if "__pycache__" not in path.parts}
    assert main(command) == 1
    said = capsys.readouterr().out
    assert _survivors() >= _SURVIVORS
    lines = {line for line, _ in _survivors()}
    assert lines == {7, 11, 12}  # no survivors in FC_Next or in the counting
    assert "plc/Lamp.st:7: operand survives\n  - Green := Button AND Key;\n" in said
    assert "plc/Lamp.st:12: dropped assignment survives, and no test runs this line" in said
    first = _found()
    new = {path for path in project.rglob("*") if "__pycache__" not in path.parts} - before
    rows = Path(".rcx/mutants-without-reason.toml")
    kept = Path(".rcx/mutants.jsonl")
    assert {one.relative_to(project) for one in new} == {Path(".rcx"), rows, kept} | {
        Path("found.json"),
        Path("it.xml"),
    }
    assert _failing() == _survivors()

    known = kept.read_text("utf-8")
    assert main(command) == 1
    assert kept.read_text("utf-8") == known  # no mutant was run again
    assert _found() == first
    capsys.readouterr()

    # With a new test, only survivors are run again, not mutants that were already detected.
    (project / "tests" / "test_key.py").write_text(_KEY, encoding="utf-8")
    assert main(command) == 1
    assert (7, "Green := Button;") not in _survivors()
    assert _SURVIVORS - _survivors() == {(7, "Green := Button;")}
    again = len(kept.read_text("utf-8").splitlines()) - len(known.splitlines())
    not_reached = sum(line == 12 for line, _ in _survivors())
    survived = first["mutants"] - first["killed"]  # type: ignore[operator]
    assert again == survived - not_reached
    capsys.readouterr()

    # A survivor with a reason counts as detected.
    text = rows.read_text("utf-8").replace('reason = ""', 'reason = "the lamp is for show"')
    Path("mutants.toml").write_text(text, encoding="utf-8")
    assert main(command) == 0
    assert "more with a reason: 100.0 %" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_after_the_time_limit_the_next_call_continues(project: Path, capsys: Captured) -> None:
    command = ["mutants", "plc", "--json", "found.json", "--minutes", "0", "--", "pytest"]
    assert main([*command[:4], "--fail-under", "0", *command[4:]]) == 0
    assert "NOT RUN YET (the next call continues)" in capsys.readouterr().out
    found = _found()
    assert found["killed"] == 0
    assert not Path(".rcx/mutants.jsonl").exists()


@pytest.mark.exhaustive
def test_after_ctrl_c_the_next_call_uses_the_saved_outcomes(
    project: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C while the third outcome is saved keeps three outcomes, and the next call uses them."""
    command = ["mutants", "plc", "--json", "found.json", "--workers", "1", "--", "pytest"]
    kept, add = Path(".rcx/mutants.jsonl"), Results.add

    def add_with_ctrl_c(self: Results, entry: Mapping[str, Any]) -> None:
        add(self, entry)
        if len(kept.read_text("utf-8").splitlines()) == 3:
            signal.raise_signal(signal.SIGINT)

    monkeypatch.setattr(Results, "add", add_with_ctrl_c)
    assert main(command) == INTERRUPTED
    assert "finished results are in .rcx; the same call continues" in capsys.readouterr().out
    done = kept.read_text("utf-8")
    assert len(done.splitlines()) == 3
    assert not Path("found.json").exists()

    assert main([*command[:4], "--minutes", "0", *command[4:]]) == 1
    assert kept.read_text("utf-8") == done
    found = _found()
    assert found["mutants"] - len(found["unreached"]) == 3  # type: ignore[operator, arg-type]


@pytest.mark.exhaustive
def test_a_new_process_gives_the_same_outcomes_as_a_forked_one(
    project: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    run = PytestCommand.of(["pytest"], project)
    mutants = UserMutants(source_files("plc"), run)
    tests = mutants.baseline()
    tasks, unreached = mutants.tasks(tests)
    assert {one.line for one in unreached} == {12}
    files = {task.mutant.file for task in tasks[:2]}
    assert files == {"plc/FC_Next.st", "plc/Lamp.st"}  # the first tasks already cover both files
    wanted = {(task.mutant.line, task.mutant.after): task for task in tasks}
    operand = wanted[7, "Green := Button;"]
    counting = next(task for task in tasks if task.mutant.file == "plc/FC_Next.st")
    # The third test does not execute FC_Next.
    assert {one.rpartition("::")[2] for one in counting.tests} == {
        "test_it_is_green_with_button_and_key",
        "test_it_counts",
    }
    assert len(operand.tests) == 3
    judge = Judge(run, tmp_path_factory.mktemp("base"))
    copies = judge.prepare()
    for task, by in ((operand, ""), (counting, "tests/test_lamp.py::test_it_counts")):
        assert judge(task).by == copies(task).by == by


@pytest.mark.exhaustive
def test_tests_must_pass_at_first(project: Path, capsys: Captured) -> None:
    file = project / "tests" / "test_lamp.py"
    file.write_text(_TESTS.replace("== 3", "== 4"), encoding="utf-8")
    assert main(["mutants", "plc", "--", "pytest"]) == 2
    said = capsys.readouterr().err
    assert "tests/test_lamp.py::test_it_counts fails with the program as it is (" in said
    assert "make all tests pass first" in said


@pytest.mark.exhaustive
def test_tests_that_do_not_run_the_program_are_refused(project: Path, capsys: Captured) -> None:
    other = "def test_nothing():\n    pass\n"
    (project / "tests" / "test_lamp.py").write_text(other, encoding="utf-8")
    assert main(["mutants", "plc", "--", "pytest"]) == 2
    assert "none of 1 tests executes a statement of plc" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["plc"], "no command for the tests is given; write rcx mutants plc -- pytest"),
        (["plc", "--fail-under", "all", "--", "pytest"], "--fail-under is all"),
        (["plc", "--minutes", "-1", "--", "pytest"], "--minutes is -1"),
        (["plc", "--json", "pytest.ini", "--", "pytest"], "was not written by this command"),
        (
            ["plc", "--reasons", "none.toml", "--", "pytest"],
            "none.toml: cannot be read: No such file or directory",
        ),
        (["plc", "--folder", "pytest.ini", "--", "pytest"], "pytest.ini: is not a folder"),
        (["none", "--", "pytest"], "none: no such file"),
        (["plc", "--", "no-such-command"], "no-such-command cannot be started"),
        (["plc", "--", "pytest", "--no-such-option"], "runs no tests"),
    ],
)
def test_bad_input_ends_with_2(
    project: Path, capsys: Captured, words: list[str], message: str
) -> None:
    assert main(["mutants", *words]) == 2
    assert message in " ".join(capsys.readouterr().err.split())


def test_an_incomplete_reason_is_refused(project: Path, capsys: Captured) -> None:
    Path("mutants.toml").write_text('[[survivor]]\nblock = "Lamp"\n', encoding="utf-8")
    assert main(["mutants", "plc", "--", "pytest"]) == 2
    assert "[[survivor]] 1 is incomplete; write block, line" in capsys.readouterr().err


_ASKS = """PROGRAM Asks
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Answered : BOOL;
  END_VAR
  OutputArea[32] := BYTE#65;
  OutputArea[34] := BYTE#1;
  Answered := InputArea[34] = BYTE#2;
END_PROGRAM
"""
_WITH_PROGRAM = """
from rcx_harness import Cell


def test_the_robot_program_answers():
    with Cell.build("plc", engine="builtin", robot="robot.toml") as cell:
        cell.run("200ms")
        for task in cell.robot.program.tasks:
            task.go(cell.now_us)
        cell.robot.write_port("SO(77)", 0)
        cell.run("100ms")
        assert cell["Main.Answered"]
"""


@pytest.mark.exhaustive
def test_a_robot_program_runs_in_the_cells_of_mutants(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The cell of each mutant runs the robot program, which answers SI(20) with SO(21)."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("PYTEST_ADDOPTS", raising=False)
    files = {
        "plc/Asks.st": _ASKS,
        "robot.toml": 'booted = true\n\n[[programs]]\nfile = "MAIN.PGM"\n',
        "MAIN.PGM": "WAIT SI(20)=1\nSO(21)=1\nWAIT SI(27)=1\n",
        "tests/test_asks.py": _WITH_PROGRAM,
        "pytest.ini": "[pytest]\nrcx_sources = plc\ntestpaths = tests\n",
    }
    for name, text in files.items():
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(text, encoding="utf-8")
    main(["mutants", "plc", "--json", "found.json", "--", "pytest", "-q"])
    assert _found()["killed"]
    assert {7, 8}.isdisjoint(line for line, _ in _survivors())
