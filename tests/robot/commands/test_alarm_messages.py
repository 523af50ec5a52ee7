"""Commands read the alarm history, and the latest alarm of a remote command."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, abnormal_end, answer_of, powered_up

MESSAGE = 0x509
ROBOT_2 = 0x2000


def test_the_10th_message_is_the_alarm_of_the_printed_example() -> None:
    """The 10th message is alarm 12.551 of the EtherNet/IP unit in option slot 1.

    The printed place C1O1 means controller 1, option slot 1.

    Rule: messages, alarm-places.
    Source: remote command guide 4.7.7
    """
    master = powered_up()
    for category in range(1, 10):
        master.robot.machine.raise_alarm(f"99.{category}")
    master.robot.machine.raise_alarm("12.551")
    expected = (0x000C, 0x0227, 0x0101, 0x0301)
    assert answer_of(master, 0x0509, 0, 1)[:4] == expected
    assert answer_of(master, 0x0509, 0, 10)[:4] == (99, 1, 0x0101, 0)
    oldest = powered_up(newest_message_first=False)
    for category in range(1, 10):
        oldest.robot.machine.raise_alarm(f"99.{category}")
    oldest.robot.machine.raise_alarm("12.551")
    assert answer_of(oldest, 0x0509, 0, 0x000A) == (*expected, *(0,) * 11)
    assert answer_of(oldest, 0x0509, 0, 1)[:2] == (99, 1)


def test_the_place_of_a_network_alarm_is_the_option_slot_of_its_unit() -> None:
    """Rule: alarm-places."""
    slots = {(0, 0, 0x0401, 0): 0x0303, (0, 0, 0, 0): 0}
    for units, place in slots.items():
        master = powered_up(option_slots=units)
        master.robot.machine.raise_alarm("12.552")
        assert answer_of(master, 0x0509, 0, 1)[2:4] == (0x0101, place)


def test_message_numbers_without_a_message_give_an_empty_answer() -> None:
    """Message numbers are 1 to 500.

    If there is no message, the answer is empty. With another setting, the command ends in an alarm.

    Rule: messages.
    Source: remote command guide 4.7.7.
    """
    assert powered_up().execute(MESSAGE, 0, 500) == NORMAL_END
    master = powered_up(undefined_data_alarm="9.9")
    assert master.execute(MESSAGE, 0, 1) == abnormal_end("9.9")
    for number in (0, 501):
        assert master.execute(MESSAGE, 0, number) == abnormal_end("4.2")


def test_the_example_shows_the_soft_limit_of_axis_1_as_the_latest_alarm() -> None:
    """The latest alarm is 2.334 at robot 1, axis 1. This alarm is also in the alarm history.

    Rule: alarm-places.
    Source: remote command guide 4.7.17
    """
    master = powered_up(axes=(Axis(soft_high=1000), Axis()))
    master.pulse("SI01")
    assert master.execute(0x0001, 4, 0, 50, 19) == abnormal_end("2.334")
    expected = (0x0002, 0x014E, 0x0001, 0x0101, *(0,) * 11)
    assert answer_of(master, 0x0515) == expected
    assert answer_of(master, 0x0509, 0, 1) == expected


@pytest.mark.parametrize("code", [0x0003, 0x0020, 0x0021])
def test_a_soft_limit_names_the_axis_of_lines_and_jogs(code: int) -> None:
    """A soft limit of axis 2 of robot 2 is reported with place 0x0002 and detail 0x0102.

    Rule: alarm-places.
    """
    axes = (Axis(), *[Axis(robot=2, soft_low=-100, soft_high=high) for high in (900_000, 100)])
    master = powered_up(axes=axes, manual_speed=100)
    master.pulse("SI01")
    master.execute(0x0100, 0, 500, 0, 1000, 0, 1000)
    words = (4, 0, 50, 500) if code == 0x0003 else (0, 2)
    assert master.execute(ROBOT_2 | code, *words)[:3] == (0x4000, 2, 334)
    assert answer_of(master, 0x0515)[2:4] == (0x0002, 0x0102)


def test_the_latest_alarm_command_counts_only_alarms_of_remote_commands() -> None:
    """The words are 0 before the first alarm.

    Alarms without a command and normal ends do not change them.

    Rule: messages, alarm-places.
    Source: remote command guide 4.7.17
    """
    master = powered_up(servo_off_alarm="5.7", axes=(Axis(), Axis(robot=2)))
    assert master.execute(0x0515) == NORMAL_END
    master.execute(ROBOT_2 | 0x001, 4, 0, 50, 19)
    master.robot.inject("alarm", group=7, category=8)
    assert answer_of(master, 0x0515)[:4] == (5, 7, 0x0002, 0)
    assert answer_of(master, 0x0509, 0, 1)[:4] == (7, 8, 0x0101, 0)
    master.turn_and_wait("SI06", False)
    master.execute(ROBOT_2 | 0x001, 4, 0, 50, 19)
    assert answer_of(master, 0x0515)[:4] == (12, 400, 0x0101, 0)
    assert master.execute(0x0FFF)[:3] == (0x4000, 12, 75)
    assert answer_of(master, 0x0515)[:4] == (12, 75, 0x0101, 0x0301)
