"""The monitors of a cell as a part of explored states, without absolute times."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import Any

from rcx_harness.watch.contract import ContractMonitor
from rcx_harness.watch.wire import INTERVAL_US, WireMonitor
from structured_text.engines.base import Program

__all__ = ["Monitors"]

#: A counter of the wire monitor that no rule reads.
_COUNTS = "commands"
_TIME, _ABOUT = "_changed_us", "_changed_what"


class Monitors:
    """The monitors of an exploration: they check the protocol rules and the rules of the blocks."""

    def __init__(
        self, program: Program, size: int, scan_us: int, steady: Collection[str] = ()
    ) -> None:
        self._wire = WireMonitor(size)
        self._contract = ContractMonitor(program, steady)
        self._scan_us = scan_us

    def _items(self) -> Any:
        return self._wire.snapshot()

    def state(self, now_us: int = 0) -> tuple[Any, Any]:
        """Return the memory of both monitors after a scan at this time."""
        # With absolute times no state would ever recur. The
        # time of the last change is stored as its age. The command counter is set to 0,
        # because no rule reads it.
        held = dict(self._items())
        held[_COUNTS] = 0
        if held[_TIME] is not None:
            ago = now_us - held[_TIME]
            # An age of INTERVAL_US or more at the next scan has no effect, so such an age is not
            # stored.
            over = ago + self._scan_us >= INTERVAL_US
            held[_TIME], held[_ABOUT] = (None, "") if over else (ago, held[_ABOUT])
        same = tuple(value for value in held.values() if not isinstance(value, dict))
        pins: Any = self._contract.snapshot()
        return same, tuple(before for before, _ in pins)

    def go_to(self, state: Sequence[Any], now_us: int) -> None:
        """Restore the memory of both monitors. The next scan is at `now_us`."""
        same, pins = state
        items: Any = self._items()
        values = iter(same)
        held: dict[str, Any] = {
            name: value if isinstance(value, dict) else next(values) for name, value in items
        }
        if held[_TIME] is not None:
            held[_TIME] = now_us - self._scan_us - held[_TIME]
        self._wire.restore(tuple(held.items()))
        self._contract.restore([(before, ()) for before in pins])

    def scan(self, now_us: int, so: bytes, si: bytes, *, connected: bool) -> list[str]:
        """Check one scan, and return the messages about the rules that it broke."""
        found = self._wire.scan(now_us, 0, so, si, connected) + self._contract.scan(now_us, 0)
        return [one.text.removeprefix("plc, scan 0: ") for one in found]
