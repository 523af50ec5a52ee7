"""Each enumeration value of each command block gives the words that the manual demands.

The expected words are in tests/spec/second_reading/pins, which was written from the manual alone.
The tests do not use spec/blocks.toml and spec/remote_commands.toml.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache

import pytest

import second_reading
from command_bench import CommandBench, bench_of
from for_each import for_each
from pin_reading import PinRow, Pins, every_block, every_enumeration, hexadecimal
from rcx_harness.spec.telegram import WORDS
from structured_text.engines.base import Value

READINGS = second_reading.every_reading()
BLOCKS = every_block()
_LEVELS = [name for name, block in BLOCKS.items() if block.level]

every_block_of_the_reading = pytest.mark.parametrize(
    "block", BLOCKS.values(), ids=[name.removeprefix("FB_") for name in BLOCKS]
)


@cache
def _levels() -> CommandBench:
    return CommandBench(_LEVELS, "builtin")


def _bench(block: Pins) -> CommandBench:
    """Return the bench in its initial state, with all pins at their defaults."""
    if not block.level:
        return bench_of(block.name, "builtin")
    bench = _levels()
    bench.choose(block.name)
    return bench


def _start(block: Pins, bench: CommandBench, pins: dict[str, Value]) -> None:
    """Start the block with these pins while the data words of an earlier command remain."""
    bench["Robot.Inner.Data"] = [0xFFFF] * 15
    bench.set({**pins, "Enable" if block.level else "Execute": True})
    bench.scan_until(lambda: bench.words[0] != 0 or bool(bench.pin("Error")), most=4)


def _sent(block: Pins, pins: dict[str, Value], robot: int = 0) -> str:
    """Send a command with these pins, and return the error in its telegram, or ""."""
    expected = block.telegram(pins, robot)
    illegal = READINGS[expected[0] & 0xFFF].problem(expected)
    bench = _bench(block)
    _start(block, bench, {**pins, "RobotNumber": robot} if block.robot else pins)
    if illegal:
        refused = bench.pin("Error") and not any(bench.words)
        return "" if refused else f"sends {hexadecimal(bench.words)}, though {illegal}"
    if bench.pin("Error"):
        return f"is refused with 16#{bench.pin('ErrorID'):04X}, not {hexadecimal(expected)}"
    if bench.words != expected:
        return f"sends {hexadecimal(bench.words)}, not {hexadecimal(expected)}"
    return ""


@for_each("block", BLOCKS.values())
def test_each_enumeration_value_is_sent_as_in_the_manual(block: Pins) -> None:
    """Each enumeration value of an input gives the words of the manual.

    Source: remote command guide 4.2 to 4.9, code and legend of each command's table.
    """
    wrong = []
    for pin, member in block.enumerated:
        value: Value = member if member not in ("FALSE", "TRUE") else member == "TRUE"
        problem = _sent(block, block.given(**{pin: value}))
        wrong += [f"{block}: {pin} = {member} {problem}"] * bool(problem)
    assert not wrong, "\n".join(wrong)


#: Enumeration values that some commands do not have, with the text of the manual's tables.
_MISSING_MEMBERS = {
    "SPEED_MM_S": "speed set in mm/s: linear and circular interpolation only",
    "PORT_DI": "an input cannot be assigned",
    "PORT_SI": "an input cannot be assigned",
    "SELECT_ALL_PROGRAMS": "enabled only when using the program RUN command, and for the reset",
    "SELECT_TASK_NUMBER": "4.6.1: program number or program name",
}


def test_only_values_that_the_commands_table_lacks_are_refused() -> None:
    """Only values that are missing in a command's table are refused.

    Source: remote command guide 4.2 to 4.9, legend of each command's table.
    """
    refused = set()
    for block in BLOCKS.values():
        for pin, member in block.enumerated:
            value: Value = member if member not in ("FALSE", "TRUE") else member == "TRUE"
            words = block.telegram(block.given(**{pin: value}))
            if READINGS[words[0]].problem(words):
                refused.add(member)
    assert refused == set(_MISSING_MEMBERS)


@for_each("block", BLOCKS.values())
def test_robots_and_defaults_are_sent_as_in_the_manual(block: Pins) -> None:
    """With default pins, bits 15 to 12 of n contain the robot number if the command has one.

    Source: remote command guide 4.2 to 4.9, robot designation.
    """
    for robot in range(5 if block.robot else 1):
        problem = _sent(block, block.given(), robot)
        assert not problem, f"{block}: RobotNumber = {robot} {problem}"


@every_block_of_the_reading
def test_each_other_pin_is_sent_in_its_word_and_unit(block: Pins) -> None:
    """Each number or text is sent in the word and unit of the manual.

    The test sends the lowest and highest legal numbers, or typical ones if the manual has no
    limits.

    Source: remote command guide 4.2 to 4.9, legend of each command's table.
    """
    wrong = []
    for entry in block.inputs:
        if entry.members or entry.how == "bool":
            continue
        pins: dict[str, Value] = {}
        if entry.where:
            number = entry.where[1].isdecimal()
            value: Value = int(entry.where[1]) if number else entry.where[1]
            pins[entry.where[0]] = True if value == "TRUE" else value
        for value in _values(block, entry, pins):
            problem = _sent(block, block.given(**pins, **{entry.pin: value}))
            wrong += [f"{block}: {entry}, {value!r} {problem}"] * bool(problem)
    assert not wrong, "\n".join(wrong)


@every_block_of_the_reading
def test_each_answer_is_shown_as_in_the_manual(block: Pins) -> None:
    """Each output shows its part of an answer.

    Source: remote command guide 4.2 to 4.9, normal end of each command.
    """
    wrong = []
    for entry in block.outputs:
        for response in _responses(entry):
            pins: dict[str, Value] = {}
            if entry.where and entry.where[0].startswith("m+"):
                low = entry.where[1].partition("..")[0]
                second_reading.place(entry.where[0])[0].write(response, int(low))
            elif entry.where:
                pins[entry.where[0]] = entry.where[1]
            wrong += list(_shown(block, block.given(**pins), response))
    assert not wrong, "\n".join(dict.fromkeys(wrong))


def _shown(block: Pins, pins: dict[str, Value], response: list[int]) -> Iterator[str]:
    """Answer a command, and yield the outputs that differ from the second reading of the manual."""
    bench = _bench(block)
    _start(block, bench, pins)
    assert not bench.pin("Error"), f"{block}: 16#{bench.pin('ErrorID'):04X}"
    status = 0x0100 if block.name == "FB_ContinuousPosition" else 0x0200
    bench.end(status, response[1:])
    for entry in block.outputs:
        expected = entry.shown(response if entry.counts(pins, response) else [0] * WORDS)
        got = bench.pin(entry.pin)
        if not _same(got, expected):
            answer = hexadecimal(response).replace("n", "m")
            yield f"{block}: {entry} shows {got!r}, not {expected!r}, with {answer}"


def _responses(entry: PinRow) -> Iterator[list[int]]:
    """Yield answers with a value for one output, in each of its words alone and in all of them."""
    if entry.how == "text":
        words = [0] * WORDS
        for part, letter in zip(entry.places, b"AB_19 Z".ljust(len(entry.places)), strict=True):
            part.write(words, letter)
        yield words
        return
    for part in entry.places:
        for value in _answers(entry, part):
            words = [0] * WORDS
            part.write(words, value)
            yield words


def _answers(entry: PinRow, part: second_reading.Place) -> Sequence[int]:
    if entry.members:
        return [one.value for one in entry.members if one.value is not None]
    if entry.how == "bcd":
        return [0x00, 0x07, 0x10, 0x27]
    if entry.how == "real":
        return [0x3FC00000, 0x40490FDB]
    if entry.how in ("bool", "rotation"):
        return [value for value in range(16) if value <= part.limits[1]]
    if part.width == 32:
        return [-12345, 1, 0x00010000, 123456]
    return [value for value in (1, 0x34, 0x1234) if value <= part.limits[1]]


def _values(block: Pins, entry: PinRow, pins: dict[str, Value]) -> Iterator[Value]:
    """Yield legal values of an input, according to the second reading of the manual."""
    words = block.telegram(block.given(**pins))
    if entry.flag:
        entry.flag.write(words, 1)
    rows = READINGS[words[0] & 0xFFF].request
    row = next((one for one in rows if entry.places[0] in one.places), None)
    if entry.how == "text":
        yield from ("A", "AB_19", "ABCDEFGHIJKLMN_9")
    elif entry.how == "real":
        yield from (1.5, -2.25, 0.0)
    else:
        assert row, f"{block}: {entry} is no row of {READINGS[words[0] & 0xFFF]}"
        for raw in _legal(entry, row.allowed(words)):
            yield _pin_value(entry, raw)


def _legal(entry: PinRow, legal: second_reading.Legal) -> Iterator[int]:
    width = entry.places[0].width
    if legal.one_bit or entry.how == "bit":
        yield from (1 << bit for bit in range(width))
    elif entry.how == "number" and width == 4:
        yield from (0, 1, -1)  # arm rotation
    elif legal.anything:
        yield from {32: (12345, -54321, 7), 16: (0x1234,)}.get(width, ((1 << width) - 1, 1))
    else:
        yield from (edge for pair in legal.ranges for edge in pair if edge or not entry.flag)


def _pin_value(entry: PinRow, raw: int) -> Value:
    value: Value = raw
    if entry.how == "bit":
        value = raw.bit_length()
    elif entry.how == "bcd":
        value = int(f"{raw:x}")
    elif entry.scale:
        value = raw / entry.scale
    count = len(entry.places)
    return value if count == 1 else [value * (-1) ** k * (k + 1) for k in range(count)]


def _same(got: Value, expected: Value) -> bool:
    if isinstance(expected, list):
        return all(_same(one, two) for one, two in zip(got, expected, strict=True))
    if isinstance(expected, float):
        return bool(abs(got - expected) <= abs(expected) * 2.0**-22)
    return bool(got == expected)


def test_every_member_of_every_type_was_sent_or_shown() -> None:
    """Each enumeration type is a pin's type or selects a code.

    Source: remote command guide 4.2 to 4.9.
    """
    used = {entry.how for block in BLOCKS.values() for entry in (*block.inputs, *block.outputs)}
    chosen = {frozenset(block.codes) for block in BLOCKS.values()}
    for name, members in every_enumeration().items():
        names = frozenset(one.name for one in members)
        assert name in used or names in chosen, name


@pytest.mark.parametrize(
    "block", [one for one in BLOCKS.values() if not one.level], ids=lambda one: str(one.name)
)
def test_a_command_without_an_end_fails_after_its_default_time_limit(block: Pins) -> None:
    """The default time limit is 60 s for movements, and 5 s for other commands.

    Source: design of the library: time limits are those of docs/reference/blocks.md; the manual
    has none.
    """
    bench = _bench(block)
    _start(block, bench, block.given())
    bench.answer(0x0100)
    begin, bench.scan_us = bench.now_us, 250_000
    try:
        bench.scan_until(lambda: bool(bench.pin("Error")), most=block.limit * 4 + 8)
    finally:
        bench.scan_us = 10_000
    waited = (bench.now_us - begin) / 1e6
    assert bench.pin("ErrorID") == 0x8011, f"{block}: 16#{bench.pin('ErrorID'):04X}"
    assert block.limit - 1 <= waited <= block.limit + 1, f"{block} fails after {waited:.2f} s"
