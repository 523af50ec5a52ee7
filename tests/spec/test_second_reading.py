"""spec/remote_commands.toml agrees with a second, independent reading of the guide.

The second reading is in tests/spec/second_reading/. Both readings judge the same telegrams. If they
differ, one of them has misread its section of the guide, and the guide decides.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import pytest

import second_reading
from for_each import for_each
from rcx_harness import spec
from rcx_harness.spec.telegram import WORDS
from second_reading import Legal, Place, Reading, Row
from shown import differences

READINGS = second_reading.every_reading()
SHOWN = 12  # Number of values that a message names. More values would not help.


@dataclass(frozen=True)
class Difference:
    """A value that only one of the two readings accepts, and the reason of the other reading."""

    part: Place
    value: int
    legal: bool
    example: str


every_command = pytest.mark.parametrize(
    "reading", READINGS.values(), ids=[f"{code:03X}" for code in READINGS]
)
#: In the tests that take the most time, the quick tier uses every third command.
some_commands = pytest.mark.exhaustive(but=[f"{code:03X}" for code in list(READINGS)[::3]])


@for_each("reading", READINGS.values())
def test_the_reading_has_each_bit_exactly_once(reading: Reading) -> None:
    """The second reading has each bit exactly once.

    Otherwise both readings could miss bits that the section does not describe.

    Source: remote command guide 4.2 to 4.9, the tables of each command
    """
    for rows, zeros in ((reading.request, reading.zero), (reading.response, reading.unused)):
        plain = [part for entry in rows if not entry.conditions for part in entry.places]
        other = [part for entry in rows if entry.conditions for part in entry.places]
        seen = _union(other)
        for part in (*plain, *zeros):
            assert not part.mask & seen, f"{reading}: {part} is there twice"
            seen |= part.mask
        missing = [f"{2 * k}.{b}" for k, b in _bits(~seen)]
        assert not missing, f"{reading}: bits {', '.join(missing)} are nowhere"


def test_the_codes_are_those_of_the_sections() -> None:
    """Both readings have the codes of the sections: 116 commands besides the status reset.

    Source: remote command guide 4.2 to 4.9, row "Command code" of each command
    """
    codes = set(spec.commands()) - {0x000}
    odd = {f"{code:03X}" for code in codes ^ set(READINGS)}
    assert not odd, f"only in one of spec and second reading: {', '.join(sorted(odd))}"
    assert len(codes) == 116


@for_each("reading", READINGS.values())
def test_robot_designation_and_section_are_those_of_the_commands_table(reading: Reading) -> None:
    """A command has a robot designation if its own table has that row.

    Source: remote command guide 4.2 to 4.9, rows of n; 3., list for the programming box
    """
    command = _command(reading)
    section, category = reading.section.split(" ")[0], (reading.code >> 8) + 1
    robot_zero = reading.robot_zero or ("robot 1" if reading.robot else command.robot_zero)
    wrong = differences(
        ("robot designation", "programming box", "section", "category", "R = 0"),
        (command.robot, command.pendant, command.section, command.category, command.robot_zero),
        (reading.robot, reading.pendant, section, category, robot_zero),
    )
    assert not wrong, f"{reading}: in the spec, {wrong} in the section"


@for_each("reading", READINGS.values())
def test_fields_are_the_rows_of_the_commands_tables(reading: Reading) -> None:
    """Each row of a table is a field with the same bits and the same kind of number.

    All other bits are zero.

    Source: remote command guide 4.2 to 4.9, rows of n+2 to n+30 and m+2 to m+30
    """
    command = _command(reading)
    wrong: list[str] = []
    for side, rows, fields in (
        ("n", reading.request, command.request),
        ("m", reading.response, command.response),
    ):
        mine = {part: entry.what for entry in rows for part in entry.places}
        theirs = {part: entry.name for entry in fields for part in _places(side, entry)}
        both = mine.keys() & theirs.keys()
        either = {part.mask for part in both}  # rows may share bits under a condition
        lost = [part for part in _sorted(mine.keys() - both) if part.mask not in either]
        wrong += [f"{part} ({mine[part]}) is no field of the spec" for part in lost]
        more = _sorted(theirs.keys() - both)
        wrong += [f"{part} ({theirs[part]}) is no row of the section" for part in more]
    if wrong:
        pytest.fail(f"{reading}:\n  " + "\n  ".join(wrong))


@some_commands
@every_command
def test_both_readings_accept_the_same_requests(reading: Reading) -> None:
    """Both readings accept the same requests: values at and next to each limit, for each flag.

    Source: remote command guide 4.2 to 4.9, legend of each command's table
    """
    command = _command(reading)
    wrong: list[Difference] = []
    for entry in reading.request:
        for conditions in product(*_selections(reading, command, entry)):
            start = [0] * WORDS
            for part, value in conditions:
                part.write(start, value)
            kept = _union(part for part, _ in conditions)
            reading.mend(start, kept)
            for part in _tried(entry):
                for value in _candidates(part, entry, command.request):
                    words = list(start)
                    part.write(words, value)
                    reading.mend(words, kept | part.mask)
                    wrong += _judged(reading, command, words, part)
    _agree(reading, wrong)


@some_commands
@every_command
def test_both_readings_agree_on_each_single_bit(reading: Reading) -> None:
    """Both readings agree whether each single bit is legal: fixed, unused, and exclusive bits.

    Source: remote command guide 4.2 to 4.9, rows of n+2 to n+30
    """
    command = _command(reading)
    base = [0] * WORDS
    reading.mend(base)
    assert not reading.problem(base), f"{reading}: no legal request was found"
    every = [Place("n", 2 * k, b, 1) for k in range(1, WORDS) for b in range(16)]
    flags = [p for entry in reading.request for p in entry.places if p.width == 1]
    wrong: list[Difference] = []
    for group in (*((part,) for part in every), *combinations(flags, 2)):
        for mended in (False, True):
            words = list(base)
            for part in group:
                part.write(words, 1)
            if mended:
                reading.mend(words, _union(group))
            wrong += _judged(reading, command, words, group[-1])
    _agree(reading, wrong)


@every_command
def test_answers_have_the_values_of_the_section(reading: Reading) -> None:
    """Source: remote command guide 4.2 to 4.9, legend of each normal end's table."""
    command = _command(reading)
    wrong: list[Difference] = []
    fields = {part: entry for entry in command.response for part in _places("m", entry)}
    for entry in reading.response:
        for part in _tried(entry):
            if part not in fields or entry.conditions:
                continue
            for value in _candidates(part, entry, command.response):
                words = [0] * WORDS
                for other in entry.places:
                    other.write(words, second_reading.first(entry.legal))
                part.write(words, value)
                theirs = fields[part].problem(command.read_response(words))
                wrong += _difference(part, value, entry.problem(words), theirs)
    _agree(reading, wrong)


