"""The functions that generated code calls: PLC arithmetic, conversions, shifts and strings."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from ctypes import c_float
from datetime import date, datetime, timedelta
from types import FunctionType
from typing import Any, NoReturn

from structured_text.language.arithmetic import quotient, remainder
from structured_text.language.scalars import (
    NANOSECONDS_PER_DAY,
    STRING_MAX,
    LiteralError,
    typed_literal,
)
from structured_text.language.system import EXCEPTION_CODES

__all__ = ["FAULTS", "FUSE", "NAMES", "MemoryAccessError", "ProgramError"]

#: Number of rounds after which a loop counts as endless, because no PLC runs as many in a scan.
FUSE = range(1_000_000)

_SECOND = 1_000_000_000


class ProgramError(Exception):
    """An error of the user's program that occurs at run time.

    `code` is its number in __SYSTEM.ExceptionCode.
    """

    code = EXCEPTION_CODES["UNKNOWN"]


class MemoryAccessError(ProgramError):
    """An access through a pointer, reference or interface that refers to no suitable memory."""

    code = EXCEPTION_CODES["ACCESS_VIOLATION"]


class _BoundsError(ProgramError):
    """An index outside an array."""

    code = EXCEPTION_CODES["ARRAYBOUNDS"]


class _EndlessError(ProgramError):
    """The error of a loop without an end; on a controller no `__TRY` catches it."""


#: The errors of a program, which the generated code catches in `__TRY`.
FAULTS = (ArithmeticError, ValueError, ProgramError, RecursionError)


def _caught(error: Exception) -> int:
    """Return the number of an error for `__CATCH(code)`; raise an error that cannot be caught."""
    if isinstance(error, (_EndlessError, RecursionError)):
        raise error
    if isinstance(error, ProgramError):
        return error.code
    if isinstance(error, ZeroDivisionError):
        real = str(error).startswith("float")
        return EXCEPTION_CODES["FPU_DIVIDEBYZERO" if real else "DIVIDEBYZERO"]
    return EXCEPTION_CODES[
        "FPU_OVERFLOW" if isinstance(error, OverflowError) else "FPU_INVALID_OPERATION"
    ]


def _f_raiseexception(code: int) -> NoReturn:
    error = ProgramError(f"the program raises exception 16#{code:X}, and no __TRY catches it")
    error.code = code
    raise error


def _member_text(names: dict[int, str], value: int) -> str:
    return names.get(value, str(value))


def _endless() -> NoReturn:
    raise _EndlessError(f"this loop has not ended after {len(FUSE)} rounds")


def _inside(index: int, low: int, high: int) -> int:
    if low <= index <= high:
        return index
    raise _BoundsError(f"index {index} is outside {low}..{high}")


def _started(block: Any, values: tuple[tuple[str, Any], ...]) -> Any:
    """Set some variables of a new block to the initial values of a declaration.

    Return the block.
    """
    for slot, value in values:
        setattr(block, slot, value)
    return block


class _Uncalled:
    """The value of a block's VAR_IN_OUT before the first call; each use raises ProgramError."""

    __slots__ = ()

    def _refuse(self, *_: Any) -> NoReturn:
        raise ProgramError("a method uses a VAR_IN_OUT of its block before the block is called")

    __getattr__ = __setattr__ = __getitem__ = __setitem__ = __iter__ = _refuse


class _Open:
    """An array of open length: the elements, and the bounds of each dimension."""

    __slots__ = ("bounds", "held")

    def __init__(self, held: list[Any], bounds: tuple[tuple[int, int], ...]) -> None:
        self.held, self.bounds = held, bounds

    def bound(self, dimension: int, upper: int) -> int:
        return self.bounds[dimension - 1][upper]

    def position(self, *indices: int) -> int:
        place = 0
        for index, (low, high) in zip(indices, self.bounds, strict=True):
            place = place * (high - low + 1) + _inside(index, low, high) - low
        return place


def _ended(text: str) -> str:
    """Return a text up to its first character 0."""
    return text.partition("\0")[0] if "\0" in text else text


