"""The elementary types: their ranges, their groups and their literals."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from datetime import date
from fractions import Fraction

from structured_text.language.types import ElementaryType

__all__ = [
    "ANY_BIT",
    "ANY_CHARS",
    "ANY_DATE",
    "ANY_DURATION",
    "ANY_INT",
    "ANY_NUM",
    "ANY_REAL",
    "ANY_STRING",
    "BOOL",
    "CORE",
    "DIGITS",
    "ELEMENTARY",
    "INT_RANGE",
    "LONGEST_STRING",
    "LREAL",
    "MOMENTS",
    "NANOSECONDS_PER_DAY",
    "REAL_MAX",
    "SIGNED",
    "STRING_MAX",
    "TIME",
    "UNSIGNED",
    "WIDTH",
    "LiteralError",
    "Scalar",
    "number",
    "string_kind",
    "string_length",
    "string_literal",
    "typed_literal",
    "within_real",
]

#: The Python form of a scalar while a program runs. BOOL is a bool. Integers, bit strings and
#: enumerations are int. REAL and LREAL are float. STRING, WSTRING, CHAR and WCHAR are str. TIME is
#: in ns, DATE and DT in ns since 1970-01-01, TOD in ns since midnight. LTIME, LDATE, LDT and LTOD
#: have the same units.
Scalar = bool | int | float | str

WIDTH = {
    "SINT": 8,
    "INT": 16,
    "DINT": 32,
    "LINT": 64,
    "USINT": 8,
    "UINT": 16,
    "UDINT": 32,
    "ULINT": 64,
    "BYTE": 8,
    "WORD": 16,
    "DWORD": 32,
    "LWORD": 64,
}
SIGNED = ("SINT", "INT", "DINT", "LINT")
UNSIGNED = ("USINT", "UINT", "UDINT", "ULINT")
ANY_INT = SIGNED + UNSIGNED
ANY_REAL = ("REAL", "LREAL")
ANY_NUM = ANY_INT + ANY_REAL
ANY_BIT = ("BOOL", "BYTE", "WORD", "DWORD", "LWORD")
ANY_DURATION = ("TIME", "LTIME")
ANY_DATE = ("DATE", "TOD", "DT", "LDATE", "LTOD", "LDT")
MOMENTS = ANY_DURATION + ANY_DATE
ANY_STRING = ("STRING", "WSTRING")
ANY_CHARS = (*ANY_STRING, "CHAR", "WCHAR")

#: Number of hexadecimal digits of each bit string.
DIGITS = {name: WIDTH[name] // 4 for name in ANY_BIT[1:]}

#: The range (lowest, highest) of each integer and bit string type.
INT_RANGE = {
    name: (-(1 << bits - 1), (1 << bits - 1) - 1) if name in SIGNED else (0, (1 << bits) - 1)
    for name, bits in WIDTH.items()
}

#: Length of a STRING or WSTRING without an explicit length, as in matiec. Longer texts are cut.
STRING_MAX = 126
#: Largest length of `STRING[n]`.
LONGEST_STRING = 65_535
REAL_MAX = float.fromhex("0x1.fffffep127")
#: Numbers from this value on are rounded to an infinite REAL.
_REAL_INFINITE = float.fromhex("0x1.ffffffp127")
NANOSECONDS_PER_DAY = 86_400_000_000_000

ELEMENTARY = {name: ElementaryType(name) for name in (*ANY_BIT, *ANY_NUM, *MOMENTS, *ANY_CHARS)}
for _short, _long in (("TOD", "TIME_OF_DAY"), ("DT", "DATE_AND_TIME")):
    ELEMENTARY[_long], ELEMENTARY[f"L{_long}"] = ELEMENTARY[_short], ELEMENTARY[f"L{_short}"]
# In CODESYS these types have the width of a pointer. In this engine a pointer has 32 bits.
for _short, _long in (("DWORD", "__XWORD"), ("UDINT", "__UXINT"), ("DINT", "__XINT")):
    ELEMENTARY[_long] = ELEMENTARY[_short]

#: The types of the standard's second edition, except WSTRING, which some tools lack. The other
#: types came with the third edition, and a program may declare something with their names.
CORE = frozenset(
    (
        *ANY_BIT,
        *ANY_NUM,
        *("TIME", "DATE", "TOD", "DT", "TIME_OF_DAY", "DATE_AND_TIME", "STRING"),
    )
)

BOOL, TIME, STRING = ELEMENTARY["BOOL"], ELEMENTARY["TIME"], ELEMENTARY["STRING"]
REAL, LREAL, WSTRING = ELEMENTARY["REAL"], ELEMENTARY["LREAL"], ELEMENTARY["WSTRING"]

_TIME_UNITS = {
    "d": NANOSECONDS_PER_DAY,
    "h": 3_600_000_000_000,
    "m": 60_000_000_000,
    "s": 1_000_000_000,
    "ms": 1_000_000,
    "us": 1_000,
    "ns": 1,
}
_TIME_PART = re.compile(r"(\d+(?:\.\d+)?)([mun]s|[dhms])")
_DAY = re.compile(r"(\d{4})-(\d{1,2})-(\d{1,2})")
_CLOCK = re.compile(r"(\d+):(\d+)(?::(\d+(?:\.\d+)?))?")
_ESCAPES = {
    "L": "\n",
    "N": "\n",
    "P": "\f",
    "R": "\r",
    "T": "\t",
    "$": "$",
    "'": "'",
    '"': '"',
}
#: Short names that a literal can have before `#` in place of a type, such as `T` for TIME.
_PREFIXES = {"T": "TIME", "D": "DATE", "LT": "LTIME", "LD": "LDATE"}


class LiteralError(ValueError):
    """A literal without a valid value; the message gives the reason."""


def number(text: str) -> int | float:
    """Return the value of an integer or real literal: `12`, `16#FF_00`, `1.5E-3`, `-7`.

    Raise LiteralError for a digit that the base does not have, an unknown base, or a too large
    value.
    """
    plain = text.replace("_", "")
    sign, plain = (-1, plain[1:]) if plain.startswith("-") else (1, plain.removeprefix("+"))
    base, _, digits = plain.rpartition("#")
    try:
        if base:
            if base not in ("2", "8", "10", "16"):
                raise LiteralError(f"base {base} does not exist; use 2, 8, 10 or 16")
            return sign * int(digits, int(base))
        if "." not in plain and "E" not in plain.upper():
            return sign * int(plain)
        if math.isinf(float(plain)):
            raise LiteralError(f"{text} is too large")
        return sign * float(plain)
    except ValueError as error:
        if isinstance(error, LiteralError):
            raise
        raise LiteralError(f"{text} is not a number") from None


def string_literal(text: str) -> str:
    """Return the characters of a quoted string literal, with `$` escapes replaced.

    In double quotes it is a WSTRING, with codes of four digits: `$00E4`.

    Raises:
        LiteralError: The literal has an unknown escape or a character outside its type, or is too
            long.
    """
    wide = text.startswith('"')
    digits, largest, name = (4, 0xFFFF, "WSTRING") if wide else (2, 0xFF, "STRING")

    def escape(found: re.Match[str]) -> str:
        code = found[1]
        if len(code) == digits:
            return chr(int(code, 16))
        if code.upper() not in _ESCAPES:
            raise LiteralError(f"${code} is not an escape; write $$ for a dollar sign")
        return _ESCAPES[code.upper()]

    value = re.sub(rf"\$([0-9A-Fa-f]{{{digits}}}|.)", escape, text[1:-1])
    if any(ord(character) > largest for character in value):
        held = "16-bit" if wide else "single-byte"
        raise LiteralError(f"a {name} holds {held} characters only")
    if len(value) > LONGEST_STRING:
        raise LiteralError(f"a {name} holds at most {LONGEST_STRING} characters")
    return value


def string_length(kind: ElementaryType) -> int:
    """Return the number of characters of a STRING or WSTRING type; 1 for CHAR, WCHAR."""
    if kind.name not in ANY_STRING:
        return 1
    return STRING_MAX if kind.length is None else kind.length


def string_kind(name: str, length: int) -> ElementaryType:
    """Return a STRING or WSTRING type for this many characters; the plain type if it suffices."""
    return ELEMENTARY[name] if length <= STRING_MAX else ElementaryType(name, length)


def typed_literal(text: str) -> tuple[ElementaryType, Scalar]:
    """Return type and value of `WORD#16#FF`, `BOOL#1`, `T#1s500ms`, `TOD#12:00:00` etc.

    Raises:
        LiteralError: The value is malformed or out of the type's range.
        KeyError: The prefix is not an elementary type.
    """
    prefix, _, rest = text.partition("#")
    kind = ELEMENTARY[_PREFIXES.get(prefix.upper(), prefix.upper())]
    if kind.name == "LTIME":
        return kind, _time(rest, "LTIME")
    if kind.name in MOMENTS:
        return kind, _SPECIAL[kind.name.removeprefix("L")](rest)
    if kind.name in ANY_CHARS:
        return _characters(kind, rest)
    if kind.name == "BOOL":
        values = {"TRUE": True, "FALSE": False, "1": True, "0": False}
        if rest.upper() not in values:
            raise LiteralError(f"{text} is not a BOOL; write TRUE or FALSE")
        return kind, values[rest.upper()]
    if not re.match(r"[-+]?\d", rest):
        raise LiteralError(f"{text} is not a number")
    value = number(rest)
    if kind.name in ANY_REAL:
        found = within_real(value) if kind.name == "REAL" else float(value)
        if found is None:
            raise LiteralError(f"{text} is too large")
        return kind, found
    if isinstance(value, float):
        raise LiteralError(f"{text}: {kind.name} has no decimals")
    low, high = INT_RANGE[kind.name]
    if not low <= value <= high:
        raise LiteralError(f"{text} is outside {kind.name} ({low} to {high})")
    return kind, value


def within_real(value: float) -> float | None:
    """Return a number as a REAL; None if it is too large.

    A number that is slightly larger becomes the largest REAL, because tools write the largest REAL
    as 3.40282347E+38, which is a little more.
    """
    if not abs(value) < _REAL_INFINITE:
        return None
    return max(-REAL_MAX, min(REAL_MAX, float(value)))


#: Limits of durations [ns], each with its text for messages. In CODESYS, LTIME has no sign.
_LONGEST_TIMES = {"TIME": (1 << 63, "106,751 days"), "LTIME": (1 << 64, "213,503 days")}


def _time(text: str, name: str = "TIME") -> int:
    plain = text.lower().replace("_", "")
    sign, plain = (-1, plain[1:]) if plain.startswith("-") else (1, plain.removeprefix("+"))
    units = list(_TIME_UNITS)
    total, end, rank = Fraction(0), 0, -1
    for part in _TIME_PART.finditer(plain):
        if part.start() != end or units.index(part[2]) <= rank:
            break
        total += Fraction(part[1]) * _TIME_UNITS[part[2]]
        end, rank = part.end(), units.index(part[2])
        if "." in part[1]:
            break
    if not plain or end != len(plain):
        raise LiteralError(f"T#{text} is not a duration; write it as T#1500ms or T#1h30m")
    most, shown = _LONGEST_TIMES["TIME" if sign < 0 else name]
    if total >= most:
        raise LiteralError(f"T#{text} is too large; a {name} holds {shown}")
    return sign * int(total)


def _date(text: str) -> int:
    found = _DAY.fullmatch(text)
    try:
        if found is None:
            raise ValueError
        day = date(int(found[1]), int(found[2]), int(found[3]))
    except ValueError:
        raise LiteralError(f"D#{text} is not a date; write it as D#2024-12-31") from None
    return (day - date(1970, 1, 1)).days * NANOSECONDS_PER_DAY


def _clock(text: str) -> int:
    found = _CLOCK.fullmatch(text.replace("_", ""))
    second = Fraction((found and found[3]) or 0)
    if found is None or int(found[1]) > 23 or int(found[2]) > 59 or second >= 60:
        raise LiteralError(f"TOD#{text} is not a time of day; write it as TOD#13:30:00")
    seconds = (int(found[1]) * 60 + int(found[2])) * 60 + second
    return int(seconds * 1_000_000_000)


def _date_and_time(text: str) -> int:
    day, _, clock = text.rpartition("-")
    return _date(day) + _clock(clock)


def _characters(kind: ElementaryType, text: str) -> tuple[ElementaryType, str]:
    """Return type and value of `STRING#'abc'`, `WSTRING#"abc"`, `CHAR#'a'`, `WCHAR#"a"`.

    Single quotes are accepted for all four types.
    """
    wide = kind.name.startswith("W")
    if text[:1] not in ("'", '"'):
        raise LiteralError(f"{kind.name}#{text} is not a text; write {kind.name}#'a'")
    if not wide and text.startswith('"'):
        raise LiteralError(f"{kind.name}#{text} needs single quotes")
    value = string_literal(f'"{text[1:-1]}"' if wide else text)
    if kind.name in ANY_STRING:
        return string_kind(kind.name, len(value)), value
    if len(value) != 1:
        raise LiteralError(f"{kind.name}#{text} is not one character")
    return kind, value


_SPECIAL: dict[str, Callable[[str], int]] = {
    "TIME": _time,
    "DATE": _date,
    "TOD": _clock,
    "DT": _date_and_time,
}