def _command(reading: Reading) -> spec.Command:
    if reading.code not in spec.commands():
        pytest.fail(f"{reading} is not in the spec")
    return spec.commands()[reading.code]


def _agree(reading: Reading, wrong: Sequence[Difference]) -> None:
    """Fail if there are differences, and name the fields, the values, and one request per field."""
    found: dict[tuple[Place, bool], list[Difference]] = {}
    for each in wrong:
        found.setdefault((each.part, each.legal), []).append(each)
    lines = []
    for (part, legal), every in found.items():
        values = sorted({each.value for each in every})
        shown = ", ".join(map(str, values[:SHOWN])) + ", ..." * (len(values) > SHOWN)
        judged = "legal by the section, not" if legal else "not legal by the section, but"
        lines.append(
            f"{part}{_name(reading, part)} = {shown}: {judged} by the spec; {every[0].example}"
        )
    if lines:
        pytest.fail(f"{reading}:\n  " + "\n  ".join(lines))


def _name(reading: Reading, part: Place) -> str:
    """Return a name for the bits: the field of the spec, or the row of the section."""
    command = _command(reading)
    for side, fields in (("n", command.request), ("m", command.response)):
        for entry in fields:
            if any(part.side == side and part.mask & one.mask for one in _places(side, entry)):
                return f" ({entry.name})"
    for row in (*reading.request, *reading.response):
        if part in row.places:
            return f" ({row.what})"
    return ""


