"""The nesting of a text: POUs, sections and statements, found by their words alone.

The parser gives no ends, and drops what it cannot read. An editor needs both, also in a text that
somebody is typing.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from structured_text.editor.texts import Text

__all__ = ["Region", "Token", "key_of", "regions_of", "scanned", "tokens_of", "walked"]

_TOKEN = re.compile(r"\w[\w\u0300-\u036f]*|:=|=>|<=|>=|<>|\.\.|\*\*|\S")
POUS = ("FUNCTION_BLOCK", "FUNCTION", "PROGRAM", "INTERFACE", "CLASS")
MEMBERS = ("METHOD", "ACTION", "PROPERTY")
_ACCESSORS = ("GET", "SET")
_GROUPS = ("CONFIGURATION", "RESOURCE", "NAMESPACE")
_STATEMENTS = ("IF", "CASE", "FOR", "WHILE", "REPEAT", "STRUCT", "UNION")
_ENDS = {
    **{f"END_{word}": word for word in (*POUS, *MEMBERS, *_ACCESSORS, *_GROUPS, *_STATEMENTS)},
    "END_TYPE": "TYPE",
    "END_VAR": "VAR",
    "__ENDTRY": "__TRY",
}
_NAMED = (*POUS, *MEMBERS, *_GROUPS)
_ACCESS = frozenset(("PUBLIC", "PRIVATE", "PROTECTED", "INTERNAL", "ABSTRACT", "FINAL", "OVERRIDE"))


@dataclass(frozen=True)
class Token:
    """A word or sign of a text."""

    text: str
    begin: int

    @property
    def word(self) -> str:
        """Return the token in upper case."""
        return self.text.upper()

    @property
    def end(self) -> int:
        """Return the offset behind the token."""
        return self.begin + len(self.text)

    @property
    def is_word(self) -> bool:
        """Return whether the token begins like a name."""
        return self.text[0].isalpha() or self.text[0] == "_"


@dataclass
class Region:
    """A POU, a part of it, or a statement with an END.

    Attributes:
        kind: Its first word in upper case; for a section of variables VAR_INPUT and so on.
        name: The name of a POU or member; None for others.
        first: The number of its first token.
        last: The number of its last token.
        begin: Its first offset.
        end: The offset behind it.
        splits: The offsets of ELSE and ELSIF in an IF or CASE.
        inside: The regions in it.
        is_closed: Whether it has its END.
    """

    kind: str
    name: Token | None
    first: int
    begin: int
    last: int = 0
    end: int = 0
    splits: list[int] = field(default_factory=list)
    inside: list[Region] = field(default_factory=list)
    is_closed: bool = False

    @property
    def is_section(self) -> bool:
        """Return whether it is a section of variables."""
        return self.kind == "VAR" or self.kind.startswith("VAR_")


def tokens_of(text: Text, begin: int = 0, end: int | None = None) -> list[Token]:
    """Return the words and signs in a part of a text, without comments and texts."""
    found = _TOKEN.finditer(text.plain, begin, len(text.plain) if end is None else end)
    return [Token(match.group(), match.start()) for match in found]


def regions_of(text: Text) -> list[Region]:
    """Return the outer regions of a text, with those inside of them."""
    return scanned(tokens_of(text))[0]


def scanned(tokens: Sequence[Token]) -> tuple[list[Region], list[Region]]:
    """Return the outer regions, and those that are open at the end, the innermost last."""
    scan = _Scan(tokens)
    for number in range(len(tokens)):
        scan.take(number)
    still_open = list(scan.open)
    scan.close_all(len(tokens) - 1)
    return scan.roots, still_open


def walked(regions: Sequence[Region]) -> Iterator[Region]:
    """Yield regions and all regions inside of them."""
    for one in regions:
        yield one
        yield from walked(one.inside)


def key_of(region: Region, above: str) -> str:
    """Return the key of the POU or member that a region is, or is inside of."""
    own = region.name.word if region.name is not None and region.kind in (*POUS, *MEMBERS) else ""
    own = own or (region.kind if region.kind in _ACCESSORS else "")
    return ".".join(filter(None, (above, own)))


class _Scan:
    def __init__(self, tokens: Sequence[Token]) -> None:
        self._tokens = tokens
        self.roots: list[Region] = []
        self.open: list[Region] = []

    def take(self, number: int) -> None:
        """Open or close a region at a token."""
        token = self._tokens[number]
        word = token.word
        if not token.is_word or (number and self._tokens[number - 1].text == "."):
            return
        if word in _ENDS:
            self._close(_ENDS[word], number)
        elif word in ("ELSE", "ELSIF"):
            if self.open and self.open[-1].kind in ("IF", "CASE"):
                self.open[-1].splits.append(token.begin)
        elif self._opens(word, number):
            if word in POUS:
                self._end_above(_GROUPS, number)
            elif word in MEMBERS:
                self._end_above((*POUS, *_GROUPS), number)
            name = self._name(number) if word in _NAMED else None
            one = Region(word, name, number, token.begin)
            (self.open[-1].inside if self.open else self.roots).append(one)
            self.open.append(one)

    def _opens(self, word: str, number: int) -> bool:
        kinds = [one.kind for one in self.open]
        if kinds and (kinds[-1] == "VAR" or kinds[-1].startswith("VAR_") or kinds[-1] == "TYPE"):
            return word in ("STRUCT", "UNION")
        if word in _ACCESSORS:
            return bool(kinds) and kinds[-1] == "PROPERTY"
        if word == "PROGRAM" and ("CONFIGURATION" in kinds or "RESOURCE" in kinds):
            return False
        if word in _NAMED:
            name = self._name(number)
            return name is not None and name.is_word
        if word == "VAR" or word.startswith("VAR_"):
            return word.removeprefix("VAR").removeprefix("_") in _SECTIONS
        return word in (*_STATEMENTS, "TYPE", "__TRY")

    def _name(self, number: int) -> Token | None:
        for token in self._tokens[number + 1 : number + 6]:
            if token.word not in _ACCESS:
                return token
        return None

    def _close(self, word: str, number: int) -> None:
        for place in range(len(self.open) - 1, -1, -1):
            one = self.open[place]
            if one.kind == word or (word == "VAR" and one.is_section):
                while len(self.open) > place + 1:
                    self._end(self.open.pop(), number - 1)
                one.is_closed = True
                self._end(self.open.pop(), number)
                return

    def _end_above(self, kinds: Sequence[str], number: int) -> None:
        """End the open regions in front of a token, down to those of some kinds."""
        while self.open and self.open[-1].kind not in kinds:
            self._end(self.open.pop(), number - 1)

    def _end(self, one: Region, last: int) -> None:
        one.last = max(last, one.first)
        one.end = self._tokens[one.last].end

    def close_all(self, last: int) -> None:
        """End all open regions at a token."""
        while self.open:
            self._end(self.open.pop(), last)


_SECTIONS = frozenset(
    (
        *("", "INPUT", "OUTPUT", "IN_OUT", "TEMP", "EXTERNAL", "GLOBAL", "STAT", "INST", "CONFIG"),
        "GENERIC",
    )
)
