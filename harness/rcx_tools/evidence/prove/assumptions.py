"""Assumptions of the proofs about a user's program; the page of the evidence lists each."""

from __future__ import annotations

__all__ = ["ASSUMPTIONS"]

#: One sentence by name.
ASSUMPTIONS = {
    "inner": "No program writes into RCX_REF: neither its part Inner nor the other fields.",
    "clock": "The PLC's clock never runs backwards; it counts less than 2^62 ns (146 years).",
    "calls": "Each robot has one FB_ReadArea (or ...Words) and one FB_WriteArea (or ...Words). A"
    " block instance belongs to one robot; none of core/ is called.",
    "missed": "No block is Busy and left uncalled for an exact multiple of 65,536 scans: the number"
    " of the scan, which is all that it sees of them, is then as if there had been none.",
    "waiters": "While a block that has no ticket yet waits for one, at most 32,767 turns begin: it"
    " gets none while 32,767 others have been taken since the turn began, or a reason is"
    " against it.",
    "counts": "A run has fewer than 2^45 scans, and fewer than 2^45 tickets (1,000 years of 1 ms).",
    "answers": "The controller answers a code and its reset as guide chapter 2 has it, each within"
    " a number of scans; the command has an end; the link has stood for Interval + Margin; no jog"
    " keeps SI(06) OFF. Of a block without a time limit and a controller that is silent nothing is"
    " promised.",
    "area": "m, n, Size and ImageSize are constant over a run; ImageSize is not above the array.",
    "log": "LogSize is constant over a run and not above the array RCX_LOG.",
    "table": "MovesSize is not above the array RCX_MOVES.",
}
