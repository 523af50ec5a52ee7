"""Generator of the input checks of a block: values that do not fit a telegram, or are illegal."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from itertools import pairwise

from rcx_harness.spec.telegram import Field, intervals
from rcx_tools.library.conditions import Conditions, both, either
from rcx_tools.library.st import guarded, indent, loop, real, statement, word
from rcx_tools.library.tables import Block, Input, Library

__all__ = ["Limits", "Pair", "checks", "decimal", "selector_groups"]

Pair = tuple[int, int]
Limits = tuple[int, ...]

_ROBOT, _VALUE, _TEXT, _REAL = "16#8040", "16#8045", "16#8046", "16#8047"

#: Limit up to which every multiple of 0.001 mm is sent exactly. From 8192 mm on, the steps between
#: two REALs are so large that the number in a telegram may be wrong by 0.001 mm.
_EXACT = 8_191_999
_PRINTABLE = (0x20, 0x7E)
#: The largest REAL. All digits are written, because some PLCs compare a REAL with the exact number.
_LARGEST = "3.4028234663852886E38"
_TYPES = {"INT": (-(2**15), 2**15 - 1), "UINT": (0, 2**16 - 1), "DINT": (-(2**31), 2**31 - 1)}


def checks(block: Block, tables: Library, sent: Sequence[str]) -> list[str]:
    """Return the statements that give the job the error of the first wrong pin.

    Arrays are checked in loops after the other checks. The loops need an additional variable,
    Refused.

    Args:
        block: The block.
        tables: The tables of all blocks and types.
        sent: Statements to execute if no pin is wrong.
    """
    # Scalars become one IF with ELSIF branches, in the order of the pins: the first wrong pin
    # determines the ErrorID. Array elements need loops, which cannot be branches. The loops run
    # after the IF, and only if there is no error yet.
    chain: list[tuple[str, str]] = []
    loops: list[str] = []
    if block.commands[0].robot:
        chain.append(("RobotNumber < 0 OR RobotNumber > 4", _ROBOT))
    conditions = Conditions(block, tables.enumerations)
    for pin in block.inputs:
        array = tables.arrays.get(pin.type)
        kind, name = (array.of, f"{pin.pin}[k]") if array else (pin.type, pin.pin)
        for guard, wrong, error in _wrong(conditions, tables, block, pin, kind, name):
            condition = both(guard, wrong)
            if not array:
                chain.append((condition, error))
                continue
            refuse = f"Refused := WORD#{error};"
            first = both("Refused = WORD#16#0000", condition)
            loops += loop(array.count, guarded(first, [refuse], 3))
    chain += [(condition, _VALUE) for condition in _products(block)]
    refused = "Refused" if loops else "Job.Trouble"
    lines = [f"{refused} := WORD#16#0000;"]
    for number, (condition, error) in enumerate(chain):
        lines += statement(f"{'ELSIF' if number else 'IF'} {condition} THEN", 2)
        lines.append(f"  {refused} := WORD#{error};")
    if loops:
        close = ["END_IF;"] if chain else []
        filled = guarded("Refused = WORD#16#0000", sent) if sent else []
        return [*lines, *close, *loops, *filled, "Job.Trouble := Refused;"]
    return [*lines, *(["ELSE", *indent(sent)] if sent else []), "END_IF;"] if chain else list(sent)


def selector_groups(
    pin: Input, part: Field
) -> list[tuple[tuple[int, ...], tuple[int, ...], float]]:
    """Return the values of the selector field in groups with equal limits and equal scale.

    Each group is (values, limits, scale).
    """
    groups: dict[tuple[tuple[int, ...], float], list[int]] = {}
    for value, limits in part.ranges.items():
        scale = pin.scale_by.get(value, pin.scale)
        groups.setdefault((limits, scale), []).append(value)
    return [(tuple(values), limits, scale) for (limits, scale), values in groups.items()]


def decimal(value: int) -> int:
    """Return the decimal number of a BCD value: 12 for 16#12."""
    return 10 * (value >> 4) + (value & 0xF)


def _wrong(
    conditions: Conditions, tables: Library, block: Block, pin: Input, kind: str, name: str
) -> Iterator[tuple[str, str, str]]:
    """Yield (guard, condition of the error, ErrorID) of each check for one pin."""
    if not pin.to or len(pin.to) > 1:
        return
    part = block.requests[pin.to[0]]
    if kind in tables.enumerations:
        members = tables.enumerations[kind].members
        bad = [one.name for one in members if part.values and one.value not in part.values]
        if bad:
            wrong = either(*(f"{name} = {member}" for member in bad))
            yield conditions.counts(pin), wrong, pin.error or _VALUE
        return
    if kind == "STRING":
        allowed = next(iter(part.ranges.values()), part.range) or _PRINTABLE
        judge = "FC_RcxTextError" if allowed == _PRINTABLE else "FC_RcxNameError"
        wrong = f"{judge}(Text := {name}, Longest := {part.length}) <> {word(0)}"
        yield conditions.counts(pin), wrong, pin.error or _TEXT
        return
    for guard, limits, scale in _limits(conditions, pin, part):
        wrong = _outside(pin, kind, name, part, limits, scale)
        if wrong:
            natural = kind == "REAL" and not limits
            yield (
                "" if kind == "WORD" and pin.flag else guard,
                wrong,
                _REAL if natural else pin.error or _VALUE,
            )


