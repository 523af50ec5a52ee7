"""The contents of a project file: its Structured Text in pieces, with line numbers.

The readers of all formats produce these classes. `open` makes sources from them.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import chain
from pathlib import Path

from structured_text.language.source import Line
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = [
    "LANGUAGES",
    "Foreign",
    "Library",
    "Lines",
    "Piece",
    "Project",
    "Unit",
    "declared_kind",
    "in_comment",
    "made",
    "trimmed",
    "without_comments",
]

Lines = tuple[Line, ...]

#: Languages of the standard and of PLC tools, with their names in messages.
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
    """A body that is not read, because its language or a part of it is not supported.

    Attributes:
        language: The language of the body; ST if a body in Structured Text has an unsupported part.
        at: The first line of the body, or the line of the unsupported part.
        why: The unsupported part, for a message.
    """

    language: str
    at: int
    why: str = ""

    @property
    def says(self) -> str:
        """Return the reason why the body is not read, as the predicate of a message."""
        if self.why:
            return f"is not read: {self.why}"
        return f"is in {LANGUAGES.get(self.language, self.language)} and is not read"


@dataclass(frozen=True)
class Piece:
    """A POU, or a method, a property or an action of a POU.

    Attributes:
        name: Name of the POU; for a part of a POU `Block.Method`.
        head: The lines from the first word to the end of the variables.
        body: The statements.
        end: The line with the last word, such as END_PROGRAM.
        parts: The methods, properties and actions of the POU.
        diagram: The diagram that the body was translated from; None for other bodies.
    """

    name: str
    head: Lines
    body: Lines | Foreign = ()
    end: Lines = ()
    parts: tuple[Piece, ...] = ()
    diagram: Diagram | None = None

    def diagrams(self) -> Iterator[tuple[str, Diagram]]:
        """Yield the diagrams of the POU and its parts, with the names of their pieces."""
        if self.diagram is not None:
            yield self.name, self.diagram
        for part in self.parts:
            yield from part.diagrams()

    def foreign(self) -> Iterator[tuple[str, Foreign]]:
        """Yield the bodies that are not in Structured Text, with the names of their pieces."""
        if isinstance(self.body, Foreign):
            yield self.name, self.body
        for part in self.parts:
            yield from part.foreign()

    def lines(self) -> Lines:
        """Return all lines of the POU, with actions behind the body.

        Bodies in other languages are omitted.
        """
        body = () if isinstance(self.body, Foreign) else self.body
        before = [part.owned() for part in self.parts if not part.is_action]
        behind = [part.owned() for part in self.parts if part.is_action]
        return (*self.head, *chain(*before), *body, *chain(*behind), *self.end)

    def owned(self) -> Lines:
        """Return all lines of a part; the lines of a drawing name the part that they belong to."""
        return tuple(
            replace(line, owner=line.owner or self.name) if line.network else line
            for line in self.lines()
        )

    @property
    def is_action(self) -> bool:
        """Return whether the piece is an action of a block or program."""
        return bool(self.head) and self.head[0].text.startswith("ACTION ")


@dataclass(frozen=True)
class Unit:
    """A declaration of a project.

    Attributes:
        kind: First word of the declaration: TYPE, FUNCTION_BLOCK, VAR_GLOBAL, CONFIGURATION ...
        piece: Name and lines of the declaration.
        generated: Whether the reader has added it, so that the file has no text of it.
    """

    kind: str
    piece: Piece
    file: Path
    generated: bool = False

    @property
    def name(self) -> str:
        """Return the name of the declared element."""
        return self.piece.name


@dataclass(frozen=True)
class Library:
    """A library that a project refers to.

    Attributes:
        name: The title of the library, without version and company.
        namespace: The name that stands before elements of the library in this project.
        at: The line of the reference in the project file.
        noted: Whether a note says that the library is not read. CODESYS projects refer to many
            system libraries, which get no note.
    """

    name: str
    namespace: str
    file: Path
    at: int
    noted: bool = True


@dataclass(frozen=True)
class Project:
    """The contents of one or more project files.

    Attributes:
        units: The declarations in the order of the files.
        notes: One line for each unread part that a user could miss.
        dialects: The dialect (`language.dialects`) of each file with a format that belongs to one
            tool.
        titles: The names by which other projects refer to this project as a library.
        namespaces: The names that other projects write before elements of this project.
        libraries: The libraries that this project refers to.
    """

    units: tuple[Unit, ...] = ()
    notes: tuple[str, ...] = ()
    dialects: tuple[tuple[str, Path], ...] = ()
    titles: tuple[str, ...] = ()
    namespaces: tuple[str, ...] = ()
    libraries: tuple[Library, ...] = ()

    def plus(self, other: Project) -> Project:
        """Return the contents of this project and another one."""
        return Project(
            (*self.units, *other.units),
            (*self.notes, *other.notes),
            (*self.dialects, *other.dialects),
            (*self.titles, *other.titles),
            (*self.namespaces, *other.namespaces),
            (*self.libraries, *other.libraries),
        )


def made(at: int, *texts: str) -> Lines:
    """Return generated lines; all get the same line number in the file."""
    return tuple(Line(text, at) for text in texts)


def trimmed(lines: Iterable[Line]) -> Lines:
    """Return the lines without empty lines at the beginning and end."""
    found = list(lines)
    while found and not found[-1].text.strip():
        found.pop()
    first = next((number for number, line in enumerate(found) if line.text.strip()), 0)
    return tuple(found[first:])


def in_comment(text: str) -> str:
    """Return a text without the marks that would end a comment."""
    return text.strip().replace("*)", "* )").replace("(*", "( *")


def without_comments(text: str) -> str:
    """Return the text with blanks in place of comments and pragmas; lines keep their numbers."""
    return _COMMENT.sub(lambda found: re.sub(r"[^\n]", " ", found[0]), text)


def declared_kind(lines: Iterable[Line]) -> str:
    """Return the first word of a declaration, in upper case."""
    found = _KIND.match(without_comments("\n".join(line.text for line in lines)))
    return found[1].upper() if found else ""
