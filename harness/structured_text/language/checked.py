"""Loading of checked projects; the result is cached while the files do not change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language import cache
from structured_text.language.project import Project, runnable
from structured_text.language.unread import not_executed

__all__ = ["analysed", "load"]


def analysed(
    paths: Sequence[Path], most: int | None = None
) -> tuple[Project | None, list[InputError]]:
    """Return the checked project, or None with all errors, as `language.load.analyse` does."""
    key = cache.sources_key(paths)
    lasting = key if cache.is_lasting(paths) else ""
    errors: list[InputError] = []

    def made() -> Project:
        from structured_text.language.load import analyse  # imported late: it is slow

        project, found = analyse(paths, most=most)
        errors.extend(found)
        if project is None:
            raise errors[0]
        return replace(project, key=lasting)

    try:
        found = cache.remembered("project", key, lambda: cache.kept("project", lasting, made))
    except InputError:
        if not errors:
            raise
        return None, errors
    return found, errors


def load(paths: Sequence[Path]) -> Project:
    """Return a checked project that has a program to run.

    Raises:
        InputError: The sources have a mistake (the first is reported, with file, line and hint), or
            the program executes a body in another language.
    """
    project, errors = analysed(paths)
    if project is None:
        raise errors[0]
    return not_executed(runnable(project), paths)
