"""The parts of a source that the formatter moves: tokens, comments, pragmas and other text.

The tokens come from the lexer of the language. The text between them is split here.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

from lark import Token

from structured_text.errors import InputError
from structured_text.language.conditional import PRAGMA
from structured_text.language.lexer import KEYWORDS, Notes, tokens
from structured_text.language.words import ACCESSORS, EXCEPTIONS
from structured_text.output.limits import MOST_TOKENS

__all__ = [
    "COMMENTS",
    "EXCLUDED",
    "HASH",
    "PRAGMAS",
    "REGIONS",
    "SKIPPED_WORD",
    "TAB",
    "Item",
    "items_of",
]

#: Kinds of items that are not tokens: comments, pragmas, regions, and text that conditional
#: compilation excludes.
COMMENTS = ("//", "(*", "/*")
PRAGMAS, REGIONS, EXCLUDED = "{", "REGION", "{IF"
#: Kinds of two other items that are not tokens: `#` before a name of Siemens, and an access word
#: that the lexer skips.
HASH, SKIPPED_WORD = "#", "SKIPPED"

#: Distance of tab stops in a source [columns].
TAB = 4

_CAPITALS = frozenset((*KEYWORDS, *ACCESSORS, *EXCEPTIONS.values(), "WORD"))
#: Types of the standard that are written in capitals like keywords.
_TYPES = frozenset(
    (
        *("BOOL", "SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT", "REAL"),
        *("LREAL", "BYTE", "WORD", "DWORD", "LWORD", "STRING", "WSTRING", "TIME", "LTIME"),
        *("DATE", "TOD", "TIME_OF_DAY", "DT", "DATE_AND_TIME"),
    )
)
_BEFORE_TYPES = ("COLON", "OF", "TO")
#: Matches the source text of a token that differs from the token's value.
_WRITTEN = re.compile(r"[\w\u0300-\u036f#]+")
_NESTED = re.compile(r"\(\*|\*\)")
#: Matches an item between two tokens.
_BETWEEN = re.compile(
    r"""(?P<space>\s+)
      | (?P<line>//[^\n]*)
      | (?P<comment>\(\*)
      | (?P<block>/\*.*?\*/)
      | (?P<pragma>\{\{.*?\}\}|\{(?P<inside>[^}]*)\})
      | (?P<region>REGION\b[^\n]*|END_REGION\b)
      | (?P<word>\w+)
      | (?P<hash>\#)""",
    re.VERBOSE | re.IGNORECASE | re.DOTALL | re.ASCII,
)
_CONDITION = re.compile(r"\{\s*(?:IF|ELSIF|ELSE|END_IF)\b[^}]*\}", re.IGNORECASE)


@dataclass
class Item:
    """A part of a source that is moved as a whole.

    Attributes:
        kind: Kind of the token, or one of the constants of this module.
        text: The text to write.
        breaks: Number of line ends between the item and the item before it.
        column: Column in the source, from 0, with tab stops at multiples of `TAB`.
        gap: Number of columns between the item and the item before it, if both are on one line.
    """

    kind: str
    text: str
    breaks: int
    column: int
    gap: int

    @property
    def is_comment(self) -> bool:
        """Return whether the item is a comment."""
        return self.kind in COMMENTS

    @property
    def is_token(self) -> bool:
        """Return whether the item is a token of the language."""
        return not self.is_comment and self.kind not in (PRAGMAS, REGIONS, EXCLUDED, HASH)


def items_of(text: str, file: Path) -> list[Item]:
    """Split a source into its items, in their order.

    Raises:
        InputError: The lexer does not accept the text.
    """
    notes = Notes()
    found = list(islice(tokens(text, file, notes), MOST_TOKENS + 1))
    if notes.errors:
        raise notes.errors[0]
    if len(found) > MOST_TOKENS:
        raise InputError(f"more than {MOST_TOKENS:,} words, numbers and signs", file=file)
    return list(_Splitter(text, file).items(found))


class _Splitter:
    """Follows the offsets in a source; `items_of` creates it."""

    def __init__(self, text: str, file: Path) -> None:
        self._text, self._file = text, file
        #: Offset and column behind the last item.
        self._end, self._column = 0, 0

    def items(self, found: list[Token]) -> Iterator[Item]:
        """Yield the tokens, and the items between them."""
        before = ""
        for token in found:
            start = token.start_pos or 0
            yield from self._between(start)
            value = str(token)
            if not self._text.startswith(value, start):
                written = _WRITTEN.match(self._text, start)
                assert written is not None, value  # only names are changed by the lexer
                value = written.group()
            end = start + len(value)
            kind = token.type
            typed = before in _BEFORE_TYPES and value.upper() in _TYPES
            if kind in _CAPITALS or (typed and kind == "IDENT"):
                value = value.upper()
            yield self._item(kind, value, start, end)
            before = kind
        yield from self._between(len(self._text))

    def _item(self, kind: str, value: str, start: int, end: int) -> Item:
        passed = self._text[self._end : start]
        column = _behind(self._column, passed)
        gap = column - self._column if "\n" not in passed else 0
        self._end, self._column = end, _behind(column, self._text[start:end])
        return Item(kind, value, passed.count("\n"), column, gap)

    def _between(self, end: int) -> Iterator[Item]:
        """Yield the items up to an offset."""
        text, at = self._text, self._end
        while at < end:
            found = _BETWEEN.match(text, at, end)
            if found is None:
                line = text.count("\n", 0, at) + 1
                column = at - text.rfind("\n", 0, at)
                raise InputError(
                    "this part cannot be laid out", file=self._file, line=line, column=column
                )
            kind, behind = str(found.lastgroup), found.end()
            if kind == "space":
                at = behind
                continue
            if kind == "line":
                value = found.group().rstrip()
                yield self._item("//", value, at, at + len(value))
            elif kind == "comment":
                behind = _behind_comment(text, at)
                yield self._item("(*", text[at:behind], at, behind)
            elif kind == "block":
                yield self._item("/*", found.group(), at, behind)
            elif kind in ("pragma", "inside"):
                behind, kind = self._behind_pragma(found, end)
                yield self._item(kind, text[at:behind], at, behind)
            elif kind == "region":
                value = found.group().rstrip()
                yield self._item(REGIONS, value, at, at + len(value))
            elif kind == "word":
                yield self._item(SKIPPED_WORD, found.group().upper(), at, behind)
            else:
                yield self._item(HASH, "#", at, behind)
            at = behind

    def _behind_pragma(self, found: re.Match[str], end: int) -> tuple[int, str]:
        """Return the end of a pragma and its kind.

        If conditional compilation excludes text, the text belongs to the item.
        """
        behind = found.end()
        inside = (found["inside"] or "").strip()
        if not PRAGMA.fullmatch(inside) or not _CONDITION.match(found.group()):
            return behind, PRAGMAS
        last = max((one.end() for one in _CONDITION.finditer(self._text, behind, end)), default=0)
        return (last, EXCLUDED) if last else (behind, PRAGMAS)


def _behind(column: int, text: str) -> int:
    """Return the column behind a text that begins in a column."""
    _, end, last = text.rpartition("\n")
    if "\t" not in last:
        return len(last) + (0 if end else column)
    before = 0 if end else column
    shift = before % TAB
    return before - shift + len(f"{' ' * shift}{last}".expandtabs(TAB))


def _behind_comment(text: str, offset: int) -> int:
    """Return the offset behind a comment, and behind the comments inside it, as the lexer does."""
    depth = 0
    for mark in _NESTED.finditer(text, offset):
        depth += 1 if mark.group() == "(*" else -1
        if not depth:
            return mark.end()
    return text.index("*)", offset + 2) + 2
