"""Legal telegrams of every remote command are accepted; all others end as documented."""

from __future__ import annotations

import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import fields
from functools import lru_cache
from typing import Any

import pytest

from rcx_harness.robot import Point, RobotConfig
from rcx_harness.spec import Command
from robot_master import Master, abnormal_end, servos_on
from telegrams import COMMANDS, illegal_fields, illegal_pairs, legal, stray_bits, words_of

FORMAT = "4.2"
#: Configuration in which each alarm of a command, except the format alarm, has its own number.
ALARMS: Mapping[str, Any] = {
    name: f"90.{number}"
    for number, name in enumerate(
        (
            entry.name
            for entry in fields(RobotConfig)
            if entry.name.endswith("_alarm") and entry.type == "str"
        ),
        1,
    )
} | {"format_alarm": FORMAT, "power_on_alarm": "", "undefined_data_alarm": ""}

#: Number of random telegrams of each command.
TELEGRAMS = 12

#: The commands that work while the programming box has authority (guide, 3).
REFERENCES = {
    *(0x101, 0x105, 0x109, 0x10D, 0x111, 0x214, 0x224, 0x304, 0x501, 0x502, 0x503, 0x505, 0x506),
    *(0x507, 0x508, 0x509, 0x50A, 0x50B, 0x50C, 0x50F, 0x510, 0x511, 0x512, 0x513, 0x514, 0x515),
    0x516,
}

#: Commands with a code that can contain a robot number (guide, 4.2 to 4.9).
WITH_ROBOT = {
    *(0x001, 0x002, 0x003, 0x004, 0x006, 0x007, 0x009, 0x00A, 0x00E, 0x00F, 0x010, 0x012, 0x013),
    *(0x014, 0x016, 0x017, 0x018, 0x019, 0x020, 0x021, 0x022, 0x024, 0x025, 0x026, 0x027, 0x028),
    *(0x030, 0x031, 0x032, 0x033, 0x034, 0x035, 0x036, 0x038, 0x039, 0x03A, 0x03B, 0x03C, 0x03D),
    *(0x044, 0x045, 0x048, 0x04B, 0x04C, 0x04D, 0x110, 0x111, 0x220, 0x224, 0x502, 0x503, 0x505),
    *(0x506, 0x50A, 0x50B, 0x50C, 0x50F, 0x510, 0x514, 0x516, 0x605, 0x606),
}
#: Commands that name one or more axes of the robot.
WITH_AXES = {
    *(0x001, 0x002, 0x003, 0x006, 0x007, 0x009, 0x00A, 0x00E, 0x00F, 0x010, 0x012, 0x013, 0x014),
    *(0x016, 0x017, 0x019, 0x020, 0x021, 0x022, 0x024, 0x025, 0x026, 0x030, 0x031, 0x033, 0x034),
    *(0x035, 0x036, 0x044, 0x045, 0x048, 0x04B, 0x04C, 0x04D, 0x220, 0x224, 0x510, 0x516, 0x605),
}
#: Commands without an illegal value: they have no field, or every bit pattern has a meaning.
ALL_LEGAL = {
    *(0x032, 0x041, 0x042, 0x043, 0x501, 0x502, 0x503, 0x505, 0x506, 0x50A, 0x50B, 0x50C, 0x50F),
    *(0x510, 0x511, 0x512, 0x514, 0x515, 0x516, 0x604, 0x607),
}
#: Speeds and arms of a robot without axes are 0 (guide, 4.7.8 to 4.7.10).
ANSWER_WITHOUT_ROBOT = {0x50A, 0x50B, 0x50C}

every_code = pytest.mark.parametrize("code", list(COMMANDS), ids="0x{:03X}".format)


@lru_cache(maxsize=1)
def _master() -> tuple[Master, object]:
    """Return a master for one robot of four axes, and its initial state.

    Only movements take time.
    """
    points = {number: Point() for number in range(6)}
    master = servos_on(points=points, command_delay=0.0, **ALARMS)
    return master, master.robot.snapshot()


