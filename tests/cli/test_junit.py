"""The results of campaign, sweep, prove and mutants as cases of a JUnit file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from junit_files import junit_root
from rcx_harness.cli.junit_option import (
    junit_file,
    moments_suite,
    mutants_suite,
    properties_suite,
    seed_case,
)
from structured_text.errors import InputError
from structured_text.mutants.mutant import Mutant
from structured_text.mutants.report import Judged
from structured_text.mutants.user import Verdicts
from structured_text.output.junit import JunitCase, JunitFile, JunitSuite, Problem, junit_xml
from structured_text.prove.user import Result

_REPLAY = "rcx run Main.st --stimulus out/a-1.toml"


def test_a_seed_that_fails_names_its_replay() -> None:
    """Source: docs/how-to/ci.md."""
    failures = {"always closed": (1_500_000, "it is open"), "recovery": (2_000_000, "it stays")}
    case = seed_case(7, 2_500_000, failures, {("always closed", 7): _REPLAY})
    text = (
        f"always closed at 1500 ms: it is open\n  replay: {_REPLAY}\nrecovery at 2000 ms: it stays"
    )
    assert case == JunitCase(
        "seed 7",
        "campaign",
        seconds=2.5,
        problems=(Problem("failure", "always closed, recovery", text),),
    )
    assert seed_case(8, 1_000_000, {}, {}).problems == ()


def test_each_moment_of_a_sweep_is_a_case() -> None:
    """Two faults at the scans 0 and 5; the second fault fails at scan 5.

    Source: docs/how-to/ci.md.
    """
    found = {("alarm", "recovery"): {5: "it stays"}}
    suite = moments_suite(
        ["link_down", "alarm"], range(0, 10, 5), 4_000, found, {("alarm", "recovery"): _REPLAY}
    )
    assert [(case.group, case.name, case.kind) for case in suite.cases] == [
        ("sweep.link_down", "scan 0 (0 ms)", ""),
        ("sweep.link_down", "scan 5 (20 ms)", ""),
        ("sweep.alarm", "scan 0 (0 ms)", ""),
        ("sweep.alarm", "scan 5 (20 ms)", "failure"),
    ]
    (problem,) = suite.cases[-1].problems
    assert problem == ("failure", "recovery", f"recovery: it stays\n  replay: {_REPLAY}")


def test_unknown_properties_are_errors_and_noted_ones_pass() -> None:
    """Source: docs/how-to/ci.md."""
    results = [
        Result("assert a.st:8", "A <> B", "a.st:8", "refuted", 1.5, command=_REPLAY, note="A = B"),
        Result("inner", "no error stops it", status="unknown", note="no time is left"),
        Result("arithmetic", "A + B stays in INT", "a.st:9", "noted"),
        Result("once", "each block once", status="proved"),
    ]
    cases = properties_suite(results).cases
    assert [case.kind for case in cases] == ["failure", "error", "", ""]
    assert (cases[0].file, cases[0].line, cases[0].seconds) == ("a.st", 8, 1.5)
    text = f"A <> B\nA = B\n  replay: {_REPLAY}"
    assert cases[0].problems == (Problem("failure", "refuted: A <> B", text),)
    assert cases[1].problems[0].text == "no error stops it\nno time is left"


def test_survivors_fail_and_survivors_with_a_reason_are_skipped() -> None:
    """Source: docs/how-to/ci.md."""
    first = Mutant("plc/A.st", "A", "operand", 7, "X := Y;", "X := Z;", "", None)
    mutants = [replace(first, line=line) for line in (7, 8, 9, 10)]
    judged = [
        Judged(mutants[0], True, "t.py::test"),
        *(Judged(one, False, "") for one in mutants[1:3]),
    ]
    verdicts = Verdicts(
        {"survivors": [{"reason": ""}, {"reason": "for show"}]}, judged, mutants[3:]
    )
    cases = mutants_suite(verdicts).cases
    assert [(case.line, case.kind) for case in cases] == [
        (7, ""),
        (8, "failure"),
        (9, "skipped"),
        (10, "skipped"),
    ]
    assert cases[1].name == "line 8: operand: X := Z;"
    assert cases[1].problems[0].text == "plc/A.st:8: operand survives\n  - X := Y;\n  + X := Z;"
    assert [case.skipped for case in cases[2:]] == ["for show", "not run yet"]


def test_a_junit_file_has_the_form_that_ci_systems_read(tmp_path: Path) -> None:
    """A case with an error and a failure counts as an error; characters that XML lacks become ?.

    Source: docs/how-to/ci.md.
    """
    problems = (Problem("failure", "m\x00", "t"), Problem("error", "e", "u"))
    cases = [
        JunitCase("a", "g", "a.st", 3, 0.25, problems),
        JunitCase("b", "g", skipped="off"),
        JunitCase("c", "g", problems=problems[:1]),
    ]
    file = tmp_path / "it.xml"
    file.write_text(junit_xml([JunitSuite("s", cases, 0.25, "log")], 0.5), encoding="utf-8")
    root = junit_root(file)
    assert root.attrib == {"tests": "3", "failures": "1", "errors": "1", "time": "0.500"}
    assert root[0].get("skipped") == "1"
    assert root[0][0].attrib == {
        "classname": "g", "name": "a", "file": "a.st", "line": "3", "time": "0.250000"
    }  # fmt: skip
    assert root[0][0][0].attrib == {"message": "m?", "type": "failure"}
    assert root[0][3].text == "log"
    JunitFile(file).write([JunitSuite("t", [])])
    assert junit_root(file)[0].get("name") == "t"


def test_a_junit_file_replaces_no_input_and_no_folder(tmp_path: Path) -> None:
    """Source: docs/how-to/ci.md."""
    mine = tmp_path / "mine.toml"
    mine.write_text("a = 1\n", encoding="utf-8")
    for file, json_file, message in (
        (mine, None, "mine.toml: would be overwritten, but it is an input"),
        (tmp_path, None, "is a folder"),
        (tmp_path / "a", tmp_path / "a", "--json and --junit name the same file"),
    ):
        with pytest.raises(InputError, match=message):
            junit_file(file, json_file, [mine])
    assert mine.read_text(encoding="utf-8") == "a = 1\n"
