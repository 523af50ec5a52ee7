"""The comment of a declaration: behind it on its line, or in the lines above it."""

from __future__ import annotations

import re

from structured_text.editor.texts import Text
from structured_text.language.syntax import Position

__all__ = ["comment_of"]

_SIGNS = re.compile(r"\A(?://+|\(\*+|/\*+)|(?:\*+\)|\*+/)\Z")
#: The star that begins each line of a comment such as the head of a file.
_STAR = re.compile(r"^\s*\*(?!\))\s?", re.MULTILINE)


def comment_of(text: Text, at: Position) -> str:
    """Return the comment of the declaration at a position, without its signs; else empty.

    A comment behind the declaration comes first. A comment above it counts if only white space and
    pragmas are between the two, and if no code is in front of the comment.
    """
    return _behind(text, at) or _above(text, at)


def _behind(text: Text, at: Position) -> str:
    begin = text.offset(at)
    end = text.offset(Position(at.line, 1 << 20))
    for first, last in text.comments:
        if begin < first <= end and not text.plain[last:end].strip():
            return _shown(text.code[first:last])
    return ""


def _above(text: Text, at: Position) -> str:
    found: list[str] = []
    below = text.offset(Position(at.line, 1))
    for first, last in reversed(text.comments):
        if last > below:
            continue
        between = text.code[last:below]
        if re.sub(r"\{[^}]*\}", "", between).strip() or between.count("\n") > _lines(between):
            break
        line = text.offset(Position(text.at(first).line, 1))
        if text.plain[line:first].strip():
            break
        found.insert(0, _shown(text.code[first:last]))
        below = line
    return "\n".join(found)


def _lines(between: str) -> int:
    """Return the number of line ends that may stand between a comment and its declaration."""
    return 1 + sum(1 for line in between.split("\n") if line.strip())


def _shown(comment: str) -> str:
    inside = _SIGNS.sub("", comment.strip())
    lines = [line.strip() for line in _STAR.sub("", inside).split("\n")]
    return "\n".join(lines).strip()
