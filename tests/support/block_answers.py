"""The meaning of a command block's outputs, read by the tests directly from spec/blocks.toml."""

from __future__ import annotations

import random
import struct
from collections.abc import Mapping
from fractions import Fraction

from block_pins import ARRAYS, Pins, members, pattern
from rcx_harness.spec.telegram import WORDS, Field, FieldValue, intervals
from rcx_tools.library.tables import Block, Output
from structured_text.engines.base import Value

_BLANK: dict[str, Value] = {"BOOL": False, "REAL": 0.0, "STRING": ""}
_LETTERS = " ABCxyz019_~!"


def blank(block: Block) -> Pins:
    """Return the outputs of a block that has received no answer."""
    return {pin.pin: _blank(pin) for pin in block.outputs}


def answered(block: Block, chance: random.Random) -> dict[str, FieldValue]:
    """Return random fields of a response that the controller may send."""
    numbers = {pin.source for pin in block.outputs if pin.type == "INT"}
    reals = {pin.source for pin in block.outputs if pin.encoding == "real"}
    fields: dict[str, FieldValue] = {}
    for name, part in block.responses.items():
        if part.type == "text":
            fields[name] = "".join(chance.choices(_LETTERS, k=chance.randint(0, 16)))
            continue
        every = [
            pattern(chance.uniform(-1e6, 1e6))
            if name in reals
            else _number(part, chance, name in numbers)
            for _ in range(part.count)
        ]
        fields[name] = tuple(every) if part.count > 1 else every[0]
    return fields


def in_words(
    block: Block, fields: Mapping[str, FieldValue], chance: random.Random
) -> tuple[int, ...]:
    """Return the 15 response words. Bits that belong to no field are random."""
    words = list(block.commands[0].respond(fields))
    for k in range(1, WORDS):
        covered = 0
        for part in block.responses.values():
            covered |= part.mask if k in part.words else 0
        words[k - 1] |= chance.choice([0, 0xFFFF]) & ~covered
    return tuple(words)


def shown(block: Block, sent: Mapping[str, FieldValue], got: Mapping[str, FieldValue]) -> Pins:
    """Return the outputs after a normal end.

    Args:
        block: The block.
        sent: Fields of the request.
        got: Fields of the response.
    """
    pins: Pins = {}
    for pin in block.outputs:
        pins[pin.pin] = _blank(pin)
        if pin.when:
            name, low, high = pin.when
            value = got[name] if name in got else sent[name]
            if not (isinstance(value, int) and low <= value <= high):
                continue
        part, field = block.responses[pin.source], got[pin.source]
        if isinstance(field, tuple):
            pins[pin.pin] = [_meant(pin, part, int(one)) for one in field]
        elif isinstance(field, str):
            pins[pin.pin] = field.rstrip()
        else:
            pins[pin.pin] = _meant(pin, part, int(field))
    return pins


def same(first: Value, second: Value) -> bool:
    """Return whether values are equal; scaled numbers may differ by the precision of a REAL."""
    if isinstance(first, list):
        return len(first) == len(second) and all(map(same, first, second))
    if isinstance(first, float):
        return bool(abs(first - second) <= abs(second) * 2.0**-22)
    return bool(first == second)


def _element(pin: Output) -> str:
    return ARRAYS[pin.type].of if pin.type in ARRAYS else pin.type


def _blank(pin: Output) -> Value:
    kind = _element(pin)
    one = members(kind)[0].name if members(kind) else _BLANK.get(kind, 0)
    return [one] * ARRAYS[pin.type].count if pin.type in ARRAYS else one


def _number(part: Field, chance: random.Random, as_int: bool) -> int:
    """Return a legal number.

    If the manual has no limits, return a number that the output can show.
    """
    if part.values:
        return chance.choice(list(part.values))
    if part.range:
        low, high = chance.choice(intervals(part.range))
    elif part.type == "s32":
        low, high = -(2**31), 2**31 - 1
    elif part.type == "u16":
        low, high = 0, 2**15 - 1 if as_int else 2**16 - 1
    else:
        low, high = 0, part.mask >> part.bits[0]
    if part.name == "port":
        return int(str(chance.randint(0, 27)), 16)
    return chance.choice([low, high, chance.randint(low, high)])


def _meant(pin: Output, part: Field, number: int) -> Value:
    kind = _element(pin)
    if members(kind):
        return next((one.name for one in members(kind) if one.value == number), _blank(pin))
    if kind == "BOOL":
        return number != 0
    if pin.encoding == "bcd":
        return int(f"{number:x}")
    if pin.encoding == "real":
        return float(struct.unpack("<f", struct.pack("<i", number))[0])
    if pin.scale:
        return float(Fraction(number) * Fraction(pin.scale).limit_denominator(10**6))
    if pin.encoding == "rotation":
        return {1: 1, 15: -1}.get(number, 0)
    return number
