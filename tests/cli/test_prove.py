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
