"""`rcx prove` reports its results in a table, in JSON, and by its exit code."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from junit_files import junit_root
from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]

PROGRAM = """PROGRAM Lamp
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Button, Green, Red : BOOL;
  END_VAR
  Green := Button;
  Red := {red};
  (* prove: Green <> Red *)
END_PROGRAM
"""


@pytest.fixture
def lamp(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "Lamp.st"
    file.write_text(PROGRAM.format(red="NOT Button"))
    return file


def test_a_program_that_is_proved_ends_with_0(lamp: Path, capsys: Captured) -> None:
    assert main(["prove", str(lamp), "--json", "out/it.json"]) == 0
    said = capsys.readouterr().out
    assert "inputs, with any value in each scan: Main.Button, and the robot" in said
    assert "4 properties: 4 proved, 0 refuted, 0 unknown" in said
    told = json.loads(Path("out/it.json").read_text())
    assert told["inputs"] == ["Main.Button"]
    assert [(one["name"], one["status"]) for one in told["properties"]] == [
        ("inner", "proved"),
        ("assert Lamp.st:8", "proved"),
        ("once", "proved"),
        ("steady", "proved"),
    ]
    assert main(["prove", str(lamp), "--json", "out/it.json"]) == 0


def test_a_counterexample_is_written_and_ends_with_1(lamp: Path, capsys: Captured) -> None:
    lamp.write_text(PROGRAM.format(red="Button"))
    assert main(["prove", str(lamp), "--junit", "out/it.xml"]) == 1
    said = capsys.readouterr().out
    assert "refuted: assert Lamp.st:8: after 1 scans of 10 ms" in said
    command = next(line for line in said.splitlines() if line.startswith("  rcx run "))
    cases = {case.get("name"): case for case in junit_root(Path("out/it.xml")).iter("testcase")}
    assert set(cases) == {"inner", "assert Lamp.st:8", "once", "steady"}
    failure = cases["assert Lamp.st:8"].find("failure")
    assert failure is not None
    assert f"replay: {command.strip()}" in str(failure.text)
    assert [name for name, case in cases.items() if len(case)] == ["assert Lamp.st:8"]
    assert main(command.split()[1:]) == 0  # only `rcx prove` reads an assertion in a comment


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--limit", "soon"], "--limit: 'soon' is not a duration"),
        (["--limit", "0s"], "--limit of 0 s is too short"),
        (["--scan", "0ms"], "--scan of 0 s is too short"),
        (["--json", "Lamp.st"], "Lamp.st: already exists and was not written by this command"),
        (["--junit", "Lamp.st"], "Lamp.st: would be overwritten, but it is an input"),
        (["--json", "a", "--junit", "a"], "a: --json and --junit name the same file"),
        (["--lib", "none"], "--lib none is not a folder"),
    ],
)
def test_bad_input_ends_with_2(
    lamp: Path, capsys: Captured, options: list[str], message: str
) -> None:
    before = lamp.read_text()
    assert main(["prove", str(lamp), *options]) == 2
    assert message in capsys.readouterr().err
    assert lamp.read_text() == before


def test_a_missing_solver_is_reported_with_the_install_command(
    lamp: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "z3", None)
    for name in [name for name in sys.modules if name.startswith("rcx_harness.verify.prove")]:
        monkeypatch.delitem(sys.modules, name)
    assert main(["prove", str(lamp)]) == 2
    assert "pip install 'rcx-harness[prove]'" in capsys.readouterr().err


PRESS = """PROGRAM Press
  VAR
    Guard : BOOL;
    Count : INT;
    Down AT %QX0.0 : BOOL;
    Held : TON;
  END_VAR
  Held(IN := Guard, PT := T#20ms);
  Count := Count + 1;
  Down := {down};
END_PROGRAM
"""


@pytest.fixture
def press(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "old.st").write_text(PRESS.format(down="Guard AND Held.Q"))
    return tmp_path / "new.st"


AGAINST = ["prove", "new.st", "--against", "old.st", "--no-robot"]


def test_a_version_with_the_same_outputs_ends_with_0(press: Path, capsys: Captured) -> None:
    """Held.Q is TRUE only while Guard is, so Guard may stand in either order."""
    press.write_text(PRESS.format(down="NOT (NOT Held.Q OR NOT Guard)"))
    assert main([*AGAINST, "--json", "it.json"]) == 0
    assert "Main.Down is the same" in capsys.readouterr().out
    told = json.loads(Path("it.json").read_text())["properties"]
    assert [(one["name"], one["status"]) for one in told] == [
        ("Main.Down", "proved"),
        ("stops", "proved"),
    ]


def test_a_difference_is_replayed_on_both_versions(press: Path, capsys: Captured) -> None:
    """Guard alone turns Down on in the first scan; with the timer it takes two scans more."""
    press.write_text(PRESS.format(down="Guard"))
    assert main(AGAINST) == 1
    said = capsys.readouterr().out
    assert "refuted: Main.Down: after 1 scan of 10 ms: Main.Down is True, not False" in said
    commands = [line.partition("rcx run ")[2] for line in said.splitlines() if "rcx run" in line]
    assert [command.split()[0] for command in commands] == ["old.st", "new.st"]
    for command, value in zip(commands, ("FALSE", "TRUE"), strict=True):
        assert main(["run", *command.replace('"', "").split()]) == 0
        assert f"Main.Down = {value}" in capsys.readouterr().out


def test_the_outputs_that_count_are_chosen(press: Path, capsys: Captured) -> None:
    """A count from 2 instead of 0 differs in the first scan: it is 3, not 1."""
    text = PRESS.format(down="Guard AND Held.Q")
    press.write_text(text.replace("Count : INT;", "Count : INT := 2;"))
    assert main(AGAINST) == 0
    capsys.readouterr()
    assert main([*AGAINST, "--output", "main.*", "--except", "Main.C*"]) == 0
    capsys.readouterr()
    assert main([*AGAINST, "--output", "Main.Count"]) == 1
    assert "after 1 scan of 10 ms: Main.Count is 3, not 1" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--output", "Main.X*"], "--output Main.X*: no variable of the programs has this name"),
        (["--except", "Main.*"], "the programs have no output to compare"),
        (["--relate", "Main.Down"], "--relate Main.Down is not a pair"),
        (["--relate", "Main.Q=Main.Down"], "Main of type Press has no member Q"),
        (["--overflow"], "--overflow is not for --against"),
        (["--json", "old.st"], "old.st: already exists and was not written by this command"),
    ],
)
def test_a_wrong_comparison_ends_with_2(
    press: Path, capsys: Captured, options: list[str], message: str
) -> None:
    press.write_text(PRESS.format(down="Guard"))
    assert main([*AGAINST, *options]) == 2
    assert message in capsys.readouterr().err


def test_options_of_a_comparison_need_an_old_version(press: Path, capsys: Captured) -> None:
    press.write_text(PRESS.format(down="Guard"))
    assert main(["prove", "new.st", "--output", "Main.Down"]) == 2
    assert "--output needs --against; name the old version" in capsys.readouterr().err


def test_an_initial_value_that_no_program_writes_counts(press: Path, capsys: Captured) -> None:
    """Nobody sets Limit, so its first value decides: 0 > -1 is TRUE, 0 > 5 is FALSE."""
    text = PRESS.format(down="Held.ET > T#0s OR Limit < 0")
    for name, limit in (("old.st", "5"), ("new.st", "-1")):
        changed = text.replace("Count : INT;", f"Count : INT; Limit : INT := {limit};")
        Path(name).write_text(changed)
    assert main(AGAINST) == 1
    assert "after 1 scan of 10 ms: Main.Down is True, not False" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_late_difference_is_unknown_and_ends_with_1(press: Path, capsys: Captured) -> None:
    """The versions differ in scan 30000, which is too late for each search and random run."""
    press.write_text(PRESS.format(down="Guard AND Held.Q AND Count <> 30000"))
    assert main([*AGAINST, "--limit", "1s", "--runs", "3"]) == 1
    said = capsys.readouterr().out
    assert "unknown: Main.Down" in said
    assert "3 random runs of 200 scans show no difference" in said
    assert "2 properties: 1 proved, 0 refuted, 1 unknown; unknown is not proved" in said
