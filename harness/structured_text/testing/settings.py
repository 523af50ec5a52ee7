"""Settings in the ini file and on the command line."""

from __future__ import annotations

from collections.abc import Sequence
from configparser import ConfigParser
from difflib import get_close_matches
from pathlib import Path

import pytest

from structured_text.errors import COMMAND, InputError, did_you_mean

__all__ = ["is_on", "project", "unknown_key"]


def project(config: pytest.Config) -> Path:
    """Return the folder to which names in the ini file and in markers are relative."""
    return config.inipath.parent if config.inipath is not None else config.rootpath


def is_on(config: pytest.Config, name: str) -> bool:
    """Return whether the command line or the ini file turns a switch on, or raise InputError."""
    if config.getoption(f"{COMMAND}_{name}") is not None:
        return True
    text = str(config.getini(f"{COMMAND}_{name}") or "")
    found = ConfigParser.BOOLEAN_STATES.get(text.strip().lower() or "no")
    if found is None:
        raise InputError(f"{COMMAND}_{name} is {text!r}", hint="write true or false")
    return found


def unknown_key(key: str, names: Sequence[str], file: Path | None) -> InputError:
    """Return the error for an unknown key of the ini file, with similar names or all names."""
    near = get_close_matches(key.lower().replace("-", "_"), names)
    hint = did_you_mean(near[:1]) or f"use {', '.join(names)}"
    return InputError(f"there is no setting {key}", file=file, hint=hint)