def _filled(target: Any, value: Any) -> None:
    """Copy the value of a structure or array into another object; its inner objects remain."""
    if isinstance(target, list):
        for place, item in enumerate(value):
            if isinstance(item, list) or hasattr(item, "__slots__"):
                _filled(target[place], item)
            else:
                target[place] = item
        return
    for slot in target.__slots__:
        item = getattr(value, slot)
        if isinstance(item, list) or hasattr(item, "__slots__"):
            _filled(getattr(target, slot), item)
        else:
            setattr(target, slot, item)


def _f32(value: float) -> float:
    return c_float(value).value


def _to_unsigned(value: float) -> int:
    """Return the nearest whole number of a real; 0 for a negative real."""
    return round(value) if value >= 0 else 0


def _real_by(dividend: float, divisor: float) -> float:
    """Divide two reals as IEEE 754 does; the divisor may be 0."""
    if divisor:
        return dividend / divisor
    if not dividend or math.isnan(dividend):
        return math.nan
    return math.copysign(math.inf, dividend) * math.copysign(1.0, divisor)


def _root_nan(value: float) -> float:
    return math.nan if value < 0 else math.sqrt(value)


def _root_absolute(value: float) -> float:
    return math.sqrt(abs(value))


def _time_times(time: int, factor: float) -> int:
    return math.trunc(time * factor)


def _time_by(time: int, divisor: float) -> int:
    return math.trunc(time / divisor)


def _shl(value: int, count: int, mask: int) -> int:
    if count < 0:
        raise ProgramError(f"the shift count {count} is negative")
    return value << count & mask if count < 64 else 0


def _shr(value: int, count: int) -> int:
    if count < 0:
        raise ProgramError(f"the shift count {count} is negative")
    return value >> count


def _rol(value: int, count: int, bits: int) -> int:
    count %= bits
    return (value << count | value >> bits - count) & (1 << bits) - 1


def _limit(low: Any, value: Any, high: Any) -> Any:
    """Return MIN(MAX(value, low), high), which the standard also defines for low above high."""
    least = value if value > low else low
    return least if least < high else high


def _mux(index: int, *values: Any) -> Any:
    if not 0 <= index < len(values):
        raise ProgramError(f"MUX selects input {index}, but has inputs 0 to {len(values) - 1}")
    return values[index]


# --- strings: the first position is 1 ---


def _length(count: int) -> int:
    if count < 0:
        raise ProgramError(f"a STRING function has the negative length or position {count}")
    return count


def _left(text: str, count: int) -> str:
    return text[: _length(count)]


def _right(text: str, count: int) -> str:
    return text[max(len(text) - _length(count), 0) :]


def _mid(text: str, count: int, position: int) -> str:
    start = _position(position)
    return text[start : start + _length(count)]


def _position(position: int) -> int:
    if position < 1:
        raise ProgramError(f"a STRING function has position {position}, but positions begin at 1")
    return position - 1


def _concat(*texts: str, most: int = STRING_MAX) -> str:
    return "".join(texts)[:most]


def _insert(text: str, other: str, position: int, most: int = STRING_MAX) -> str:
    at = _length(position)
    return (text[:at] + other + text[at:])[:most]


def _delete(text: str, count: int, position: int) -> str:
    at = _position(position)
    return text[:at] + text[at + _length(count) :]


def _replace(text: str, other: str, count: int, position: int, most: int = STRING_MAX) -> str:
    at = _position(position)
    return (text[:at] + other + text[at + _length(count) :])[:most]


def _find(text: str, other: str) -> int:
    return text.find(other) + 1 if other else 0


_BASED = re.compile(r"(2|8|16)#([0-9A-Fa-f_]+)")
_WHOLE = re.compile(r"\s*([-+]?)([0-9][0-9_]*)")
_DECIMAL = re.compile(r"\s*[-+]?[0-9]*\.[0-9]*(?:[eE][-+]?[0-9]+)?")


def _string_to_int(text: str) -> int:
    """Return the number at the start of a text, in decimal or as 16#..; 0 if there is none."""
    based = _BASED.match(text)
    if based is not None:
        try:
            return int(based[2].replace("_", ""), int(based[1]))
        except ValueError:
            return 0
    whole = _WHOLE.match(text)
    if whole is None:
        return 0
    return int(whole[2].replace("_", "")) * (-1 if whole[1] == "-" else 1)


