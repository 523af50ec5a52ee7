"""What a distribution may add to the language server: a library, warnings, actions and commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from lsprotocol import types

from structured_text.editor.diagnostics import Note
from structured_text.editor.programs import find_sources
from structured_text.editor.settings import Settings
from structured_text.errors import COMMAND, InputError
from structured_text.projects.missing import by_library
from structured_text.projects.sources import SourceFiles

__all__ = ["Extras", "Lens", "Plain"]


@dataclass(frozen=True)
class Lens:
    """A command that is shown above a line.

    Attributes:
        line: Line in the file, from 1.
        title: The text that is shown.
        action: The name of the command, for `Extras.perform`.
    """

    line: int
    title: str
    action: str
    arguments: tuple[Any, ...] = ()


class Extras(Protocol):
    """What surrounds the program.

    Attributes:
        name: The name of the server, which is shown beside each mistake.
        version: The version of the distribution.
    """

    name: str
    version: str

    def notes(self, sources: SourceFiles, settings: Settings) -> list[Note]:
        """Return warnings on a program without errors.

        The method may run in another process, to which the extras are sent by pickle.
        """

    def find(self, program: Sequence[Path], settings: Settings) -> SourceFiles:
        """Find the sources of a program, and the library files that it needs."""

    def explained(
        self, errors: list[InputError], sources: SourceFiles, settings: Settings
    ) -> list[InputError]:
        """Return the errors with better hints, and errors of missing libraries joined."""

    def hover(self, words: Sequence[str]) -> str:
        """Return more text about a name, in Markdown.

        `words` are the name of a block, and possibly that of its pin. Empty: nothing to add.
        """

    def actions(
        self, path: Path, text: str, diagnostics: Sequence[types.Diagnostic]
    ) -> list[tuple[str, types.TextEdit, types.Diagnostic]]:
        """Return changes that remove a mistake: title, change, and what it removes."""

    def lenses(self, path: Path, sources: SourceFiles) -> list[Lens]:
        """Return the commands to show in a file."""

    def perform(
        self, action: str, arguments: Sequence[Any], sources: SourceFiles, settings: Settings
    ) -> Note:
        """Carry out the command of a lens, and return its result."""


class Plain:
    """The extras of a distribution without a library."""

    name = COMMAND
    version = "0"

    def notes(self, sources: SourceFiles, settings: Settings) -> list[Note]:
        """Return no notes."""
        del sources, settings
        return []

    def find(self, program: Sequence[Path], settings: Settings) -> SourceFiles:
        """Find the sources of a program."""
        return find_sources(program, settings)

    def explained(
        self, errors: list[InputError], sources: SourceFiles, settings: Settings
    ) -> list[InputError]:
        """Return the errors, joined for each missing library."""
        del settings
        return by_library(errors, sources.missing, sources.declared)

    def hover(self, words: Sequence[str]) -> str:
        """Return no text."""
        del words
        return ""

    def actions(
        self, path: Path, text: str, diagnostics: Sequence[types.Diagnostic]
    ) -> list[tuple[str, types.TextEdit, types.Diagnostic]]:
        """Return no changes."""
        del path, text, diagnostics
        return []

    def lenses(self, path: Path, sources: SourceFiles) -> list[Lens]:
        """Return no commands."""
        del path, sources
        return []

    def perform(
        self, action: str, arguments: Sequence[Any], sources: SourceFiles, settings: Settings
    ) -> Note:
        """Raise InputError, because there are no commands."""
        del arguments, sources, settings
        raise InputError(f"there is no command {action}")
