"""Assumptions that the proofs make about a user's program. The evidence page lists each."""

from __future__ import annotations

__all__ = ["ASSUMPTIONS"]

#: The sentence of each assumption, by name.
ASSUMPTIONS = {
    "inner": "No program writes into RCX_REF: neither its part Inner nor the other fields.",
    "clock": "The PLC's clock never runs backwards; it counts less than 2^62 ns (146 years).",
    "calls": "Each robot has one FB_ReadArea (or ...Words) and one FB_WriteArea (or ...Words). A "
    "block instance belongs to one robot; none of core/ is called.",
    "missed": "No block is Busy and left uncalled for an exact multiple of 65,536 scans. A block "
    "sees only the number of the scan, so it would not detect this gap.",
    "waiters": "While a block waits for a ticket, at most 32,767 turns begin. It gets no ticket "
    "while 32,767 other tickets have been taken since the turn began, or while an error prevents "
    "it.",
    "counts": "A run has fewer than 2^45 scans and fewer than 2^45 tickets (1,000 years with scans "
    "of 1 ms).",
    "answers": "The controller answers a code and its reset as in guide chapter 2, each within a "
    "number of scans; the command has an end; the link has been up for Interval + Margin; no jog "
    "holds SI(06) OFF. If a block has no time limit and the controller does not answer, nothing "
    "is proved.",
    "area": "m, n, Size and ImageSize are constant over a run; ImageSize does not exceed the "
    "array.",
    "log": "LogSize is constant over a run and does not exceed the array RCX_LOG.",
    "table": "MovesSize does not exceed the array RCX_MOVES.",
}
