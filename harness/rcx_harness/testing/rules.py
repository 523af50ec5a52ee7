"""Names that a user may misspell: rules in a marker, keys in the ini file."""

from __future__ import annotations

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path

import pytest

from rcx_harness.errors import InputError
from rcx_harness.spec.telegram import did_you_mean

__all__ = ["RULES", "unknown_key", "wrong_marker"]

#: Every rule whose breach is reported, by who reports it.
RULES = {
    "monitor": (
        "interval",
        "start against stop",
        "reserved",
        "data before code",
        "command held",
        "ready before code",
    ),
    "contract": ("contract",),
    "calls": ("calls",),
    "robot": ("interval", "reserved", "ready-first", "hold-command"),
}


def wrong_marker(marker: pytest.Mark) -> str:
    """What is wrong with a marker `allow_violations`; empty if nothing."""
    names = list(dict.fromkeys(name for some in RULES.values() for name in some))
    every = f"the rules are: {', '.join(names)}"
    if marker.kwargs:
        written = ", ".join(f"{name}=" for name in marker.kwargs)
        hint = 'write it as @pytest.mark.allow_violations("interval")'
        return f"@pytest.mark.allow_violations takes names of rules, not {written}; {hint}"
    for rule in marker.args:
        if rule not in names:
            near = get_close_matches(rule, names) if isinstance(rule, str) else []
            return f"there is no rule {rule!r}; {did_you_mean(near) or every}"
    return ""


def unknown_key(key: str, names: Sequence[str], file: Path | None) -> InputError:
    """That there is no such key in the ini file, with the nearest names, or all."""
    near = get_close_matches(key.lower().replace("-", "_"), names)
    hint = did_you_mean(near[:1]) or f"use {', '.join(names)}"
    return InputError(f"there is no setting {key}", file=file, hint=hint)
