"""Legal and illegal telegrams of every remote command, made from the table of their fields.

Illegal values are calculated from the limits in the table, without the check that the controller
uses.
"""

from __future__ import annotations

import random
import struct
from collections.abc import Iterator, Mapping
from itertools import combinations
from typing import Any

from rcx_harness.spec import Command, Field, FieldValue, commands

#: All commands except the status reset, by code.
COMMANDS: Mapping[int, Command] = {code: one for code, one in commands().items() if code}

_LIMITS = {"u16": (0, 0xFFFF), "s16": (-(2**15), 2**15 - 1), "s32": (-(2**31), 2**31 - 1)}
_PRINTABLE = tuple(chr(code) for code in range(0x20, 0x7F))

#: Limits that the table of fields does not have: an arch distance has no sign (guide 4.2.1), and
#: the robot limits the payload, here to 50 kg (4.4.2).
_PAYLOADS = {1: 50, 2: 50_000, 262: 50}
_WAYS = ("arch_distance1", "arch_distance2")


def legal(command: Command, chance: random.Random) -> dict[str, FieldValue]:
    """Return random legal values of all fields, with limits more often than values between them."""
    values: dict[str, FieldValue] = {}
    for part in sorted(command.request, key=lambda part: bool(part.by)):
        values[part.name] = _value(command, part, values, chance)
    for first, second in command.exclusive:
        if values[first] and values[second]:
            values[chance.choice((first, second))] = 0
    if command.product:
        one, two, three = command.product.fields
        low, high = command.product.range
        values[one] = chance.randint(low, high)
        values[two] = chance.randint(1, high // int(values[one]))  # type: ignore[arg-type]
        most = high // (values[one] * values[two])  # type: ignore[operator]
        values[three] = chance.choice((1, most))
    return values


def illegal_fields(command: Command) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Return telegrams in which one field has an illegal value, each with the reason."""
    for part in command.request:
        for selector in part.ranges or (None,):
            values = legal(command, random.Random(f"{command.code} {part.name} {selector}"))
            if selector is not None:
                values[part.by] = selector
            for first, second in command.exclusive:
                values[first] = values[second] = 0
            for other in command.request:  # fields that depend on the selector must stay legal
                if other.by and other.by == part.by and other is not part:
                    values[other.name] = _value(command, other, values, random.Random(0))
            for wrong in _wrong(part, selector):
                shown = f"{part.name} {wrong!r} ({part.by} {selector})"
                yield shown, words_of(command, {**values, part.name: wrong})


def stray_bits(command: Command) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Return telegrams in which a bit is set that must be 0 or belongs to an unused word."""
    covered = [0] * 16
    for part in command.request:
        for k in part.words:
            covered[k] |= part.mask
    words = words_of(command, legal(command, random.Random(command.code)))
    for k in range(1, 16):
        free = [bit for bit in range(16) if not covered[k] >> bit & 1]
        if not covered[k]:
            free = [0, 15, random.Random(command.code * 16 + k).randrange(1, 15)]
        for bit in free:
            yield f"n+{2 * k} bit {bit}", (*words[:k], words[k] | 1 << bit, *words[k + 1 :])


def illegal_pairs(command: Command) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Return telegrams with two flags that exclude each other, or with a product too large."""
    values = legal(command, random.Random(command.code))
    flags = sorted({name for pair in command.exclusive for name in pair})
    for first, second in combinations(flags, 2):
        pair = {**dict.fromkeys(flags, 0), first: 1, second: 1}
        yield f"{first} and {second}", words_of(command, {**values, **pair})
    if command.product:
        one, two, three = command.product.fields
        high = command.product.range[1]
        for factors in ((high, 2, 1), (1, high, 2), (2, 1, high), (182, 181, 1), (32, 32, 32)):
            wrong = dict(zip((one, two, three), factors, strict=True))
            yield f"product of {factors}", words_of(command, {**values, **wrong})


def words_of(command: Command, values: Mapping[str, Any]) -> tuple[int, ...]:
    """Return the 16 words of these values. The values may be illegal; the robot number is 0."""
    words = [command.code] + [0] * 15
    for part in command.request:
        _store(words, part, values[part.name])
    return tuple(words)


def _intervals(limits: tuple[int, ...]) -> list[tuple[int, int]]:
    return [(limits[k], limits[k + 1]) for k in range(0, len(limits), 2)]


def _width(part: Field) -> tuple[int, int]:
    """Return the lowest and highest number that the bits of the field can hold."""
    if part.type == "bits":
        return 0, (1 << (part.bits[1] - part.bits[0] + 1)) - 1
    return _LIMITS[part.type]


def _allowed(part: Field, values: Mapping[str, FieldValue]) -> tuple[int, ...] | None:
    """Return the legal limits of the field with these values, or None if every number is legal."""
    if not part.by:
        return part.range
    return part.ranges.get(values[part.by])  # type: ignore[arg-type]


def _value(
    command: Command, part: Field, values: Mapping[str, FieldValue], chance: random.Random
) -> FieldValue:
    allowed = _allowed(part, values)
    if part.type == "text":
        legal_ones = [c for c in _PRINTABLE if _inside(ord(c), allowed or (0x20, 0x7E))]
        length = chance.choice((0, 1, part.length, chance.randint(0, part.length)))
        return "".join(chance.choice(legal_ones) for _ in range(length)).rstrip()
    every = tuple(_number(command, part, values, allowed, chance) for _ in range(part.count))
    return every if part.count > 1 else every[0]


def _number(
    command: Command,
    part: Field,
    values: Mapping[str, FieldValue],
    allowed: tuple[int, ...] | None,
    chance: random.Random,
) -> int:
    if part.values:
        return chance.choice(list(part.values))
    low, high = chance.choice(_intervals(allowed)) if allowed else _width(part)
    if command.name == "WriteParameter" and part.name == "value":
        high = _PAYLOADS.get(int(str(values["parameter"])), high)
    if part.name in _WAYS:
        low = 0
    number = chance.choice((low, high, chance.randint(low, high), chance.randint(low, high)))
    if part.one_bit:
        single = [1 << bit for bit in range(16) if low <= 1 << bit <= high]
        return chance.choice(single) if single else number
    if part.name == "value" and int(values.get("variable1", 0)) >= 256:  # type: ignore[arg-type]
        real = chance.choice((0.0, -1.5, 3.25e38, chance.uniform(-1e6, 1e6)))
        return int(struct.unpack("<i", struct.pack("<f", real))[0])
    return number


def _inside(number: int, limits: tuple[int, ...]) -> bool:
    return any(low <= number <= high for low, high in _intervals(limits))


def _wrong(part: Field, selector: int | None) -> Iterator[FieldValue]:
    """Return illegal values that the bits of the field can hold."""
    limits = part.range if selector is None else part.ranges[selector]
    if part.type == "text":
        for code in range(1, 0xFF):
            if not _inside(code, limits or (0x20, 0x7E)):
                place = code % 16
                yield "A" * place + chr(code) + "A" * (15 - place)
        yield "A\0B"
        return
    low, high = _width(part)
    if part.values:
        near = range(low, high + 1) if high < 256 else _near(part.values, low, high)
        yield from (number for number in near if number not in part.values)
        return
    if limits is None:
        return
    edges = {edge for pair in _intervals(limits) for edge in pair}
    for number in _near(edges, low, high):
        if not _inside(number, limits):
            yield number
    if part.one_bit:
        yield from (
            number
            for number in range(1, 1 << 6)
            if number & (number - 1) and _inside(number, limits)
        )


def _near(numbers: Any, low: int, high: int) -> list[int]:
    """Return the neighbours of the numbers, and the limits of the field's range."""
    near = {number + way for number in numbers for way in (-1, 1)} | {low, high}
    return sorted(number for number in near if low <= number <= high)


def _store(words: list[int], part: Field, value: Any) -> None:
    """Write the value of a field into its words of the telegram."""
    if part.type == "bits":
        words[part.at // 2] = words[part.at // 2] & ~part.mask | value << part.bits[0]
        return
    if part.type == "text":
        raw = value.encode("latin-1").ljust(part.length)
    else:
        code = {"u16": "H", "s16": "h", "s32": "i"}[part.type]
        every = value if isinstance(value, tuple) else (value,)
        raw = struct.pack(f"<{part.count}{code}", *every)
    for k, word in enumerate(struct.unpack(f"<{len(raw) // 2}H", raw)):
        words[part.at // 2 + k] = word
