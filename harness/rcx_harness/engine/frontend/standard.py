"""The standard functions and function blocks: their names, pins and types."""

from __future__ import annotations

import re
from dataclasses import dataclass

from rcx_harness.engine.frontend.scalars import (
    ANY_BIT,
    ANY_DATE,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    ELEMENTARY,
)
from rcx_harness.engine.types import BlockType, Variable

__all__ = ["BLOCKS", "FUNCTIONS", "UNSUPPORTED", "Signature", "conversion"]

_ANY = (*ANY_BIT, *ANY_NUM, "TIME", *ANY_DATE, "STRING")
_ORDERED = tuple(name for name in _ANY if name != "BOOL")


@dataclass(frozen=True)
class Signature:
    """How a standard function may be called.

    `pins` are (name, type); the type is the name of an elementary type, `ANY_INT`, or `T` for
    the one type that all pins marked so share and that must be in `group`. `result` is likewise;
    `ANY_INT` there means the integer type that the context asks for. An `extensible` function
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


_SHIFT = Signature((("IN", "T"), ("N", "ANY_INT")), ANY_BIT, "T")
_S = ("STRING",)

FUNCTIONS = {
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
    "LEN": Signature((("IN", "STRING"),), _S, "ANY_INT"),
    **dict.fromkeys(
        ("LEFT", "RIGHT"), Signature((("IN", "STRING"), ("L", "ANY_INT")), _S, "STRING")
    ),
    **dict.fromkeys(
        ("MID", "DELETE"),
        Signature((("IN", "STRING"), ("L", "ANY_INT"), ("P", "ANY_INT")), _S, "STRING"),
    ),
    "CONCAT": Signature((("IN1", "STRING"), ("IN2", "STRING")), _S, "STRING", True),
    "INSERT": Signature((("IN1", "STRING"), ("IN2", "STRING"), ("P", "ANY_INT")), _S, "STRING"),
    "REPLACE": Signature(
        (("IN1", "STRING"), ("IN2", "STRING"), ("L", "ANY_INT"), ("P", "ANY_INT")), _S, "STRING"
    ),
    "FIND": Signature((("IN1", "STRING"), ("IN2", "STRING")), _S, "ANY_INT"),
    "TRUNC": Signature((("IN", "T"),), ANY_REAL, "ANY_INT"),
    **dict.fromkeys(("ADD_TIME", "SUB_TIME"), _binary(("TIME",))),
    **dict.fromkeys(
        ("MULTIME", "DIVTIME"), Signature((("IN1", "TIME"), ("IN2", "ANY_NUM")), (), "TIME")
    ),
}

#: Blocks of matiec's library and the standard that no engine here runs.
UNSUPPORTED = frozenset(["SEMA", "RTC", "PID", "RAMP", "INTEGRAL", "DERIVATIVE", "HYSTERESIS"])

_CONVERSION = re.compile(r"([A-Z_]+?)_TO_([A-Z_]+)")


def conversion(name: str) -> tuple[str, str] | None:
    """The (source, target) type names of a conversion such as `INT_TO_REAL`.

    Returns:
        None if there is no such conversion: between a type and itself, among TIME and the
        dates other than DT to DATE and DT to TOD, from STRING to those, and BCD.
    """
    found = _CONVERSION.fullmatch(name)
    if found is None or found[1] not in ELEMENTARY or found[2] not in ELEMENTARY:
        return None
    source, target = ELEMENTARY[found[1]].name, ELEMENTARY[found[2]].name
    moments = ("TIME", *ANY_DATE)
    if source == target or (source == "STRING" and target in moments):
        return None
    if source in moments and target in moments:
        return (source, target) if source == "DT" and target in ("DATE", "TOD") else None
    return source, target


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


BLOCKS = _blocks()
