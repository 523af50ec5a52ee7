"""The controller's clock: date and time, running on virtual time."""

from __future__ import annotations

from datetime import date, datetime, time, timedelta

__all__ = ["Clock"]

_CENTURY = 2000  # only the lower two digits of a year go over the wire


class Clock:
    """It shows `start` at time 0 and goes on without power."""

    def __init__(self, start: str) -> None:
        self._zero = datetime.fromisoformat(start)

    def now(self, now_us: int) -> datetime:
        """Date and time at `now_us`, without fractions of a second."""
        return (self._zero + timedelta(microseconds=now_us)).replace(microsecond=0)

    def set_date(self, now_us: int, year: int, month: int, day: int) -> None:
        """Change the date; the time goes on.

        Args:
            now_us: When it is changed.
            year: Lower two digits of a year from 2000 on.
            month: 1 to 12.
            day: 1 to 31.

        Raises:
            ValueError: there is no such day.
        """
        shown = self._zero + timedelta(microseconds=now_us)
        self._set(now_us, datetime.combine(date(_CENTURY + year, month, day), shown.time()))

    def set_time(self, now_us: int, hour: int, minute: int, second: int) -> None:
        """Change the time, which begins with that second; the date stays."""
        today = self.now(now_us).date()
        self._set(now_us, datetime.combine(today, time(hour, minute, second)))

    def _set(self, now_us: int, moment: datetime) -> None:
        self._zero = moment - timedelta(microseconds=now_us)
