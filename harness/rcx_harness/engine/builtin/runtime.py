"""What the generated code calls: arithmetic as in a PLC, conversions, shifts and strings."""

from __future__ import annotations

import math
import re
from ctypes import c_float
from typing import Any, NoReturn

from rcx_harness.engine.builtin.moments import (
    date_text,
    day_of,
    dt_text,
    time_of,
    time_text,
    tod_text,
)
from rcx_harness.engine.frontend.scalars import STRING_MAX

__all__ = ["FUSE", "NAMES", "ProgramError"]

#: Rounds after which a loop counts as endless; a scan with so many would not fit any PLC.
FUSE = range(1_000_000)


class ProgramError(Exception):
    """A mistake of the program that shows only while it runs."""


def _endless() -> NoReturn:
    raise ProgramError(f"this loop has not ended after {len(FUSE)} rounds")


def _inside(index: int, low: int, high: int) -> int:
    if low <= index <= high:
        return index
    raise ProgramError(f"index {index} is outside {low}..{high}")


def _div(a: int, b: int) -> int:
    """Division that cuts towards zero."""
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


def _mod(a: int, b: int) -> int:
    """Remainder with the sign of the dividend; 0 for a divisor of 0, as the standard says."""
    if b == 0:
        return 0
    rest = abs(a) % abs(b)
    return -rest if a < 0 else rest


def _f32(value: float) -> float:
    return c_float(value).value


def _to_unsigned(value: float) -> int:
    """Nearest whole number of a real, 0 for a negative one."""
    return round(value) if value >= 0 else 0


def _time_times(time: int, factor: float) -> int:
    return math.trunc(time * factor)


def _time_by(time: int, divisor: float) -> int:
    return math.trunc(time / divisor)


def _shl(value: int, count: int, mask: int) -> int:
    if count < 0:
        raise ProgramError(f"a shift by {count}")
    return value << count & mask if count < 64 else 0


def _shr(value: int, count: int) -> int:
    if count < 0:
        raise ProgramError(f"a shift by {count}")
    return value >> count


def _rol(value: int, count: int, bits: int) -> int:
    count %= bits
    return (value << count | value >> bits - count) & (1 << bits) - 1


def _limit(low: Any, value: Any, high: Any) -> Any:
    """MIN(MAX(value, low), high), as the standard defines it also where low is above high."""
    least = value if value > low else low
    return least if least < high else high


def _mux(index: int, *values: Any) -> Any:
    if not 0 <= index < len(values):
        raise ProgramError(f"MUX selects {index} of {len(values)} inputs")
    return values[index]


# --- strings: positions count from 1 ---


def _length(count: int) -> int:
    if count < 0:
        raise ProgramError(f"a length or position of {count} in a STRING function")
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
        raise ProgramError(f"position {position} in a STRING; the first is 1")
    return position - 1


def _concat(*texts: str) -> str:
    return "".join(texts)[:STRING_MAX]


def _insert(text: str, other: str, position: int) -> str:
    at = _length(position)
    return (text[:at] + other + text[at:])[:STRING_MAX]


def _delete(text: str, count: int, position: int) -> str:
    at = _position(position)
    return text[:at] + text[at + _length(count) :]


def _replace(text: str, other: str, count: int, position: int) -> str:
    at = _position(position)
    return (text[:at] + other + text[at + _length(count) :])[:STRING_MAX]


def _find(text: str, other: str) -> int:
    return text.find(other) + 1 if other else 0


_BASED = re.compile(r"(2|8|16)#([0-9A-Fa-f_]+)")
_WHOLE = re.compile(r"\s*([-+]?)([0-9][0-9_]*)")
_DECIMAL = re.compile(r"\s*[-+]?[0-9]*\.[0-9]*(?:[eE][-+]?[0-9]+)?")


def _string_to_int(text: str) -> int:
    """The number a text begins with, in decimal or as 16#..; 0 if it begins with none."""
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


def _bits_to_string(value: int) -> str:
    return f"16#{value:x}"


def _real_to_string(value: float) -> str:
    return f"{value:.10g}"


#: The names that generated code finds.
NAMES: dict[str, Any] = {
    "FUSE": FUSE,
    "endless": _endless,
    "inside": _inside,
    "div": _div,
    "mod": _mod,
    "f32": _f32,
    "c_float": c_float,
    "to_unsigned": _to_unsigned,
    "time_times": _time_times,
    "time_by": _time_by,
    "shl": _shl,
    "shr": _shr,
    "rol": _rol,
    "limit": _limit,
    "mux": _mux,
    "left": _left,
    "right": _right,
    "mid": _mid,
    "concat": _concat,
    "insert": _insert,
    "delete": _delete,
    "replace": _replace,
    "find": _find,
    "string_to_int": _string_to_int,
    "string_to_real": _string_to_real,
    "string_to_bool": _string_to_bool,
    "bits_to_string": _bits_to_string,
    "real_to_string": _real_to_string,
    "time_text": time_text,
    "date_text": date_text,
    "tod_text": tod_text,
    "dt_text": dt_text,
    "day_of": day_of,
    "time_of": time_of,
    "trunc": math.trunc,
    "math": math,
}
