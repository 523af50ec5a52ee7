"""Benches for the blocks FB_AxisArea and FB_WorkArea.

Each begins with a valid and recent position.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from alone import Alone


@cache
def _block(name: str, engine: str) -> Alone:
    return Alone(name, {}, engine)


class _Area:
    """An area block with a valid and recent position.

    A list that is too short is filled with zeros.
    """

    block = position = ""
    zero: float = 0

    def __init__(self, engine: str = "auto", **inputs: Any) -> None:
        self._block = _block(self.block, engine)
        self._block.restart()
        for name, value in {"PositionValid": True, "Age": "T#0ms", **inputs}.items():
            self[name] = value

    def __setitem__(self, pin: str, value: Any) -> None:
        long = [*value, *[self.zero] * (6 - len(value))] if isinstance(value, list) else value
        self._block[f"Block.{pin}"] = long

    def __getitem__(self, pin: str) -> Any:
        return self._block[f"Block.{pin}"]

    def at(self, *place: float) -> str:
        """Scan once with this position, and return `inside`, `outside` or `-` for neither."""
        self[self.position] = list(place)
        self._block.scan(0)
        assert not (self["Inside"] and self["Outside"])
        assert self["Error"] is (self["ErrorID"] != 0)
        return "inside" if self["Inside"] else "outside" if self["Outside"] else "-"


class AxisArea(_Area):
    """FB_AxisArea."""

    block, position = "FB_AxisArea", "Pulses"


class WorkArea(_Area):
    """FB_WorkArea."""

    block, position, zero = "FB_WorkArea", "PositionMm", 0.0
