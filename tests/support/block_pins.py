"""The meaning of a command block's pins, read by the tests directly from spec/blocks.toml.

Only the tables are shared with the generator of the blocks. A telegram is given by its fields and
their names; another module converts it into words.
"""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction

from pin_reading import refused_with
from rcx_harness.spec.telegram import Field, FieldValue, intervals
from rcx_tools.library.tables import Block, Input, Member, library
from structured_text.engines.base import Value

Pins = dict[str, Value]
Fields = dict[str, FieldValue]
Pair = tuple[int, int]

ARRAYS = library().arrays
_KINDS = library().enumerations

#: Below 2**13 a REAL has steps of less than half of 0.001. The blocks refuse larger values.
_EXACT = 2**13 * 1000 - 1
_RANGES = {"INT": (-(2**15), 2**15 - 1), "UINT": (0, 2**16 - 1), "DINT": (-(2**31), 2**31 - 1)}
_DEFAULTS: dict[str, Value] = {"BOOL": False, "REAL": 0.0, "STRING": ""}


def single(value: float) -> float:
    """Return the nearest single-precision number."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def pattern(value: float) -> int:
    """Return the bits of a single-precision number as a signed 32 bit integer."""
    return int(struct.unpack("<i", struct.pack("<f", value))[0])


def members(kind: str) -> Sequence[Member]:
    """Return the members of an enumeration type, or an empty sequence for other types."""
    return _KINDS[kind].members if kind in _KINDS else ()


def _element(kind: str) -> str:
    return ARRAYS[kind].of if kind in ARRAYS else kind


class Reading:
    """The request side of one block: its pins' meaning, and their legal and illegal values."""

    def __init__(self, block: Block) -> None:
        self.block = block
        self.command = block.commands[0]
        self.requests: Mapping[str, Field] = {
            one.name: _only(one, block.only.get(one.name)) for one in self.command.request
        }
        self.filler: dict[str, Input] = {}
        for pin in reversed(block.inputs):
            self.filler |= dict.fromkeys((*pin.to, pin.flag), pin)

    @property
    def pins(self) -> dict[str, Input]:
        """Return the inputs in the table, by name."""
        selected = [self.block.select] if self.block.select else []
        return {pin.pin: pin for pin in (*selected, *self.block.inputs)}

    def default(self, pin: Input) -> Value:
        """Return the value of an unconnected input, according to the table."""
        kind, text = _element(pin.type), pin.default
        value: Value = _DEFAULTS.get(kind, 0)
        if members(kind):
            value = text or members(kind)[0].name
        elif text:
            value = {"BOOL": text == "TRUE", "STRING": text.strip("'")}.get(kind)
            value = float(text) if kind == "REAL" else int(text) if value is None else value
        return [value] * ARRAYS[pin.type].count if pin.type in ARRAYS else value

    def code(self, pins: Pins) -> int:
        """Return word n of the telegram: the command code with the robot number."""
        command = self.command
        if self.block.select:
            names = [one.name for one in members(self.block.select.type)]
            command = self.block.commands[names.index(pins[self.block.select.pin])]
        return int(command.code | pins.get("RobotNumber", 0) << 12)

    def fields(self, pins: Pins) -> Fields:
        """Return the request's fields for the values of all pins."""
        fields = self._start()
        for pin in self.block.inputs:
            self._apply(fields, pin, pins[pin.pin])
        return fields

    def _start(self) -> Fields:
        every: Fields = {}
        for name, part in self.requests.items():
            blank: FieldValue = (0,) * part.count if part.count > 1 else part.fixed or 0
            every[name] = "" if part.type == "text" else blank
        return every

    def _counts(self, fields: Fields, pin: Input) -> bool:
        """Return whether the pin has an effect. `fields` has the values of the pins before it."""
        if pin.when:
            name, low, high = pin.when
            value = fields[name]
            if not (isinstance(value, int) and low <= value <= high):
                return False
        part = self.requests[pin.to[0]]
        return not part.by or part.by == pin.flag or fields[part.by] in part.ranges

    def _apply(self, fields: Fields, pin: Input, value: Value) -> None:
        if not self._counts(fields, pin) or (pin.flag and not value):
            return
        if pin.flag:
            fields[pin.flag] = 1
        if len(pin.to) > 1:
            names = [one.name for one in members(pin.type)]
            chosen = names.index(value)
            if chosen:
                fields[pin.to[chosen - 1]] = 1
            return
        part = self.requests[pin.to[0]]
        scale = self._scale(fields, pin, part)
        if pin.type in ARRAYS:
            fields[part.name] = tuple(_coded(pin, part, one, scale) for one in value)
        elif pin.type == "STRING":
            fields[part.name] = value
        else:
            fields[part.name] = _coded(pin, part, value, scale)

    def _scale(self, fields: Fields, pin: Input, part: Field) -> float:
        selector = fields[part.by] if part.by else None
        return pin.scale_by[selector] if isinstance(selector, int) and pin.scale_by else pin.scale

    # ---- legal values

    def draw(self, chance: random.Random, forced: Mapping[str, Value] | None = None) -> Pins:
        """Return legal values of all pins: the forced values as given, the others at random."""
        given = dict(forced or {})
        pins: Pins = {}
        if self.command.robot:
            pins["RobotNumber"] = chance.randint(0, 4)
        if self.block.select:
            pins[self.block.select.pin] = chance.choice(members(self.block.select.type)).name
        fields = self._start()
        for pin in self.block.inputs:
            value = given.get(pin.pin)
            if pin.pin not in given:
                room = self._room(pin, {**given, **pins})
                value = chance.choice(self._legal(fields, pin, chance, room))
            pins[pin.pin] = value
            self._apply(fields, pin, value)
        return {**pins, **given}

    def edges(self, chance: random.Random) -> Iterator[Pins]:
        """Return pin values in which each pin takes each of its limits, or each of a few values."""
        for name in ["RobotNumber"] * self.command.robot:
            yield from (self.draw(chance, {name: number}) for number in range(5))
        for member in members(self.block.select.type) if self.block.select else ():
            assert self.block.select
            yield self.draw(chance, {self.block.select.pin: member.name})
        for pin in self.block.inputs:
            for forced, fields in self._contexts(pin):
                for value in self._legal(fields, pin, chance, None):
                    yield self.draw(chance, {**forced, pin.pin: value})

    def _room(self, pin: Input, others: Pins) -> int | None:
        """Return the largest value of this factor for which the product of all factors is legal."""
        limits = self.command.product
        if not limits or pin.to[0] not in limits.fields:
            return None
        factors = [others.get(self.filler[name].pin, 1) for name in limits.fields]
        return int(limits.range[1] // math.prod(factors))

    def _contexts(self, pin: Input) -> Iterator[tuple[Pins, Fields]]:
        """Return each value of the pin on which this pin depends, with the resulting fields."""
        part = self.requests[pin.to[0]]
        names = {name for name in (part.by, pin.when and pin.when[0]) if name and name != pin.flag}
        names -= self.block.only.keys() - self.filler.keys()  # each block has a fixed value here
        fillers = {self.filler[name].pin: self.filler[name] for name in names}
        assert len(fillers) <= 1, "a pin depends on one other pin at most"
        if not fillers:
            yield {}, self._start()
        for name, filler in fillers.items():
            fixed = random.Random(name)
            for value in self._legal(self._start(), filler, fixed, None):
                fields = self._start()
                self._apply(fields, filler, value)
                yield {name: value}, fields

    def _legal(
        self, fields: Fields, pin: Input, chance: random.Random, room: int | None
    ) -> list[Value]:
        """Return legal values of a pin: all if there are few, else the limits and some between."""
        if pin.type in ARRAYS:
            count = ARRAYS[pin.type].count
            every = self._legal_scalars(fields, pin, chance, room)
            return [[chance.choice(every) for _ in range(count)] for _ in range(6)]
        return self._legal_scalars(fields, pin, chance, room)

    def _legal_scalars(
        self, fields: Fields, pin: Input, chance: random.Random, room: int | None
    ) -> list[Value]:
        kind = _element(pin.type)
        counts = self._counts(fields, pin)
        part = self.requests[pin.to[0]]
        if members(kind):
            names = [one.name for one in members(kind)]
            return [name for name in names if not (counts and self._wrong_member(pin, name))]
        if kind == "BOOL":
            return [False, True]
        if kind == "STRING":
            characters = _characters(part)
            long = "".join(chance.choices(characters, k=part.length))
            return [long, long[chance.randrange(part.length) :], *([] if counts else ["\t"])]
        if kind == "WORD":
            mask = part.mask >> part.bits[0]
            return [0, 1, mask, chance.randint(1, mask), chance.randint(1, mask)]
        if kind == "REAL" and pin.encoding == "real":
            return [0.0, 3.4028234663852886e38, -1.0, single(chance.uniform(-1e6, 1e6))]
        if not counts:
            return [single(-1e9), 1e9] if kind == "REAL" else list(_RANGES[kind])
        values: list[Value] = [0] if pin.flag else []
        per_unit = self._scale(fields, pin, part) or 1
        for low, high in self._pairs(fields, pin):
            top = min(high, room) if room else high
            few = range(low, top + 1) if top - low < 16 else ()
            values += few or [low, chance.randint(low, top), top]
        if kind == "REAL":
            return [single(float(Fraction(step) / Fraction(per_unit))) for step in values]
        return values

    def _wrong_member(self, pin: Input, name: str) -> bool:
        """Return whether this member of the enumeration is illegal in the command's field."""
        if len(pin.to) > 1:
            return False
        known = self.requests[pin.to[0]].values
        value = next(one.value for one in members(pin.type) if one.name == name)
        return bool(known) and value not in known

    def _pairs(self, fields: Fields, pin: Input) -> list[Pair]:
        """Return the ranges of legal values of a numeric pin, in the unit of the field."""
        part, kind = self.requests[pin.to[0]], _element(pin.type)
        if pin.range:
            return intervals(pin.range)
        limits = part.range or ()
        if part.by:
            selector = 1 if part.by == pin.flag else fields[part.by]
            assert isinstance(selector, int)
            limits = part.ranges[selector]
        pairs = intervals(limits) if limits else [(one, one) for one in sorted(part.values)]
        if not pairs:
            pairs = [_natural(part, pin.signed)]
        if pin.encoding == "bit":
            bits = [k for k in range(1, 17) if any(a <= 1 << k - 1 <= b for a, b in pairs)]
            numbers = [0] * (pairs[0][0] == 0) + bits
            return [(numbers[0], numbers[-1])]
        if pin.encoding == "bcd":
            return [(int(f"{low:x}"), int(f"{high:x}")) for low, high in pairs]
        if kind == "REAL" and not limits:
            return [(-_EXACT, _EXACT)]
        lowest, highest = _RANGES.get(kind, pairs[-1])
        return [(max(low, lowest), min(high, highest)) for low, high in pairs]

    # ---- illegal values

    def refused(self, chance: random.Random) -> Iterator[tuple[Pins, int]]:
        """Return pins with one illegal value, and the ErrorID that errors.md gives for it."""
        for number in [-1, 5, -32768, 32767] * self.command.robot:
            yield self.draw(chance, {"RobotNumber": number}), 0x8040
        for pin in self.block.inputs:
            for forced, fields in self._contexts(pin):
                for value, error in self._illegal(fields, pin):
                    if pin.type not in ARRAYS:
                        yield {**self.draw(chance, forced), pin.pin: value}, error
                        continue
                    for k in range(ARRAYS[pin.type].count):
                        pins = self.draw(chance, forced)
                        elements = [*pins[pin.pin]]
                        elements[k] = value
                        yield {**pins, pin.pin: elements}, error
        if self.command.product:
            names = [self.filler[name].pin for name in self.command.product.fields]
            for factors in ((2, 16384, 1), (32767, 1, 2), (32, 32, 32), (32767, 32767, 32767)):
                yield self.draw(chance, dict(zip(names, factors, strict=True))), 0x8045

    def _illegal(self, fields: Fields, pin: Input) -> Iterator[tuple[Value, int]]:
        kind = _element(pin.type)
        error = refused_with(pin.pin)
        part = self.requests[pin.to[0]]
        if kind == "WORD" and (pin.flag or self._counts(fields, pin)):
            width = (part.mask >> part.bits[0]).bit_length()
            yield from ((1 << bit, error) for bit in range(width, 16))
        if not self._counts(fields, pin) or kind in ("WORD", "BOOL"):
            return
        if members(kind):
            names = [one.name for one in members(kind) if self._wrong_member(pin, one.name)]
            yield from ((name, error) for name in names)
        elif kind == "STRING":
            known = _characters(part)
            strange = [chr(code) for code in range(1, 128) if chr(code) not in known + " "]
            inner = [] if " " in known else [" A", "A A", "A" * (part.length - 2) + " A"]
            yield from ((text, error) for text in inner)  # a space at the end is a filler
            yield from (("A" * length, error) for length in (part.length + 1, 60))
            yield from ((text, error) for text in strange)
            yield from (("A" * (part.length - 1) + text, error) for text in strange[::8])
        elif kind == "REAL" and pin.encoding == "real":
            yield from ((value, 0x8047) for value in (math.inf, -math.inf, math.nan))
        elif kind == "REAL":
            yield from self._illegal_reals(fields, pin, part, error)
        else:
            pairs = self._pairs(fields, pin)
            lowest, highest = _RANGES[kind]
            beyond = [value for low, high in pairs for value in (low - 1, high + 1)]
            tries = {lowest, highest, *beyond}
            for value in sorted(tries):
                given = value != 0 or not pin.flag
                inside = any(low <= value <= high for low, high in pairs)
                if given and not inside and lowest <= value <= highest:
                    yield value, error

    def _illegal_reals(
        self, fields: Fields, pin: Input, part: Field, error: int
    ) -> Iterator[tuple[Value, int]]:
        """Return values just beyond the limits and far beyond them, each with its ErrorID.

        The ErrorID is 16#8047 if the field has no limits.
        """
        ((low, high),) = self._pairs(fields, pin)
        natural = not part.range and not part.ranges
        per_unit = self._scale(fields, pin, part) or 1
        step = 2 if natural else 1
        near = [single((low - step) / per_unit), single((high + step) / per_unit)]
        for value in (*near, -1e30, 1e30, math.inf, -math.inf, math.nan):
            yield value, 0x8047 if natural else error


def _only(part: Field, sent: Sequence[int] | None) -> Field:
    """Return the field, restricted to the values that this block sends."""
    return part if sent is None else replace(part, values={k: part.values[k] for k in sent})


def _characters(part: Field) -> str:
    """Return the characters that are legal in a text field."""
    limits = part.range or next(iter(part.ranges.values()), (0x20, 0x7E))
    return "".join(chr(code) for low, high in intervals(limits) for code in range(low, high + 1))


def _natural(part: Field, signed: bool) -> Pair:
    """Return the lowest and the highest number that fit into a field."""
    width = {"u16": 16, "s16": 16, "s32": 32}.get(part.type, part.bits[1] - part.bits[0] + 1)
    if signed or part.type.startswith("s"):
        return -(2 ** (width - 1)), 2 ** (width - 1) - 1
    return 0, 2**width - 1


def _coded(pin: Input, part: Field, value: Value, scale: float) -> int:
    """Convert the value of a pin into the number in the telegram's field."""
    number = value
    if members(_element(pin.type)):
        number = next(one.value for one in members(_element(pin.type)) if one.name == value)
    elif pin.encoding == "bit":
        number = 1 << value - 1 if value else 0
    elif pin.encoding == "bcd":
        number = int(str(value), 16)
    elif pin.encoding == "real":
        number = pattern(value)
    elif scale:
        number = round(Fraction(single(value)) * Fraction(scale))
    if pin.signed and number < 0:
        number += 2 ** (part.bits[1] - part.bits[0] + 1)
    return int(number)