def _string_to_real(text: str) -> float:
    found = _DECIMAL.match(text)
    if found is None:
        return float(_string_to_int(text))
    try:
        return float(found.group())
    except ValueError:
        return 0.0


def _string_to_bool(text: str) -> bool:
    return text.upper() in ("1", "TRUE")


def _string_to_moment(text: str, name: str) -> int:
    """Return the duration or date that a text represents as a literal; 0 for any other text."""
    short = name.removeprefix("L")
    try:
        kind, value = typed_literal(text if "#" in text else f"{name}#{text}")
    except (KeyError, LiteralError):
        return 0
    return int(value) if kind.name.removeprefix("L") == short else 0


def _narrow(text: str) -> str:
    """Return a wide text as a STRING, with `?` for each character that a STRING cannot hold."""
    return text.encode("latin-1", "replace").decode("latin-1")


def _first(text: str) -> str:
    return text[:1] or "\0"


def _to_bcd(value: int, digits: int) -> int:
    if not 0 <= value < 10**digits:
        raise ProgramError(f"{value} is not a number of {digits} BCD digits")
    return int(str(value), 16)


def _from_bcd(value: int) -> int:
    digits = f"{value:x}"
    if not digits.isdigit():
        raise ProgramError(f"16#{digits} is not a BCD number")
    return int(digits)


# --- the calendar ---


def _concat_date(year: int, month: int, day: int) -> int:
    try:
        days = (date(year, month, day) - date(1970, 1, 1)).days
    except ValueError:
        raise ProgramError(f"there is no date {year}-{month:02d}-{day:02d}") from None
    return days * NANOSECONDS_PER_DAY


def _concat_tod(hour: int, minute: int, second: int, millisecond: int) -> int:
    parts = ((hour, 24), (minute, 60), (second, 60), (millisecond, 1000))
    if not all(0 <= value < limit for value, limit in parts):
        shown = f"{hour:02d}:{minute:02d}:{second:02d}.{millisecond:03d}"
        raise ProgramError(f"there is no time of day {shown}")
    return ((hour * 60 + minute) * 60 + second) * _SECOND + millisecond * 1_000_000


def _concat_dt(
    year: int, month: int, day: int, hour: int, minute: int, second: int, millisecond: int
) -> int:
    return _concat_date(year, month, day) + _concat_tod(hour, minute, second, millisecond)


