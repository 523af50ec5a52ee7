"""Helpers that write Structured Text as a list of lines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from functools import cache

from rcx_harness import spec
from structured_text.output.toml_files import load_toml

__all__ = ["WIDTH", "case", "guarded", "indent", "loop", "named", "real", "statement", "word"]

WIDTH = 100

_ERROR = re.compile(r"\bWORD#16#(80[0-9A-F]{2})\b")


def word(value: int) -> str:
    """Return a number as WORD literal of Structured Text."""
    return f"WORD#16#{value:04X}"


def real(value: float) -> str:
    """Return a number as REAL literal of Structured Text."""
    return repr(float(value))


@cache
def _errors() -> dict[str, str]:
    rows = load_toml(spec.folder() / "errors.toml")["error"]
    return {f"{row['id']:04X}": row["name"] for row in rows}


def named(line: str) -> str:
    """Return a line of ST with a comment that contains the names of its ErrorIDs."""
    found = [_errors()[one] for one in _ERROR.findall(line) if one in _errors()]
    return f"{line} (* {', '.join(found)} *)" if found else line


def indent(lines: Iterable[str], by: int = 1) -> list[str]:
    """Return the lines with two more spaces of indentation."""
    return [f"{'  ' * by}{line}" for line in lines]


def statement(text: str, at: int = 0) -> list[str]:
    """Return a statement as lines. They are broken before AND and OR, otherwise after commas.

    Args:
        text: The statement as one line.
        at: Indentation that will be added later, in steps of two spaces.
    """
    room = WIDTH - 2 * at
    lines = [""]
    for part in text.replace(" AND ", "\0 AND ").replace(" OR ", "\0 OR ").split("\0"):
        pieces = [part] if len(part) + 4 <= room else part.replace(", ", ",\0 ").split("\0")
        for piece in pieces:
            if lines[-1] and len(lines[-1]) + len(piece) > room:
                lines.append(f"    {piece.strip()}")
            else:
                lines[-1] += piece
    return lines


def guarded(condition: str, lines: Sequence[str], at: int = 0) -> list[str]:
    """Return the lines inside of `IF condition THEN`.

    If the condition is empty, return only the lines.
    """
    if not condition:
        return list(lines)
    return [*statement(f"IF {condition} THEN", at), *indent(lines), "END_IF;"]


def loop(count: int, lines: Sequence[str]) -> list[str]:
    """Return a loop of the lines for k from 1 to `count`."""
    return ["k := 1;", f"WHILE k <= {count} DO", *indent([*lines, "k := k + 1;"]), "END_WHILE;"]


def case(selector: str, branches: Sequence[tuple[str, str]], comment: str = "") -> list[str]:
    """Return a CASE with one statement in each branch. For a single branch return an IF.

    Args:
        selector: The expression that is compared.
        branches: Label and statement of each branch.
        comment: Comment about values without a branch.
    """
    if not branches:
        return []
    if len(branches) == 1:
        return guarded(f"{selector} = {branches[0][0]}", [branches[0][1]])
    rows = [f"{label}: {text}" for label, text in branches]
    return [f"CASE {selector} OF", *indent(rows), f"END_CASE; {comment}".rstrip()]
