"""The list of rules is complete: the keys in it exist, and a test names every rule."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest

from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import SECTIONS
from rcx_harness.spec.rules import BASES, Rule, rules
from rcx_tools.docs import fidelity
from rcx_tools.docs.fidelity import fidelity_page
from structured_text.errors import InputError

HERE = Path(__file__).parent
#: Keys that only describe a robot, so no rule is needed for them.
PLAIN = {"size", "work_areas"}


def test_every_knob_is_a_key_and_every_key_belongs_to_a_rule() -> None:
    keys = {entry.name for entry in fields(RobotConfig)}
    knobs = {knob for rule in rules() for knob in rule.knobs}
    assert knobs <= keys
    assert keys - knobs == PLAIN


def test_a_rule_of_the_manual_has_its_section_and_no_knob() -> None:
    names = [rule.id for rule in rules()]
    assert len(set(names)) == len(names)
    assert all(not (rule.section and rule.knobs) for rule in rules())
    assert {rule.basis for rule in rules() if rule.section} == {"manual"}


def test_a_rule_that_is_public_or_measured_names_its_source() -> None:
    """The basis of a rule is the manual, a public source, a measurement, or an assumption."""
    assert Rule("a", "text", section="ch. 1").basis == "manual"
    assert Rule("a", "text", knobs=("b",)).basis == "assumed"
    for basis in ("public", "measured"):
        assert Rule("a", "text", basis=basis, source="who").source == "who"
        with pytest.raises(InputError, match="source ''"):
            Rule("a", "text", basis=basis)
    with pytest.raises(InputError, match="basis 'guessed'"):
        Rule("a", "text", basis="guessed")
    with pytest.raises(InputError, match="with section 'ch"):
        Rule("a", "text", section="ch. 1", basis="public", source="who")
    with pytest.raises(InputError, match="source 'who'"):
        Rule("a", "text", source="who")


def test_every_rule_is_named_by_a_test() -> None:
    named: set[str] = set()
    for file in HERE.rglob("test_*.py"):
        for line in re.findall(r"Rule: ([\w, -]+)\.", file.read_text(encoding="utf-8")):
            named |= {name.strip() for name in line.split(",")}
    known = {rule.id for rule in rules()}
    assert named - known == set(), "tests name rules that do not exist"
    assert known - named == set(), "rules without a test"


def test_the_page_shows_every_rule_with_its_section_or_knobs() -> None:
    page = fidelity_page()
    for rule in rules():
        assert f"`{rule.id}`" in page
        assert all(f"`{knob}`" in page for knob in rule.knobs)
    assert "`min_interval` (100)" in page
    assert "`host_version` (0x0108)" in page


def test_every_key_is_in_one_section_and_the_page_shows_it_there() -> None:
    sections = {section.__name__: [entry.name for entry in fields(section)] for section in SECTIONS}
    listed = [name for names in sections.values() for name in names]
    assert listed == [entry.name for entry in fields(RobotConfig)]
    rows = fidelity_page().partition("| Section | What it is | Keys |\n")[2].splitlines()[1:]
    assert [row.split("`")[1] for row in rows] == list(sections)
    for row, names in zip(rows, sections.values(), strict=True):
        assert re.findall(r"`(\w+)`", row)[1:] == names


def test_the_sections_can_be_read_each_by_itself() -> None:
    """`RobotConfig(key=...)` and `config.key` work without the name of the key's section."""
    config = RobotConfig(servo_on_delay=10.0, busy_alarm="6.7")
    assert all(isinstance(config, section) for section in SECTIONS)
    assert (config.servo_on_delay, config.busy_alarm, config.size) == (10.0, "6.7", 48)


def test_the_rules_of_each_list_are_numbered_from_1_on() -> None:
    """Other pages and messages refer to a rule by a number such as A15."""
    page = fidelity_page()
    for letter, basis in zip("MPRA", BASES, strict=True):
        mine = [rule.id for rule in rules() if rule.basis == basis]
        rows = re.findall(rf"^\| {letter}(\d+) `([\w-]+)` \|", page, re.MULTILINE)
        assert rows == [(str(number), name) for number, name in enumerate(mine, 1)]


def test_the_page_names_the_source_of_other_rules(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "## Measured at a real controller\n\nNone yet.\n" in fidelity_page()
    found = Rule(
        "found", "It blinks.", basis="public", source="a list", knobs=("size", "host_version")
    )
    seen = Rule("seen", "It hums.", basis="measured", source="A. B., host 1.08")
    monkeypatch.setattr(fidelity, "rules", lambda: (found, seen))
    page = fidelity_page()
    assert "| P1 `found` | It blinks. | a list | `size` (48), `host_version` (0x0108) |" in page
    assert "| R1 `seen` | It hums. | A. B., host 1.08 | none |" in page
    assert "has been measured" not in page
