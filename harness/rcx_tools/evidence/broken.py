"""Copies of the library: as it is, and with one block broken on purpose, to be found."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from rcx_tools.evidence.results import ROOT

__all__ = ["broken_library", "library_copy"]

_LIBRARY = ROOT / "plc" / "lib"


@contextmanager
def library_copy() -> Iterator[Path]:
    """The library as it is now: a long check is not disturbed by work on it."""
    with TemporaryDirectory() as folder:
        yield Path(shutil.copytree(_LIBRARY, Path(folder) / "lib"))


@contextmanager
def broken_library(file: str, old: str, new: str) -> Iterator[Path]:
    """Copy the library; in one of its files, `old` becomes `new`.

    Raises:
        ValueError: `old` does not stand there exactly once.
    """
    with TemporaryDirectory() as folder:
        lib = Path(folder) / "lib"
        shutil.copytree(_LIBRARY, lib)
        text = (lib / file).read_text(encoding="utf-8")
        if text.count(old) != 1:
            raise ValueError(f"{file} has changed: {old!r} is there {text.count(old)} times")
        (lib / file).write_text(text.replace(old, new), encoding="utf-8")
        yield lib
