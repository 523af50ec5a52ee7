"""The robot in the language server: its library, the order of calls, and first mistakes."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lsprotocol import types

from rcx_harness.cell.sources import blame_lib, library_names, source_files
from rcx_harness.editor.areas import area_edits, missing_areas
from rcx_harness.editor.commands import lenses, perform
from rcx_harness.editor.facts import more_about
from rcx_harness.watch.source_findings import source_findings
from structured_text.editor.diagnostics import Note
from structured_text.editor.extras import Fix, Lens, Plain
from structured_text.editor.settings import Settings
from structured_text.errors import DISTRIBUTION, InputError, in_network, shown_column
from structured_text.export.refused import refused, tools
from structured_text.language import syntax as s
from structured_text.language.checked import analysed
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

    def notes(self, sources: SourceFiles, settings: Settings) -> list[Note]:
        """Return what `rcx check` warns of; and what the chosen tool refuses."""
        project, errors = analysed(sources.all)
        if project is None or errors:
            return []
        prefix = library_names(settings.lib or None).prefix
        found = [
            (finding.file, finding.at, finding.text, finding.strict, rule)
            for finding, rule in source_findings(sources, project, prefix)
        ]
        for one in refused(tools()[settings.tool], sources, project, None) if settings.tool else ():
            rule, verb = ("refused", "refuses") if one.certain else ("may-be-refused", "may refuse")
            text = f"{settings.tool} {verb} this: {one.text}"
            found.append((one.file, one.at, text, one.certain, rule))
        return [
            Note(
                str(file),
                int(at.line),
                shown_column(at.column) or 0,
                in_network(at.line, text),
                "error" if certain else "warning",
                rule,
            )
            for file, at, text, certain, rule in dict.fromkeys(found)
        ]

    def hover(self, owner: str, name: str, kind: str) -> str:
        """Return ErrorIDs, legal values and the page of a block of the library."""
        return more_about(owner, name) or more_about(name) or more_about(kind)

    def fixes(self, path: Path, text: str, diagnostics: Sequence[types.Diagnostic]) -> list[Fix]:
        """Return changes that add missing calls of FB_ReadArea and FB_WriteArea."""
        found = []
        for one in diagnostics:
            edits = area_edits(path, text, one.range.start.line + 1, one.message)
            if edits:
                title = f"Add {' and '.join(missing_areas(one.message))}"
                found.append(Fix(title, edits, one))
        return found

    def lenses(self, path: Path, source: s.Source, sources: SourceFiles) -> list[Lens]:
        """Return the commands prove, run and sweep for each program."""
        return lenses(path, source, sources)

    def perform(
        self,
        action: str,
        arguments: Sequence[Any],
        program: Sequence[Path],
        sources: SourceFiles,
        settings: Settings,
    ) -> list[Note]:
        """Carry out a command on the saved files."""
        return perform(action, arguments, program, sources, settings)

    def explained(
        self, errors: list[InputError], sources: SourceFiles, settings: Settings
    ) -> list[InputError]:
        """Return the errors; those about unknown names have hints about the library."""
        errors = super().explained(errors, sources, settings)
        return [blame_lib(error, settings.lib or None) for error in errors]
