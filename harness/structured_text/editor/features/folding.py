"""Folding: POUs, sections, statements with an END, comments and regions."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import Index
from structured_text.editor.structure import regions_of, walked
from structured_text.editor.texts import Text, document

__all__ = ["folding"]

_Kind = lsp.FoldingRangeKind
#: A pragma that begins or ends a region, and the words of TIA Portal.
_MARK = re.compile(
    r"\{\s*(end)?_?region\b[^}]*\}|^[ \t]*(END_)?REGION\b", re.IGNORECASE | re.MULTILINE
)


def folding(index: Index, path: Path | str, text: str) -> list[lsp.FoldingRange]:
    """Return the parts of a file that an editor can fold, by their first line."""
    del index  # folding follows the text while somebody is typing
    whole = document(text, str(path))
    found = [*_regions(whole), *_comments(whole), *_marked(whole)]
    unique = {(one.start_line, one.end_line): one for one in reversed(found)}
    return sorted(unique.values(), key=lambda one: (one.start_line, -one.end_line))


def _regions(text: Text) -> Iterator[lsp.FoldingRange]:
    for one in walked(regions_of(text)):
        begins = [one.begin, *one.splits]
        ends = [*one.splits, one.end]
        for number, (begin, end) in enumerate(zip(begins, ends, strict=True)):
            # The line with ELSE or END remains visible.
            closed = number < len(one.splits) or one.is_closed
            first, last = _line(text, begin), _line(text, end) - closed
            if last > first:
                yield lsp.FoldingRange(first, last)


def _comments(text: Text) -> Iterator[lsp.FoldingRange]:
    """Yield comments of several lines, and comments with // in consecutive lines."""
    begin = last = -1
    for first, behind in text.comments:
        line, end = _line(text, first), _line(text, behind)
        alone = not text.code[text.offset(text.at(first)._replace(column=1)) : first].strip()
        if alone and begin >= 0 and line == last + 1:
            last = end
            continue
        if last > begin >= 0:
            yield lsp.FoldingRange(begin, last, kind=_Kind.Comment)
        begin, last = (line, end) if alone or end > line else (-1, -1)
    if last > begin >= 0:
        yield lsp.FoldingRange(begin, last, kind=_Kind.Comment)


def _marked(text: Text) -> Iterator[lsp.FoldingRange]:
    """Yield the regions that pragmas mark."""
    waiting: list[int] = []
    for match in _MARK.finditer(text.code):
        line = _line(text, match.end() - 1)
        if not (match[1] or match[2]):
            waiting.append(line)
        elif waiting:
            yield lsp.FoldingRange(waiting.pop(), line, kind=_Kind.Region)


def _line(text: Text, offset: int) -> int:
    """Return the line of an offset, from 0."""
    return text.at(offset).line - 1
