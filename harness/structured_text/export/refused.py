"""The constructs of a program that a tool refuses; `check --for` reports them.

Three sources are combined: the constructs beyond the portable subset that the tool accepts
(`constructs.toml`), the functions, blocks and operators that it has (`words`), and the declarations
that an export for it does not support. A construct may be refused if no document says that it is
accepted.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from structured_text.export.words import words
from structured_text.language import syntax as s
from structured_text.language.constructs import Use
from structured_text.language.parser import parse
from structured_text.language.portability import reserved_names
from structured_text.language.project import Project
from structured_text.output.toml_files import load_toml
from structured_text.projects.sources import SourceFiles

__all__ = ["CONSTRUCTS_FILE", "Refusal", "Tool", "refused", "tools"]

#: The table of the constructs that each tool accepts or refuses.
CONSTRUCTS_FILE = Path(__file__).parent / "constructs.toml"

_ON_LIST = " is not on the list for "
#: Variants of a construct that a tool may refuse although it accepts the construct. For example, a
#: tool that accepts `//` comments may refuse `/* */`.
_SAID_APART = ("/* */",)


@dataclass(frozen=True)
class Tool:
    """A tool for which a program may be intended.

    Attributes:
        export: The export format for the tool.
        words: The name of the tool's list of functions and blocks, in the folder `words`.
        takes: Constructs that the tool accepts, with the source.
        refuses: Constructs that the tool refuses, with the source.
        own: Endings of the tool's own files, in lower case; constructs in these files are not
            checked.
        instead: What to write instead of a construct, if it differs from the general advice.
        note: The difference between the program and the export, if the export writes the same
            construct in another form; else empty.
    """

    title: str
    export: str
    words: str
    takes: Mapping[str, str]
    refuses: Mapping[str, str]
    own: tuple[str, ...] = ()
    instead: Mapping[str, str] = field(default_factory=dict)
    note: str = ""

    def verdict(self, use: Use) -> bool | None:
        """Return whether the tool accepts a construct; None if no source says so."""
        if str(use) in self.takes:
            return True
        if use.construct in self.refuses:
            return False
        covered = use.construct in self.takes and use.detail not in _SAID_APART
        return True if covered else None


@dataclass(frozen=True)
class Refusal:
    """A construct that a tool refuses, or may refuse if `certain` is False.

    Attributes:
        text: The construct with its detail, and what to write instead.
        kind: The construct without its detail, and what to write instead; places of one kind are
            reported together.
        detail: What is special about the place, such as the types of a conversion; may be empty.
    """

    file: Path
    at: s.Position
    text: str
    certain: bool
    kind: str
    detail: str = ""


@cache
def tools() -> Mapping[str, Tool]:
    """Return the tools by their names on the command line."""
    content = load_toml(CONSTRUCTS_FILE)
    sources: Mapping[str, str] = content.pop("sources")

    def said(lists: Mapping[str, Sequence[str]]) -> dict[str, str]:
        return {one: sources[key] for key, listed in lists.items() for one in listed}

    return {
        name: Tool(
            table["title"],
            table["export"],
            table["words"],
            said(table.get("takes", {})),
            said(table.get("refuses", {})),
            tuple(table.get("own", ())),
            table.get("instead", {}),
            table.get("note", ""),
        )
        for name, table in content.items()
    }


def refused(
    tool: Tool, sources: SourceFiles, project: Project, program: Sequence[Path] | None
) -> list[Refusal]:
    """Return all that a tool refuses in the user's files, in the order of files and lines.

    Raise InputError if the export fails. The sources must be free of errors. If `program` is None,
    the export is not run, and constructs that only the export detects are not reported.
    """
    users = [file for file in sources.users[0] if file.suffix.lower() not in tool.own]
    found = [_refusal(tool, use) for use in project.uses if use.file in users]
    listed = {part.name.key for part in _declared(sources.all) if _is_function(part)}
    for file in users:
        for one in parse(file).declarations:
            found += _by_name(tool, file, one, listed)
    if program is not None and not project.uses:
        found += _not_carried(tool, sources, users, program)
    kept = dict.fromkeys(one for one in found if one is not None)
    return sorted(kept, key=lambda one: (str(one.file), one.at))


def _refusal(tool: Tool, use: Use) -> Refusal | None:
    taken = tool.verdict(use)
    if taken:
        return None
    advice = tool.instead.get(use.construct, use.instead)
    kind = f"{use.construct}; {advice}"
    return Refusal(use.file, use.at, f"{use}; {advice}", taken is False, kind, use.detail)


def _declared(files: Sequence[Path]) -> Iterator[s.Declaration]:
    for file in files:
        yield from parse(file).declarations


def _is_function(one: s.Declaration) -> bool:
    return isinstance(one, s.Pou) and one.kind == "FUNCTION"


def _by_name(tool: Tool, file: Path, one: s.Declaration, functions: set[str]) -> Iterator[Refusal]:
    """Yield functions, blocks and operators that the tool lacks, and names that may be reserved."""
    if isinstance(one, s.Pou | s.TypeDecl):
        for at, why in words(tool.words).lacking(one, functions):
            yield Refusal(file, at, why, certain=False, kind=why)
    # matiec reserves only the words of the second edition of IEC 61131-3.
    if tool.words != "iec" or tool.export != "st":
        for at, why in reserved_names(one):
            name, _, kind = why.partition(" is ")
            yield Refusal(file, at, why, certain=False, kind=kind, detail=name)


def _not_carried(
    tool: Tool, sources: SourceFiles, users: Sequence[Path], program: Sequence[Path]
) -> Iterator[Refusal]:
    """Yield the user's declarations that the export does not support.

    A declaration is omitted if the list of functions and blocks already explains the refusal.
    """
    from structured_text.export.targets import export

    if sources.folder is None:
        return
    for one in export(tool.export, sources.folder, program, only_needed=True).missing:
        if one.file in users and not one.replaced and _ON_LIST not in one.why:
            at = s.Position(one.line, 1)
            construct, _, detail = one.what.partition(" ")
            kind = f"{construct}: {one.why}"
            yield Refusal(one.file, at, f"{one.what}: {one.why}", True, kind, detail)
