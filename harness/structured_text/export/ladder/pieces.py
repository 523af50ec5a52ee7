"""The statements of a POU with their text, their comments and their places."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from structured_text.export.parts import Part, plain
from structured_text.language import syntax as s
from structured_text.language.lexer import tokens
from structured_text.language.parser import parse_text

__all__ = ["Piece", "pieces_of"]

_COMMENT = re.compile(r"\(\*(.*?)\*\)", re.DOTALL)
_OPENING = ("IF", "CASE", "FOR", "WHILE", "REPEAT")


@dataclass(frozen=True)
class Piece:
    """A statement that is not inside another statement.

    Attributes:
        node: The statement; its positions are places in `source`.
        source: The text of the POU.
        begin: Where the statement and the comments before it begin in `source`.
        start: Where the statement itself begins.
        end: Where the statement ends, with the comments behind it on the same line.
        comment: The text of these comments, and of those inside a call or an assignment.
        line: The line of the user's file.
        shift: The line of the user's file for line 0 of `source`.
    """

    node: s.Statement
    source: str
    begin: int
    start: int
    end: int
    comment: str
    line: int
    shift: int


def pieces_of(part: Part) -> list[Piece]:
    """Return the statements of a POU in their order."""
    assert isinstance(part.node, s.Pou)
    head = f"{part.head}\n"
    source = f"{head}{part.body}\nEND_{part.kind}"
    (pou,) = parse_text(source, part.file).declarations
    assert isinstance(pou, s.Pou)
    shift = part.line - head.count("\n") - 1
    found, end = [], len(head)
    for node, (start, stop) in zip(pou.body, _places(source, part.file, len(head)), strict=True):
        stop = _with_remark(source, stop)
        comment = "\n".join(plain(said[1]) for said in _COMMENT.finditer(source[end:stop]))
        line = source.count("\n", 0, start) + 1 + shift
        found.append(Piece(node, source, end, start, stop, comment, line, shift))
        end = stop
    return found


def _places(source: str, file: Path, begin: int) -> list[tuple[int, int]]:
    """Return where each statement begins and ends; empty statements are left out."""
    places, depth, start = [], 0, None
    for token in tokens(source, file):
        at = token.start_pos or 0
        kind = str(token.type)
        if at < begin or kind.startswith(("END_PROGRAM", "END_FUNCTION")):
            continue
        if start is None and kind != "SEMICOLON":
            start = at
        depth += (kind in _OPENING) - (kind in [f"END_{word}" for word in _OPENING])
        if kind == "SEMICOLON" and not depth and start is not None:
            places.append((start, at + 1))
            start = None
    return places


def _with_remark(source: str, stop: int) -> int:
    """Return the end of a statement with the comments behind it on its line."""
    found = re.compile(r"[ \t]*\(\*.*?\*\)(?=[ \t]*$)", re.DOTALL | re.MULTILINE)
    match = found.match(source, stop)
    return match.end() if match is not None else stop
