"""A watchdog for processes with regular signs of life."""

from __future__ import annotations

from enum import Enum

__all__ = ["LIMIT_US", "Watchdog"]

LIMIT_US = 2_000_000
"""Longest time between two signs of life; a process gives one every 0.3 s."""


class Watchdog:
    """A watchdog for one process; the caller gives the time."""

    class Finding(Enum):
        """The result of a check by the watchdog."""

        SILENT = "silent"
        """The process has now been silent for too long."""
        BACK = "back"
        """The process has given a sign of life again."""

    def __init__(self, limit_us: int = LIMIT_US) -> None:
        self._limit_us = limit_us
        self._looked_us: int | None = None
        self._excused_us = 0
        self.silent_since_us: int | None = None

    def look(self, heard_us: int, now_us: int) -> Watchdog.Finding | None:
        """Evaluate the latest sign of life; call it at least twice within the limit.

        If the watchdog itself was not called for a long time, the measurement of the silence
        restarts, because the whole computer may have been asleep.

        `heard_us` is the time of the last sign of life; 0: none yet.

        Returns:
            The change since the last call; None without a change.
        """
        looked_us, self._looked_us = self._looked_us, now_us
        if looked_us is None or now_us - looked_us >= self._limit_us // 2:
            self._excused_us = now_us
        silent = bool(heard_us) and now_us - max(heard_us, self._excused_us) >= self._limit_us
        if silent and self.silent_since_us is None:
            self.silent_since_us = heard_us
            return self.Finding.SILENT
        if self.silent_since_us is not None and heard_us > self.silent_since_us:
            self.silent_since_us = None
            return self.Finding.BACK
        return None
