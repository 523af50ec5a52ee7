"""docs/reference/files.md has every key that the code accepts, and its example files run.

The expected keys come from the data classes and tables that the harness uses to read the files.
"""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

from rcx_harness.cell import EVENTS
from rcx_harness.cell.stimulus import KEYS
from rcx_harness.cli.app import main
from rcx_harness.robot.config import Axis, RobotConfig, RobotProgram
from rcx_harness.robot.config.checks import CHOICES, RANGES
from rcx_harness.robot.stored import QUANTITIES, parameter_names, parameter_ranges
from rcx_harness.spec.rules import rules
from structured_text.errors import InputError

_PAGE = (Path(__file__).resolve().parents[3] / "docs/reference/files.md").read_text(
    encoding="utf-8"
)
_PLAIN = re.compile(r"`([^`]+)`")


def _table(head: str) -> dict[str, tuple[str, ...]]:
    """Return a table's rows by the names in their first cells; `head` is the table's first heading.

    A row that has several names in its first cell counts for each of them.
    """
    part = re.split(rf"^\| {re.escape(head)} \|.*\n\|[-|]+\n", _PAGE, flags=re.MULTILINE)[1]
    rows: dict[str, tuple[str, ...]] = {}
    for line in part.partition("\n\n")[0].splitlines():
        first, *rest = (cell.strip() for cell in line.strip("|").split("|"))
        rows |= dict.fromkeys(_PLAIN.findall(first) or [first], tuple(rest))
    return rows


def _example(section: str) -> str:
    return _PAGE.partition(f"## {section}\n")[2].partition("```toml\n")[2].partition("```")[0]


def test_every_key_of_an_entry_of_the_stimulus_is_there_and_no_other() -> None:
    assert set(_table("Key of `[[at]]`")) == set(KEYS)


def test_every_event_is_there_and_no_other() -> None:
    arguments = {"group", "category", "port", "on", "share", "to", "by", "rpi", "start"}
    assert set(_table("Events")) - arguments == set(EVENTS)


def test_every_key_of_a_robot_file_is_there_or_a_setting_of_the_page_on_fidelity() -> None:
    listed = {re.sub(r"[\[\]]|\.[NR]", "", key) for key in _table("Key")}
    knobs = {knob for rule in rules() for knob in rule.knobs}
    names = {entry.name for entry in fields(RobotConfig)}
    assert "settings" in listed
    assert listed - {"settings", "data_file"} <= names
    assert names - listed <= knobs


@pytest.mark.parametrize(("table", "kind"), [("axes", Axis), ("programs", RobotProgram)])
def test_every_key_of_a_table_is_there_with_its_default(table: str, kind: type) -> None:
    shown = _table(f"Key of `[[{table}]]`")
    # path and offset are internal fields; they are not keys of a robot file
    internal = {"path", "offset"}
    assert set(shown) == {entry.name for entry in fields(kind)} - internal
    words = {"None": "no workpiece", "()": "none", "True": "true", "": "none"}
    for name, (_, default) in shown.items():
        given = str(getattr(kind(), name)).removesuffix(".0")
        assert default == words.get(given, given), name


@pytest.mark.parametrize(("table", "number"), [("points", 19), ("pallets", 10)])
def test_the_page_has_every_key_of_stored_data(table: str, number: int, tmp_path: Path) -> None:
    """The page has every key of stored data.

    The list comes from the message about an unknown key.
    """
    file = tmp_path / "robot.toml"
    file.write_text(f"[{table}.{number}]\nzzzz = 1\n", encoding="utf-8")
    with pytest.raises(InputError) as caught:
        RobotConfig.load(file)
    there = caught.value.hint.removeprefix("there are ").split(", ")
    assert set(_table(f"Key of `[{table}.N]`")) == set(there)


def test_every_range_of_the_tables_is_that_of_the_code() -> None:
    shown = _table("Key of `[[axes]]`")
    for name in set(shown) & set(RANGES):
        low, high = RANGES[name]
        assert f"{low} to {high}" in shown[name][0], name
    for name in set(shown) & set(CHOICES):
        assert tuple(_PLAIN.findall(shown[name][0])) == CHOICES[name], name


def test_every_parameter_is_there_with_its_range() -> None:
    shown = _table("Parameters")
    assert set(shown) == set(parameter_names().values())
    for name, (low, high) in parameter_ranges().items():
        assert shown[name] == (f"{low} or {high}" if high == 1 else f"{low} to {high}",), name


def test_every_setting_of_words_is_there_with_its_words() -> None:
    shown = {name: tuple(_PLAIN.findall(words)) for name, (words,) in _table("Setting").items()}
    others = {"size", *_table("Key of `[[axes]]`")}
    assert shown == {name: words for name, words in CHOICES.items() if name not in others}


def test_every_item_of_the_real_time_output_is_there() -> None:
    part = _PAGE.partition("Items of the real time output: ")[2].partition("upper word")[0]
    assert set(_PLAIN.findall(part)) == {q for q in QUANTITIES if "." not in q} | {".high"}


def test_the_steps_of_the_page_are_understood() -> None:
    part = _PAGE.partition("Examples of steps: ")[2].partition("\n\n")[0]
    steps = tuple(_PLAIN.findall(part))
    assert len(steps) == 19
    RobotConfig(programs=(RobotProgram(steps=steps), RobotProgram()))


@pytest.mark.exhaustive
def test_the_example_files_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The example files run with the program of `rcx new`.

    Its movement ends abnormally, and no rule is broken.
    """
    folder = tmp_path / "cell"
    assert main(["new", str(folder)]) == 0
    for section in ("Stimulus file", "Robot file"):
        name = section.partition(" ")[0].lower()
        (folder / f"{name}.toml").write_text(_example(section), encoding="utf-8")
    named = [f"--{name}={folder / name}.toml" for name in ("robot", "stimulus")]
    trace = f"--trace={tmp_path / 'trace.jsonl'}"
    run = ["run", str(folder / "plc"), *named, trace, "--engine=builtin", "--for=4s"]
    assert main([*run, "--watch=Main.Fault"]) == 0
    assert "no violations" in capsys.readouterr().out
    assert f'"Main.Fault":{0x8020}' in (tmp_path / "trace.jsonl").read_text(encoding="utf-8")


def test_the_example_of_a_robot_file_has_every_table() -> None:
    tables = set(re.findall(r"^\[+(\w+)", _example("Robot file"), re.MULTILINE))
    listed = {name for name in _table("Key") if name.startswith("[")}
    assert tables == {re.sub(r"[\[\]]|\.[NR]", "", name) for name in listed}
