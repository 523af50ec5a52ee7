"""The tables in spec/ agree with the tables and examples of the manual."""

from __future__ import annotations

import re

import pytest

from for_each import for_each
from rcx_harness import spec
from structured_text.errors import InputError


def _mask(found: tuple[spec.Signal, ...], byte: int) -> int:
    return sum(1 << signal.bit for signal in found if signal.byte == byte)


def test_dedicated_bits_are_those_of_the_profile() -> None:
    """The dedicated bits are those of the manual. Other bits of bytes 32 and 33 are reserved.

    Bytes 46 and 47 are reserved as well.

    Source: manual chapter 5, 1
    """
    table = spec.signals()
    assert (_mask(table.output, 32), _mask(table.output, 33)) == (0b0001_1111, 0b0011_1111)
    assert (_mask(table.input, 32), _mask(table.input, 33)) == (0b0100_0011, 0b1111_0101)
    assert table.reserved_bytes == (46, 47)


def test_the_number_of_a_signal_gives_its_byte_and_bit() -> None:
    """The number of a signal gives its byte and bit: SO(02) is bit 2 of m+32, SI(17) bit 7 of n+33.

    Source: manual chapter 5, 1.
    """
    table = spec.signals()
    for signal in table.output + table.input:
        letters, port, bit = re.fullmatch(r"(S[OI])\((\d)(\d)\)", signal.signal).groups()  # type: ignore[union-attr]
        assert signal.address == f"{'m' if letters == 'SO' else 'n'}+{32 + int(port)}"
        assert signal.bit == int(bit)
        assert signal.short == f"{letters}{port}{bit}"
        assert signal.acts in (("",) if letters == "SO" else ("edge", "level"))


def test_inputs_that_act_by_their_edge() -> None:
    """Source: manual chapter 5, 2, bit input."""
    edges = {signal.short for signal in spec.signals().input if signal.acts == "edge"}
    assert edges == {"SI01", "SI12", "SI14", "SI15", "SI16", "SI17"}


@pytest.mark.parametrize("name", ["SO02", "SO(02)", "SO02_ServoOn"])
def test_a_signal_is_found_by_each_of_its_names(name: str) -> None:
    assert spec.signals().find(name).title == "Servo ON status output"


@pytest.mark.parametrize(
    ("number", "group", "category"),
    [
        ("2.334", 0x0002, 0x014E),
        ("4.2", 0x0004, 0x0002),
        ("4.202", 0x0004, 0x00CA),
        ("12.100", 0x000C, 0x0064),
        ("12.400", 0x000C, 0x0190),
        ("12.551", 0x000C, 0x0227),
        ("12.552", 0x000C, 0x0228),
        ("12.600", 0x000C, 0x0258),
        ("12.762", 0x000C, 0x02FA),
        ("12.763", 0x000C, 0x02FB),
        ("12.900", 0x000C, 0x0384),
        ("12.904", 0x000C, 0x0388),
    ],
)
def test_alarm_codes(number: str, group: int, category: int) -> None:
    """Source: manual chapter 4, 4; remote command guide 1.1 and 4.2.1; 4.202: public list."""
    alarm = spec.alarms()[number]
    assert (alarm.group, alarm.category) == (group, category)
    assert len(spec.alarms()) == 12


@pytest.mark.parametrize(
    ("name", "shown", "section"),
    [
        ("StatusReset", "0x0000", "4.1"),
        ("MovePtp", "0xR001", "4.2.1"),
        ("WritePoint", "0x0100", "4.3.1"),
        ("ReadPoint", "0x0101", "4.3.1"),
        ("ReadVersion", "0x0501", "4.7.1"),
        ("ReadPositionPulses", "0xR505", "4.7.4"),
        ("ReadPositionMm", "0xR506", "4.7.4"),
        ("AlarmReset", "0x0604", "4.8.3"),
    ],
)
def test_command_codes(name: str, shown: str, section: str) -> None:
    """Source: remote command guide, the commands' own sections."""
    entry = spec.command(name)
    assert (entry.shown, entry.section) == (shown, section)
    assert spec.command(shown) is entry


def test_commands_under_the_authority_of_the_programming_box() -> None:
    """Exactly the commands of the manual's list need the authority of the programming box.

    The test checks the commands that are in the table.

    Source: remote command guide chapter 3, restrictions.
    """
    allowed = {code for code, entry in spec.commands().items() if entry.pendant}
    listed = {0x000, 0x101, 0x105, 0x109, 0x10D, 0x111, 0x214, 0x224, 0x304, 0x501, 0x502, 0x503}
    listed |= {0x505, 0x506, 0x507, 0x508, 0x509, 0x50A, 0x50B, 0x50C, 0x50F, 0x510, 0x511, 0x512}
    listed |= {0x513, 0x514, 0x515, 0x516}
    assert allowed == listed & spec.commands().keys()


