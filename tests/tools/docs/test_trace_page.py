"""trace.md has every field that a run writes, and its example lines come from runs.

The expected values come from five runs.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main
from rcx_harness.cli.run import RunOptions
from rcx_harness.trace.chart import MOST_INSTANTS
from structured_text.language.displayed import LONGEST

_ROOT = Path(__file__).resolve().parents[3]
_PAGE = (_ROOT / "docs/reference/trace.md").read_text(encoding="utf-8")
_NAME = re.compile(r"`([^`]+)`")

#: A program that changes both inputs in one scan, which breaks a rule for both monitors.
_STIMULUS = "[[at]]\ntime = '500ms'\nset = { 'Main.Bits0' = 0x41 }\n"
_LEFT_HANDED = """\
robot = "YK400XEC"
[[axes]]
[[axes]]
start = -100000
[pallets.1]
positions = [1, 1, 1]
first_point = 1
[points]
1 = { mm = [0, 300] }
2 = { mm = [0, 300] }
3 = { mm = [0, 300] }
4 = { mm = [0, 300] }
5 = { mm = [0, 300] }
[work_areas]
Feeder = [[0, 200], [100, 300]]
"""
_PROGRAMS = _ROOT / "tests/data/robot_programs"
_WATCHED = _ROOT / "tests/cell/programs/Watched.st"


def _example(name: str, *robots: str) -> list[str]:
    folder = _ROOT / "plc/examples" / name
    given = [f"--robot={folder / robot}" for robot in robots]
    return [str(folder), f"--stimulus={folder / 'stimulus.toml'}", *given]


@pytest.fixture(scope="module")
def lines(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Return the trace lines of the page's examples, and of a run with all kinds of variables."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "lib").mkdir()
    (folder / "s.toml").write_text(_STIMULUS, encoding="utf-8")
    (folder / "arm.toml").write_text(_LEFT_HANDED, encoding="utf-8")
    raw = [str(_ROOT / "tests/cell/programs/RawArea.st"), f"--lib={folder / 'lib'}"]
    runs = (
        [
            *_example("04_pick_and_place", "robot.toml"),
            "--watch=Main.Carry.Stage,Main.Cycle.Count",
            "--positions=mm",
        ],
        [
            *_example("12_two_robots", "robot1.toml", "robot2.toml"),
            *("--m=0", "--m=48", "--n=0", "--n=48"),
        ],
        [*raw, f"--stimulus={folder / 's.toml'}"],
        [
            *(str(_WATCHED), raw[1], "--watch=Main.*"),
            *(f"--robot={folder / 'arm.toml'}", "--positions=pulses"),
        ],
        [
            *(str(_PROGRAMS / "Supervisor.st"), f"--robot={_PROGRAMS / 'robot.toml'}"),
            f"--stimulus={_PROGRAMS / 'stimulus.toml'}",
        ],
    )
    found = []
    for number, options in enumerate(runs):
        trace = folder / f"{number}.jsonl"
        long = "2s" if number == 4 else "1s"
        ended = main(["run", *options, "--engine=builtin", f"--for={long}", f"--trace={trace}"])
        assert ended == (1 if number == 2 else 0)
        found += trace.read_text(encoding="utf-8").splitlines()
    return found


def _rows(head: str) -> list[list[str]]:
    """Return the rows of the table whose first column has the heading `head`."""
    part = re.split(rf"^\| {re.escape(head)} \|.*\n\|[-|]+\n", _PAGE, flags=re.MULTILINE)[1]
    table = part.partition("\n\n")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table]


def _fields(head: str) -> set[str]:
    return {name for row in _rows(head) for name in _NAME.findall(row[0])}


_KINDS = {"format": "Header", "scan": "Scan", "cycle": "Cycle", "violation": "Broken rule"}


def _kind(entry: dict[str, Any]) -> str:
    (kind,) = (title for key, title in _KINDS.items() if key in entry)
    return kind


@pytest.mark.parametrize("title", _KINDS.values())
def test_every_field_of_every_kind_of_record_is_there_and_no_other(
    lines: list[str], title: str
) -> None:
    written = [entry for entry in map(json.loads, lines) if _kind(entry) == title]
    assert {key for entry in written for key in entry} == _fields(title)


@pytest.mark.parametrize("title", _KINDS.values())
def test_what_is_only_there_sometimes_is_told(lines: list[str], title: str) -> None:
    written = [set(entry) for entry in map(json.loads, lines) if _kind(entry) == title]
    sometimes = set.union(*written) - set.intersection(*written)
    told = {
        name
        for row in _rows(title)
        for name in _NAME.findall(row[0])
        if re.search(r"\bonly\b|not of the first", row[1])
    }
    assert told == sometimes


def test_the_example_lines_are_lines_of_runs(lines: list[str]) -> None:
    shown = re.findall(r"^\{.*\}$", _PAGE, re.MULTILINE)
    assert len(shown) == 8
    assert [line for line in shown if line not in lines] == []
    assert {_kind(json.loads(line)) for line in shown} == set(_KINDS.values())


def _types(entry: Any) -> Iterator[Any]:
    """Return a type from the header of a trace, and the types that it contains."""
    yield entry
    if isinstance(entry, dict):
        for inner in (*entry.get("members", {}).values(), entry.get("of")):
            if isinstance(inner, (dict, str)):
                yield from _types(inner)


def test_every_form_of_a_type_is_there(lines: list[str]) -> None:
    headers = [entry for entry in map(json.loads, lines) if "format" in entry]
    found = {
        tuple(one) if isinstance(one, dict) else ()
        for header in headers
        for kind in header.get("watch", {}).values()
        for one in _types(kind)
    }
    forms = [row[1] for row in _rows("Type in `watch`")]
    shown = {tuple(re.findall(r'"(\w+)":', form)) for form in forms}
    assert found == shown


def test_the_page_has_every_entry_of_a_robot(lines: list[str]) -> None:
    """The page has every entry that describes a robot: its shape and its pose."""
    entries = [json.loads(line) for line in lines]
    robots = [one for entry in entries for every in entry.get("robots", []) for one in every]
    poses = [one for entry in entries for one in entry.get("poses", [])]
    assert {key for one in robots for key in one} == _fields("Robot")
    assert {key for one in poses for key in one} <= _fields("Pose")
    assert _fields("Pose") == {"left", "shift", "hand"}


def test_every_entry_of_a_program_and_of_a_task_is_there(lines: list[str]) -> None:
    entries = [json.loads(line) for line in lines]
    programs = [one for entry in entries for every in entry.get("programs", []) for one in every]
    tasks = [one for entry in entries for one in entry.get("tasks", [])]
    assert {key for one in programs for key in one} == _fields("Program")
    assert {key for one in tasks for key in one} == _fields("Task")


def test_every_option_is_there_with_its_default() -> None:
    defaults = {"--watch": "none", "--positions": "not shown", "--scale": "`events`"}
    assert {_NAME.findall(row[0])[0]: row[-1] for row in _rows("Option")} == defaults
    options = RunOptions([])
    assert (options.watch, options.positions, options.scale) == (None, "", "events")


def test_the_limits_of_the_page_are_those_of_the_code() -> None:
    text = " ".join(_PAGE.split())
    assert text.count(f"more than {LONGEST} elements") == 2
    assert f"at most {MOST_INSTANTS} columns." in text
