"""Checked projects, each of them loaded once: what the front end finds does not change."""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from rcx_harness.engine import cache
from rcx_harness.engine.frontend import load as load_anew
from rcx_harness.engine.frontend.project import Project

__all__ = ["is_lasting", "load"]


def load(paths: Sequence[Path]) -> Project:
    """A checked project; from the cache where the same files were loaded before.

    Raises:
        InputError: the first mistake, with file, line and what to do.
    """
    key = cache.sources_key(paths)

    def made() -> Project:
        return replace(load_anew(paths), key=key if is_lasting(paths) else "")

    def found() -> Project:
        return cache.kept("project", key if is_lasting(paths) else "", made)

    return cache.remembered("project", key, found)


def is_lasting(paths: Sequence[Path]) -> bool:
    """Are these files to be there tomorrow? What is made of temporary ones is not kept."""
    temporary = Path(tempfile.gettempdir()).resolve()
    folders = [folder.resolve() for folder in {path.parent for path in paths}]
    return not any(temporary in (folder, *folder.parents) for folder in folders)
