"""The pages of commands have a row for each option and no other rows."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest
import typer

from rcx_harness.cli.compare import compare
from rcx_harness.cli.farm import FarmOptions
from rcx_harness.cli.judge import judge
from rcx_harness.cli.points import points
from rcx_harness.cli.probe import probe
from rcx_harness.cli.view import view


def _listed(repository: Path, page: str, prefix: str = "--") -> set[str]:
    """Return the names of the options in the tables of a page."""
    text = (repository / f"docs/how-to/{page}.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (`--.+?) \|", text, re.MULTILINE)
    return {name for row in rows for name in re.findall(rf"`({prefix}[a-z-]+)`", row)}


@pytest.mark.parametrize(
    ("name", "command", "prefix"),
    [
        ("compare", compare, "--"),
        ("judge", judge, "--"),
        ("points", points, "--"),
        ("probe", probe, "--"),
        ("view", view, "-"),
    ],
)
def test_every_option_of_a_command_has_its_row_and_no_other(
    repository: Path, name: str, command: Callable[..., Any], prefix: str
) -> None:
    app = typer.Typer(add_completion=False)
    app.command()(command)
    made = typer.main.get_command(app)
    options = {name for one in made.params for name in one.opts if name.startswith(prefix)}
    assert _listed(repository, name, prefix) == options


def test_every_option_of_a_farm_has_its_row_and_no_other(repository: Path) -> None:
    options = {"--" + one.name.replace("_", "-") for one in fields(FarmOptions)}
    assert _listed(repository, "cluster") == options
