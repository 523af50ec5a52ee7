"""judge.md: its options are the command's, its rules those that are judged; it is short."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import pytest
import typer

from rcx_harness.cli.judge import judge
from rcx_harness.trace.chart import MOST_INSTANTS
from rcx_harness.watch import answers, wire

#: Lines of a terminal or a window that people have, twice, with what folds.
_TWO_SCREENS = 130


@pytest.fixture
def page(repository: Path) -> str:
    return (repository / "docs/how-to/judge.md").read_text(encoding="utf-8")


def test_every_option_has_its_row_and_no_other(page: str) -> None:
    app = typer.Typer(add_completion=False)
    app.command()(judge)
    command = typer.main.get_command(app)
    options = {name for one in command.params for name in one.opts if name.startswith("--")}
    rows = re.findall(r"^\| (`--.+?) \|", page, re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"`(--[a-z-]+)`", row)} == options


def test_every_rule_that_is_judged_is_named(page: str) -> None:
    rules = {
        rule
        for module in (wire, answers)
        for rule in re.findall(r'\("([a-z ]+)", (?:f"|text|f\'|shown)', inspect.getsource(module))
    }
    assert {"interval", "command held", "status", "response", "reserved"} <= rules
    judged = rules - {"data before code"}
    assert {rule for rule in judged if f"`{rule}`" not in page} == set()


def test_safety_comes_first_and_the_page_is_short(page: str) -> None:
    assert page.splitlines()[2].startswith("> **Safety.**")
    assert len(page.splitlines()) <= _TWO_SCREENS
    assert f"{MOST_INSTANTS} instants" in page
