"""The text of a source: a file, or Structured Text extracted from a file."""

from __future__ import annotations

from codecs import BOM_UTF8
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from structured_text.errors import NO_COLUMN, InputError
from structured_text.output.limits import SOURCE
from structured_text.output.reading import file_bytes, text_of

__all__ = [
    "ELSEWHERE",
    "Extract",
    "Line",
    "NetworkLine",
    "Unread",
    "in_dialect",
    "is_narrow",
    "origin",
    "source_text",
    "title_of",
]

if TYPE_CHECKING:
    _AnyPath = Path
else:
    _AnyPath = type(Path())  # PosixPath or WindowsPath, because Path itself cannot be subclassed

#: Byte order marks of encodings that are not supported.
_MARKS = {
    b"\xff\xfe\0\0": "UTF-32",
    b"\0\0\xfe\xff": "UTF-32",
    b"\xff\xfe": "UTF-16",
    b"\xfe\xff": "UTF-16",
}

#: Offset of line numbers. A line with this offset comes from the project file, and not from the
#: file of the extract.
ELSEWHERE = 10_000_000


@dataclass(frozen=True)
class Line:
    """A line of Structured Text, and its position in the file from which it was taken.

    Attributes:
        text: The line without its line end.
        at: Line in the file, from 1.
        shift: Number to add to a column of this text to get the column in the file; 0 for a line
            with a network that has no column in the file.
        network: The part of a drawing that the line was translated from, such as `rung 3`,
            `network 3`, `step Fill` or `transition 2`; empty for a line of text.
        owner: Name of the method or action with the drawing, such as `Main.Work`; empty if it is
            the body of the POU.
    """

    text: str
    at: int
    shift: int = 0
    network: str = ""
    owner: str = ""


class NetworkLine(int):
    """A line number in a file, and the translated line that it belongs to.

    It equals the plain number, so that only code that names a network distinguishes them.

    Attributes:
        pou: Name of the POU, method or action with the drawing; empty if it is not known.
        line: The line of the translation.
    """

    pou: str
    line: Line

    def __new__(cls, number: int, pou: str, line: Line) -> NetworkLine:
        """Return a line number with its POU and the line of the translation."""
        made = super().__new__(cls, number)
        made.pou, made.line = pou, line
        return made

    def __getnewargs__(self) -> tuple[int, str, Line]:  # type: ignore[override]
        """Return the arguments of `__new__` for pickle."""
        return int(self), self.pou, self.line

    @property
    def network(self) -> str:
        """Return the part of the drawing, such as `rung 3`."""
        return self.line.network

    @property
    def text(self) -> str:
        """Return the text of the translated line, without indentation."""
        return self.line.text.strip()

    @property
    def place(self) -> str:
        """Return POU and network for a message, such as `Main, rung 3`."""
        return f"{self.pou}, {self.network}" if self.pou else self.network


@dataclass(frozen=True)
class Unread:
    """A body that is in another language than Structured Text.

    Its POU is declared with an empty body, so that the rest of the sources can be checked.

    Attributes:
        name: Name of the POU; `Block.Method` for a part of a POU.
        says: The reason, as the predicate of a message.
        language: The short name of its language, for lists.
        file: The file with the body.
        at: The line of the body in that file.
    """

    name: str
    says: str
    language: str
    file: Path
    at: int


