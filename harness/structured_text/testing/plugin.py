"""The pytest plugin of the toolkit: coverage of programs, and the runs of `mutants`.

pytest loads this module in every run of an environment that has the package. Therefore it imports
nothing of the toolkit until a setting or an order needs it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import pytest

from structured_text.errors import COMMAND
from structured_text.testing import COVERAGE

__all__ = ["add_options", "check_keys", "is_set", "order"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of coverage, and their keys of the ini file."""
    add_options(parser, COVERAGE)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Execute the order of `mutants`, or count coverage if a setting demands it."""
    check_keys(config, [f"{COMMAND}_{name}" for name in COVERAGE])
    if (place := order()) is not None:
        from structured_text.testing.mutants import start as start_mutants

        start_mutants(config, place)
    elif is_set(config, COVERAGE):
        from structured_text.testing.coverage import start

        start(config)


def order() -> Path | None:
    """Return the order file of a run of mutants (structured_text.mutants.order), or None."""
    named = os.environ.get("RCX_MUTANT_ORDER")
    return Path(named) if named else None


def add_options(parser: pytest.Parser, options: Mapping[str, Mapping[str, Any]]) -> None:
    """Add options to the command line, with their keys of the ini file."""
    group = parser.getgroup(COMMAND)
    for name, about in options.items():
        option = f"--{COMMAND}-{name.replace('_', '-')}"
        group.addoption(option, dest=f"{COMMAND}_{name}", default=None, **about)
        several = about.get("action") == "append"
        many: dict[str, Any] = {"type": "linelist", "default": []} if several else {}
        text = f"{about['help']}; as {option}"
        parser.addini(f"{COMMAND}_{name}", text, **{"default": None, **many})


def check_keys(config: pytest.Config, names: Iterable[str]) -> None:
    """Refuse unknown keys of the ini file, or of `-o`, that begin as the toolkit's keys do.

    `names` are all known keys, for the message.

    Raises:
        UsageError: An option has an unknown key. pytest prints the message.
    """
    every = getattr(config, "_inicfg", None)  # pytest 9.1 and later warn if inicfg is read
    given = dict.fromkeys(config.inicfg if every is None else every, config.inipath)
    given |= {key.partition("=")[0].strip(): None for key in config.getoption("override_ini") or ()}
    for key, file in given.items():
        if key.lower().startswith((f"{COMMAND}_", f"{COMMAND}-")) and not _registered(config, key):
            from structured_text.testing.settings import unknown_key

            raise pytest.UsageError(f"{COMMAND}: {unknown_key(key, list(names), file)}")


def is_set(config: pytest.Config, names: Iterable[str]) -> bool:
    """Return whether the command line or the ini file sets any of these options."""
    return any(
        config.getoption(f"{COMMAND}_{name}") is not None or config.getini(f"{COMMAND}_{name}")
        for name in names
    )


def _registered(config: pytest.Config, key: str) -> bool:
    """Return whether a plugin or a conftest.py has registered the key."""
    try:
        config.getini(key)
    except ValueError:
        return False
    return True
