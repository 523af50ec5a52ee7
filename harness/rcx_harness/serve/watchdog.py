"""Says when a process that should show its life regularly stands still, and when it goes on."""

from __future__ import annotations

from enum import Enum

__all__ = ["LIMIT_US", "Watchdog"]

LIMIT_US = 2_000_000
"""A process that has not shown its life for so long stands still; each does so every 0.3 s."""


class Watchdog:
    """Watches one process; no clock of its own.

    Args:
        limit_us: Longest silence.
    """

    class Finding(Enum):
        """What a look finds."""

        SILENT = "silent"
        """It has just been silent for too long."""
        BACK = "back"
        """It is heard again."""

    def __init__(self, limit_us: int = LIMIT_US) -> None:
        self._limit_us = limit_us
        self._looked_us: int | None = None
        self._excused_us = 0
        self.silent_since_us: int | None = None

    def look(self, heard_us: int, now_us: int) -> Watchdog.Finding | None:
        """Take what is known now; at least two looks are needed within the limit.

        If the watcher itself has stood still, the silence begins anew: the whole computer may have
        been asleep.

        Args:
            heard_us: When it was heard last; 0: it has not begun yet.
            now_us: Now, by the same clock.

        Returns:
            What has changed since the last look; None if nothing has.
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