def _day_of_week(moment: int) -> int:
    """Return the day of the week, 0 for Sunday; 1970-01-01 was a Thursday."""
    return (moment // NANOSECONDS_PER_DAY + 4) % 7


def _bits_to_string(value: int) -> str:
    return f"16#{value:x}"


def _real_to_string(value: float) -> str:
    return f"{value:.10g}"


def _day_of(moment: int) -> int:
    """Return midnight of a DT, as a DATE."""
    return moment - moment % NANOSECONDS_PER_DAY


def _time_of(moment: int) -> int:
    """Return the time of day of a DT, as a TOD."""
    return moment % NANOSECONDS_PER_DAY


def _time_text(time: int) -> str:
    """Return a duration as `T#1d2h3m4s5.6ms`; the text ends at the last part that is not zero."""
    sign, rest = ("-", -time) if time < 0 else ("", time)
    parts = []
    for size, unit in ((86_400, "d"), (3_600, "h"), (60, "m"), (1, "s")):
        amount, rest = divmod(rest, size * _SECOND)
        parts.append(f"{sign if amount else ''}{amount}{unit}")
        if not rest:
            return f"T#{''.join(parts)}"
    return f"T#{''.join(parts)}{sign}{rest / 1_000_000:g}ms"


def _date_text(moment: int) -> str:
    """Return a date as `D#2024-12-31`."""
    day = datetime(1970, 1, 1) + timedelta(days=moment // NANOSECONDS_PER_DAY)
    return f"D#{day:%Y-%m-%d}"


def _tod_text(moment: int) -> str:
    """Return a time of day as `TOD#13:30:00`, with six decimals if the seconds are not whole."""
    return f"TOD#{_clock(moment)}"


def _dt_text(moment: int) -> str:
    """Return a DT as `DT#2024-12-31-13:30:00`, with six decimals for parts of seconds."""
    return f"DT#{_date_text(moment)[2:]}-{_clock(moment)}"


def _clock(moment: int) -> str:
    seconds, rest = divmod(moment % NANOSECONDS_PER_DAY, _SECOND)
    minutes, second = divmod(seconds, 60)
    hour, minute = divmod(minutes, 60)
    shown = f"{second + rest / _SECOND:09.6f}" if rest else f"{second:02d}"
    return f"{hour:02d}:{minute:02d}:{shown}"


def _ltime_text(time: int) -> str:
    """Return an LTIME in the form of `_time_text`, with nanoseconds."""
    whole = f"L{_time_text(time)}"
    rest = abs(time) % _SECOND
    if not rest:
        return whole
    milliseconds, nanoseconds = divmod(rest, 1_000_000)
    digits = f"{milliseconds}.{nanoseconds:06d}".rstrip("0").rstrip(".")
    return f"{whole[: whole.index('s') + 1]}{'-' if time < 0 else ''}{digits}ms"


# --- numbers, durations and times as CODESYS writes them ---

#: Units of a duration, from the largest [ns].
_PARTS = (
    (86_400 * _SECOND, "d"),
    (3_600 * _SECOND, "h"),
    (60 * _SECOND, "m"),
    (_SECOND, "s"),
    (1_000_000, "ms"),
    (1_000, "us"),
    (1, "ns"),
)


def _short_lreal_text(value: float) -> str:
    """Return the fewest digits that give the same LREAL; at least one is after the point."""
    return repr(value)


def _short_real_text(value: float) -> str:
    """Return the fewest digits that give the same REAL; at least one is after the point."""
    for digits in range(1, 9):
        text = f"{value:.{digits}g}"
        if c_float(float(text)).value == value:
            return repr(float(text))
    return repr(float(f"{value:.9g}"))


def _short_time_text(time: int) -> str:
    """Return a TIME as `T#1h5s20ms`, without the parts that are zero."""
    return f"T#{_short_parts(time - time % 1_000_000, 'ms')}"


def _short_ltime_text(time: int) -> str:
    """Return an LTIME as `LTIME#1h5s20us`, without the parts that are zero."""
    return f"LTIME#{_short_parts(time, 'ns')}"


def _short_parts(time: int, least: str) -> str:
    sign, rest, parts = ("-", -time, "") if time < 0 else ("", time, "")
    for size, unit in _PARTS:
        amount, rest = divmod(rest, size)
        if amount:
            parts += f"{amount}{unit}"
    return f"{sign}{parts}" if parts else f"0{least}"


def _short_tod_text(moment: int) -> str:
    """Return a time of day as `TOD#13:30:00`, with three decimals if the seconds are not whole."""
    seconds, rest = divmod(moment % NANOSECONDS_PER_DAY, _SECOND)
    fraction = f".{rest // 1_000_000:03d}" if rest >= 1_000_000 else ""
    return f"TOD#{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}{fraction}"


def _short_ltod_text(moment: int) -> str:
    """Return a time of day as `LTOD#13:30:00`, with nine decimals if the seconds are not whole."""
    seconds, rest = divmod(moment % NANOSECONDS_PER_DAY, _SECOND)
    fraction = f".{rest:09d}" if rest else ""
    return f"LTOD#{seconds // 3600:02d}:{seconds // 60 % 60:02d}:{seconds % 60:02d}{fraction}"


def _long(text: Callable[[int], str]) -> Callable[[int], str]:
    return lambda moment: f"L{text(moment)}"


#: The names that generated code can use: `inside` is the function `_inside` of this module.
NAMES: dict[str, Any] = {
    **{
        name[1:]: one
        for name, one in list(globals().items())
        if name.startswith("_") and isinstance(one, FunctionType)
    },
    "FAULTS": FAULTS,
    "FUSE": FUSE,
    "Open": _Open,
    "c_float": c_float,
    "div": quotient,
    "math": math,
    "mod": remainder,
    "trunc": math.trunc,
    "uncalled": _Uncalled(),
}
# The text of an LDATE, LTOD or LDT is an L and the text of the DATE, TOD or DT.
NAMES |= {f"l{name}": _long(NAMES[name]) for name in ("date_text", "tod_text", "dt_text")}
