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
from structured_text.language import syntax as s
from structured_text.projects.missing import by_library
from structured_text.projects.sources import SourceFiles

__all__ = ["Extras", "Fix", "Lens", "Plain"]


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


@dataclass(frozen=True)
class Fix:
    """A change that removes a mistake."""

    title: str
    edits: list[types.TextEdit]
    diagnostic: types.Diagnostic


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

    def hover(self, owner: str, name: str, kind: str) -> str:
        """Return more text about a declared name, in Markdown; empty if there is nothing to add.

        `owner` is the name of the declaration around it, and `kind` the type of a variable; both
        may be empty.
        """

    def fixes(self, path: Path, text: str, diagnostics: Sequence[types.Diagnostic]) -> list[Fix]:
        """Return changes that remove mistakes in a document."""

    def lenses(self, path: Path, source: s.Source, sources: SourceFiles) -> list[Lens]:
        """Return the commands to show in a file."""

    def perform(
        self,
        action: str,
        arguments: Sequence[Any],
        program: Sequence[Path],
        sources: SourceFiles,
        settings: Settings,
    ) -> list[Note]:
        """Carry out the command of a lens, and return its results.

        `program` are the files and folders of the program.
        """


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

    def hover(self, owner: str, name: str, kind: str) -> str:
        """Return no text."""
        del owner, name, kind
        return ""

    def fixes(self, path: Path, text: str, diagnostics: Sequence[types.Diagnostic]) -> list[Fix]:
        """Return no changes."""
        del path, text, diagnostics
        return []

    def lenses(self, path: Path, source: s.Source, sources: SourceFiles) -> list[Lens]:
        """Return no commands."""
        del path, source, sources
        return []

    def perform(
        self,
        action: str,
        arguments: Sequence[Any],
        program: Sequence[Path],
        sources: SourceFiles,
        settings: Settings,
    ) -> list[Note]:
        """Raise InputError, because there are no commands."""
        del arguments, program, sources, settings
        raise InputError(f"there is no command {action}")
