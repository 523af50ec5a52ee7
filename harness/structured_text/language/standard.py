"""The standard functions and function blocks: their names, pins and types.

A name of the second edition is `reserved`: a declaration of the program cannot replace it. Names of
the third edition or of vendors yield to a declaration of the program.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from structured_text.language.scalars import (
    ANY_BIT,
    ANY_CHARS,
    ANY_DATE,
    ANY_DURATION,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    ANY_STRING,
    CORE,
    ELEMENTARY,
    MOMENTS,
)
from structured_text.language.types import BlockType, Variable

__all__ = [
    "BLOCKS",
    "FUNCTIONS",
    "MOMENT_OPERATORS",
    "PIN_NAMES",
    "UNSUPPORTED",
    "Signature",
    "bcd",
    "conversion",
    "convertible",
    "overload",
    "pin_name",
    "rare",
    "reserved",
    "truncation",
]

_ANY = (*ANY_BIT, *ANY_NUM, *MOMENTS, *ANY_CHARS)
_ORDERED = tuple(name for name in _ANY if name != "BOOL")


@dataclass(frozen=True)
class Signature:
    """The parameters and the result of a standard function.

    `pins` holds pairs (name, type). A type is the name of an elementary type, `ANY_INT`, or `T`:
    all pins marked `T` share one type, which must be in `group`. `result` is written likewise;
    there, `ANY_INT` means the integer type that the context requires. An `extensible` function
    takes more arguments like its last one.
    """

    pins: tuple[tuple[str, str], ...]
    group: tuple[str, ...]
    result: str
    extensible: bool = False


def _unary(group: tuple[str, ...]) -> Signature:
    return Signature((("IN", "T"),), group, "T")


def _binary(group: tuple[str, ...], result: str = "T", *, extensible: bool = False) -> Signature:
    return Signature((("IN1", "T"), ("IN2", "T")), group, result, extensible)


def _pins(text: str, result: str) -> Signature:
    """Return a signature from pins with their own types: `YEAR:ANY_INT MONTH:ANY_INT`."""
    pairs = (item.split(":") for item in text.split())
    return Signature(tuple((name, kind) for name, kind in pairs), (), result)


_SHIFT = Signature((("IN", "T"), ("N", "ANY_INT")), ANY_BIT, "T")
_S = ANY_STRING

_SECOND_EDITION = {
    "ABS": _unary(ANY_NUM),
    **dict.fromkeys(
        ("SQRT", "LN", "LOG", "EXP", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN"), _unary(ANY_REAL)
    ),
    **dict.fromkeys(("ADD", "MUL"), _binary(ANY_NUM, extensible=True)),
    **dict.fromkeys(("SUB", "DIV"), _binary(ANY_NUM)),
    "MOD": _binary(ANY_INT),
    "EXPT": Signature((("IN1", "T"), ("IN2", "ANY_NUM")), ANY_REAL, "T"),
    "MOVE": _unary(_ANY),
    **dict.fromkeys(("SHL", "SHR", "ROL", "ROR"), _SHIFT),
    **dict.fromkeys(("AND", "OR", "XOR"), _binary(ANY_BIT, extensible=True)),
    "SEL": Signature((("G", "BOOL"), ("IN0", "T"), ("IN1", "T")), _ANY, "T"),
    **dict.fromkeys(("MAX", "MIN"), _binary(_ORDERED, extensible=True)),
    "LIMIT": Signature((("MN", "T"), ("IN", "T"), ("MX", "T")), _ORDERED, "T"),
    "MUX": Signature((("K", "ANY_INT"), ("IN0", "T"), ("IN1", "T")), _ANY, "T", True),
    **dict.fromkeys(("GT", "GE", "EQ", "LE", "LT"), _binary(_ANY, "BOOL", extensible=True)),
    "NE": _binary(_ANY, "BOOL"),
    "LEN": Signature((("IN", "T"),), _S, "ANY_INT"),
    **dict.fromkeys(("LEFT", "RIGHT"), Signature((("IN", "T"), ("L", "ANY_INT")), _S, "T")),
    **dict.fromkeys(
        ("MID", "DELETE"), Signature((("IN", "T"), ("L", "ANY_INT"), ("P", "ANY_INT")), _S, "T")
    ),
    "CONCAT": _binary(_S, extensible=True),
    "INSERT": Signature((("IN1", "T"), ("IN2", "T"), ("P", "ANY_INT")), _S, "T"),
    "REPLACE": Signature((("IN1", "T"), ("IN2", "T"), ("L", "ANY_INT"), ("P", "ANY_INT")), _S, "T"),
    "FIND": _binary(_S, "ANY_INT"),
    "TRUNC": Signature((("IN", "T"),), ANY_REAL, "ANY_INT"),
    **dict.fromkeys(("ADD_TIME", "SUB_TIME"), _binary(("TIME",))),
    **dict.fromkeys(
        ("MULTIME", "DIVTIME"), Signature((("IN1", "TIME"), ("IN2", "ANY_NUM")), (), "TIME")
    ),
}

_CLOCK = "HOUR:ANY_INT MINUTE:ANY_INT SECOND:ANY_INT MILLISECOND:ANY_INT"
_DAY = "YEAR:ANY_INT MONTH:ANY_INT DAY:ANY_INT"

#: Functions of the third edition, and functions of the second edition with a type in their name.
_MORE = {
    "ATAN2": Signature((("Y", "T"), ("X", "T")), ANY_REAL, "T"),
    "CONCAT_DATE_TOD": _pins("IN1:DATE IN2:TOD", "DT"),
    "CONCAT_DATE_LTOD": _pins("IN1:DATE IN2:LTOD", "LDT"),
    "CONCAT_DATE": _pins(_DAY, "DATE"),
    "CONCAT_TOD": _pins(_CLOCK, "TOD"),
    "CONCAT_LTOD": _pins(_CLOCK, "LTOD"),
    "CONCAT_DT": _pins(f"{_DAY} {_CLOCK}", "DT"),
    "CONCAT_LDT": _pins(f"{_DAY} {_CLOCK}", "LDT"),
    "DAY_OF_WEEK": _pins("IN:DATE", "ANY_INT"),
}

FUNCTIONS = {**_SECOND_EDITION, **_MORE}


def _moment_operators() -> Iterator[tuple[str, tuple[str, str, str, str]]]:
    """Yield the names of date functions with (operator, both operand types, result type)."""
    for long in ("", "L"):
        time, day, clock, both = (long + name for name in ("TIME", "DATE", "TOD", "DT"))
        for moment in (clock, both):
            yield f"ADD_{moment}_{time}", ("+", moment, time, moment)
            yield f"SUB_{moment}_{time}", ("-", moment, time, moment)
        for moment in (day, clock, both):
            yield f"SUB_{moment}_{moment}", ("-", moment, moment, time)
        for word, op in (("MUL", "*"), ("DIV", "/")):
            yield f"{word}_{time}", (op, time, "ANY_NUM", time)
    yield "ADD_LTIME", ("+", "LTIME", "LTIME", "LTIME")
    yield "SUB_LTIME", ("-", "LTIME", "LTIME", "LTIME")


#: Functions that do the same as an operator on a date or duration and a date, duration or number.
MOMENT_OPERATORS = dict(_moment_operators())

#: Functions of the second edition that few tools have.
_RARE = frozenset(
    (
        *("ADD_TOD_TIME", "ADD_DT_TIME", "SUB_DATE_DATE", "SUB_TOD_TIME", "SUB_TOD_TOD"),
        *("SUB_DT_TIME", "SUB_DT_DT", "CONCAT_DATE_TOD"),
    )
)

#: Blocks of the standard or of matiec's library that no engine of this package runs.
UNSUPPORTED = frozenset(["SEMA", "RTC", "PID", "RAMP", "INTEGRAL", "DERIVATIVE", "HYSTERESIS"])

_CONVERSION = re.compile(r"([A-Z_]+?)_TO_([A-Z_]+)")
#: Pairs (source, target) of date and duration types between which a conversion exists. LTIME,
#: LDATE, LDT and LTOD are treated like TIME, DATE, DT and TOD.
_MOMENT_PAIRS = (
    *(("DT", "DATE"), ("DT", "TOD"), ("DATE", "DT"), ("TIME", "TOD"), ("TOD", "TIME")),
    # These conversions treat a date as the time since 1970-01-01.
    *(("TIME", "DT"), ("DT", "TIME"), ("TIME", "DATE"), ("DATE", "TIME")),
)


def conversion(name: str) -> tuple[str, str] | None:
    """Return the (source, target) type names of a conversion such as `INT_TO_REAL`.

    Returns:
        None if there is no such conversion: from a type to itself; between dates and durations,
            except for the pairs in `_MOMENT_PAIRS`; between a character and a type that is neither
            an integer nor a bit string nor a text; and BCD (see `bcd`).
    """
    found = _CONVERSION.fullmatch(name)
    if found is None or found[1] not in ELEMENTARY or found[2] not in ELEMENTARY:
        return None
    source, target = ELEMENTARY[found[1]].name, ELEMENTARY[found[2]].name
    return (source, target) if convertible(source, target) else None


def convertible(source: str, target: str) -> bool:
    """Return whether there is a conversion between two different elementary types."""
    if source == target:
        return False
    if source in MOMENTS and target in MOMENTS:
        pair = source.removeprefix("L"), target.removeprefix("L")
        return pair[0] == pair[1] or pair in _MOMENT_PAIRS
    for one, other in ((source, target), (target, source)):
        if one in ("CHAR", "WCHAR"):
            return other in ANY_CHARS or other in ANY_INT or (other in ANY_BIT and other != "BOOL")
    return True


def overload(name: str) -> str:
    """Return the target type of a conversion from any type, such as `TO_INT`; else empty."""
    target = name.removeprefix("TO_")
    return ELEMENTARY[target].name if name.startswith("TO_") and target in ELEMENTARY else ""


_TRUNCATION = re.compile(r"(?:(L?REAL)_)?TRUNC_([A-Z]+)")


def truncation(name: str) -> tuple[str, str] | None:
    """Return source and target of `TRUNC_INT`, `LREAL_TRUNC_DINT` and so on.

    The source is empty if the function takes any real type. The result is None for other names.
    """
    found = _TRUNCATION.fullmatch(name)
    return None if found is None or found[2] not in ANY_INT else (found[1] or "", found[2])


_UNSIGNED_OF = {"BYTE": "USINT", "WORD": "UINT", "DWORD": "UDINT", "LWORD": "ULINT"}
_FROM_BCD = re.compile(r"(?:([A-Z]+)_)?BCD_TO_([A-Z]+)")
_TO_BCD = re.compile(r"(?:([A-Z]+)_)?TO_BCD_([A-Z]+)")


def bcd(name: str) -> tuple[str, str, str] | None:
    """Return the meaning of `WORD_BCD_TO_UINT`, `BCD_TO_UINT`, `TO_BCD_WORD` and so on.

    Returns:
        FROM_BCD or TO_BCD, the source (empty for any) and the target; None for other names.
    """
    found = _FROM_BCD.fullmatch(name)
    if found is not None and found[2] in ANY_INT and (found[1] or "BYTE") in _UNSIGNED_OF:
        return "FROM_BCD", found[1] or "", found[2]
    found = _TO_BCD.fullmatch(name)
    if found is not None and found[2] in _UNSIGNED_OF and (found[1] or "INT") in ANY_INT:
        return "TO_BCD", found[1] or "", found[2]
    return None


def rare(name: str) -> bool:
    """Return whether a function is of the second edition but not of the portable subset."""
    return name in _RARE or (bcd(name) is not None and not name.startswith("TO_"))


def _block(name: str, inputs: str, outputs: str) -> BlockType:
    variables = [
        Variable(pin, ELEMENTARY[kind], section)
        for section, pins in (("VAR_INPUT", inputs), ("VAR_OUTPUT", outputs))
        for pin, kind in (item.split(":") for item in pins.split())
    ]
    return BlockType(name, tuple(variables))


def _blocks() -> dict[str, BlockType]:
    blocks = [
        _block("R_TRIG", "CLK:BOOL", "Q:BOOL"),
        _block("F_TRIG", "CLK:BOOL", "Q:BOOL"),
        _block("SR", "S1:BOOL R:BOOL", "Q1:BOOL"),
        _block("RS", "S:BOOL R1:BOOL", "Q1:BOOL"),
        *(_block(name, "IN:BOOL PT:TIME", "Q:BOOL ET:TIME") for name in ("TON", "TOF", "TP")),
    ]
    for suffix, kind in [("", "INT")] + [("_" + k, k) for k in ("DINT", "LINT", "UDINT", "ULINT")]:
        up = _block(f"CTU{suffix}", f"CU:BOOL R:BOOL PV:{kind}", f"Q:BOOL CV:{kind}")
        down = _block(f"CTD{suffix}", f"CD:BOOL LD:BOOL PV:{kind}", f"Q:BOOL CV:{kind}")
        both = _block(
            f"CTUD{suffix}",
            f"CU:BOOL CD:BOOL R:BOOL LD:BOOL PV:{kind}",
            f"QU:BOOL QD:BOOL CV:{kind}",
        )
        blocks += [up, down, both]
    return {block.name: block for block in blocks}


def _more_blocks() -> dict[str, BlockType]:
    """Return the timers with the type of the duration in the name, such as TON_LTIME."""
    blocks = []
    for name in ("TON", "TOF", "TP"):
        for long, kind in ((f"{name}_TIME", "TIME"), *((n, "LTIME") for n in _long_names(name))):
            blocks.append(_block(long, f"IN:BOOL PT:{kind}", f"Q:BOOL ET:{kind}"))
    return {block.name: block for block in blocks}


def _long_names(name: str) -> tuple[str, str]:
    return f"{name}_LTIME", f"L{name}"


_CORE_BLOCKS = _blocks()
BLOCKS = {**_CORE_BLOCKS, **_more_blocks()}

#: Alternative pin names of the standard and of CODESYS, by the first word of the block's name.
PIN_NAMES = {
    "SR": {"SET1": "S1", "RESET": "R"},
    "RS": {"SET": "S", "RESET1": "R1"},
    "CTU": {"RESET": "R"},
    "CTD": {"LOAD": "LD"},
    "CTUD": {"RESET": "R", "LOAD": "LD"},
}


def pin_name(block: BlockType, name: str) -> str:
    """Return a block's upper-case name of a pin, with alternative standard names replaced."""
    key = name.upper()
    if BLOCKS.get(block.name) is not block:
        return key
    return PIN_NAMES.get(block.name.partition("_")[0], {}).get(key, key)


def reserved(name: str) -> bool:
    """Return whether the second edition has a type, function or block of this name."""
    pair = conversion(name)
    return (
        name in CORE
        or name in ("T", "D")
        or name in _CORE_BLOCKS
        or name in _SECOND_EDITION
        or name in UNSUPPORTED
        or (pair is not None and _in_second_edition(*pair))
    )


def _in_second_edition(source: str, target: str) -> bool:
    moments = (*ANY_DURATION, *ANY_DATE)
    if source not in CORE or target not in CORE or (source == "STRING" and target in moments):
        return False
    if source in moments and target in moments:
        return source == "DT"
    return True
