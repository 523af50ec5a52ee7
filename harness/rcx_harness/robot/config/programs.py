"""The programs of a robot file that are in files of their own."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rcx_harness.robot.program import read_program, text_of
from structured_text.errors import InputError

__all__ = ["program_texts", "with_programs"]


def program_texts(file: Path, table: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the text of each of the `[[programs]]` of a robot file, empty without `file`.

    Raises:
        InputError: a file cannot be read, or the first error in it.
    """
    texts = []
    for entry in _entries(table):
        name = entry.get("file", "")
        if not isinstance(name, str) or not name:
            texts.append("")
            continue
        if clash := [key for key in ("text", "steps", "duration") if key in entry]:
            raise InputError(f"'{clash[0]}' and 'file' exclude each other", file=file)
        path = file.parent / name
        text = text_of(path)
        _, errors = read_program(text, path)
        if errors:
            raise errors[0]
        texts.append(text)
    return tuple(texts)


def with_programs(table: Mapping[str, Any], texts: tuple[str, ...]) -> dict[str, Any]:
    """Return a robot file with the texts of its programs, each named as its file by default."""
    if not any(texts):
        return dict(table)
    programs = [
        {"name": _name(entry["file"]), **entry, "text": text} if text else entry
        for entry, text in zip(_entries(table), texts, strict=True)
    ]
    return {**table, "programs": programs}


def _entries(table: Mapping[str, Any]) -> list[dict[str, Any]]:
    entries = table.get("programs", [])
    plain = isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries)
    return entries if plain else []


def _name(file: str) -> str:
    """Return the name of a program from its file name: upper case letters, digits and _."""
    return re.sub(r"[^A-Z0-9_]", "_", Path(file).stem.upper())
