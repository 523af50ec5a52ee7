"""XML of PLC tools: elements that know their lines, and nothing that a file could harm with."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from rcx_harness.engine.source import Line
from rcx_harness.errors import InputError

__all__ = ["Element", "read_xml"]

#: Elements inside each other; projects have some 30.
_DEEPEST = 200
_WRONG_ENCODING = 19  # XML_ERROR_INCORRECT_ENCODING: said to be UTF-16, and is not


@dataclass(eq=False)
class Element:
    r"""An element; names are without their name spaces.

    Attributes:
        content: Its elements, and pieces of text as lines that go on where the one before ended,
            but for the empty line `"\n"`, which ends one.
    """

    name: str
    attributes: dict[str, str]
    at: int
    content: list[Element | Line] = field(default_factory=list)
    end: int = 0

    def get(self, name: str, default: str = "") -> str:
        """An attribute."""
        return self.attributes.get(name, default)

    @property
    def children(self) -> list[Element]:
        """Its elements."""
        return [one for one in self.content if isinstance(one, Element)]

    def all(self, *path: str) -> list[Element]:
        """The elements on a path of names."""
        found = [self]
        for name in path:
            found = [child for one in found for child in one.children if child.name == name]
        return found

    def first(self, *path: str) -> Element | None:
        """The first element on a path of names."""
        found = self.all(*path)
        return found[0] if found else None

    def below(self, *names: str) -> Iterator[Element]:
        """All elements of these names below this one, in their order; none inside another."""
        for child in self.children:
            if child.name in names:
                yield child
            else:
                yield from child.below(*names)

    def lines(self) -> list[Line]:
        """Its text and that of all below it, by lines."""
        found: list[Line] = []
        fresh = True
        for piece in self.pieces():
            if piece.text == "\n":
                if fresh:
                    found.append(Line("", piece.at))
                fresh = True
            elif fresh:
                found.append(piece)
                fresh = False
            else:
                last = found[-1]
                found[-1] = Line(last.text + piece.text, last.at, last.shift)
        return found

    def text(self) -> str:
        """Its text and that of all below it, without white space around."""
        return "\n".join(line.text for line in self.lines()).strip()

    def pieces(self) -> Iterator[Line]:
        """Its text and that of all below it, piece by piece."""
        for one in self.content:
            if isinstance(one, Line):
                yield one
            else:
                yield from one.pieces()


def read_xml(file: Path) -> Element:
    """Read a file.

    Raises:
        InputError: it cannot be read, is not well-formed, or has a document type.
    """
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"cannot read the file: {error.strerror}", file=file) from None
    try:
        return _Reader(file, None).read(content)
    except expat.ExpatError as error:
        if error.code != _WRONG_ENCODING:
            raise _malformed(error, file) from None
    try:
        return _Reader(file, "utf-8").read(content)
    except expat.ExpatError as error:
        raise _malformed(error, file) from None


def _malformed(error: expat.ExpatError, file: Path) -> InputError:
    return InputError(
        f"is not well-formed XML: {expat.ErrorString(error.code)}",
        file=file,
        line=error.lineno,
        column=error.offset + 1,
        hint="export it again from its tool",
    )


class _Reader:
    def __init__(self, file: Path, encoding: str | None) -> None:
        self._file = file
        self._open: list[Element] = []
        self._root: Element | None = None
        self._parser = expat.ParserCreate(encoding, namespace_separator=" ")
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = self._text
        self._parser.StartDoctypeDeclHandler = self._doctype

    def read(self, content: bytes) -> Element:
        self._parser.Parse(content, True)
        assert self._root is not None
        return self._root

    def _error(self, message: str) -> InputError:
        return InputError(message, file=self._file, line=self._parser.CurrentLineNumber)

    def _doctype(self, *_: object) -> None:
        # Entities that name entities grow without end, and others read further files.
        raise self._error("a document type (DOCTYPE) is not read: no PLC tool writes one")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        plain = {key.rpartition(" ")[2]: value for key, value in attributes.items()}
        element = Element(name.rpartition(" ")[2], plain, self._parser.CurrentLineNumber)
        if self._open:
            self._open[-1].content.append(element)
        else:
            self._root = element
        if len(self._open) >= _DEEPEST:
            raise self._error(f"more than {_DEEPEST} elements inside each other")
        self._open.append(element)

    def _end(self, name: str) -> None:
        del name
        self._open.pop().end = self._parser.CurrentLineNumber

    def _text(self, text: str) -> None:
        at, column = self._parser.CurrentLineNumber, self._parser.CurrentColumnNumber
        parts = text.split("\n")
        for number, part in enumerate(parts):
            if number:
                self._open[-1].content.append(Line("\n", at))
            if part:
                self._open[-1].content.append(Line(part, at, column))
