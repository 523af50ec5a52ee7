"""Assumptions that the proofs make about a user's program. The evidence page lists all of them."""

from __future__ import annotations

__all__ = ["ASSUMPTIONS"]

#: The sentence of each assumption, by name.
ASSUMPTIONS = {
    "inner": (
        "The program does not write into RCX_REF: neither into Inner nor into the other fields."
    ),
    "clock": (
        "The clock of the PLC never runs backwards, and it counts less than 2^62 ns (146 years)."
    ),
    "calls": (
        "Each robot has exactly one FB_ReadArea (or FB_ReadAreaWords) and one FB_WriteArea (or "
        "FB_WriteAreaWords). An instance of a block belongs to one robot. The program calls no "
        "block of core/ itself."
    ),
    "missed": (
        "No block stays Busy without a call for an exact multiple of 65,536 scans. A block "
        "compares only the numbers of the scans, so it would not detect such a gap."
    ),
    "waiters": (
        "While a block waits with a ticket, at most 32,767 turns begin. A block gets no ticket if "
        "32,767 other tickets have been taken since the current turn began, or while an error "
        "prevents its start."
    ),
    "counts": "A run has fewer than 2^45 scans and fewer than 2^45 tickets (1,000 years with scans "
    "of 1 ms).",
    "answers": (
        "The controller answers a code and its reset as in guide chapter 2, each within a number "
        "of scans. The command ends. The link has been up for Interval + Margin. No jog holds "
        "SI(06) OFF. If a block has no time limit and the controller does not answer, nothing is "
        "proved."
    ),
    "area": (
        "m, n, Size and ImageSize are constant during a run, and ImageSize does not exceed the "
        "array."
    ),
    "log": "LogSize is constant during a run and does not exceed the array RCX_LOG.",
    "table": "MovesSize does not exceed the array RCX_MOVES.",
}