@pytest.fixture
def fresh() -> Master:
    """Return the controller in its initial state."""
    master, snapshot = _master()
    master.robot.restore(snapshot)
    master.send()
    return master


def _end(master: Master, words: Iterable[int]) -> tuple[int, ...]:
    """Send a telegram, and return words m to m+30 three cycles later.

    After three cycles, only movements are still running.
    """
    master.send(*words)
    master.run(15)
    shown = master.words
    master.send()
    master.run(10)
    return shown


def _state(thing: Any) -> Any:
    """Return all data that commands can change as one value, except clocks and histories.

    The function visits every attribute of the controller, so that new data are included.
    """
    passing = {"rng", "now_us", "_now_us", "history", "latest_of_command", "inputs"}
    passing |= {"operating_us", "servo_on_us", "_since_us", "_config", "config", "_due_us"}
    # Programs refer to the controller, which would make a circle.
    passing |= {"_machine", "perform"}
    if isinstance(thing, (int, float, str, bytes, type(None))):
        return thing
    if isinstance(thing, dict):
        return {key: _state(value) for key, value in thing.items()}
    if isinstance(thing, (list, tuple, bytearray)):
        return [_state(value) for value in thing]
    if hasattr(thing, "__dict__"):
        return {key: _state(value) for key, value in vars(thing).items() if key not in passing}
    return repr(thing)


def _refused(master: Master, telegrams: Iterator[tuple[str, tuple[int, ...]]], alarm: str) -> int:
    """Check that all telegrams end in this alarm and change nothing; return their number."""
    before, count, accepted = _state(master.robot.machine), 0, []
    for wrong, words in telegrams:
        count += 1
        answer = _end(master, words)
        if answer != abnormal_end(alarm):
            accepted.append(f"{wrong}: {answer[0]:#06x} {answer[1]}.{answer[2]}")
    assert not accepted
    assert _state(master.robot.machine) == before
    return count


@every_code
def test_legal_telegrams_are_accepted(code: int) -> None:
    """A legal telegram may still end in another alarm, for example if its point is undefined.

    Rule: format.
    Source: remote command guide 4.2 to 4.9
    """
    command, chance = COMMANDS[code], random.Random(code)
    master, snapshot = _master()
    for _ in range(TELEGRAMS):
        values = legal(command, chance)
        words = command.encode(values)
        assert words == words_of(command, values)
        assert command.decode(words) == values
        master.robot.restore(snapshot)
        answer = _end(master, words)
        assert answer[0] in (0x0100, 0x0200, 0x4000)
        assert answer[:3] != abnormal_end(FORMAT)[:3], values


@every_code
def test_an_illegal_value_ends_in_the_format_alarm(code: int, fresh: Master) -> None:
    """Values next to a limit or without a meaning, and illegal texts, are refused.

    Two bits or none are refused where exactly one bit must be set.

    Rule: abnormal-end, comment-characters, one-axis.
    Source: remote command guide 4.2 to 4.9; 1.2, abnormal end status
    """
    _refused(fresh, illegal_fields(COMMANDS[code]), FORMAT)


@every_code
def test_a_fixed_or_unused_bit_that_is_set_ends_in_the_format_alarm(
    code: int, fresh: Master
) -> None:
    """The test sets each fixed bit of words that have fields, and three bits of other words.

    Source: remote command guide 4.2 to 4.9
    """
    assert _refused(fresh, stray_bits(COMMANDS[code]), FORMAT) > 0


@pytest.mark.parametrize(
    "code",
    [code for code, one in COMMANDS.items() if one.exclusive or one.product],
    ids="0x{:03X}".format,
)
def test_exclusive_flags_and_products_beyond_the_limit_are_refused(
    code: int, fresh: Master
) -> None:
    """Flags that exclude each other are refused, such as position output in pulses and in mm.

    Pallets with too many work positions are refused, too.

    Rule: both-outputs.
    Source: remote command guide 4.2, p and m; 4.2.12; 4.3.3
    """
    assert _refused(fresh, illegal_pairs(COMMANDS[code]), FORMAT) > 0


