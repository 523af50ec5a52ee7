"""The constructs that a PLC tool refuses, as text: grouped by kind, with their places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby

from rcx_harness.cli.options import counted
from structured_text.errors import place_text
from structured_text.export.refused import Refusal

__all__ = ["grouped"]

#: Greatest number of lines of a kind, and of places in a line.
_LINES, _PLACES = 6, 6


def grouped(found: Sequence[Refusal]) -> list[str]:
    """Return the lines of a report: certain refusals first, then the most frequent kinds.

    Places in one file with the same detail share a line.
    """
    kinds: dict[tuple[bool, str], list[Refusal]] = {}
    for one in found:
        kinds.setdefault((one.certain, one.kind), []).append(one)
    lines: list[str] = []
    for (certain, kind), those in sorted(
        kinds.items(), key=lambda item: (not item[0][0], -len(item[1]), item[0][1])
    ):
        label = "refused" if certain else "may be refused"
        lines.append(f"{label} in {counted(len(those), 'place')}: {kind}")
        lines += _places(those)
    return lines


def _places(those: Sequence[Refusal]) -> Iterator[str]:
    """Yield a line for each file and detail of a kind, and how many places are left out."""
    left = len(those)
    shared = groupby(sorted(those, key=lambda one: (*_line(one), one.at)), key=_line)
    for number, ((_, network, detail), group) in enumerate(shared):
        if number == _LINES:
            yield f"  ... and {counted(left, 'more place')}: --json lists all"
            return
        first, *others = group
        left -= 1 + len(others)
        text = place_text(first.file, first.at.line, first.at.column)
        shown = [] if network else others[: _PLACES - 1]
        text += "".join(f", {place_text(None, *one.at)}" for one in shown)
        if len(others) > len(shown):
            text += f" and {len(others) - len(shown)} more"
        yield f"  {text}{f': {detail}' if detail else ''}"


def _line(one: Refusal) -> tuple[str, str, str]:
    """Return the key of the places that share a line; the rungs of a drawing do not."""
    return str(one.file), str(getattr(one.at.line, "place", "")), one.detail
