"""Each command block behaves as the description of its pins in spec/blocks.toml.

The test simulates the controller. It does not use the generator of the blocks;
tests/support/block_pins and block_answers read the tables directly. Telegrams are decoded with
spec/remote_commands.toml, which test_worked_examples.py compares with the examples of the guide.
"""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from datetime import timedelta
from itertools import islice

import pytest

from block_answers import answered, blank, in_words, same, shown
from block_pins import Pins, Reading
from both_engines import ENGINES
from command_bench import BLOCKS, CommandBench, bench_of
from rcx_harness.spec.telegram import WORDS, Command, FieldValue
from structured_text.language.types import BlockType
from structured_text.output.units import parse_us

pytestmark = [
    pytest.mark.parametrize("engine", ENGINES, scope="module"),
    pytest.mark.parametrize("name", list(BLOCKS), scope="module"),
]
#: In the slowest tests, the quick run uses only every second block.
_SOME = pytest.mark.exhaustive(but=[f"builtin-{name}" for name in list(BLOCKS)[::2]])

_NOTHING = [0] * WORDS

#: Field values that no pin can select. The comments give the reasons.
_UNREACHABLE = {
    "hand": {3: "none, as 0"},
    "data_number": {63: "several data at once", 15: "several data at once"},
}

#: Fields that are always 0 in a block's telegram, because another block sets them.
_ZERO = {
    "FB_ReadPositionPulses": ("continuous",),  # FB_ContinuousPosition
    "FB_ReadPositionMm": ("continuous",),
    "FB_WriteScaraHand": ("data4",),  # FB_WriteHand
    "FB_ReadProgramInfo": ("task", "program_name"),
    "FB_ReadProgramInfoByTask": ("program", "program_name"),
    "FB_ReadProgramInfoByName": ("program", "task"),
}


#: Blocks that send only one value of a field, because other blocks send the other values: method
#: (guide 4.6.4).
_ONLY_VALUES = {
    "FB_ReadProgramInfo": {"method": (1,)},
    "FB_ReadProgramInfoByTask": {"method": (2,)},
    "FB_ReadProgramInfoByName": {"method": (4,)},
}


@pytest.fixture
def plc(engine: str, name: str) -> CommandBench:
    return bench_of(name, engine)


@pytest.fixture
def reading(name: str) -> Reading:
    return Reading(BLOCKS[name])


@pytest.fixture
def chance(name: str) -> random.Random:
    """Return a random generator that gives the same numbers in every run."""
    return random.Random(name)


def _read(command: Command, words: Sequence[int]) -> dict[str, FieldValue]:
    """Decode the fields of a telegram, and check that all other bits are 0.

    A text includes its trailing spaces. Words of 0 give an empty text.
    """
    fields = command.decode(words)
    again = [0] * WORDS
    for part in command.request:
        if part.type == "text":
            raw = b"".join(words[k].to_bytes(2, "little") for k in part.words)
            fields[part.name] = raw.decode("latin-1").strip("\0")
            for k in part.words:
                again[k] = words[k]
        else:
            part.write(again, fields[part.name])
    assert list(words[1:]) == again[1:], "bits are set outside of all fields"
    return fields


def _expected(reading: Reading, pins: Pins) -> dict[str, FieldValue]:
    """Return the field values that the pins must give. A text is padded with spaces."""
    fields = reading.fields(pins)
    for pin in reading.block.inputs:
        if pin.type == "STRING" and (not pin.when or fields[pin.when[0]] == pin.when[1]):
            text = str(fields[pin.to[0]])
            fields[pin.to[0]] = text.ljust(reading.requests[pin.to[0]].length)
    return fields


def _check(reading: Reading, pins: Pins, words: Sequence[int]) -> dict[str, FieldValue]:
    assert words[0] == reading.code(pins), pins
    fields = _read(reading.command, words)
    assert fields == _expected(reading, pins), pins
    assert reading.command.problem(words) == ""
    return fields


def _draws(reading: Reading, chance: random.Random, rounds: int = 20) -> Iterator[Pins]:
    yield from (reading.draw(chance) for _ in range(rounds))


def _another(reading: Reading, chance: random.Random, first: Pins) -> Pins:
    """Return pin values that give another telegram than `first`, if the block has such values."""
    draws = list(_draws(reading, chance))
    telegram = (reading.code(first), reading.fields(first))
    others = (one for one in draws if (reading.code(one), reading.fields(one)) != telegram)
    return next(others, draws[0])


