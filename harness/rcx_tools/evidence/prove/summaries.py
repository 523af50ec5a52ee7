"""What stands for a function or block with long loops: any result that it can give.

Each is a property of its own (`functions.py`), proved of the function's body.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping
from typing import Any

import z3

from rcx_harness.verify.prove import reals
from rcx_harness.verify.prove.machine import Machine, Path

__all__ = ["SUMMARIES"]

#: FC_RcxMilliseconds gives at most 20 days.
LONGEST_MS = 1_728_000_000


def _milliseconds(machine: Machine, arguments: list[Any]) -> Any:
    result = z3.BitVec(machine.fresh("milliseconds"), 32)
    machine.assume(z3.And(result >= 0, result <= LONGEST_MS))
    return result


def _real_bits(machine: Machine, arguments: list[Any]) -> Any:
    """The pattern itself, 0 for -0.0; anything for what is no number."""
    (number,) = arguments
    if number.known:
        pattern: Any = z3.BitVecVal(int.from_bytes(struct.pack(">f", number.value), "big"), 32)
    else:
        pattern = number.value
    size = pattern & 0x7FFF_FFFF
    anything = z3.BitVec(machine.fresh("real_bits"), 32)
    return z3.If(
        size == 0, z3.BitVecVal(0, 32), z3.If(z3.UGT(size, 0x7F80_0000), anything, pattern)
    )


def _bits_real(machine: Machine, arguments: list[Any]) -> Any:
    """The pattern itself; infinity is the largest number, what is no number and -0.0 are 0.0."""
    (given,) = arguments
    pattern = given if z3.is_bv(given) else z3.BitVecVal(given, 32)
    size = pattern & 0x7FFF_FFFF
    none = z3.Or(size == 0, z3.UGT(size, 0x7F80_0000))
    largest = (pattern & 0x8000_0000) | 0x7F7F_FFFF
    return reals.Real(
        z3.If(none, z3.BitVecVal(0, 32), z3.If(size == 0x7F80_0000, largest, pattern))
    )


def scan_time_keeps(machine: Machine, instance: Path, memory: Mapping[Path, Any]) -> Any:
    """What holds of an FB_RcxScanTime between its calls: less than a millisecond is left over."""
    rest = machine.term((*instance, "REST"), memory)
    return z3.And(rest >= 0, rest < 1_000_000)


def _scan_time(machine: Machine, arguments: list[Any]) -> None:
    (instance,) = arguments
    kind = machine.project.pous["FB_RCXSCANTIME"].block
    assert kind is not None
    machine.havoc(instance, kind)
    machine.assume(scan_time_keeps(machine, instance, machine.snapshot()))


SUMMARIES: dict[str, Callable[[Machine, list[Any]], Any]] = {
    "FC_RCXMILLISECONDS": _milliseconds,
    "FC_RCXREALBITS": _real_bits,
    "FC_RCXBITSREAL": _bits_real,
    "FB_RCXSCANTIME": _scan_time,
}
