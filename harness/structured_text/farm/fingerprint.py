"""The properties of a computer that verdicts depend on; they must be equal on all computers."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TypeAlias

from structured_text.output.results import digest

__all__ = ["PACKAGES", "Fingerprint", "differences", "digest_of", "fingerprint"]

#: Pairs of name and value of a property, in words for users.
Fingerprint: TypeAlias = tuple[tuple[str, str], ...]

#: The folders of the toolkit itself.
PACKAGES = (Path(__file__).parents[1],)


@cache
def fingerprint(packages: tuple[Path, ...] = PACKAGES) -> Fingerprint:
    """Return name and value of each property that verdicts of these packages depend on."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return (("Python", python), ("its sources", digest_of(packages)))


def digest_of(folders: Sequence[Path]) -> str:
    """Return a hash of the files in folders, without compiled files and installed data."""
    found = []
    for folder in folders:
        files = [file for file in folder.rglob("*") if file.is_file()]
        others = {"__pycache__", "_data"}
        own = [file for file in files if not others & set(file.relative_to(folder).parts)]
        found.append(digest(folder, own))
    if len(found) == 1:
        return found[0]
    return hashlib.sha256("".join(found).encode()).hexdigest()[:16]


def differences(here: Fingerprint, there: Fingerprint) -> str:
    """Return the differences between two fingerprints in words; empty if they are equal."""
    other = dict(there)
    return ", ".join(
        f"{name} {value} here, {other.get(name, 'none')} there"
        for name, value in here
        if other.get(name) != value
    )