def test_the_pins_are_those_of_the_table(plc: CommandBench, reading: Reading) -> None:
    """Names, types and defaults of all pins, also of Timeout, are those of the table."""
    block = reading.block
    kind = plc.program.type_of(f"Main.{block.name.removeprefix('FB_')}Block")
    assert isinstance(kind, BlockType)
    robot = {"RobotNumber": "INT"} if reading.command.robot else {}
    inputs = {pin.pin: pin.type for pin in reading.pins.values()} | robot
    outputs = {pin.pin: pin.type for pin in block.outputs}
    common_inputs = {"Execute": "BOOL", "Timeout": "TIME"}
    flags = dict.fromkeys(("Done", "Busy", "Active", "Error"), "BOOL")
    words = dict.fromkeys(("ErrorID", "AlarmGroup", "AlarmCategory"), "WORD")
    for section, names in (
        ("VAR_INPUT", inputs | common_inputs),
        ("VAR_OUTPUT", outputs | flags | words),
    ):
        there = {one.name: one.type for one in kind.variables if one.section == section}
        assert {name: getattr(one, "name", "") for name, one in there.items()} == names
    for pin in reading.pins.values():
        assert plc.pin(pin.pin) == reading.default(pin), pin.pin
    limit = timedelta(microseconds=parse_us(block.timeout))
    assert plc.pin("Timeout") == limit


def test_a_block_with_its_defaults_sends_a_legal_command(
    plc: CommandBench, reading: Reading
) -> None:
    """A block with its default inputs sends a legal command. Source: design of the library, 3."""
    pins = {pin.pin: reading.default(pin) for pin in reading.pins.values()}
    _check(reading, pins, plc.exchange({}))