def test_every_command_with_a_field_that_has_limits_was_sent_illegal_values() -> None:
    """The tests of illegal values cover every command that has a field with limits."""
    assert {code for code, one in COMMANDS.items() if not list(illegal_fields(one))} == ALL_LEGAL


@pytest.mark.parametrize(
    ("words", "knobs"),
    [
        pytest.param(
            (0x0003, 0x0006, 0, 751, 1), {"scara_robots": ()}, id="751 mm/s of no SCARA robot"
        ),
        pytest.param((0x0002, 0x0005, 0x0401, 1, 1, *([0] * 5), 0xFFFF, 0xFFFF), {}, id="arch 1"),
        pytest.param((0x0002, 0x0005, 0x0401, 1, 1, *([0] * 7), 0xFFFF, 0xFFFF), {}, id="arch 2"),
        pytest.param((0x0220, 0, 1, 0, 51), {}, id="WEIGHT above the maximum payload"),
        pytest.param((0x0220, 0, 2, 0, 50_001), {}, id="WEIGHTG above the maximum payload"),
        pytest.param((0x0220, 0, 262, 1, 51), {}, id="AXWGHT above the maximum payload"),
        pytest.param((0x0200, 0, 256, 0, 0, 0x7FC0), {}, id="not a number"),
        pytest.param((0x0204, 0, 256, 0, 0, 0x7F80), {}, id="infinite"),
        pytest.param(
            (0x0240, 0, 1, 3, 1), {"several_elements": False}, id="two elements, not allowed"
        ),
    ],
)
def test_values_beyond_limits_of_a_section_or_of_the_robot_are_refused(
    words: tuple[int, ...], knobs: Mapping[str, Any]
) -> None:
    """Source: remote command guide 4.2.1, 4.4.1, 4.4.2, 4.4.4."""
    points = {number: Point() for number in range(6)}
    master = servos_on(**{"points": points, "command_delay": 0.0, **ALARMS, **knobs})
    _refused(master, iter([("", words + (0,) * (16 - len(words)))]), FORMAT)


@every_code
def test_the_robot_number_of_a_command_is_0_to_4(code: int, fresh: Master) -> None:
    """In a code without a robot number, such a number makes an undefined code.

    Robots from 5 on do not exist.

    Rule: other-alarms.
    Source: remote command guide 3, R; 4.2 to 4.9
    """
    words = words_of(COMMANDS[code], legal(COMMANDS[code], random.Random(code)))
    alarm = ALARMS["absent_robot_alarm" if code in WITH_ROBOT else "undefined_code_alarm"]
    numbers = range(5, 16) if code in WITH_ROBOT else range(1, 16)
    telegrams = ((f"R {robot}", (code | robot << 12, *words[1:])) for robot in numbers)
    assert _refused(fresh, telegrams, alarm) > 10


@every_code
def test_commands_for_robots_2_to_4_are_refused_if_only_robot_1_exists(
    code: int, fresh: Master
) -> None:
    """Rule: other-alarms, robot-zero, absent-robot-zero. Source: remote command guide 3, R."""
    if code not in WITH_ROBOT:
        assert not COMMANDS[code].robot
        return
    words = words_of(COMMANDS[code], legal(COMMANDS[code], random.Random(code)))
    one = _end(fresh, (code | 0x1000, *words[1:]))
    assert one[0] != 0
    assert one[:3] != abnormal_end(ALARMS["absent_robot_alarm"])[:3]
    assert one[:3] != abnormal_end(FORMAT)[:3]
    _, snapshot = _master()
    fresh.robot.restore(snapshot)
    telegrams = ((f"R {robot}", (code | robot << 12, *words[1:])) for robot in (2, 3, 4))
    if code in ANSWER_WITHOUT_ROBOT:
        assert [_end(fresh, sent) for _, sent in telegrams] == [(0x0200,) + (0,) * 15] * 3
    else:
        assert _refused(fresh, telegrams, ALARMS["absent_robot_alarm"]) == 3


