"""What a project file holds: its Structured Text in pieces, with the lines that they stand in."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from structured_text.language.source import Line

__all__ = [
    "LANGUAGES",
    "Foreign",
    "Lines",
    "Piece",
    "Project",
    "Unit",
    "declared_kind",
    "made",
    "trimmed",
    "without_comments",
]

Lines = tuple[Line, ...]

#: Languages of the standard and of the tools, as they are named in messages.
LANGUAGES = {
    "LD": "Ladder Diagram (LD)",
    "RLL": "Ladder Diagram (RLL)",
    "FBD": "Function Block Diagram (FBD)",
    "NWL": "Ladder or Function Block Diagram, or IL (LD/FBD/IL)",
    "CFC": "Continuous Function Chart (CFC)",
    "SFC": "Sequential Function Chart (SFC)",
    "IL": "Instruction List (IL)",
    "UML": "UML",
}

_COMMENT = re.compile(r"\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|\{[^}\n]*\}", re.DOTALL)
_KIND = re.compile(r"\s*([A-Za-z_]+)")


@dataclass(frozen=True)
class Foreign:
    """A body that is not read.

    Attributes:
        language: That it is in; ST where something in it is not supported.
        at: Its line, or that of what is not supported.
        why: What that is.
    """

    language: str
    at: int
    why: str = ""

    @property
    def says(self) -> str:
        """Why it is not read, as messages say it behind its name."""
        if self.why:
            return f"is not read: {self.why}"
        return f"is in {LANGUAGES.get(self.language, self.language)} and is not read"


@dataclass(frozen=True)
class Piece:
    """A POU, or a method, a property or an action of one.

    Attributes:
        name: As it is called; of a part of a POU `Block.Method`.
        head: From the first word to the end of the variables.
        body: The statements.
        end: The last word.
        parts: What is inside it besides.
    """

    name: str
    head: Lines
    body: Lines | Foreign = ()
    end: Lines = ()
    parts: tuple[Piece, ...] = ()

    def foreign(self) -> Iterator[tuple[str, Foreign]]:
        """The bodies that are no Structured Text, and whose they are."""
        if isinstance(self.body, Foreign):
            yield self.name, self.body
        for part in self.parts:
            yield from part.foreign()

    def lines(self) -> Lines:
        """All of it, actions behind the body; bodies in other languages are left out."""
        body = () if isinstance(self.body, Foreign) else self.body
        before = [part.lines() for part in self.parts if not part.is_action]
        behind = [part.lines() for part in self.parts if part.is_action]
        return (*self.head, *chain(*before), *body, *chain(*behind), *self.end)

    @property
    def is_action(self) -> bool:
        """Is it an action of a block or program?"""
        return bool(self.head) and self.head[0].text.startswith("ACTION ")


@dataclass(frozen=True)
class Unit:
    """A declaration of a project.

    Attributes:
        kind: Its first word; TYPE, FUNCTION_BLOCK, VAR_GLOBAL, CONFIGURATION ...
        piece: What it is called and says.
        file: Where it is.
    """

    kind: str
    piece: Piece
    file: Path

    @property
    def name(self) -> str:
        """As it is called."""
        return self.piece.name


@dataclass(frozen=True)
class Project:
    """What was read of a project.

    Attributes:
        units: In the order in which they stand there.
        notes: What is not read and might be missed, a line each.
    """

    units: tuple[Unit, ...] = ()
    notes: tuple[str, ...] = ()

    def plus(self, other: Project) -> Project:
        """Both."""
        return Project((*self.units, *other.units), (*self.notes, *other.notes))


def made(at: int, *texts: str) -> Lines:
    """Lines that stand for one of the file."""
    return tuple(Line(text, at) for text in texts)


def trimmed(lines: Iterable[Line]) -> Lines:
    """Without the empty lines at both ends."""
    found = list(lines)
    while found and not found[-1].text.strip():
        found.pop()
    first = next((number for number, line in enumerate(found) if line.text.strip()), 0)
    return tuple(found[first:])


def without_comments(text: str) -> str:
    """The text with comments and pragmas blanked, its lines as they were."""
    return _COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def declared_kind(lines: Iterable[Line]) -> str:
    """The first word of a declaration, in upper case."""
    found = _KIND.match(without_comments("\n".join(line.text for line in lines)))
    return found[1].upper() if found else ""
