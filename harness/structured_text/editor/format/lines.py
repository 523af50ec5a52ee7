"""The lines of the result: which parts stand on a line, and in which column each part begins."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from structured_text.editor.format.items import COMMENTS, EXCLUDED, PRAGMAS, REGIONS, TAB
from structured_text.editor.format.spaces import space_between
from structured_text.editor.format.structure import Begin, Colon, Part

__all__ = ["INDENT", "WIDTH", "Line", "Placed", "lines_of", "place", "written"]

#: Indentation of a block [columns].
INDENT = 2
#: Length of a line that is not exceeded without need [columns].
WIDTH = 100
#: Words that end the first line of a block.
_HEAD_ENDS = ("THEN", "DO", "OF")
#: Words behind which a condition or expression is aligned.
_ALIGNED_BEHIND = frozenset(
    (*("IF", "ELSIF", "WHILE", "CASE", "UNTIL", "ASSIGN", "SENDTO", "COMMA", "LPAR", "LSQB"),)
)
_OPENING, _CLOSING = ("LPAR", "LSQB"), ("RPAR", "RSQB")
#: Ends of POUs and beginnings of POUs, between which an empty line is added.
_ENDS = frozenset(
    (
        *("END_FUNCTION", "END_FUNCTION_BLOCK", "END_PROGRAM", "END_CLASS", "END_INTERFACE"),
        *("END_TYPE", "END_CONFIGURATION", "END_ACTION", "END_METHOD", "END_PROPERTY"),
    )
)
_UNITS = frozenset(
    (
        *("FUNCTION", "FUNCTION_BLOCK", "PROGRAM", "CLASS", "INTERFACE", "TYPE", "CONFIGURATION"),
        *("ACTION", "METHOD", "PROPERTY", *COMMENTS, PRAGMAS, "VAR_GLOBAL"),
    )
)
#: Greatest indentation of a continued line that is retained [columns].
_FARTHEST = 12


@dataclass
class Placed:
    """A part with its distance from the part before it on its line.

    Attributes:
        part: The part.
        space: Number of spaces before it; 0 for the first part of a line.
        column: Column in the result.
    """

    part: Part
    space: int = 0
    column: int = 0

    @property
    def end(self) -> int:
        """Return the column behind the part."""
        last = self.text.rpartition("\n")
        return len(last[2]) + (0 if last[1] else self.column)

    @property
    def text(self) -> str:
        """Return the text of the part; the lines of a comment move together with its first line."""
        item = self.part.item
        head, end, rest = item.text.partition("\n")
        if not end or not item.is_comment:
            return item.text
        lines = [(_indentation(line), line.lstrip()) for line in rest.split("\n")]
        room = min((depth for depth, text in lines if text), default=0)
        by = max(self.column - item.column, -room)
        moved = (f"{' ' * (depth + by)}{text}" if text else "" for depth, text in lines)
        return "\n".join([head, *moved])


def _indentation(line: str) -> int:
    """Return the number of columns before the text of a line."""
    return len(line[: len(line) - len(line.lstrip())].expandtabs(TAB))


@dataclass
class Line:
    """A line of the result; a comment of several lines belongs to one line.

    Attributes:
        parts: The parts in their order.
        blank: Whether an empty line is before it.
    """

    parts: list[Placed] = field(default_factory=list)
    blank: bool = False

    @property
    def first(self) -> Part:
        """Return the first part."""
        return self.parts[0].part

    @property
    def continues(self) -> bool:
        """Return whether the line continues the statement of the line before it."""
        return self.first.begin == Begin.NO

    @property
    def trailing(self) -> Placed | None:
        """Return the comment at the end of the line, if code is before it."""
        last = self.parts[-1]
        return last if len(self.parts) > 1 and last.part.item.is_comment else None


def lines_of(parts: Sequence[Part]) -> list[Line]:
    """Divide the parts into lines, and decide the spaces between the parts of a line."""
    lines: list[Line] = []
    before: Part | None = None
    earlier: Part | None = None
    for part in parts:
        if before is None or _breaks(before, part, lines[-1]):
            blank = before is not None and (part.item.breaks > 1 or _needs_blank(before, part))
            lines.append(Line([Placed(part)], blank))
        else:
            lines[-1].parts.append(Placed(part, space_between(earlier, before, part)))
        if before is not None and before.item.is_token:
            earlier = before
        before = part
    return lines


def _breaks(before: Part, part: Part, line: Line) -> bool:
    """Return whether a part begins a new line."""
    one, item = before.item, part.item
    if one.kind in ("//", REGIONS, EXCLUDED):
        return True
    if part.begin != Begin.NO and not one.is_token and "\n" in one.text:
        return True
    if part.begin == Begin.LINE:
        return item.breaks > 0 or any(placed.part.item.is_token for placed in line.parts)
    if part.begin == Begin.AS_WRITTEN:
        return item.breaks > 0
    if not item.breaks or (one.is_token and item.kind in ("SEMICOLON", "STRUCT", "UNION")):
        return False
    if item.kind in _HEAD_ENDS and one.is_token and _fits(line, item.text):
        return False
    return not (before.colon != Colon.NONE and item.kind == "LPAR")


def _fits(line: Line, word: str) -> bool:
    """Return whether a word fits behind a line that begins a statement."""
    if line.continues or any("\n" in placed.part.item.text for placed in line.parts):
        return False
    code = sum(placed.space + len(placed.part.item.text) for placed in line.parts)
    return INDENT * line.first.level + code + 1 + len(word) <= WIDTH


def _needs_blank(before: Part, part: Part) -> bool:
    """Return whether an empty line is added before a part: between two POUs."""
    return before.item.kind in _ENDS and part.item.kind in _UNITS


def place(lines: Sequence[Line]) -> None:
    """Set the column of each part.

    A line that continues a statement is aligned as in the source if the source has one of the usual
    alignments.
    """
    anchors = _Anchors()
    every = [placed for line in lines for placed in line.parts]
    following = {id(one): two.part for one, two in pairwise(every)}
    last: Placed | None = None
    for line in lines:
        first = line.parts[0]
        if line.continues:
            first.column = anchors.column(first.part)
        else:
            first.column = INDENT * _level(first.part, following.get(id(first)))
        for placed in line.parts:
            if placed is not first:
                assert last is not None
                placed.column = last.end + placed.space
            anchors.add(placed, first)
            last = placed


def _level(part: Part, following: Part | None) -> int:
    """Return the level of a line that begins a statement.

    A comment before ELSE, END or a label may be as deep as this word or as the block before it, as
    in the source.
    """
    item = part.item
    if following is None or item.is_token or not following.item.is_token:
        return part.level
    below = following.item.column == item.column
    return min(part.level, following.level) if below else part.level


class _Anchors:
    """Columns at which lines of a statement may be aligned, in source and result."""

    def __init__(self) -> None:
        #: Depth, column in the source, column in the result, and whether it ends with its argument.
        self._columns: list[tuple[int, int, int, bool]] = []
        #: For each open parenthesis: column of its line, and of the first part behind it.
        self._open: list[tuple[int, int | None]] = []
        self._before = ""
        self._start = (0, 0)

    def add(self, placed: Placed, first: Placed) -> None:
        """Read the next part."""
        part = placed.part
        item = part.item
        if part.begin != Begin.NO and item.is_token:
            self._columns, self._open = [], []
            self._start = (item.column, placed.column)
        elif self._before in _ALIGNED_BEHIND:
            depth, opened = len(self._open), self._before in _OPENING
            if self._before == "COMMA":
                self._columns = [one for one in self._columns if one[0] < depth or not one[3]]
            self._columns.append((depth, item.column, placed.column, not opened))
            if opened and placed is not first:
                self._open[-1] = (self._open[-1][0], placed.column)
        self._before = item.kind
        if item.kind in _OPENING:
            self._columns.append((len(self._open) + 1, item.column, placed.column, False))
            self._open.append((first.column, None))
        elif item.kind in _CLOSING and self._open:
            self._open.pop()
            self._columns = [one for one in self._columns if one[0] <= len(self._open)]

    def column(self, part: Part) -> int:
        """Return the column of the first part of a line that continues a statement."""
        item = part.item
        there, here = self._start
        if item.kind in _CLOSING and self._open and self._open[-1][1] is None:
            return self._open[-1][0]
        if item.kind in _HEAD_ENDS:
            return here
        for _, source, column, _ in reversed(self._columns):
            if item.column == source:
                return column
        offset = item.column - there
        if 0 < offset <= _FARTHEST and offset % INDENT == 0:
            return here + offset
        for _, source, column, _ in reversed(self._columns):
            if item.column == source + INDENT:
                return column + INDENT
        if not self._open:
            return here + INDENT
        line, behind = self._open[-1]
        return line + INDENT if behind is None else behind


def written(lines: Iterable[Line]) -> Iterator[str]:
    """Yield the lines as text."""
    for line in lines:
        if line.blank:
            yield ""
        texts, end = [], 0
        for placed in line.parts:
            texts += [" " * (placed.column - end), placed.text]
            end = placed.end
        yield "".join(texts)
