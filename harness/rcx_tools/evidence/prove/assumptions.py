"""What the proofs take for granted of a user's program; each is said on the page."""

from __future__ import annotations

__all__ = ["ASSUMPTIONS"]

#: By name: one sentence.
ASSUMPTIONS = {
    "inner": "No program writes into RCX_REF: neither its part Inner nor the other fields.",
    "clock": "The PLC's clock never runs backwards; it counts less than 2^62 ns (146 years).",
    "turn": "A job that keeps its turn from scan to scan has the ticket that is served"
    " (of the library: property tickets).",
    "between": "Each robot has one FB_ReadArea (or ...Words) and one FB_WriteArea (or ...Words);"
    " all other blocks are called between the two, and none of core/ is called.",
    "area": "m, n, Size and ImageSize are constant over a run; ImageSize is not above the array.",
}
