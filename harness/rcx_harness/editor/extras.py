"""The robot in the language server: its library, the order of calls, and first mistakes."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from rcx_harness.cell.sources import blame_lib, source_files
from structured_text.editor.extras import Plain
from structured_text.editor.settings import Settings
from structured_text.errors import DISTRIBUTION, InputError
from structured_text.projects.sources import SourceFiles

__all__ = ["RobotExtras"]


class RobotExtras(Plain):
    """The additions for programs that use the robot's library."""

    name = "rcx"
    version = version(DISTRIBUTION)

    def find(self, program: Sequence[Path], settings: Settings) -> SourceFiles:
        """Find the sources of a program, and the files of the library that it needs."""
        lib = settings.lib or None
        dialect = settings.dialect or None
        return source_files(list(program), lib, settings.replace, dialect, settings.device)

    def explained(
        self, errors: list[InputError], sources: SourceFiles, settings: Settings
    ) -> list[InputError]:
        """Return the errors; those about unknown names have hints about the library."""
        errors = super().explained(errors, sources, settings)
        return [blame_lib(error, settings.lib or None) for error in errors]