def test_the_fields_of_every_table_entry_are_consistent() -> None:
    """The fields of a command do not overlap, lie in n+2 to n+30, and name existing fields."""
    for entry in spec.commands().values():
        for fields in (entry.request, entry.response):
            covered = [0] * 16
            names = [part.name for part in fields]
            assert len(set(names)) == len(names)
            for part in fields:
                assert part.by in ("", *names)
                for k in part.words:
                    assert 1 <= k <= 15
                    assert not covered[k] & part.mask
                    covered[k] |= part.mask


def test_every_range_fits_into_the_type_of_its_field() -> None:
    """Every range fits into the type of its field, which is a word or a double word."""
    least_and_most = {"u16": (0, 2**16 - 1), "s16": (-(2**15), 2**15 - 1)}
    least_and_most["s32"] = (-(2**31), 2**31 - 1)
    for entry in spec.commands().values():
        for part in (*entry.request, *entry.response):
            least, most = least_and_most.get(part.type, (0, part.mask >> part.bits[0]))
            for edges in (part.range or (0, 0), *part.ranges.values()):
                assert [least, *edges, most] == sorted([least, *edges, most]), entry.name


def test_encode_gives_the_printed_telegram() -> None:
    """The encoder gives the telegram that the guide prints: a movement to point 19 at 50 %.

    Source: remote command guide chapter 2, example.
    """
    words = spec.command("MovePtp").encode({"speed_mode": 2, "speed": 50, "point": 19}, robot=3)
    assert words == (0x3001, 0x0004, 0, 0x0032, 0x0013) + (0,) * 11


def test_decode_gives_back_what_was_encoded() -> None:
    entry = spec.command("WritePoint")
    values: dict[str, spec.FieldValue] = {"unit": 1, "hand": 2, "arm1": 15, "point": 100}
    values["positions"] = (1, -1, 70000)
    words = entry.encode(values)
    assert words[4:10] == (1, 0, 0xFFFF, 0xFFFF, 0x1170, 0x0001)
    assert entry.decode(words) == {**values, "arm2": 0, "positions": (1, -1, 70000, 0, 0, 0)}


@pytest.mark.parametrize(
    ("values", "robot", "message"),
    [
        ({"speeed": 5}, 0, "has no field 'speeed'; did you mean speed"),
        ({"speed_mode": 2, "speed": 101}, 0, "speed is 101, not 1 to 100"),
        ({"speed_mode": 3}, 0, "speed_mode is 3, which has no meaning"),
        ({"speed_mode": 4}, 0, "speed_mode is 4, which has no meaning"),
        ({"point": -1}, 0, "point is -1, not 0 to 29999"),
        ({"point": "a"}, 0, "point is 'a', not a whole number"),
        ({"point": 30000}, 0, "point is 30000, not 0 to 29999"),
        ({"position_pulses": 1, "position_mm": 1}, 0, "cannot both be 1"),
        ({}, 5, "cannot designate robot 5"),
    ],
)
def test_encode_refuses_values_that_the_manual_does_not_allow(
    values: dict[str, int], robot: int, message: str
) -> None:
    """Source: remote command guide 4.2.1."""
    with pytest.raises(InputError, match=message):
        spec.command("MovePtp").encode(values, robot)


def test_a_robot_number_is_refused_where_the_command_has_none() -> None:
    with pytest.raises(InputError, match="cannot designate robot 1"):
        spec.command("0x0501").encode({}, robot=1)


def test_more_values_than_there_are_places_are_refused() -> None:
    with pytest.raises(InputError, match="positions has no room"):
        spec.command("WritePoint").encode({"positions": (0,) * 7})


def test_texts_and_real_numbers_have_their_places() -> None:
    """Texts and real numbers are encoded as in the guide. The first character is in the lower byte.

    Spaces fill a text, and 0x00 ends a text that is read.

    Source: remote command guide chapter 1, 1.1; 4.6
    """
    words = [0] * 16
    text = spec.Field("comment", at=8, type="text", length=16)
    text.write(words, "12")
    assert words[4:6] == [0x3231, 0x2020]
    assert text.read(words) == "12"
    words[5:12] = [0] * 7
    assert text.read(words) == "12"
    with pytest.raises(InputError, match="no room"):
        text.write(words, "x" * 17)
    with pytest.raises(InputError, match="has the character '\u00e9', not ASCII"):
        text.write(words, "\u00e9")
    real = spec.Field("value", at=4, type="f32")
    real.write(words, 1.5)
    assert words[2:4] == [0x0000, 0x3FC0]
    assert real.read(words) == 1.5
    with pytest.raises(
        InputError, match=r"value is 1e\+39, not -3\.40282.*e\+38 to 3\.40282.*e\+38"
    ):
        real.write(words, 1e39)
    with pytest.raises(InputError, match="value is 'a', not a number"):
        real.write(words, "a")


