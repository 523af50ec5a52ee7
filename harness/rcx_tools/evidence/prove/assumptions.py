"""What the proofs take for granted of a user's program; each is said on the page."""

from __future__ import annotations

__all__ = ["ASSUMPTIONS"]

#: By name: one sentence.
ASSUMPTIONS = {
    "inner": "No program writes into RCX_REF: neither its part Inner nor the other fields.",
    "clock": "The PLC's clock never runs backwards; it counts less than 2^62 ns (146 years).",
    "area": "m, n, Size and ImageSize are constant over a run; ImageSize is not above the array.",
    "log": "LogSize is constant over a run and not above the array RCX_LOG.",
}
