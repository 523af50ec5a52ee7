"""The instructions of function block diagrams.

An instruction of an older controller is a block with a structure; newer controllers have functions
without one, for which the same expressions are used. An expression is in the language of Logix, so
that its types are converted as in other routines.

Source: Rockwell 1756-RM003N, 1756-RM006K and Studio 5000 help, the section of each instruction.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

__all__ = ["CALLED", "FUNCTIONS", "GATES", "NO_TEXT", "Called", "Function"]


@dataclass(frozen=True)
class Function:
    """An instruction that calculates a value.

    Attributes:
        type: The structure of the block.
        inputs: Its inputs.
        expression: The value in the language of Logix, with `{Name}` for an input; empty for those
            that `values` calculates.
        output: Its output.
    """

    type: str
    inputs: tuple[str, ...]
    expression: str = ""
    output: str = "Dest"


@dataclass(frozen=True)
class Called:
    """An instruction that is the call of a function block.

    Attributes:
        type: The structure, which is a function block.
        settings: Arguments that tell instructions with the same structure apart.
        arrays: Names of its arrays of REAL.
        optional: Those that may be missing.
    """

    type: str
    settings: str = ""
    arrays: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()


_TWO, _ONE = ("SourceA", "SourceB"), ("Source",)


def _math(sign: str) -> Function:
    return Function("FBD_MATH", _TWO, f"{{SourceA}} {sign} {{SourceB}}")


def _compared(sign: str) -> Function:
    return Function("FBD_COMPARE", _TWO, f"{{SourceA}} {sign} {{SourceB}}")


def _advanced(name: str) -> Function:
    return Function("FBD_MATH_ADVANCED", _ONE, f"{name}({{Source}})")


_LIMITS = ("LowLimit", "Test", "HighLimit")
_LIM = Function(
    "FBD_LIMIT",
    _LIMITS,
    "({LowLimit} <= {HighLimit} AND {LowLimit} <= {Test} AND {Test} <= {HighLimit}"
    " OR {LowLimit} > {HighLimit} AND ({LowLimit} <= {Test} OR {Test} <= {HighLimit}))",
)
_SQR, _TRN = _advanced("SQRT"), Function("FBD_TRUNCATE", _ONE, "TRUNC({Source})")
_XPY = _math("**")
_TOD, _FRD = Function("FBD_CONVERT", _ONE), Function("FBD_CONVERT", _ONE)
#: Instructions that calculate a value, by name. Names of functions are those without `__F`.
FUNCTIONS: Mapping[str, Function] = {
    "ADD": _math("+"),
    "SUB": _math("-"),
    "MUL": _math("*"),
    "DIV": _math("/"),
    "MOD": _math("MOD"),
    "XPY": _XPY,
    "EXPT": _XPY,
    "NEG": Function("FBD_MATH_ADVANCED", _ONE, "-({Source})"),
    "ABS": _advanced("ABS"),
    "SQR": _SQR,
    "SQRT": _SQR,
    **{name: _advanced(name) for name in ("SIN", "COS", "TAN", "LN", "LOG", "DEG", "RAD")},
    "ASN": _advanced("ASIN"),
    "ASIN": _advanced("ASIN"),
    "ACS": _advanced("ACOS"),
    "ACOS": _advanced("ACOS"),
    "ATN": _advanced("ATAN"),
    "ATAN": _advanced("ATAN"),
    "TRN": _TRN,
    "TRUNC": _TRN,
    "TOD": _TOD,
    "TO_BCD": _TOD,
    "FRD": _FRD,
    "BCD_TO": _FRD,
    **dict.fromkeys(("EQU", "EQ"), _compared("=")),
    **dict.fromkeys(("NEQ", "NE"), _compared("<>")),
    **dict.fromkeys(("LES", "LT"), _compared("<")),
    **dict.fromkeys(("LEQ", "LE"), _compared("<=")),
    **dict.fromkeys(("GRT", "GT"), _compared(">")),
    **dict.fromkeys(("GEQ", "GE"), _compared(">=")),
    **dict.fromkeys(("LIM", "LIMIT"), _LIM),
    "MEQ": Function(
        "FBD_MASK_EQUAL",
        ("Source", "Mask", "Compare"),
        "({Source} AND {Mask}) = ({Compare} AND {Mask})",
    ),
    "MVMT": Function(
        "FBD_MASKED_MOVE",
        ("Source", "Mask", "Target"),
        "({Source} AND {Mask}) OR ({Target} AND NOT ({Mask}))",
    ),
    **{
        word: Function("FBD_LOGICAL", _TWO, f"{{SourceA}} {word} {{SourceB}}")
        for word in ("AND", "OR", "XOR")
    },
    "NOT": Function("FBD_LOGICAL", _ONE, "NOT ({Source})"),
}
#: Functions without a structure of numbers. BAND, BOR and BXOR join their wired inputs by a word.
GATES = {"BAND": "AND", "BOR": "OR", "BXOR": "XOR"}
#: Instructions that are the call of a function block, by name.
CALLED: Mapping[str, Called] = {
    "BAND": Called("FBD_BOOLEAN_AND"),
    "BOR": Called("FBD_BOOLEAN_OR"),
    "BXOR": Called("FBD_BOOLEAN_XOR"),
    "BNOT": Called("FBD_BOOLEAN_NOT"),
    "TONR": Called("FBD_TIMER"),
    "TOFR": Called("FBD_TIMER", "OffDelay := TRUE"),
    "RTOR": Called("FBD_TIMER", "Retentive := TRUE"),
    "CTUD": Called("FBD_COUNTER"),
    "OSRI": Called("FBD_ONESHOT", "Falling := FALSE"),
    "OSFI": Called("FBD_ONESHOT", "Falling := TRUE"),
    "SETD": Called("DOMINANT_SET"),
    "RESD": Called("DOMINANT_RESET"),
    "BTDT": Called("FBD_BIT_FIELD_DISTRIBUTE"),
    "MAXC": Called("MAXIMUM_CAPTURE"),
    "MINC": Called("MINIMUM_CAPTURE"),
    "SEL": Called("SELECT"),
    "HLL": Called("HL_LIMIT"),
    "SCL": Called("SCALE"),
    "MAVE": Called(
        "MOVING_AVERAGE", arrays=("StorageArray", "WeightArray"), optional=("WeightArray",)
    ),
}
#: Instructions of `CALLED` that Structured Text does not have.
NO_TEXT = ("BAND", "BOR", "BXOR", "BNOT", "SEL")