@pytest.mark.parametrize("name", ["MovePpt", "0x0777", ""])
def test_an_unknown_command_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="no remote command is called"):
        spec.command(name)


_NAMED = ("RegisterProgram", "ExecuteProgram", "StepProgram", "SkipProgram", "NextProgram",
          "ResetProgram", "ReadProgramInfo")  # fmt: skip


def _text_words(first: tuple[int, ...], at: int, raw: bytes) -> list[int]:
    """Return 16 words with these words at the beginning and this text from byte `at` on."""
    area = bytearray(32)
    for k, word in enumerate(first):
        area[2 * k : 2 * k + 2] = word.to_bytes(2, "little")
    area[at : at + len(raw)] = raw
    return [int.from_bytes(area[k : k + 2], "little") for k in range(0, 32, 2)]


@for_each("name", _NAMED)
@for_each(
    "text, told",
    [
        (b"MAIN".ljust(16), ""),
        (b"MAIN".ljust(16, b"\0"), ""),
        (b"ABCDEFGHIJKLM_09", ""),
        (b"A B".ljust(16), "the character ' '"),
        (b" MAIN".ljust(16), "the character ' '"),
        (b"A B".ljust(16, b"\0"), "the character ' '"),
        (b"MAIN ".ljust(16, b"\0"), "the character ' '"),
        (b"MAIN\0".ljust(16), "16#00 before its end"),
        (b"MAIN\0 \0".ljust(16, b"\0"), "16#00 before its end"),
        (b"MA\0IN".ljust(16), "16#00 before its end"),
        (b"MAIN".rjust(16, b"\0"), "16#00 before its end"),
        (b"main".ljust(16), "the character 'm'"),
        (b"A-B".ljust(16), "the character '-'"),
        (b"MAIN\x80".ljust(16), "the character"),
    ],
)
def test_a_program_name_is_filled_with_one_kind_of_character(
    name: str, text: bytes, told: str
) -> None:
    """A program name shorter than 16 characters is filled with one kind of character only.

    A name has upper case letters, digits and underscores.

    Source: manual, remote command guide 4.6.1 to 4.6.4: spaces in the text, 0x00 in the examples.
    """
    command = spec.command(name)
    first = (command.code, 4, 0, 0, 1) if name == "RegisterProgram" else (command.code, 4)
    problem = command.problem(_text_words(first, 12, text))
    assert problem.startswith(f"program_name has {told}") if told else not problem


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (b"WAIT ORG".ljust(16), ""),
        (b"WAIT ORG".ljust(16, b"\0"), ""),
        (b"".ljust(16, b"\0"), ""),
        (b" ~".ljust(16), ""),
        (b"WAIT\0".ljust(16), "16#00 before its end"),
        (b"WAIT\0ORG".ljust(16, b"\0"), "16#00 before its end"),
        (b"WAIT\x7f".ljust(16), "the character"),
        (b"WAIT\x1f".ljust(16), "the character"),
    ],
)
def test_a_comment_may_have_spaces_and_is_filled_with_one_kind_of_character(
    text: bytes, told: str
) -> None:
    """Source: manual, remote command guide 4.3.2: 0x20 to 0x7E; the example fills with 0x00."""
    problem = spec.command("WritePointComment").problem(_text_words((0x104, 0, 50), 8, text))
    assert problem.startswith(f"comment has {told}") if told else not problem


@pytest.mark.parametrize("text", ["A B", " MAIN", "A\0B", "MAIN\0", "main", "A-B", "É"])
def test_encode_refuses_a_name_with_other_characters(text: str) -> None:
    """Source: manual, remote command guide 4.6.2, legend of bb."""
    with pytest.raises(InputError, match="program_name has"):
        spec.command("ExecuteProgram").encode({"method": 4, "program_name": text})


def test_encode_fills_a_name_with_spaces() -> None:
    """Source: manual, remote command guide 4.6.2: when shorter than 16 characters, use a space."""
    words = spec.command("ExecuteProgram").encode({"method": 4, "program_name": "MAIN"})
    assert words[6:14] == (0x414D, 0x4E49, *[0x2020] * 6)
    filled = spec.command("ExecuteProgram").encode({"method": 4, "program_name": "MAIN  "})
    assert filled == words
