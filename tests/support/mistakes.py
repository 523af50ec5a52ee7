"""Check sources and list all errors, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.load import analyse


def check(paths: Sequence[Path]) -> list[InputError]:
    """Return all errors in the sources, in the order of the given files."""
    return analyse(paths)[1]