def _judged(
    reading: Reading, command: spec.Command, words: Sequence[int], part: Place
) -> Iterator[Difference]:
    """Return the difference if the two sides judge this request differently."""
    shown = " ".join(f"n+{2 * k}=16#{words[k]:04X}" for k in range(1, WORDS) if words[k])
    found = part.read(words)
    for each in _difference(part, found, reading.problem(words), command.problem(words)):
        yield replace(each, example=f"{each.example}; request {shown or 'all 0'}")


def _difference(part: Place, number: int, mine: str, theirs: str) -> Iterator[Difference]:
    if bool(mine) != bool(theirs):
        yield Difference(part, number, not mine, mine or theirs)


def _places(side: str, entry: spec.Field) -> Iterator[Place]:
    """Return the places (word and bits) of a field of the spec, as in the second reading."""
    if entry.type == "bits":
        low, high = entry.bits
        yield Place(side, entry.at, low, high - low + 1)
        return
    size = entry.length if entry.type == "text" else entry.count
    text = f"text {size}" if entry.type == "text" else f"{entry.type} x{size}"
    yield from second_reading.place(f"{side}+{entry.at} {text}")


def _tried(entry: Row) -> tuple[Place, ...]:
    """Return the places of a row to test.

    Of a text, these are the first, second and last character.
    """
    text = entry.places[0].kind == "t"
    return (*entry.places[:2], entry.places[-1]) if text else entry.places


def _selections(
    reading: Reading, command: spec.Command, entry: Row
) -> Iterator[list[tuple[Place, int]]]:
    """Return the values to test for each place on which the row depends in one of the readings."""
    on: dict[Place, list[Legal]] = {}
    for other, when, _ in entry.conditions:
        on.setdefault(other, []).append(when)
    names = {field.name: field for field in command.request}
    for field in command.request:
        if field.by in names and set(_places("n", field)) & set(entry.places):
            on.setdefault(next(_places("n", names[field.by])), [])
    for part, cases in on.items():
        low, high = part.limits
        tried = {edge for case in cases for edge in case.edges()} | {0, 1}
        if part.width <= 6:
            tried = set(range(high + 1))
        yield [(part, value) for value in sorted(tried) if low <= value <= high]


def _candidates(part: Place, entry: Row, fields: Sequence[spec.Field]) -> list[int]:
    """Return values to test: all if they are few, else both sides of limits and each bit."""
    low, high = part.limits
    if part.width <= 6:
        return list(range(low, high + 1))
    tried = {low, 0, 1, high}.union(*(legal.edges() for _, _, legal in entry.conditions))
    tried |= entry.legal.edges() | {1 << bit for bit in range(part.width)}
    for field in fields:
        if part in _places(part.side, field):
            pairs = [field.range or (0, 0), *field.ranges.values()]
            edges = {int(edge) for pair in pairs for edge in pair} | set(field.values)
            tried |= {edge + beside for edge in edges for beside in (-1, 0, 1)}
    return sorted(value for value in tried if low <= value <= high)


def _union(places: Iterator[Place] | Sequence[Place]) -> int:
    whole = 0
    for part in places:
        whole |= part.mask
    return whole


def _bits(mask: int) -> Iterator[tuple[int, int]]:
    """Return word and number of each bit that is 1 in n+2 to n+30."""
    for k in range(1, WORDS):
        for bit in range(16):
            if mask >> (16 * k + bit) & 1:
                yield k, bit


def _sorted(places: Iterable[Place]) -> list[Place]:
    return sorted(places, key=lambda part: (part.at, part.low))
