"""What has to be the same wherever work is done, so that its verdicts are."""

from __future__ import annotations

import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path

from rcx_harness.cell.sources import default_lib
from rcx_harness.spec import folder as spec_folder
from rcx_harness.verify.kept import digest

__all__ = ["differences", "fingerprint"]

_PACKAGE = Path(__file__).parents[2]


@cache
def fingerprint() -> tuple[tuple[str, str], ...]:
    """Name and value of each thing, for people."""
    python = f"{sys.version_info.major}.{sys.version_info.minor}"
    found = [("rcx-harness", version("rcx-harness")), ("Python", python)]
    folders = {"its sources": _PACKAGE, "its tables": spec_folder(), "its library": default_lib()}
    for name, folder in folders.items():
        files = [file for file in folder.rglob("*") if file.is_file()]
        others = {"__pycache__", "_data"}
        own = [file for file in files if not others & set(file.relative_to(folder).parts)]
        found.append((name, digest(folder, own)))
    return tuple(found)


def differences(here: tuple[tuple[str, str], ...], there: tuple[tuple[str, str], ...]) -> str:
    """What is not the same, in words; empty: nothing."""
    other = dict(there)
    return ", ".join(
        f"{name} {value} here, {other.get(name, 'none')} there"
        for name, value in here
        if other.get(name) != value
    )
