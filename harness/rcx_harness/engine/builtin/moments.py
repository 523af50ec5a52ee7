"""TIME and dates as text and in parts; all are held in nanoseconds."""

from __future__ import annotations

from datetime import datetime, timedelta

from rcx_harness.engine.frontend.scalars import NANOSECONDS_PER_DAY

__all__ = ["date_text", "day_of", "dt_text", "time_of", "time_text", "tod_text"]

_SECOND = 1_000_000_000


def day_of(moment: int) -> int:
    """Midnight of a DT, as a DATE."""
    return moment - moment % NANOSECONDS_PER_DAY


def time_of(moment: int) -> int:
    """Time of day of a DT, as a TOD."""
    return moment % NANOSECONDS_PER_DAY


def time_text(time: int) -> str:
    """A duration as `T#1d2h3m4s5.6ms`, down to the last part that is not zero."""
    sign, rest = ("-", -time) if time < 0 else ("", time)
    parts = []
    for size, unit in ((86_400, "d"), (3_600, "h"), (60, "m"), (1, "s")):
        amount, rest = divmod(rest, size * _SECOND)
        parts.append(f"{sign if amount else ''}{amount}{unit}")
        if not rest:
            return f"T#{''.join(parts)}"
    return f"T#{''.join(parts)}{sign}{rest / 1_000_000:g}ms"


def date_text(moment: int) -> str:
    """`D#2024-12-31`."""
    day = datetime(1970, 1, 1) + timedelta(days=moment // NANOSECONDS_PER_DAY)
    return f"D#{day:%Y-%m-%d}"


def tod_text(moment: int) -> str:
    """`TOD#13:30:00`, with six decimals where the seconds are not whole."""
    return f"TOD#{_clock(moment)}"


def dt_text(moment: int) -> str:
    """`DT#2024-12-31-13:30:00`, with six decimals where the seconds are not whole."""
    return f"DT#{date_text(moment)[2:]}-{_clock(moment)}"


def _clock(moment: int) -> str:
    seconds, rest = divmod(moment % NANOSECONDS_PER_DAY, _SECOND)
    minutes, second = divmod(seconds, 60)
    hour, minute = divmod(minutes, 60)
    shown = f"{second + rest / _SECOND:09.6f}" if rest else f"{second:02d}"
    return f"{hour:02d}:{minute:02d}:{shown}"
