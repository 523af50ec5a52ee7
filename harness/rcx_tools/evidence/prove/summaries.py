"""Summaries: terms that replace functions or blocks with long loops, or trigonometric functions.

A summary allows every result that the function can give. `functions.py` proves for every argument
that the summaries of FC_RcxMilliseconds, FC_RcxRealBits, FC_RcxBitsReal and FB_RcxFirstRow agree
with their bodies. The other summaries allow any value and need no proof.
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

#: The greatest result of FC_RcxMilliseconds: 20 days.
LONGEST_MS = 1_728_000_000
#: Standard functions that the terms cannot express.
WAVES = ("SIN", "COS", "ATAN")


def pattern_of(number: reals.Real) -> Any:
    """Return the IEEE 754 pattern of a REAL, as a term."""
    if not number.known:
        return number.value
    return z3.BitVecVal(int.from_bytes(struct.pack(">f", number.value), "big"), 32)


def nearest_milliseconds(value: Any, result: Any) -> Any:
    """Return the specification of FC_RcxMilliseconds: nearest number of ms, from 0 to 20 days.

    The specification is valid for every TIME of 64 bits. Its result has as many bits as a TIME. A
    proof that uses the specification must assume it explicitly.
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
    """Return the result of FC_RcxRealBits for a number: its bit pattern, but 0 for -0.0."""
    return z3.If(pattern & 0x7FFF_FFFF == 0, z3.BitVecVal(0, 32), pattern)


def _is_number(pattern: Any) -> Any:
    """Return the claim that the bit pattern is not NaN."""
    return z3.ULE(pattern & 0x7FFF_FFFF, 0x7F80_0000)


def _real_bits(machine: Machine, arguments: list[Any]) -> Any:
    """Return the bit pattern of a number. For NaN return an arbitrary value."""
    (number,) = arguments
    pattern = pattern_of(number)
    anything = z3.BitVec(machine.fresh("real_bits"), 32)
    return z3.If(_is_number(pattern), bits_of(pattern), anything)


def _bits_real(machine: Machine, arguments: list[Any]) -> Any:
    """Return an arbitrary number, because no proof depends on its value."""
    return reals.anything(machine.fresh("bits_real"), "REAL")


def _scan_time(machine: Machine, arguments: list[Any]) -> None:
    """Let FB_RcxScanTime return any time, because no proof depends on the duration of a scan."""
    kind = machine.project.pous["FB_RCXSCANTIME"].block
    assert kind is not None
    machine.havoc(arguments[0], kind)


def is_first_row(row: Any, error: Any, rows: Any, size: Any) -> Any:
    """Return the specification of FB_RcxFirstRow: a row in use, or ErrorID 16#8051.

    ErrorID 16#8055 means that the used row is already done.
    """
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
    """Return a summary of a sine or a similar function.

    The summary allows any REAL as result, but the same REAL for the same argument. It therefore
    covers every function of a REAL. The accuracy of a PLC is not part of the proofs.
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
