"""What stands for a function or block with long loops, and for a sine: any result it can give.

`functions.py` proves those of FC_RcxMilliseconds, FC_RcxRealBits, FC_RcxBitsReal and
FB_RcxFirstRow of their bodies, for every argument; the others take any value for granted.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import z3

from structured_text.prove import reals
from structured_text.prove.machine import Machine

__all__ = [
    "LONGEST_MS",
    "SUMMARIES",
    "WAVES",
    "bits_of",
    "is_first_row",
    "nearest_milliseconds",
    "pattern_of",
]

#: FC_RcxMilliseconds gives at most 20 days.
LONGEST_MS = 1_728_000_000
#: Standard functions that no term says.
WAVES = ("SIN", "COS", "ATAN")


def pattern_of(number: reals.Real) -> Any:
    """The IEEE 754 pattern of a REAL, as a term."""
    if not number.known:
        return number.value
    return z3.BitVecVal(int.from_bytes(struct.pack(">f", number.value), "big"), 32)


def nearest_milliseconds(value: Any, result: Any) -> Any:
    """What FC_RcxMilliseconds gives: the nearest number, 0 below 0, at most 20 days.

    It is said of every TIME of 64 bits and of the result with as many bits as a TIME; whoever
    needs it for an argument assumes it.
    """
    ms = 1_000_000
    whole = result * ms
    near = z3.And(2 * value - ms < 2 * whole, 2 * whole <= 2 * value + ms)
    return z3.And(
        z3.Implies(value < 0, result == 0),
        z3.Implies(z3.And(value >= 0, value < LONGEST_MS * ms), near),
        z3.Implies(value >= LONGEST_MS * ms, result == LONGEST_MS),
        result >= 0,
        result <= LONGEST_MS,
    )


def _milliseconds(machine: Machine, arguments: list[Any]) -> Any:
    result = z3.BitVec(machine.fresh("milliseconds"), 32)
    machine.assume(z3.And(result >= 0, result <= LONGEST_MS))
    return result


def bits_of(pattern: Any) -> Any:
    """What FC_RcxRealBits gives for a number with this pattern: 0 for -0.0, else the pattern."""
    return z3.If(pattern & 0x7FFF_FFFF == 0, z3.BitVecVal(0, 32), pattern)


def _is_number(pattern: Any) -> Any:
    """Not NaN."""
    return z3.ULE(pattern & 0x7FFF_FFFF, 0x7F80_0000)


def _real_bits(machine: Machine, arguments: list[Any]) -> Any:
    """Anything for what is no number."""
    (number,) = arguments
    pattern = pattern_of(number)
    anything = z3.BitVec(machine.fresh("real_bits"), 32)
    return z3.If(_is_number(pattern), bits_of(pattern), anything)


def _bits_real(machine: Machine, arguments: list[Any]) -> Any:
    """Any number: no proof leans on which."""
    return reals.anything(machine.fresh("bits_real"), "REAL")


def _scan_time(machine: Machine, arguments: list[Any]) -> None:
    """FB_RcxScanTime may give any time: no proof leans on how long a scan takes."""
    kind = machine.project.pous["FB_RCXSCANTIME"].block
    assert kind is not None
    machine.havoc(arguments[0], kind)


def is_first_row(row: Any, error: Any, rows: Any, size: Any) -> Any:
    """What FB_RcxFirstRow gives: a row in use, which may be done already (16#8055), or 16#8051."""
    used = z3.And(row >= 1, row <= rows, rows <= size)
    return z3.Or(z3.And(z3.Or(error == 0, error == 0x8055), used), error == 0x8051)


def _first_row(machine: Machine, arguments: list[Any]) -> None:
    (instance,) = arguments
    kind = machine.project.pous["FB_RCXFIRSTROW"].block
    assert kind is not None
    rows, size = (machine.term((*instance, name)) for name in ("ROWS", "MOVESSIZE"))
    machine.havoc(instance, kind)
    row, error = (machine.term((*instance, name)) for name in ("ROW", "ERRORID"))
    machine.assume(is_first_row(row, error, rows, size))


def _wave(name: str) -> Callable[[Machine, list[Any]], Any]:
    """A sine or the like: any REAL, the same one for the same argument. It is more than there is.

    How far a PLC's own is right is no matter of proof.
    """
    word = z3.BitVecSort(32)
    function = z3.Function(name, word, word)

    def result(machine: Machine, arguments: list[Any]) -> Any:
        del machine
        (number,) = arguments
        return reals.Real(function(pattern_of(reals.settled(number, "REAL"))))

    return result


SUMMARIES: dict[str, Callable[[Machine, list[Any]], Any]] = {
    "FC_RCXMILLISECONDS": _milliseconds,
    "FC_RCXREALBITS": _real_bits,
    "FC_RCXBITSREAL": _bits_real,
    "FB_RCXFIRSTROW": _first_row,
    "FB_RCXSCANTIME": _scan_time,
    **{name: _wave(name) for name in WAVES},
}