def test_the_telegram_has_the_values_of_the_pins(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """Random legal pin values give the right telegram. Pins without an effect get random values."""
    for pins in _draws(reading, chance):
        _check(reading, pins, plc.exchange(pins))


@_SOME
def test_every_value_of_every_field_can_be_sent(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """The telegrams contain the limits of numbers, all listed values, and each flag ON and OFF."""
    command = reading.command
    codes = set()
    sent = []
    assert reading.block.zero == _ZERO.get(reading.block.name, ())
    assert reading.block.only == _ONLY_VALUES.get(reading.block.name, {})
    for pins in [*reading.edges(chance), *_draws(reading, chance)]:
        words = plc.exchange(pins)
        codes.add(words[0])
        sent.append(_check(reading, pins, words))
    assert {code & 0x0FFF for code in codes} == {one.code for one in reading.block.commands}
    assert {code >> 12 for code in codes} == set(range(5 if command.robot else 1))
    for part in reading.requests.values():
        if part.name in reading.block.zero:
            continue
        if part.fixed is not None:
            assert {fields[part.name] for fields in sent} == {part.fixed}
            continue
        seen = {fields[part.name] for fields in sent}
        never = set(_UNREACHABLE.get(part.name, ()))
        assert len(seen) > 1, f"{part.name} never changes in the telegrams"
        assert {*part.values, *(part.range or ())} - never <= seen, part.name
        selectors = reading.requests[part.by].values if part.by else {}
        for selector, limits in part.ranges.items():
            if selectors and selector not in selectors:
                continue  # another block sends this value
            there = {fields[part.name] for fields in sent if fields[part.by] == selector}
            assert part.type == "text" or {*limits} - never <= there, f"{part.name} of {selector}"


def test_illegal_pins_end_in_an_error_and_send_nothing(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """An illegal input gives its ErrorID, and nothing is sent.

    Source: docs/reference/errors.md, 16#8040 to 16#8047.
    """
    for pins, error in reading.refused(chance):
        plc.set({**pins, "Execute": True})
        plc.scan()
        assert plc.words == _NOTHING, pins
        plc.scan()
        assert plc.shown == ["Error"], pins
        assert plc.pin("ErrorID") == error, pins
        for _ in range(2):
            assert plc.words == _NOTHING, pins
            plc.scan()
        plc.set({"Execute": False})
        plc.scan()
        assert plc.words == _NOTHING, pins
        assert plc.shown == []
        legal = reading.draw(chance)
        _check(reading, legal, plc.exchange(legal))


def test_the_inputs_are_sampled_on_the_rising_edge(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """Inputs that change after the rising edge have no effect on the command."""
    for _ in range(5):
        first = reading.draw(chance)
        other = _another(reading, chance, first)
        plc.answer(0x0200)
        plc.set({**first, "Execute": True})
        plc.scan(3)
        assert plc.words[0] == 0, "nothing may be sent before the ready status"
        assert plc.shown == ["Busy", "Active"]
        plc.set(other)
        plc.answer(0)
        plc.scan_until(lambda: plc.words[0] != 0, most=3)
        _check(reading, first, plc.words)
        plc.set(reading.draw(chance))
        plc.answer(0x0100, scans=2)
        _check(reading, first, plc.words)
        plc.end()
        for illegal, _error in islice(reading.refused(chance), 1):
            plc.set(illegal)
        plc.answer(0, scans=3)
        assert plc.shown == ["Done"]
        plc.finish()


@_SOME
def test_the_outputs_show_the_response(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """At a normal end the outputs show the response, and keep it until the next end.

    The inputs change before the end, which has no effect.
    """
    block = reading.block
    before = blank(block)
    for pins in _draws(reading, chance, 40):
        got = answered(block, chance)
        plc.send(pins)
        plc.set(reading.draw(chance))
        plc.answer(0x0100, [0xFFFF] * 15, scans=1)
        assert plc.shown == ["Busy", "Active"]
        _compare(plc, before)
        expected = shown(block, reading.fields(pins), got)
        plc.end(response=in_words(block, got, chance))
        assert plc.shown == ["Done"]
        _compare(plc, expected)
        plc.answer(0, [0xFFFF] * 15, scans=1)
        plc.finish()
        assert plc.shown == []
        _compare(plc, expected)
        before = expected


@_SOME
def test_an_abnormal_end_clears_the_outputs_and_shows_the_alarm(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """After an abnormal end, only the alarm is shown. Source: remote command guide 1.1, 0x4000."""
    block = reading.block
    for group, category in ((12, 600), (12, 400), (2, 334)) * 4:
        got = answered(block, chance)
        plc.exchange(reading.draw(chance), in_words(block, got, chance))
        plc.send(reading.draw(chance))
        plc.end(0x4000, [group, category, *[0x0101] * 13])
        assert plc.shown == ["Error"]
        assert plc.pin("ErrorID") == 0x8020
        assert (plc.pin("AlarmGroup"), plc.pin("AlarmCategory")) == (group, category)
        _compare(plc, blank(block))
        plc.scan()
        assert (plc.pin("AlarmGroup"), plc.pin("AlarmCategory")) == (group, category)
        plc.finish()
        assert (plc.pin("AlarmGroup"), plc.pin("AlarmCategory")) == (0, 0)


def _compare(plc: CommandBench, expected: Pins) -> None:
    got = plc.pins(expected)
    for name, value in expected.items():
        assert same(got[name], value), f"{name} is {got[name]}, not {value}"


def test_only_a_rising_edge_samples_the_inputs(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """Only a rising edge while the block is not Busy samples the inputs.

    Source: design of the library, 3.
    """
    limits = [timedelta(seconds=number) for number in (11, 12, 13)]
    for first in _draws(reading, chance, 3):
        other = _another(reading, chance, first)
        plc.send({**first, "Timeout": limits[0]})
        held = _held(plc)
        plc.set({"Execute": False})
        plc.scan()
        plc.set({**other, "Timeout": limits[1], "Execute": True})
        plc.scan()
        assert _held(plc) == held, "an edge while Busy has no effect"
        plc.end()
        plc.answer(0)
        refused = [pins for pins, _error in islice(reading.refused(chance), 5)]
        for pins in [other, *refused, reading.draw(chance)]:
            plc.set({**pins, "Timeout": limits[2]})
            plc.scan()
            assert plc.shown == ["Done"]
            assert _held(plc) == held, f"after Done: {pins}"
        plc.finish()
        for pins in refused[:1]:
            plc.set({**pins, "Execute": True})
            plc.scan(2)
            held = _held(plc)
            plc.set({**other, "Timeout": limits[0]})
            plc.scan()
            assert plc.shown == ["Error"]
            assert _held(plc) == held, f"after an error: {other}"
            plc.finish()


def test_an_edge_right_after_the_end_starts_the_block_again(
    plc: CommandBench, reading: Reading, chance: random.Random
) -> None:
    """Execute falls before the end, so Done is TRUE for one scan.

    Execute rises in the call after the end, and the block starts again.
    """
    first = reading.draw(chance)
    other = _another(reading, chance, first)
    plc.send(first)
    plc.set({"Execute": False})
    plc.end()
    assert plc.shown == ["Done"]
    plc.answer(0)
    plc.set({**other, "Execute": True})
    plc.scan_until(lambda: plc.words[0] != 0, most=3)
    _check(reading, other, plc.words)


def _held(plc: CommandBench) -> Pins:
    """Return the values that the block has stored at the edge, in itself and in its job."""
    kind = plc.program.type_of(f"Main.{plc.instance}")
    assert isinstance(kind, BlockType)
    own = [one.name for one in kind.variables if one.section == "VAR"]
    # the omitted variables do not store inputs
    kept = [name for name in own if name not in ("Job", "k", "Number")]
    return plc.pins([*kept, "Job.Holder", "Job.Trouble", "Job.Longest"])
