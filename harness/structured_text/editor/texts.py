"""The text of a document as an editor sees it: lines, words, comments and code.

The lexer leaves out comments, and needs a whole text. Here the text may be broken, and comments are
found. In files of TwinCAT, only the contents of CDATA sections are Structured Text.
"""

from __future__ import annotations

import re
import unicodedata
from bisect import bisect_right
from functools import cached_property, lru_cache
from pathlib import Path

from structured_text.language.syntax import Position
from structured_text.projects.formats import OBJECTS, PLCPROJ, TASKS

__all__ = ["Text", "document", "same_name"]

#: Matches a comment, a text, or a pragma; a comment (* *) only up to its opening.
_SKIPPED = re.compile(
    r"""(?P<line>//[^\n]*)
      | (?P<nested>\(\*)
      | (?P<block>/\*.*?(?:\*/|\Z))
      | (?P<text>'(?:\$.|[^$'\n])*'?|"(?:\$.|[^$"\n])*"?)
      | (?P<pragma>\{[^}]*\}?)""",
    re.VERBOSE | re.DOTALL,
)
_MARKS = re.compile(r"\(\*|\*\)")
_WORD = re.compile(r"[^\W\d][\w\u0300-\u036f]*")
_CDATA = re.compile(r"<!\[CDATA\[(.*?)(?:\]\]>|\Z)", re.DOTALL)
#: The start tags of actions and accessors in TwinCAT, which need no declaration of their own.
_HEAD = re.compile(r"<(?:(?P<accessor>Get|Set)\b|Action\s+Name=\"(?P<action>\w+)\")")
#: Endings of files in XML.
_XML = (*OBJECTS, PLCPROJ, TASKS, ".xml", ".l5x")


class Text:
    """The text of a document.

    Attributes:
        text: The whole text with plain line ends.
        lines: Its lines.
        code: The text with blanks in place of the XML around the Structured Text.
        plain: The code with blanks in place of comments, texts and pragmas.
        comments: The offsets of each comment: its first, and the one behind it.
        skipped: The offsets of each comment, text and pragma.
    """

    def __init__(self, text: str, path: Path | str = "") -> None:
        self.text = text.replace("\r\n", "\n").replace("\r", "\n")
        self.lines = self.text.split("\n")
        self._starts = [0, *(match.end() for match in re.finditer("\n", self.text))]
        xml = Path(str(path)).suffix.lower() in _XML
        self.code = _inside(self.text) if xml else self.text
        self.comments: list[tuple[int, int]] = []
        self.skipped: list[tuple[int, int]] = []
        self.plain = self._plain()

    def offset(self, at: Position) -> int:
        """Return the offset of a position; positions outside are moved into the text."""
        line = min(max(at.line, 1), len(self.lines)) - 1
        return self._starts[line] + min(max(at.column - 1, 0), len(self.lines[line]))

    def at(self, offset: int) -> Position:
        """Return the position of an offset."""
        line = bisect_right(self._starts, offset)
        return Position(line, offset - self._starts[line - 1] + 1)

    def word(self, offset: int) -> tuple[int, int] | None:
        """Return begin and end of the name at an offset, or that ends there; None without one."""
        begin = offset
        while begin and _is_part(self.plain[begin - 1]):
            begin -= 1
        found = _WORD.match(self.plain, begin)
        return found.span() if found is not None and found.end() >= offset else None

    def name_at(self, at: Position) -> str:
        """Return the name that begins at a position; empty if there is none."""
        if not 0 < at.line <= len(self.lines) or at.column > len(self.lines[at.line - 1]) + 1:
            return ""
        found = _WORD.match(self.lines[at.line - 1], at.column - 1)
        return found.group() if found is not None else ""

    @cached_property
    def words(self) -> frozenset[str]:
        """Return all names of the text in upper case."""
        return frozenset(_key(word) for word in _WORD.findall(self.code))

    def _plain(self) -> str:
        found: list[str] = []
        done = 0
        while match := _SKIPPED.search(self.code, done):
            end = match.end()
            if match.lastgroup == "nested":
                end = _behind(self.code, match.start())
            if match.lastgroup in ("line", "nested", "block"):
                self.comments.append((match.start(), end))
            self.skipped.append((match.start(), end))
            inside = self.code[match.start() : end]
            found += [self.code[done : match.start()], _blank(inside)]
            done = end
        return "".join((*found, self.code[done:]))


@lru_cache(maxsize=8)
def document(text: str, path: str) -> Text:
    """Return the text of a document; several features of one text share it."""
    return Text(text, path)


def same_name(one: str, other: str) -> bool:
    """Return whether two names are the same to the language, which ignores their case."""
    return _key(one) == _key(other)


def _key(name: str) -> str:
    if name.isascii():
        return name.upper()
    return unicodedata.normalize("NFKC", name).upper()


def _is_part(letter: str) -> bool:
    return letter == "_" or letter.isalnum() or "\u0300" <= letter <= "\u036f"


def _blank(text: str) -> str:
    return re.sub(r"[^\n]", " ", text)


def _inside(text: str) -> str:
    """Return the text with blanks outside of the CDATA sections; heads of actions remain."""
    found: list[str] = []
    done = 0
    for match in _CDATA.finditer(text):
        found += [_heads(text[done : match.start(1)]), match.group(1)]
        done = match.end(1)
    return "".join((*found, _heads(text[done:])))


def _heads(markup: str) -> str:
    """Return blanks with `ACTION Name`, `GET` or `SET` in place of the start tags."""
    found: list[str] = []
    done = 0
    for match in _HEAD.finditer(markup):
        kind = str(match.lastgroup)
        width = match.start(kind) - match.start()
        word = "ACTION" if kind == "action" else ""
        found += [_blank(markup[done : match.start()]), word.ljust(width), match.group(kind)]
        done = match.end(kind)
    return "".join((*found, _blank(markup[done:])))


def _behind(text: str, offset: int) -> int:
    """Return the offset behind a comment that may contain comments."""
    depth = 0
    for mark in _MARKS.finditer(text, offset):
        depth += 1 if mark.group() == "(*" else -1
        if not depth:
            return mark.end()
    end = text.find("*)", offset + 2)  # in some tools, the first `*)` ends the comment
    return end + 2 if end >= 0 else len(text)
