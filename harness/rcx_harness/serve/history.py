"""The last seconds of a controller, as lanes of a timing chart."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable

from rcx_harness.serve.status import Change
from rcx_harness.spec import signals
from rcx_harness.trace.chart import Lane

__all__ = ["History"]

_SKIPPED = 30  # of a change's four bytes the first two are bytes 0 and 1, then come 32 and 33


class History:
    """Keeps what changed within the last `kept_us`, and the state before that.

    Args:
        kept_us: How far back it reaches [us].
        most: Changes that are kept at most, so that memory stays bounded.
    """

    def __init__(self, kept_us: int = 60_000_000, most: int = 20_000) -> None:
        self._kept_us = kept_us
        self._most = most
        self._changes: deque[Change] = deque()
        self.now_us = 0

    def add(self, changes: Iterable[Change], now_us: int) -> None:
        """Take new changes, in order of time; it is `now_us`."""
        self._changes.extend(changes)
        self.now_us = max(self.now_us, now_us)
        kept = self._changes
        oldest = self.now_us - self._kept_us
        while len(kept) > 1 and (kept[1].t_us <= oldest or len(kept) > self._most):
            kept.popleft()

    def lanes(self) -> list[Lane]:
        """All dedicated signals, code, status and the connection, each with its changes."""
        table = signals()
        connection = Lane("Connection with the master", "event")
        code, status = Lane("Remote command code", "word"), Lane("Remote status", "word")
        inputs = [Lane(f"{one.signal} {one.title}", "input") for one in table.input]
        outputs = [Lane(f"{one.signal} {one.title}", "output") for one in table.output]
        for change in self._changes:
            si, so = bytes.fromhex(change.si), bytes.fromhex(change.so)
            _set(connection, change.t_us, int(change.connected))
            _set(code, change.t_us, int.from_bytes(si[:2], "little"))
            _set(status, change.t_us, int.from_bytes(so[:2], "little"))
            for lane, one in zip(inputs + outputs, table.input + table.output, strict=True):
                area = si if lane.kind == "input" else so
                _set(lane, change.t_us, area[one.byte - _SKIPPED] >> one.bit & 1)
        return [connection, *inputs, *outputs, code, status]


def _set(lane: Lane, t_us: int, value: int) -> None:
    if value != (lane.changes[-1][1] if lane.changes else 0):
        lane.changes.append((t_us, value))
