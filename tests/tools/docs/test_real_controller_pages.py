"""Pages for who has a real controller: options, safety first, short; probes.md is complete."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import typer

from rcx_harness.cli.compare import compare
from rcx_harness.cli.points import points
from rcx_harness.cli.probe import probe
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.spec.rules import rules
from rcx_tools.docs.probes import probes_page

#: Lines of a page that is two screens long.
_TWO_SCREENS = 100


@pytest.mark.parametrize(
    ("name", "command"), [("compare", compare), ("points", points), ("probe", probe)]
)
def test_every_option_has_its_row_and_no_other(
    repository: Path, name: str, command: Callable[..., Any]
) -> None:
    page = (repository / f"docs/how-to/{name}.md").read_text(encoding="utf-8")
    app = typer.Typer(add_completion=False)
    app.command()(command)
    made = typer.main.get_command(app)
    options = {name for one in made.params for name in one.opts if name.startswith("--")}
    rows = re.findall(r"^\| (`--.+?) \|", page, re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"`(--[a-z-]+)`", row)} == options


@pytest.mark.parametrize("name", ["compare", "points", "probe", "real-controller"])
def test_safety_comes_first_and_the_page_is_short(repository: Path, name: str) -> None:
    lines = (repository / f"docs/how-to/{name}.md").read_text(encoding="utf-8").splitlines()
    assert re.match(r"> \*\*Safety( first)?\.\*\*", lines[2])
    assert len(lines) <= _TWO_SCREENS


def test_the_page_on_probes_has_every_question_and_every_assumed_rule() -> None:
    page = probes_page()
    for one in questions():
        assert f"| `{one.id}` | {one.risk.value} | {one.title} |" in page
    named = re.findall(r"^\| `([\w-]+)` \| [^|]+\|$", page, re.MULTILINE)
    assert named == [rule.id for rule in rules() if rule.basis == "assumed"]
