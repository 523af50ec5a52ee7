"""What has to be the same wherever work is done, so that its verdicts are."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import TypeAlias

from structured_text.output.results import digest

__all__ = ["PACKAGES", "Fingerprint", "differences", "digest_of", "fingerprint"]

#: Name and value of each thing, for people.
Fingerprint: TypeAlias = tuple[tuple[str, str], ...]

#: The toolkit itself.
PACKAGES = (Path(__file__).parents[1],)


@cache
def fingerprint(packages: tuple[Path, ...] = PACKAGES) -> Fingerprint:
    """Return name and value of what verdicts of these packages rest on."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    return (("Python", python), ("its sources", digest_of(packages)))


def digest_of(folders: Sequence[Path]) -> str:
    """Return a hash of the files in folders, without compiled ones and installed data."""
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
    """What is not the same, in words; empty: nothing."""
    other = dict(there)
    return ", ".join(
        f"{name} {value} here, {other.get(name, 'none')} there"
        for name, value in here
        if other.get(name) != value
    )
