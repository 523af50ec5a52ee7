"""Compute, move, logical, trigonometric and conversion instructions.

A REAL destination is an operand: the sources of ADD, SUB, MUL, DIV and MOD are converted to REAL
first. Integers are calculated as DINT. Source: Rockwell 1756-RM003, compute instructions, and data
conversions.
"""

from __future__ import annotations

from collections.abc import Callable

from structured_text.projects.rockwell.data import INTEGERS, NUMBERS
from structured_text.projects.rockwell.expression_reader import Value, bare
from structured_text.projects.rockwell.ladder.call import Call, Entry

__all__ = ["COMPUTES"]

_REALS = ("REAL", "LREAL")
#: Instructions and the functions of the standard.
_FUNCTIONS = {
    "SQR": "SQRT",
    **{name: name for name in ("SIN", "COS", "TAN", "LN", "LOG")},
    "ASN": "ASIN",
    "ACS": "ACOS",
    "ATN": "ATAN",
}
#: Other names of instructions, in later versions of the tool.
_RENAMED = {"SQRT": "SQR", "ASIN": "ASN", "ACOS": "ACS", "ATAN": "ATN"}
_SCALES = {"DEG": "57.2957795", "RAD": "0.0174532925"}


def _sources(call: Call, target: int, *places: int) -> list[Value]:
    """Return the values of sources, as REAL if the destination is one."""
    values = [call.number(place) for place in places]
    kind = call.tag(target)[1].type
    if kind in _REALS:
        return [_as_real(call, value, kind) for value in values]
    return values


def _as_real(call: Call, value: Value, kind: str) -> Value:
    if value[1] in _REALS and NUMBERS.index(value[1]) >= NUMBERS.index(kind):
        return value
    return call.operand(0).converted(value, kind), kind


def _arithmetic(sign: str) -> Callable[[Call], None]:
    def translate(call: Call) -> None:
        left, right = _sources(call, 2, 0, 1)
        value = call.operand(0).calculated(left, sign, right)
        call.when(call.assigned(2, value))

    return translate


def _xpy(call: Call) -> None:
    left, right = (_as_real(call, call.number(place), "REAL") for place in (0, 1))
    call.when(call.assigned(2, (f"({left[0]} ** {right[0]})", "REAL")))


def _cpt(call: Call) -> None:
    call.when(call.assigned(0, call.value(1)))


def _mov(call: Call) -> None:
    value = call.value(0)
    if value[1] == "BOOL":
        raise call.error(f"{call.raw(0)} is a BOOL, and {call.entry.name} moves numbers")
    call.when(call.assigned(1, value))


def _clr(call: Call) -> None:
    call.when(call.assigned(0, ("0", "DINT")))


def _neg(call: Call) -> None:
    (value,) = _sources(call, 1, 0)
    call.when(call.assigned(1, (f"(-{value[0]})", value[1])))


def _abs(call: Call) -> None:
    (value,) = _sources(call, 1, 0)
    call.when(call.assigned(1, (f"ABS({bare(value[0])})", value[1])))


def _function(name: str) -> Callable[[Call], None]:
    def translate(call: Call) -> None:
        value = call.number(0)
        kind = "LREAL" if value[1] == "LREAL" else "REAL"
        text, kind = _as_real(call, value, kind)
        call.when(call.assigned(1, (f"{name}({bare(text)})", kind)))

    return translate


def _scaled(factor: str) -> Callable[[Call], None]:
    def translate(call: Call) -> None:
        value = call.number(0)
        kind = "LREAL" if value[1] == "LREAL" else "REAL"
        text, kind = _as_real(call, value, kind)
        call.when(call.assigned(1, (f"({text} * {factor})", kind)))

    return translate


def _trn(call: Call) -> None:
    value = call.number(0)
    if value[1] in _REALS:
        value = f"TRUNC({bare(value[0])})", "DINT"
    call.when(call.assigned(1, value))


