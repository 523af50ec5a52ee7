"""Replay files of a search, which never overwrite a file that no search has written."""

from __future__ import annotations

import os
from pathlib import Path

from structured_text.errors import COMMAND, InputError

__all__ = ["BEGINS", "MARK", "check"]

MARK = f"# {COMMAND} replay: "
"""The first characters of a stimulus file that a search has written."""

#: First bytes of each kind of replay file.
BEGINS = {".toml": MARK.encode(), ".svg": b"<svg "}


def check(file: Path) -> None:
    """Refuse to overwrite a file that no search has written."""
    if not os.path.isfile(file):
        return
    with file.open("rb") as stream:
        found = stream.read(16)
    if found and not found.startswith(BEGINS[file.suffix][:16]):
        hint = "name another folder with --out, or remove this file"
        raise InputError(f"already exists and was not written by {COMMAND}", file=file, hint=hint)
