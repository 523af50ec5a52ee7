"""The XML reader for projects of PLC tools.

Elements have line numbers, and unsafe XML is refused.
"""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.parsers import expat

from structured_text.errors import InputError
from structured_text.language.source import Line
from structured_text.output.limits import PROJECT
from structured_text.output.reading import file_bytes

__all__ = ["Element", "read_xml"]

#: Largest nesting of elements; projects have about 30 levels.
_DEEPEST = 200
#: The declaration of an encoding, in the first bytes.
_DECLARED = re.compile(
    rb"(?:\xef\xbb\xbf)?<\?xml\s[^>]*?encoding\s*=\s*[\"']([A-Za-z][\w.\-]*)[\"']"
)
_PROLOG = 400
#: Multi-byte encodings, each with the codec of Python. Windows uses these names for encodings with
#: more characters, so each codec is the one with more characters.
_CODECS = {
    **dict.fromkeys(("shiftjis", "sjis", "xsjis", "mskanji", "windows31j", "cp932"), "cp932"),
    **dict.fromkeys(("eucjp", "xeucjp"), "euc_jp"),
    "iso2022jp": "iso2022_jp_2",
    **dict.fromkeys(("gb2312", "gbk", "xgbk", "euccn", "gb18030", "cp936"), "gb18030"),
    **dict.fromkeys(("big5", "cp950"), "cp950"),
    **dict.fromkeys(("euckr", "ksc56011987", "cp949"), "cp949"),
    "utf8": "utf-8",
}
#: Names of single-byte encodings.
_NARROW = re.compile(r"(us)?ascii|(iso8859|latin|windows|cp|koi8|mac)\w+")


@dataclass(eq=False)
class Element:
    r"""An XML element; names have no namespace prefix.

    Attributes:
        at: The line of the start tag.
        content: The child elements and pieces of text. A piece continues the line of the piece
        before it; the piece `"\n"` ends a line.
        end: The line of the end tag.
    """

    name: str
    attributes: dict[str, str]
    at: int
    content: list[Element | Line] = field(default_factory=list)
    end: int = 0

    def get(self, name: str, default: str = "") -> str:
        """Return an attribute as text; empty if the element does not have it."""
        return self.attributes.get(name, default)

    @property
    def children(self) -> list[Element]:
        """Return the child elements, without text."""
        return [one for one in self.content if isinstance(one, Element)]

    def all(self, *path: str) -> list[Element]:
        """Return the elements that a path of names leads to, from child to child."""
        found = [self]
        for name in path:
            found = [child for one in found for child in one.children if child.name == name]
        return found

    def first(self, *path: str) -> Element | None:
        """Return the first element that a path of names leads to, or None."""
        found = self.all(*path)
        return found[0] if found else None

    def below(self, *names: str) -> Iterator[Element]:
        """Yield all elements with these names below this one, in order.

        An element inside a yielded element is left out.
        """
        for child in self.children:
            if child.name in names:
                yield child
            else:
                yield from child.below(*names)

    def lines(self) -> list[Line]:
        """Return the text of the element and of all elements below it, by lines."""
        found: list[Line] = []
        line: list[Line] = []
        for piece in self.pieces():
            if piece.text != "\n":
                line.append(piece)
                continue
            found.append(_joined(line) if line else Line("", piece.at))
            line = []
        return [*found, _joined(line)] if line else found

    def text(self) -> str:
        """Return the text of the element and all elements below it, without outer white space."""
        return "\n".join(line.text for line in self.lines()).strip()

    def pieces(self) -> Iterator[Line]:
        """Yield the text of the element and of all elements below it, piece by piece."""
        for one in self.content:
            if isinstance(one, Line):
                yield one
            else:
                yield from one.pieces()


def _joined(pieces: list[Line]) -> Line:
    """Return the pieces of a line as a single piece."""
    first = pieces[0]
    if len(pieces) == 1:
        return first
    return Line("".join(piece.text for piece in pieces), first.at, first.shift)


def read_xml(file: Path) -> Element:
    """Read an XML file and return its root element, or raise InputError."""
    content = file_bytes(file, PROJECT)
    declared = _DECLARED.match(content[:_PROLOG])
    if declared is not None:
        content = _as_utf8(content, declared[1].decode("ascii"), file)
    try:
        return _Reader(file, "utf-8" if declared is not None else None).read(content)
    except expat.ExpatError as error:
        raise _malformed(error, file) from None


def _as_utf8(content: bytes, name: str, file: Path) -> bytes:
    """Return the content in UTF-8, because expat itself reads few multi-byte encodings.

    Raise InputError if the encoding is unknown, or the content is not in this encoding.
    """
    key = re.sub(r"[-_ ]", "", name.lower())
    if key.startswith("utf16"):
        return content  # a declaration in 8-bit characters contradicts UTF-16: the content is UTF-8
    hint = "export it again as UTF-8, or declare its encoding in the first line"
    codec = _CODECS.get(key) or (name if _NARROW.fullmatch(key) else "unknown")
    try:
        return content.decode(codec).encode().removeprefix(codecs.BOM_UTF8)
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        message = f"byte {error.start} is not {name}"
    except LookupError:
        line, message = 1, f"the encoding {name!r:.40} is not known"
    raise InputError(message, file=file, line=line, hint=hint)


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
        # Nested entities can grow without limit, and external entities read other files.
        raise self._error("a document type (DOCTYPE) is not read: no PLC tool writes one")

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        plain = {key.rpartition(" ")[2]: value for key, value in attributes.items()}
        element = Element(name.rpartition(" ")[2], plain, self._parser.CurrentLineNumber)
        if self._open:
            self._open[-1].content.append(element)
        else:
            self._root = element
        if len(self._open) >= _DEEPEST:
            raise self._error(f"more than {_DEEPEST} nested elements")
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
