"""The places of the vertical pieces of lines in the channel between two columns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Vertical", "tracks"]

#: Pieces in one channel for which all changes of the order are tried; more would take too long.
_MOST = 12


@dataclass(frozen=True)
class Vertical:
    """A vertical piece.

    Attributes:
        line: The number of its line.
        left: The rows in which the line goes on to the left.
        right: The rows in which it goes on to the right.
    """

    line: int
    left: tuple[int, ...]
    right: tuple[int, ...]

    @property
    def ends(self) -> tuple[int, int]:
        """Return the first and last row."""
        rows = (*self.left, *self.right)
        return min(rows), max(rows)


def tracks(pieces: Sequence[Vertical]) -> tuple[dict[int, int], int]:
    """Return the offset of each line's piece in the channel, and the width of the channel.

    Pieces in rows that are apart share a place. The order has few crossings.
    """
    if not pieces:
        return {}, 0
    order = sorted(pieces, key=lambda piece: (piece.ends, piece.line))
    better = len(order) <= _MOST
    while better:
        better = False
        for k in range(len(order) - 1):
            swapped = [*order[:k], order[k + 1], order[k], *order[k + 2 :]]
            if _crossings(swapped) < _crossings(order):
                order, better = swapped, True
    # Each piece stands right of all pieces before it in the order that overlap it.
    placed: list[tuple[Vertical, int]] = []
    for piece in order:
        track = max((at + 1 for other, at in placed if _near(piece, other)), default=0)
        placed.append((piece, track))
    return (
        {piece.line: 1 + 2 * track for piece, track in placed},
        3 + 2 * max(track for _, track in placed),
    )


def _near(one: Vertical, other: Vertical) -> bool:
    """Return whether two pieces overlap or would seem to be connected."""
    return one.ends[0] <= other.ends[1] + 1 and other.ends[0] <= one.ends[1] + 1


def _crossings(order: Sequence[Vertical]) -> int:
    """Return how often the lines of pieces cross that stand in this order from left to right."""
    count = 0
    for k, piece in enumerate(order):
        first, last = piece.ends
        for other in order[k + 1 :]:
            low, high = other.ends
            count += sum(first < row < last for row in other.left)
            count += sum(low < row < high for row in piece.right)
    return count