def _bitwise(op: str) -> Callable[[Call], None]:
    def translate(call: Call) -> None:
        reader = call.operand(0)
        left, right = reader.alike_bits(call.number(0), call.number(1))
        text = f"({left[0]} {op} {right[0]})"
        call.when(call.assigned(2, reader.of_bits((text, left[1]))))

    return translate


def _not(call: Call) -> None:
    reader = call.operand(0)
    text, kind = reader.bits(call.number(0))
    call.when(call.assigned(1, reader.of_bits((f"(NOT {text})", kind))))


def _mvm(call: Call) -> None:
    reader = call.operand(0)
    before = call.operand(2).value()
    source, mask, kept = reader.alike_bits(call.number(0), call.number(1), before)
    text = f"(({source[0]} AND {mask[0]}) OR ({kept[0]} AND NOT {mask[0]}))"
    call.when(call.assigned(2, reader.of_bits((text, source[1]))))


def _tod(call: Call) -> None:
    """Convert a number to BCD; the digits of a negative number are those of its amount."""
    value = call.number(0)
    if value[1] not in INTEGERS:
        raise call.error(f"{call.raw(0)} is a {value[1]}, TOD needs a whole number")
    reader = call.operand(0)
    text = f"DINT_TO_UDINT(ABS({bare(reader.converted(value, 'DINT'))}))"
    call.when(call.assigned(1, (f"DWORD_TO_DINT(UDINT_TO_BCD_DWORD({text}))", "DINT")))


def _frd(call: Call) -> None:
    text, kind = call.bits(0)
    if kind != "DWORD":
        raise call.error("FRD of a LINT is not supported", "use a DINT")
    call.when(call.assigned(1, (f"UDINT_TO_DINT(DWORD_BCD_TO_UDINT({text}))", "DINT")))


_TWO = ("Source A", "Source B", "Destination")
_ONE = ("Source", "Destination")


def _named(name: str, operands: tuple[str, ...], translate: Callable[[Call], None]) -> Entry:
    return Entry(name, operands, translate, f"1756-RM003, {_RENAMED.get(name, name)}")


COMPUTES = (
    _named("ADD", _TWO, _arithmetic("+")),
    _named("SUB", _TWO, _arithmetic("-")),
    _named("MUL", _TWO, _arithmetic("*")),
    Entry("DIV", _TWO, _arithmetic("/"), "1756-RM003, DIV; a division by 0 is assumed"),
    Entry("MOD", _TWO, _arithmetic("MOD"), "1756-RM003, MOD; a division by 0 is assumed"),
    Entry("XPY", ("Source X", "Source Y", "Destination"), _xpy, "1756-RM003, XPY"),
    Entry("EXPT", ("Source X", "Source Y", "Destination"), _xpy, "1756-RM003, XPY"),
    Entry("CPT", ("Destination", "Expression"), _cpt, "1756-RM003, CPT; types are assumed"),
    _named("MOV", _ONE, _mov),
    Entry("MOVE", _ONE, _mov, "1756-RM003, MOV"),
    _named("CLR", ("Destination",), _clr),
    _named("NEG", _ONE, _neg),
    _named("ABS", _ONE, _abs),
    *(_named(name, _ONE, _function(plain)) for name, plain in _FUNCTIONS.items()),
    *(_named(name, _ONE, _function(name)) for name in _RENAMED),
    *(_named(name, _ONE, _scaled(factor)) for name, factor in _SCALES.items()),
    _named("TRN", _ONE, _trn),
    Entry("TRUNC", _ONE, _trn, "1756-RM003, TRN"),
    *(_named(name, _TWO, _bitwise(name)) for name in ("AND", "OR", "XOR")),
    _named("NOT", _ONE, _not),
    _named("MVM", ("Source", "Mask", "Destination"), _mvm),
    _named("TOD", _ONE, _tod),
    Entry("TO_BCD", _ONE, _tod, "1756-RM003, TOD"),
    _named("FRD", _ONE, _frd),
    Entry("BCD_TO", _ONE, _frd, "1756-RM003, FRD"),
)
