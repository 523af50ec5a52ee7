"""Columns that several lines share: colons, assignments, and comments behind the code.

An alignment of the source remains if it is consistent. Otherwise colons and comments of
declarations get the first column that is free in all lines of their paragraph. A paragraph ends at
an empty line.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from operator import attrgetter

from structured_text.editor.format.lines import WIDTH, Line, Placed
from structured_text.editor.format.structure import Colon

__all__ = ["align", "align_comments"]

#: Distance of a comment from the code before it [columns].
_GAP = 2
_GIVES = ("ASSIGN", "SENDTO")


@dataclass
class _Cell:
    """A part of a line that may be aligned with parts of other lines.

    Attributes:
        placed: The part.
        least: Its first free column, counted from the beginning of the line.
        source: Its column in the source, counted in the same way.
    """

    placed: Placed
    least: int
    source: int


def align(lines: Sequence[Line]) -> None:
    """Align the colons of declarations. Retain aligned assignments."""
    for group in _groups(lines, _colon):
        _set(group, _shared(group) or max(cell.least for cell in group))
    for find in (_declared_value, _assignment, _argument):
        for group in _groups(lines, find):
            for _, equal in groupby(group, attrgetter("source")):
                run = list(equal)
                column = _shared(run) if len(run) > 1 else None
                _set(run, column if column is not None else 0)


def _set(group: Sequence[_Cell], column: int) -> None:
    for cell in group:
        cell.placed.space += max(0, column - cell.least)


def _shared(group: Sequence[_Cell]) -> int | None:
    """Return the column that all cells have in the source; None if it is not free in all lines."""
    columns = {cell.source for cell in group}
    column = columns.pop()
    if columns or column < max(cell.least for cell in group):
        return None
    return column


def _groups(lines: Sequence[Line], find: Callable[[Line], Placed | None]) -> Iterator[list[_Cell]]:
    """Yield the cells of each paragraph; lines of comments do not divide it."""
    group: list[_Cell] = []
    before = (0, 0)
    for line in lines:
        cell = _cell(line, find)
        level = line.first.level, line.first.depth
        if group and (line.blank or _divides(line, cell) or (cell and level != before)):
            yield group
            group = []
        if cell is not None:
            group.append(cell)
            before = level
    if group:
        yield group


def _divides(line: Line, cell: _Cell | None) -> bool:
    return cell is None and line.first.item.is_token and not line.continues


def _cell(line: Line, find: Callable[[Line], Placed | None]) -> _Cell | None:
    found = find(line)
    if found is None:
        return None
    origin = line.first.item.column
    at = 0
    for placed in line.parts:
        if placed is not line.parts[0]:
            if placed.part.item.breaks:
                return None
            at += placed.space
        if placed is found:
            return _Cell(placed, at, placed.part.item.column - origin)
        if "\n" in placed.part.item.text:
            return None
        at += len(placed.part.item.text)
    return None


def _colon(line: Line) -> Placed | None:
    """Return the colon of a line with a single declaration."""
    found = [placed for placed in line.parts if placed.part.colon == Colon.DECLARED]
    located = any(placed.part.item.kind == "AT" for placed in line.parts)
    return found[0] if len(found) == 1 and not line.continues and not located else None


def _declared_value(line: Line) -> Placed | None:
    """Return the sign before the initial value in a line with a single declaration."""
    return _assigned(line) if _colon(line) is not None else None


def _assignment(line: Line) -> Placed | None:
    """Return the sign of an assignment that begins in the line."""
    declares = any(placed.part.declares for placed in line.parts)
    if declares or line.continues or line.first.item.kind not in ("IDENT", "THIS"):
        return None
    return _assigned(line)


def _argument(line: Line) -> Placed | None:
    """Return the sign behind the name of an argument that begins the line."""
    if not line.continues or len(line.parts) < 2 or line.parts[1].part.item.kind not in _GIVES:
        return None
    return line.parts[1]


def _assigned(line: Line) -> Placed | None:
    """Return the first sign of an assignment outside of parentheses."""
    found = (one for one in line.parts if one.part.item.kind == "ASSIGN" and not one.part.depth)
    return next(found, None)


def align_comments(lines: Sequence[Line]) -> None:
    """Set the columns of comments behind the code.

    Comments of declarations share a column. A comment that would be too long there stands directly
    behind its code. Behind statements, comments remain in their columns as far as possible.
    """
    group: list[list[_Row]] = []
    alone = False
    for line in lines:
        declares = any(placed.part.declares for placed in line.parts)
        if group and (line.blank or not (declares or not line.first.item.is_token)):
            _align_group(group)
            group = []
        if line.trailing is None:
            alone = True
        elif declares:
            if alone or not group:
                group.append([])
            group[-1].append(_Row.of(line))
            alone = False
        else:
            _retain(line)
    if group:
        _align_group(group)
    for before, line in pairwise(lines):
        comment, item = before.trailing or _below(before), line.first.item
        if comment is None or not item.is_comment or item.breaks != 1:
            continue
        if item.column == comment.part.item.column:
            line.parts[0].column = comment.column


def _below(line: Line) -> Placed | None:
    return line.parts[0] if line.first.item.is_comment else None


def _retain(line: Line) -> None:
    comment = line.trailing
    assert comment is not None
    item, end = comment.part.item, line.parts[-2].end
    comment.column = item.column
    if item.breaks or item.column <= end:
        comment.column = end + min(max(item.gap, 1), _GAP)


def _align_group(runs: Sequence[Sequence[_Row]]) -> None:
    """Set the columns of the comments of a paragraph of declarations.

    Each run has the comments of successive lines.
    """
    rows = [row for run in runs for row in run]
    if all(_is_aligned(run) for run in runs):
        for row in rows:
            row.comment.column = row.source
        return
    fits = [row.end + _GAP for row in rows if row.end + _GAP + row.length <= WIDTH]
    column = max(fits, default=0)
    for row in rows:
        row.comment.column = column
        if row.end + _GAP > column or column + row.length > WIDTH:
            row.comment.column = row.end + _GAP


@dataclass
class _Row:
    """A line of a declaration with a comment.

    Attributes:
        comment: The comment.
        source: The column of the comment in the source; -1 if it was on another line.
        end: The column behind the code.
        length: Length of the first line of the comment.
    """

    comment: Placed
    source: int
    end: int
    length: int

    @classmethod
    def of(cls, line: Line) -> _Row:
        comment = line.trailing
        assert comment is not None
        item = comment.part.item
        source = -1 if item.breaks else item.column
        return cls(comment, source, line.parts[-2].end, len(item.text.partition("\n")[0]))

    def is_beside(self, column: int, often: bool) -> bool:
        """Return whether a comment that is not in the column has an allowed place beside it.

        It may be directly behind the code, or end where lines end.
        """
        if 1 <= self.source - self.end <= _GAP:
            return often or self.end + _GAP > column or column + self.length >= WIDTH
        return self.source > self.end and self.source + self.length == WIDTH


def _is_aligned(rows: Sequence[_Row]) -> bool:
    """Return whether the comments of successive lines are aligned in the source."""
    columns = Counter(row.source for row in rows if row.source > row.end)
    return any(
        all(row.source == column > row.end or row.is_beside(column, number > 1) for row in rows)
        for column, number in columns.items()
    )
