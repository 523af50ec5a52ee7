"""What stands for a function with long loops: any result that it can give.

Each is a property of its own (`functions.py`), proved of the function's body.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import z3

from rcx_harness.verify.prove import reals
from rcx_harness.verify.prove.machine import Machine

__all__ = ["SUMMARIES"]

#: FC_RcxMilliseconds gives at most 20 days.
LONGEST_MS = 1_728_000_000


def _milliseconds(machine: Machine, arguments: list[Any]) -> Any:
    result = z3.BitVec(machine.fresh("milliseconds"), 32)
    machine.assume(z3.And(result >= 0, result <= LONGEST_MS))
    return result


def _real_bits(machine: Machine, arguments: list[Any]) -> Any:
    """The pattern itself, but +0.0 for -0.0; of NaN anything."""
    pattern = arguments[0].value
    number = z3.ULE(pattern & 0x7FFF_FFFF, 0x7F80_0000)
    bits = z3.If(pattern == 0x8000_0000, z3.BitVecVal(0, 32), pattern)
    return z3.If(number, bits, z3.BitVec(machine.fresh("real_bits"), 32))


def _bits_real(machine: Machine, arguments: list[Any]) -> Any:
    return reals.anything(machine.fresh("bits_real"), "REAL")


def _scan_time(machine: Machine, arguments: list[Any]) -> None:
    """FB_RcxScanTime may give any time: no proof leans on how long a scan takes."""
    block = machine.project.pous["FB_RCXSCANTIME"].block
    assert block is not None
    machine.havoc(arguments[0], block)


SUMMARIES: dict[str, Callable[[Machine, list[Any]], Any]] = {
    "FC_RCXMILLISECONDS": _milliseconds,
    "FC_RCXREALBITS": _real_bits,
    "FC_RCXBITSREAL": _bits_real,
    "FB_RCXSCANTIME": _scan_time,
}
