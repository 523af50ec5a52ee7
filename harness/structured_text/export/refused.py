"""What a tool refuses of a program as it is written: `check --for`.

Three things are put together: which constructs beyond the portable subset the tool takes
(`constructs.toml`), which functions, blocks and operators it has (`words`), and what an export for
it does not carry. A construct of which no source says that it is taken may be refused.
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

#: Which tool takes which construct.
CONSTRUCTS_FILE = Path(__file__).parent / "constructs.toml"

_ON_LIST = " is not on the list for "
#: Details that a word on their construct does not cover: who takes `//` may not take this.
_SAID_APART = ("/* */",)


@dataclass(frozen=True)
class Tool:
    """A tool that a program may be meant for.

    Attributes:
        title: What it is called.
        export: The target of the export for it.
        words: Its list of functions and blocks, in the folder `words`.
        takes: Constructs that it takes, with what says so.
        refuses: Constructs that it refuses, likewise.
        own: Endings of its own files, in lower case: it refuses nothing of them.
        instead: What to do there instead of a construct, where that is something of its own.
        note: How it differs where the export writes the same another way; or empty.
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
        """Does it take a construct? None where no source says so or denies it."""
        if str(use) in self.takes:
            return True
        if use.construct in self.refuses:
            return False
        covered = use.construct in self.takes and use.detail not in _SAID_APART
        return True if covered else None


@dataclass(frozen=True)
class Refusal:
    """What a tool refuses, or may refuse where `certain` is False."""

    file: Path
    at: s.Position
    text: str
    certain: bool

    def __str__(self) -> str:
        kind = "refused" if self.certain else "may be refused"
        return f"{self.file}:{self.at.line}:{self.at.column}: {kind}: {self.text}"


@cache
def tools() -> Mapping[str, Tool]:
    """The tools by the names that the command line knows them by."""
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
    """All that a tool refuses of the user's files, in the order of files and lines.

    Args:
        tool: The tool.
        sources: The files, free of errors.
        project: What they mean.
        program: What the export would be given; None where it cannot be asked: then what only
            the export itself knows is not among them.

    Raises:
        InputError: the export cannot be made.
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
    text = f"{use}; {tool.instead.get(use.construct, use.instead)}"
    return Refusal(use.file, use.at, text, certain=taken is False)


def _declared(files: Sequence[Path]) -> Iterator[s.Declaration]:
    for file in files:
        yield from parse(file).declarations


def _is_function(one: s.Declaration) -> bool:
    return isinstance(one, s.Pou) and one.kind == "FUNCTION"


def _by_name(tool: Tool, file: Path, one: s.Declaration, functions: set[str]) -> Iterator[Refusal]:
    """Functions, blocks and operators that the tool has not, and names that may be its words."""
    if isinstance(one, s.Pou | s.TypeDecl):
        for at, why in words(tool.words).lacking(one, functions):
            yield Refusal(file, at, why, certain=False)
    if tool.words != "iec" or tool.export != "st":  # matiec has the words of the second edition
        for at, why in reserved_names(one):
            yield Refusal(file, at, why, certain=False)


def _not_carried(
    tool: Tool, sources: SourceFiles, users: Sequence[Path], program: Sequence[Path]
) -> Iterator[Refusal]:
    """What the export does not carry of the user's files, without what the lists have told."""
    from structured_text.export.targets import export

    if sources.folder is None:
        return
    for one in export(tool.export, sources.folder, program, only_needed=True).missing:
        if one.file in users and not one.replaced and _ON_LIST not in one.why:
            at = s.Position(one.line, 1)
            yield Refusal(one.file, at, f"{one.what}: {one.why}", certain=True)
