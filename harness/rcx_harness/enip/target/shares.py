"""A limited number of places, of which no address can take all."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable

__all__ = ["has_room"]

_KEPT_PART = 8


def has_room(taken: Iterable[str], peer: str, places: int, of_peer: int) -> bool:
    """May this address take one more place?

    Args:
        taken: The address of each place that is taken.
        peer: The address that asks.
        places: How many there are; the last eighth is for addresses that have none yet.
        of_peer: How many one address may have.
    """
    count = Counter(taken)
    own = count[peer]
    kept = places // _KEPT_PART if own else 0
    return own < of_peer and count.total() < places - kept
