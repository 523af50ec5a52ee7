"""`rcx check --json` and `--sarif` write the findings, and `--strict` makes warnings an error."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main
from rcx_harness.cli.findings import Finding, as_json, as_sarif
from structured_text.errors import NO_COLUMN, InputError
from structured_text.language.portability import LintFinding
from structured_text.language.source import Line, NetworkLine
from structured_text.language.syntax import Position

Captured = pytest.CaptureFixture[str]

_FAULTY = "PROGRAM P\n  VAR\n    a : INT;\n  END_VAR\n  a := TRUE;\nEND_PROGRAM\n"
#: The pin Connected is not wired.
_WARNED = """\
PROGRAM P
  VAR
    Image : RCX_IMAGE; Robot : RCX_REF; Read : FB_ReadArea; Write : FB_WriteArea;
  END_VAR
  Read(Robot := Robot, Image := Image, m := 0, Size := 48);
  Write(Robot := Robot, Image := Image, n := 0, Size := 48,
        EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the current folder of the command."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _source(folder: Path, text: str, name: str = "Main program.st") -> str:
    (folder / name).write_text(text, encoding="utf-8")
    return name


def _log(file: Path) -> dict[str, Any]:
    loaded: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    return loaded


def test_json_lists_an_error_with_its_place(place: Path, capsys: Captured) -> None:
    name = _source(place, _FAULTY)
    assert main(["check", name, "--json"]) == 2
    found = json.loads(capsys.readouterr().out)
    (error,) = found["findings"]
    assert (error["level"], error["rule"]) == ("error", "error")
    assert (error["file"], error["line"], error["column"]) == (name, 5, 8)
    assert "BOOL" in error["text"]
    assert found["summary"] == ""


def test_json_lists_a_warning_and_the_summary(place: Path, capsys: Captured) -> None:
    name = _source(place, _WARNED)
    assert main(["check", name, "--json", "found.json"]) == 0
    found = _log(place / "found.json")
    warnings = {item["rule"] for item in found["findings"] if item["level"] == "warning"}
    assert "first-mistake" in warnings
    assert found["summary"] in capsys.readouterr().out
    assert found["summary"].startswith("1 file checked")


def test_a_clean_program_gives_an_empty_list(place: Path, capsys: Captured) -> None:
    name = _source(place, "PROGRAM P\n  VAR\n    a : INT;\n  END_VAR\n  a := 1;\nEND_PROGRAM\n")
    assert main(["check", name, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["findings"] == []


def test_sarif_names_rule_level_and_relative_place(place: Path) -> None:
    """The file is relative to the current folder, and its blank is escaped."""
    name = _source(place, _FAULTY)
    assert main(["check", name, "--sarif", "found.sarif"]) == 2
    log = _log(place / "found.sarif")
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    (result,) = run["results"]
    assert (result["ruleId"], result["level"]) == ("error", "error")
    assert run["tool"]["driver"]["rules"][result["ruleIndex"]]["id"] == "error"
    (location,) = result["locations"]
    assert location["physicalLocation"] == {
        "artifactLocation": {"uri": "Main%20program.st"},
        "region": {"startLine": 5, "startColumn": 8},
    }


def test_sarif_names_a_file_outside_of_the_folder_by_its_whole_path(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Such a file has a URI with the scheme `file`."""
    _source(place, _FAULTY)
    (place / "inner").mkdir()
    monkeypatch.chdir(place / "inner")
    assert main(["check", "../Main program.st", "--sarif", "found.sarif"]) == 2
    (result,) = _log(place / "inner/found.sarif")["runs"][0]["results"]
    uri = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri.startswith("file:///")


def test_sarif_has_the_findings_of_a_robot_program(place: Path) -> None:
    name = _source(place, "*LOOP:\nGOTO *NOWHERE\n", "MAIN.PGM")
    assert main(["check", name, "--sarif", "found.sarif"]) == 2
    results = _log(place / "found.sarif")["runs"][0]["results"]
    assert {result["ruleId"] for result in results} == {"robot-program"}


def test_strict_makes_a_warning_the_exit_code_1(place: Path) -> None:
    name = _source(place, _WARNED)
    assert main(["check", name]) == 0
    assert main(["check", name, "--strict"]) == 1


def test_strict_makes_an_uncertain_refusal_the_exit_code_1(place: Path, capsys: Captured) -> None:
    """An uncertain refusal alone ends with 0."""
    text = "PROGRAM P\n  VAR\n    a : INT; b : DINT;\n  END_VAR\n  b := a;\nEND_PROGRAM\n"
    name = _source(place, text)
    command = ["check", name, "--for", "rockwell"]
    assert main(command) == 0
    assert "may be refused" in capsys.readouterr().out
    assert main([*command, "--strict", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)["findings"]
    assert {item["rule"] for item in found} == {"may-be-refused"}
    assert [(item["line"], item["column"]) for item in found] == [(5, 8)]


def test_a_file_of_another_program_is_not_overwritten(place: Path, capsys: Captured) -> None:
    name = _source(place, _WARNED)
    (place / "found.sarif").write_text("my notes", encoding="utf-8")
    assert main(["check", name, "--sarif", "found.sarif"]) == 2
    assert "already exists" in capsys.readouterr().err
    assert (place / "found.sarif").read_text(encoding="utf-8") == "my notes"


def test_an_own_file_is_overwritten(place: Path) -> None:
    name = _source(place, _WARNED)
    for _ in range(2):
        assert main(["check", name, "--sarif", "found.sarif", "--json", "found.json"]) == 0


def test_the_same_file_for_both_forms_is_refused(place: Path, capsys: Captured) -> None:
    name = _source(place, _WARNED)
    assert main(["check", name, "--sarif", "found", "--json", "found"]) == 2
    assert "name the same file" in capsys.readouterr().err


def test_a_finding_in_a_drawing_names_its_rung_and_has_no_column() -> None:
    """The column of a translated statement is not a column of the file."""
    line = NetworkLine(8, "Main", Line("Last := First;", 8, 0, "rung 3"))
    error = InputError("is wrong", file="main.xml", line=line, column=NO_COLUMN + 5)
    assert Finding.of_error(error) == Finding(
        "error", "error", "Main, rung 3: is wrong", "main.xml", 8
    )
    found = LintFinding(Path("main.xml"), Position(line, NO_COLUMN + 5), "is long", strict=False)
    assert Finding.of_lint(found, "portability") == Finding(
        "warning", "portability", "Main, rung 3: is long", "main.xml", 8
    )
    assert '"line": 8,' in as_json([Finding.of_error(error)], "")
    assert '"startLine": 8\n' in as_sarif([Finding.of_error(error)], Path())