def _with_absent_axes(command: Command) -> Iterator[tuple[str, tuple[int, ...]]]:
    """Return telegrams whose only error is an axis number: the robot has no axes 5 and 6."""
    names = {part.name for part in command.request}
    plain = dict.fromkeys(("axis_designation", "axes", "point", "pallet", "work"), 1)
    plain |= dict.fromkeys(("speed_mode", "position_pulses", "position_mm"), 0)
    plain |= {"parameter": 257, "value": 50}
    values = legal(command, random.Random(command.code))
    values.update({name: value for name, value in plain.items() if name in names})
    for name in sorted(names & {"axes", "arch_axis"}):
        for bit in (4, 5):
            yield f"{name} bit {bit}", words_of(command, {**values, name: 1 << bit})


@pytest.mark.parametrize("code", sorted(WITH_AXES - {0x510, 0x516}), ids="0x{:03X}".format)
def test_an_axis_that_the_robot_does_not_have_is_refused(code: int, fresh: Master) -> None:
    """A robot with four axes has no axes 5 and 6.

    Commands for them are refused, but reading their torque gives 0.

    Rule: other-alarms.
    """
    assert _end(fresh, (0x0108, 0, 1, 1, 1, 1, 1))[0] == 0x0200  # pallet 1
    telegrams = _with_absent_axes(COMMANDS[code])
    assert _refused(fresh, telegrams, ALARMS["no_axis_alarm"]) >= 2


def test_the_sections_of_the_guide_name_the_commands_with_axes() -> None:
    """Source: remote command guide 4.2, 4.4.2, 4.7.12, 4.7.18, 4.8.4."""
    assert {code for code, one in COMMANDS.items() if list(_with_absent_axes(one))} == WITH_AXES


@every_code
def test_with_programming_box_authority_only_the_references_work(code: int, fresh: Master) -> None:
    """All other commands end abnormally and have no effect.

    Rule: pendant-commands.
    Source: remote command guide 3, restrictions
    """
    fresh.robot.inject("pendant_on")
    words = words_of(COMMANDS[code], legal(COMMANDS[code], random.Random(code)))
    if code in REFERENCES:
        shown = _end(fresh, words)
        assert shown[0] != 0
        assert shown[:3] != abnormal_end(ALARMS["pendant_alarm"])[:3]
    else:
        _refused(fresh, iter([("", words)]), ALARMS["pendant_alarm"])


@every_code
def test_no_command_works_while_a_safety_setting_disables_inputs(code: int, fresh: Master) -> None:
    """The status stays 0x0000, and nothing happens.

    Rule: safety-commands.
    Source: remote command guide 3, restrictions
    """
    fresh.robot.inject("safety_on")
    before = _state(fresh.robot.machine)
    words = words_of(COMMANDS[code], legal(COMMANDS[code], random.Random(code)))
    assert _end(fresh, words) == (0,) * 16
    assert _state(fresh.robot.machine) == before


def test_a_code_that_the_guide_does_not_have_is_refused(fresh: Master) -> None:
    """The test sends all other codes of the 4096, and the status reset command with a robot number.

    Rule: other-alarms.
    Source: remote command guide 3
    """
    codes = [code for code in range(1, 0x1000) if code not in COMMANDS]
    assert len(codes) == 4095 - 116
    more = [code | 0x1000 for code in codes[::97]] + [0x1000, 0x4000, 0xF000, 0xFFFF]
    telegrams = ((f"{code:#06x}", (code,) + (0,) * 15) for code in codes + more)
    _refused(fresh, telegrams, ALARMS["undefined_code_alarm"])


def test_only_commands_with_a_robot_number_in_the_guide_accept_one() -> None:
    """Source: remote command guide 4.2 to 4.9."""
    assert {code for code, one in COMMANDS.items() if one.robot} == WITH_ROBOT
