"""Legal values of an input, taken from the tables of the telegrams or from the input's comment."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rcx_harness.spec.telegram import Field, intervals
from rcx_tools.docs.blocks.source import Pin, Pou, kinds
from rcx_tools.library import library
from rcx_tools.library.checks import decimal, selector_groups
from rcx_tools.library.tables import Block, Input

__all__ = ["range_of"]

#: Pattern of numbers and ranges in a comment: `1 to 4; 0 = robot 1`, `2..7, 10..15`.
_SAID = re.compile(
    r"-?\d+(?:\.\d+)?(?:\.\.| to )-?\d+(?:\.\d+)?"
    r"(?:(?:, | \.\. |, with Size 256 also )\d+\.\.\d+)*"
)
#: Ranges of inputs of the area blocks. The comments of these inputs do not follow the pattern.
_AREAS = {"Size": "48, 256", "m": "0 to ImageSize - Size", "n": "0 to ImageSize - Size"}

_REAL_STEPS = 8191.999


def range_of(pou: Pou, pin: Pin) -> str:
    """Return the legal values of an input in words. Empty if all values of the type are legal.

    Args:
        pou: The block.
        pin: One of its inputs.
    """
    if pin.name == "RobotNumber":
        return "0 to 4"
    if pin.name in _AREAS:
        return _AREAS[pin.name]
    if pin.default == "T#100ms":
        return "T#100ms and longer"
    if members := kinds()[pin.type].members if pin.type in kinds() else {}:
        refused = _refused_members(pou, pin)
        return ", ".join(f"`{name}`" for name in members if name not in refused)
    block = library().blocks.get(pou.name)
    entries = block.inputs if block else ()
    entry = next((one for one in entries if one.pin == pin.name), None)
    if entry is None or block is None or not entry.to:
        said = _SAID.search(pin.comment) if pin.type not in ("TIME", "BOOL") else None
        return said[0] if said else ""
    return _of_field(block, entry, block.requests[entry.to[0]])


def _refused_members(pou: Pou, pin: Pin) -> set[str]:
    """Return the members of an enumeration that are not legal in the field of a command."""
    tables = library()
    block, enumeration = tables.blocks.get(pou.name), tables.enumerations.get(pin.type)
    entries = block.inputs if block else ()
    entry = next((one for one in entries if one.pin == pin.name), None)
    if not (block and entry and enumeration and len(entry.to) == 1):
        return set()
    known = block.requests[entry.to[0]].values
    return {one.name for one in enumeration.members if known and one.value not in known}


def _of_field(block: Block, entry: Input, part: Field) -> str:
    if entry.type == "BOOL":
        return ""
    if entry.type == "STRING":
        return f"up to {part.length} characters"
    zero = ["0 (not given)"] if entry.flag and entry.type != "BOOL" else []
    if entry.type == "WORD":
        bits = (part.mask >> part.bits[0]).bit_length()
        return f"bits 0 to {bits - 1}" if part.type == "bits" else f"16#0000 to 16#{part.mask:04X}"
    if entry.range:
        return _span(entry, entry.range, entry.scale)
    if part.by and part.by != entry.flag and not entry.when:
        return "; ".join(
            f"{_span(entry, limits, scale)} with {_members(block, part.by, values)}"
            for values, limits, scale in selector_groups(entry, part)
        )
    limits = part.range
    if part.by:
        limits = part.ranges.get(entry.when[1] if entry.when else 1)
    if limits:
        return ", ".join([*zero, _span(entry, limits, entry.scale)])
    if entry.encoding != "real" and entry.scale and entry.type in ("REAL", "RCX_POSITION"):
        return f"-{_REAL_STEPS} to {_REAL_STEPS}"
    return ""


def _members(block: Block, field: str, values: Sequence[int]) -> str:
    """Return values of a field as members of an enumeration: the type of the pin for this field."""
    filler = next(one for one in block.inputs if field in one.to)
    names = {one.value: one.name for one in library().enumerations[filler.type].members}
    return ", ".join(f"`{names[value]}`" for value in values)


def _span(entry: Input, limits: tuple[int, ...], scale: float) -> str:
    shown = []
    for low, high in intervals(limits):
        a, b = low, high
        if entry.encoding == "bit" and not entry.range:
            a, b = (1 if low else 0), high.bit_length()
        elif entry.encoding == "bcd":
            a, b = decimal(low), decimal(high)
        scaled = scale and scale != 1
        ends = [f"{one / scale:g}" if scaled else str(one) for one in (a, b)]
        shown.append(ends[0] if a == b else f"{ends[0]} to {ends[1]}")
    return ", ".join(shown)