def _limits(
    conditions: Conditions, pin: Input, part: Field
) -> Iterator[tuple[str, tuple[int, ...], float]]:
    """Yield guard, limits (may be empty) and scale of the field that a pin fills."""
    counts = conditions.counts(pin)
    if pin.range:
        yield counts, pin.range, pin.scale
    elif part.by and part.by == pin.flag:
        yield counts, part.ranges[1], pin.scale
    elif part.by and pin.when and pin.when[0] == part.by:
        yield counts, part.ranges[pin.when[1]], pin.scale
    elif part.by:
        for values, limits, scale in selector_groups(pin, part):
            yield both(conditions.among(part.by, values), counts), limits, scale
    else:
        yield counts, part.range or (), pin.scale


def _outside(
    pin: Input, kind: str, name: str, part: Field, limits: tuple[int, ...], scale: float
) -> str:
    """Return the condition that the pin is outside of the limits or of the field's range."""
    if kind == "BOOL":
        return ""
    if kind == "WORD":
        highest = limits[-1] if limits else part.mask >> part.bits[0]
        stray = 0xFFFF & ~((1 << highest.bit_length()) - 1)
        empty = f"{name} = {word(0)}" if limits and limits[0] > 0 and not pin.flag else ""
        over = f"({name} AND {word(stray)}) <> {word(0)}" if stray else ""
        return either(*filter(None, (empty, over)))
    if kind == "REAL" and pin.encoding == "real":
        return _beyond(name, f"-{_LARGEST}", _LARGEST)
    pairs = _pairs(pin, part, limits)
    if kind == "REAL":
        low, high = pairs[0][0], pairs[-1][1]
        if (low, high) == _TYPES["DINT"]:
            low, high = -_EXACT, _EXACT
        return _beyond(name, _limit(low, -1, scale), _limit(high, 1, scale))
    lowest, highest = _TYPES[kind]
    if pairs[0][0] == pairs[-1][1]:
        return f"{name} <> {pairs[0][0]}"
    parts = []
    if pairs[0][0] > lowest:
        parts.append(f"{name} < {pairs[0][0]}")
    for (_, end), (begin, _) in pairwise(pairs):
        parts.append(f"({name} > {end} AND {name} < {begin})")
    if pairs[-1][1] < highest:
        parts.append(f"{name} > {pairs[-1][1]}")
    return " OR ".join(parts)


def _limit(value: int, outward: int, scale: float) -> str:
    """Return a limit of a REAL as text.

    If the REAL is beyond the exact limit, the limit is widened by a tenth of a step.

    For example the REAL 0.01 is a little less than 0.01, and some PLCs compare it with the exact
    number.
    """
    (held,) = struct.unpack("<f", struct.pack("<f", value / scale))
    beyond = (held - value / scale) * outward > 0
    return real(round((value + outward / 10) / scale, 6) if beyond else value / scale)


def _beyond(name: str, low: str, high: str) -> str:
    """Return the condition that a REAL is not from `low` to `high`. It also holds for NaN.

    The comparison is a call of FC_RcxOutside, which also detects NaN.
    """
    return f"FC_RcxOutside(Value := {name}, Lowest := {low}, Highest := {high})"


def _pairs(pin: Input, part: Field, limits: Sequence[int]) -> list[Pair]:
    """Return the intervals of legal values for a pin that is a whole number."""
    if pin.encoding == "bit" and not pin.range:
        lowest, highest = (limits[0], limits[-1]) if limits else (0, part.mask >> part.bits[0])
        return [(1 if lowest else 0, highest.bit_length())]
    if limits:
        pairs = intervals(limits)
        return [(decimal(a), decimal(b)) for a, b in pairs] if pin.encoding == "bcd" else pairs
    if part.values:
        return _runs(sorted(part.values))
    if part.type == "bits":
        width = part.bits[1] - part.bits[0] + 1
        return [(-(2 ** (width - 1)), 2 ** (width - 1) - 1)] if pin.signed else [(0, 2**width - 1)]
    return [{"u16": (0, 2**16 - 1), "s16": _TYPES["INT"]}.get(part.type, _TYPES["DINT"])]


def _runs(values: Sequence[int]) -> list[Pair]:
    """Return consecutive values as intervals."""
    runs: list[Pair] = []
    for value in values:
        if runs and runs[-1][1] == value - 1:
            runs[-1] = (runs[-1][0], value)
        else:
            runs.append((value, value))
    return runs


def _products(block: Block) -> Iterator[str]:
    """Yield the conditions that a product exceeds its limit.

    The product is checked factor by factor to avoid an overflow.
    """
    limits = block.commands[0].product
    if limits is None:
        return
    pins = {pin.to[0]: pin.pin for pin in block.inputs if pin.to}
    names = [f"INT_TO_DINT({pins[name]})" for name in limits.fields]
    for count in range(2, len(names) + 1):
        yield f"{' * '.join(names[:count])} > {limits.range[1]}"