class Extract(_AnyPath):
    """A file together with the Structured Text that was extracted from it.

    An extract is accepted wherever the path of a source is. Messages name the file and its lines.
    Paths derived from an extract (its parent, its absolute path) are plain paths.

    Attributes:
        lines: The text, or None for a plain path.
        title: Name for this source. It corresponds to the stem of a separate file.
        dialect: The dialect of the program (`language.dialects`); empty if the path says none.
        unread: The bodies that are missing in the text, because they are in another language.
        project: The project file that the lines from `ELSEWHERE` on come from, if the extract's own
            file replaces a body of the project. Otherwise empty.
        diagrams: The ladder and function block diagrams that lines were translated from, with the
            names of their POUs, methods and actions. Coverage draws them; the language does not
            use them.
        generated: Whether the text is not in the file at all, as the function of an instruction
            that a reader adds. Coverage does not count it.
    """

    lines: tuple[Line, ...] | None = None
    title: str = ""
    dialect: str = ""
    unread: tuple[Unread, ...] = ()
    project: str = ""
    diagrams: tuple[tuple[str, Any], ...] = ()
    generated: bool = False
    _whole_hash: int | None = None

    @classmethod
    def make(
        cls,
        file: Path,
        lines: tuple[Line, ...] | None,
        title: str = "",
        project: str = "",
        unread: tuple[Unread, ...] = (),
        dialect: str = "",
        diagrams: tuple[tuple[str, Any], ...] = (),
        generated: bool = False,
    ) -> Extract:
        """Return the extract of a file; without lines, a path that only carries the dialect."""
        made = cls(str(file))
        made.lines, made.title, made.dialect = _told_apart(lines, generated), title, dialect
        made.project, made.unread, made.diagrams = project, unread, diagrams
        made.generated = generated
        return made

    def place(self, line: int) -> tuple[str, int]:
        """Return the file and line to show for a line number in this source."""
        if self.project and line > ELSEWHERE:
            there = line - ELSEWHERE
            if isinstance(line, NetworkLine):
                there = NetworkLine(there, line.pou, line.line)
            return self.project, there
        return str(self), line

    def __eq__(self, other: object) -> bool:
        """Return whether path, dialect and lines are equal."""
        if self is other:  # comparing all lines is slow, and paths are compared often
            return True
        return (
            super().__eq__(other)
            and self.dialect == getattr(other, "dialect", "")
            and self.lines == getattr(other, "lines", None)
        )

    def __hash__(self) -> int:
        """Return the hash of path and lines, computed once."""
        if self.lines is None:
            return super().__hash__()
        if self._whole_hash is None:
            self._whole_hash = hash((super().__hash__(), self.lines))
        return self._whole_hash

    def __reduce__(self) -> tuple[Any, ...]:
        """Return constructor and arguments for pickle; those of Path without lines and dialect."""
        if self.lines is None and not self.dialect:
            return Path, (str(self),)
        given = (str(self), self.lines, self.title, self.project, self.unread, self.dialect)
        return Extract.make, (*given, self.diagrams, self.generated)


def _told_apart(lines: tuple[Line, ...] | None, generated: bool) -> tuple[Line, ...] | None:
    """Return the lines of a translation with columns that differ if the line in the file is equal.

    Several statements of a network, and generated statements, have the same line in the file.
    Without different columns, their positions would be equal, and steps of the debugger, branches
    of the coverage and renamed variables would be mixed up. The new columns are greater than
    `NO_COLUMN`, and are not shown.
    """
    if lines is None or not (generated or any(line.network for line in lines)):
        return lines
    ends: dict[int, int] = {}
    seen: set[int] = set()
    made = []
    for line in lines:
        if not line.shift and (line.network or line.at in seen):
            end = ends.setdefault(line.at, NO_COLUMN)
            ends[line.at] = end + len(line.text) + 1
            line = replace(line, shift=end)
        seen.add(line.at)
        made.append(line)
    return tuple(made)


def in_dialect(file: Path, dialect: str) -> Path:
    """Return the path of a source with its dialect."""
    if getattr(file, "dialect", "") == dialect:
        return file
    if not isinstance(file, Extract):
        return Extract.make(file, None, dialect=dialect)
    given = (file, file.lines, file.title, file.project, file.unread, dialect, file.diagrams)
    return Extract.make(*given, file.generated)


def source_text(file: Path) -> str:
    """Return the Structured Text of a source, or raise InputError."""
    lines = getattr(file, "lines", None)
    if lines is not None:
        return "".join(f"{line.text}\n" for line in lines)
    content = file_bytes(file, SOURCE)
    hint = "save the file as UTF-8"
    for mark, encoding in _MARKS.items():
        if content.startswith(mark):
            raise InputError(f"the file is {encoding}", file=file, hint=hint)
    text = _narrow(content) if _first_narrow(content) is not None else text_of(content, file)
    if "\0" in text:
        raise InputError("the file is not a text file, or is in UTF-16", file=file, hint=hint)
    return text


def is_narrow(file: Path) -> int | None:
    """Return the first line with a byte that is not UTF-8; None for a file in UTF-8.

    Such a file is read as Windows-1252, which older tools write.
    """
    if getattr(file, "lines", None) is not None:
        return None
    content = file_bytes(file, SOURCE)
    first = _first_narrow(content)
    return None if first is None else content.count(b"\n", 0, first) + 1


def _first_narrow(content: bytes) -> int | None:
    """Return the position of the first byte that is not UTF-8; None after a byte order mark."""
    if content.startswith(BOM_UTF8):
        return None
    try:
        content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        return error.start
    return None


def _narrow(content: bytes) -> str:
    text = content.decode("cp1252", errors="replace")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def title_of(file: Path) -> str:
    """Return the title of an extract, or the stem of any other file."""
    return getattr(file, "title", "") or file.stem


def origin(file: Path, line: int, column: int) -> tuple[int, int]:
    """Convert line and column in the source's text to those in the file; they count from 1."""
    lines = getattr(file, "lines", None)
    if not lines:
        return line, column
    found = lines[min(line, len(lines)) - 1]
    column = max(1, column + found.shift)
    if found.network:
        owner = found.owner or getattr(file, "title", "")
        return NetworkLine(found.at, owner, found), column
    return found.at, column
