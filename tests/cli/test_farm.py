"""Commands that distribute their work have options for workers and clusters."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import pytest
import typer
from rich.console import Console
from typer.testing import CliRunner

from rcx_harness.cli.farm import FarmOptions
from rcx_harness.cli.options import with_options
from structured_text.errors import InputError
from structured_text.output.system import processors


@dataclass(frozen=True)
class Options(FarmOptions):
    """The common options together with one argument of the command."""

    name: Annotated[str, typer.Argument()]


@pytest.fixture
def given() -> list[Options]:
    """Return an empty list. The test command adds its options to the list at each call."""
    return []


@pytest.fixture
def app(given: list[Options]) -> typer.Typer:
    """Return a test command that only records its options."""
    made = typer.Typer(add_completion=False)

    @made.command()
    @with_options(Options)
    def command(options: Options) -> None:
        given.append(options)

    return made


def test_a_command_has_the_common_options_and_its_own(
    app: typer.Typer, given: list[Options]
) -> None:
    for arguments in (["a.st"], ["a.st", "--workers", "3"]):
        assert CliRunner().invoke(app, arguments).exit_code == 0
    assert [one.farm(Console()).workers for one in given] == [processors(), 3]


def test_zero_workers_are_refused(app: typer.Typer) -> None:
    assert CliRunner().invoke(app, ["a.st", "--workers", "0"]).exit_code == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (
            {"cluster": "tcp://127.0.0.1:8786", "workers": 2},
            "--workers cannot be combined with --cluster",
        ),
        ({"cluster_plain": True}, "--cluster-plain needs --cluster; name the scheduler, too"),
        ({"cluster_ca": Path("ca.pem")}, "--cluster-ca needs --cluster"),
        ({"cluster": "tcp://192.0.2.1:8786"}, "and nothing would be encrypted"),
        ({"cluster": "tls://192.0.2.1:8786"}, "needs --cluster-ca"),
        ({"cluster": "here"}, "no such address"),
    ],
)
def test_options_that_exclude_each_other_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=re.escape(message)):
        FarmOptions(**options).farm(Console())


def test_plain_connections_can_be_allowed() -> None:
    FarmOptions(cluster="tcp://192.0.2.1:8786", cluster_plain=True).farm(Console())
