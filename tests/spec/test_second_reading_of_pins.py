"""spec/blocks.toml, the types of plc/lib and the signals agree with a second reading.

tests/command/test_every_member.py checks the words on the wire. These tests check names, defaults
and meanings, which telegrams do not show.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

import pytest

from for_each import for_each
from pin_reading import PinRow, Pins, every_block, every_enumeration
from plc_bench import LIBRARY
from rcx_harness import spec
from rcx_harness.spec.telegram import WORDS, Command, Field
from rcx_tools.library.tables import library
from second_reading import FOLDER, every_reading
from structured_text.language import syntax as s
from structured_text.language.parser import parse
from structured_text.output.toml_files import load_toml

FILES = {file.stem: file for file in LIBRARY}
ENUMERATIONS = every_enumeration()
MEANINGS: list[dict[str, Any]] = load_toml(FOLDER / "pins/meanings.toml")["rows"]
#: Pins that each command block has besides the pins of its command.
_ALWAYS = {"Execute", "Enable", "RobotNumber", "Timeout"}


def _place(row: dict[str, Any]) -> str:
    return f"{row['place']}-0x{row['codes'][:3]}"


every_type = pytest.mark.parametrize("name", ENUMERATIONS)
every_block_of_the_reading = pytest.mark.parametrize(
    "block", every_block().values(), ids=list(every_block())
)


def test_both_readings_have_the_same_types_and_blocks() -> None:
    """The tables and the second reading have the same types and blocks."""
    odd = set(ENUMERATIONS) ^ set(library().enumerations)
    odd |= set(every_block()) ^ set(library().blocks)
    assert not odd, f"only in one of spec and second reading: {', '.join(sorted(odd))}"


@every_type
def test_each_member_has_the_value_and_the_meaning_of_the_manuals_table(name: str) -> None:
    """Each member of a type has the value and the meaning of the manual.

    A type that selects a command has no values on the wire. Its members count from 0.

    Source: the section that tests/spec/second_reading/pins/members.toml names.
    """
    members = {one.name: one for one in library().enumerations[name].members}
    wrong = [f"{one} is no member of the reading" for one in members]
    for place, mine in enumerate(ENUMERATIONS[name]):
        if mine.name not in members:
            wrong.append(f"{mine.name} is no member of the spec")
            continue
        wrong.remove(f"{mine.name} is no member of the reading")
        one = members[mine.name]
        value = place if mine.value is None else mine.value
        if value != one.value:
            wrong.append(f"{mine.name} is {one.value} in the spec, not {value}")
        if mine.words not in one.meaning:
            wrong.append(f"{mine.name} means {one.meaning!r}, not {mine.words!r}")
    assert not wrong, f"{name}:\n  " + "\n  ".join(wrong)


@every_type
def test_each_type_of_the_library_has_its_members_and_their_meanings(name: str) -> None:
    """Each type in plc/lib has the members and, in comments, their meanings.

    Source: the section that tests/spec/second_reading/pins/members.toml names.
    """
    text = FILES[name].read_text(encoding="utf-8")
    rows = dict(re.findall(r"^    (\w+),? +\(\* (.*) \*\)$", text, re.MULTILINE))
    assert list(rows) == [one.name for one in library().enumerations[name].members], name
    wrong = [
        f"{one.name} is said to be {rows.get(one.name)!r}, not {one.words!r}"
        for one in ENUMERATIONS[name]
        if one.words not in rows.get(one.name, "")
    ]
    assert not wrong, f"{name}:\n  " + "\n  ".join(wrong)


@for_each("block", every_block().values())
def test_each_member_selects_the_command_of_its_section(block: Pins) -> None:
    """Each member of a selector type selects the command of its section.

    The commands are in the order of the members. A block without a selector has one command.

    Source: the section that tests/spec/second_reading/pins/blocks.toml names.
    """
    commands = library().blocks[block.name].commands
    theirs = [f"{one.code:03X}" for one in commands]
    mine = [f"{block.codes[one]:03X}" for one in _chosen(block)]
    assert theirs == mine, f"{block}: the commands are {theirs}, not {mine}"


def _chosen(block: Pins) -> list[str]:
    """Return the members that select a command, in the order of their type."""
    types = [[one.name for one in members] for members in ENUMERATIONS.values()]
    found = [names for names in types if set(names) == set(block.codes)]
    return found[0] if found else list(block.codes)


@every_block_of_the_reading
def test_the_inputs_and_their_defaults_are_those_of_the_reading(block: Pins) -> None:
    """Inputs and their defaults are those of the second reading.

    Without a default in the file of the block, it is 0, FALSE, '' or the first member.

    Source: the section that tests/spec/second_reading/pins/blocks.toml names.
    """
    (pou,) = (one for one in parse(FILES[block.name]).declarations if isinstance(one, s.Pou))
    inputs: dict[str, str] = {}
    for section in pou.sections:
        if section.kind != "VAR_INPUT":
            continue
        for variable in section.variables:
            assert isinstance(variable.spec, s.NamedSpec)
            for pin in variable.names:
                inputs[pin.text] = _default(variable.initial, variable.spec.name.text)
    limit = inputs.pop("Timeout")
    assert limit == f"T#{block.limit}s", f"{block}: Timeout = {limit}"
    assert ("RobotNumber" in inputs) == block.robot, f"{block}: RobotNumber"
    mine = block.defaults
    wrong = [f"{pin} is in the block only" for pin in inputs if pin not in {*mine, *_ALWAYS}]
    wrong += [
        f"{pin} = {inputs.get(pin, 'missing')}, not {default}"
        for pin, default in mine.items()
        if inputs.get(pin) != default
    ]
    assert not wrong, f"{block}:\n  " + "\n  ".join(wrong)


@for_each("block", every_block().values())
def test_the_ranges_in_the_comments_of_the_pins_are_those_of_the_sections(block: Pins) -> None:
    """A range in the comment of a pin is the range of its section.

    Both ends are legal, and the numbers beyond them are illegal.

    The range of an array applies to its elements.

    Source: remote command guide 4.2 to 4.9, legend of each command's table.
    """
    text = FILES[block.name].read_text(encoding="utf-8")
    _, _, pins = text.partition("VAR_INPUT")
    wrong: list[str] = []
    for pin, said in re.findall(r"^    (\w+) +: [^(]* \(\* (.*) \*\)$", pins, re.MULTILINE):
        rows = [one for one in (*block.inputs, *block.outputs) if one.pin == pin]
        spans = [(_number(low), _number(high)) for low, high in _SPAN.findall(said)]
        if pin in _OTHER_RANGES and spans:
            wrong += [] if spans == [_OTHER_RANGES[pin]] else [f"{pin}: {said}"]
        elif spans and not (rows and rows[0].members):
            assert rows, f"{block}: {pin} is not in the reading"
            zero = "; 0 = " in said or "; 0 for " in said
            right = all(_is_span(block, rows[0], *span, zero=zero) for span in spans)
            wrong += [] if right else [f"{pin}: {said}"]
    assert not wrong, f"{block}:\n  " + "\n  ".join(wrong)


#: Robots are 1 to 4 (guide 1.1). Three patterns of a rotation have a meaning (4.2.1 and 4.3.1).
_OTHER_RANGES = {"RobotNumber": (1, 4), "Arm1": (-1, 1), "Arm2": (-1, 1)}
#: A range such as `1 to 16` or `16#00 to 16#FF`.
_SPAN = re.compile(r"(?<![\w.])(16#[0-9A-F]+|-?\d+) to (16#[0-9A-F]+|-?\d+)(?![.\d])")


def _number(text: str) -> int:
    return int(text.removeprefix("16#"), 16 if text.startswith("16#") else 10)


def _is_span(block: Pins, row: PinRow, low: int, high: int, *, zero: bool) -> bool:
    """Return whether the section has this range.

    If `zero` is TRUE, the comment explains the value 0.
    """
    if len(row.places) > 1:
        return high - low + 1 == len(row.places)
    return all(_is_legal(block, row, one) for one in (low, high)) and not any(
        _is_legal(block, row, one) for one in (low - 1, high + 1) if one or not zero
    )


def _is_legal(block: Pins, row: PinRow, number: int) -> bool:
    (part,) = row.places
    raw = [0] * WORDS
    try:
        row.write(raw, number)
    except ValueError:  # not digits of a BCD number
        return False
    fits = number <= part.width if row.how == "bit" else number < 1 << part.width
    if not fits or (row.how == "pattern" and number < 0):
        return False
    for code in block.codes.values():
        reading = every_reading()[code]
        for entry in (*reading.request, *reading.response):
            if part in entry.places:
                sets = [legal for _, _, legal in entry.conditions] or [entry.legal]
                return any(one.holds(part.read(raw)) for one in sets)
    raise AssertionError(f"{block}: {row} is no row of the section")


@pytest.mark.parametrize("block", ["FB_WriteIoPort", "FB_WriteIoPortBit", "FB_ReadIoPort"])
def test_the_ports_in_the_head_of_a_block_are_those_of_the_section(block: str) -> None:
    """Source: remote command guide 4.5.1 and 4.5.2, legend of the port numbers."""
    head = FILES[block].read_text(encoding="utf-8").partition("*)")[0]
    ports = {
        "FB_WriteIoPort": "DO, MO and SO: 2 to 7, 10 to 17, 20 to 27; LO: 0, 1; TO: 0.",
        "FB_WriteIoPortBit": "DO, MO and SO: 2 to 7, 10 to 17, 20 to 27; LO: 0, 1; TO: 0.",
        "FB_ReadIoPort": "DI, DO, MO, SI and SO: 0 to 7, 10 to 17, 20 to 27; LO: 0, 1; TO: 0.",
    }
    assert ports[block] in " ".join(head.replace("*", " ").split())


def _default(initial: object, kind: str) -> str:
    """Return an initial value in the notation of the second reading."""
    if isinstance(initial, s.Literal):
        return initial.text
    if isinstance(initial, s.Name):
        return initial.text
    kind = library().arrays[kind].of if kind in library().arrays else kind
    if kind in library().enumerations:
        return library().enumerations[kind].members[0].name
    empty = {"BOOL": "FALSE", "WORD": "16#0000", "REAL": "0.0", "STRING": "''"}
    return empty.get(kind, "0")


@for_each("number", range(len(MEANINGS)))
def test_each_value_of_a_field_means_what_the_commands_table_says(number: int) -> None:
    """Each value of a field has the meaning that the table of the command gives.

    The meanings appear in `rcx decode` and docs/reference/commands.md.

    Source: remote command guide 4.2 to 4.9, legend of each command's table.
    """
    row, wrong = MEANINGS[number], []
    for code in row["codes"].split():
        command = spec.commands()[int(code, 16)]
        fields = dict(_fields(command))
        assert row["place"] in fields, f"{command.shown}: no field begins at {row['place']}"
        field = fields[row["place"]]
        mine = {int(value, 0): words for value, words in row["values"].items()}
        for value, words in mine.items():
            if words not in field.values.get(value, ""):
                is_now = repr(field.values.get(value, "not in the spec"))
                wrong.append(f"{command.shown}: {field.name} = {value} is {is_now}, not {words!r}")
        for value in field.values.keys() - mine.keys():
            wrong.append(f"{command.shown}: {field.name} = {value} is in no table of the section")
    assert not wrong, f"{row['place']}:\n  " + "\n  ".join(wrong)


def test_every_field_with_values_has_its_meanings_in_the_reading() -> None:
    """Source: remote command guide 4.2 to 4.9."""
    read = {(code, row["place"]) for row in MEANINGS for code in row["codes"].split()}
    missing = [
        f"{command.shown} {where} ({field.name})"
        for command in spec.commands().values()
        for where, field in _fields(command)
        if len(field.values) > 1 and (f"{command.code:03X}", where) not in read
    ]
    assert not missing, "\n".join(missing)


def _fields(command: Command) -> Iterator[tuple[str, Field]]:
    """Return a dictionary of fields by their first word or bit, such as `n+4` or `n+2.1`."""
    for side, fields in (("n", command.request), ("m", command.response)):
        for field in fields:
            low = f".{field.bits[0]}" if field.type == "bits" else ""
            yield f"{side}+{field.at}{low}", field


@for_each("code", load_toml(FOLDER / "pins/commands.toml"))
def test_each_code_is_the_command_of_the_list(code: str) -> None:
    """Source: remote command guide 4.2 to 4.9, lists and sections."""
    command = spec.commands()[int(code, 16)]
    shown = f"{command.name} | {command.title}"
    assert shown == load_toml(FOLDER / "pins/commands.toml")[code], f"0x{code}"


def test_each_signal_has_the_place_and_the_name_of_the_profile() -> None:
    """Source: manual chapter 5, 1, table of the bits; 2, which inputs act by their edge."""
    table = load_toml(FOLDER / "pins/signals.toml")
    wrong = []
    for side, signals in (("output", spec.signals().output), ("input", spec.signals().input)):
        theirs = {one.short: one for one in signals}
        assert list(theirs) == [text.split(" | ")[0] for text in table[side]], side
        for text in table[side]:
            short, address, title, name, acts, words = text.split(" | ")
            one = theirs[short]
            shown = f"{one.address}.{one.bit}", one.title, one.name, one.acts or "-"
            for what, got, mine in zip(
                ("place", "title", "name", "action"),
                shown,
                (address, title, f"{short}_{name}", acts),
                strict=True,
            ):
                if got != mine:
                    wrong.append(f"{short}: {what} is {got!r}, not {mine!r}")
            if words not in one.meaning:
                wrong.append(f"{short}: means {one.meaning!r}, not {words!r}")
    assert not wrong, "\n".join(wrong)
