"""Commands of category 8 set up the real time output in words 24 to 127 of the extended area."""

from __future__ import annotations

import struct
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.robot import Axis, RobotConfig
from rcx_harness.robot.stored import QUANTITIES
from robot_master import NORMAL_END, Master, abnormal_end, powered_up

DEFINE, READ, ENABLE = 0x701, 0x702, 0x703
DUTY = 13
#: Axis data in which 20 % of the maximum torque are 100 % of the rated torque.
HOLDING = (Axis(holding_torque=20), Axis(holding_torque=-10), Axis(robot=2, holding_torque=1))


def _master(**config: Any) -> Master:
    return powered_up(**{"size": 256, "axes": HOLDING, **config})


def _word(master: Master, number: int) -> int:
    return int(struct.unpack_from("<H", master.so, 2 * number)[0])


def test_the_examples_define_word_24_as_the_motor_duty_of_robot_1_axis_2_and_show_it() -> None:
    """Once enabled, word 24 shows the torque of -10 % of the maximum as 50 % of the rated torque.

    Rule: real-time-output, real-time-items.
    Source: remote command guide 4.9.1, 4.9.2, 4.9.3
    """
    master = _master()
    master.pulse("SI01")
    assert master.execute(0x0701, 0, 0x18, 0, 0x0D, 1, 2) == NORMAL_END
    answer = (0x0200, 0, 0x18, 0, 0x0D, 1, 2, *(0,) * 9)
    assert master.execute(0x0702, 0, 0x18) == answer
    assert _word(master, 24) == 0
    assert master.execute(0x0703, 0, 1) == NORMAL_END
    assert _word(master, 24) == 50


def test_each_word_shows_the_item_that_was_defined_last() -> None:
    """Words 24 and 127 are the first and the last word.

    Rule: real-time-output.
    Source: remote command guide 4.9.1
    """
    master = _master()
    master.pulse("SI01")
    master.execute(DEFINE, 0, 24, 0, DUTY, 1, 2)
    master.execute(DEFINE, 0, 24, 0, DUTY, 1, 1)
    master.execute(DEFINE, 0, 127, 0, DUTY, 2, 1)
    master.execute(ENABLE, 0, 1)
    assert (_word(master, 24), _word(master, 127)) == (100, 5)
    assert not any(master.so[50:254])


def test_words_without_real_time_output_belong_to_the_robot_programs() -> None:
    """While the function is invalid, all words belong to the robot programs.

    Rule: real-time-update.
    Source: remote command guide 4.9.3
    """
    master = _master()
    master.pulse("SI01")
    for word in (24, 25):
        master.robot.write_port(f"SOW({word})", 0x1234)
    master.execute(DEFINE, 0, 24, 0, DUTY, 1, 1)
    assert (_word(master, 24), _word(master, 25)) == (0x1234, 0x1234)
    master.execute(ENABLE, 0, 1)
    assert (_word(master, 24), _word(master, 25)) == (100, 0x1234)
    master.execute(ENABLE, 0, 0)
    assert (_word(master, 24), _word(master, 25)) == (0x1234, 0x1234)


def test_real_time_words_follow_the_axes_without_a_change_from_the_master() -> None:
    """The words follow the axes even if the master changes nothing. Rule: real-time-update."""
    axes = (Axis(moving_torque=10), Axis())
    master = _master(axes=axes)
    master.pulse("SI01")
    master.execute(DEFINE, 0, 30, 0, DUTY, 1, 1)
    master.execute(ENABLE, 0, 1)
    master.send(0x001, 4, 0, 100, 19)
    master.run(50)
    image = bytes(master.si)
    seen: list[int] = []
    for _ in range(200):
        master.so = master.robot.cycle(master.now_us, image)
        master.now_us += 5000
        if not seen or seen[-1] != _word(master, 30):
            seen.append(_word(master, 30))
    assert master.status == 0x0200
    assert seen == [50, 0]


def test_the_words_are_updated_at_the_interval_of_the_configuration() -> None:
    """The words change every 40 ms, and do not show positions between two updates.

    Rule: real-time-update.
    """
    items = {1: "position_pulses"}
    master = _master(real_time_interval=40.0, real_time_items=items)
    master.execute(DEFINE, 0, 30, 0, 1, 1, 1)
    master.execute(ENABLE, 0, 1)
    seen = []
    for number in range(40):
        master.robot.positions[0] = number
        master.run(5)
        seen.append(_word(master, 30))
    steps = sorted(set(seen[8:]))
    assert len(steps) >= 4
    assert {after - before for before, after in pairwise(steps)} == {8}


def test_a_definition_takes_effect_at_once() -> None:
    """The update interval of 60 s applies only to values, not to the definition of a word.

    Rule: real-time-update.
    """
    master = _master(real_time_interval=60_000.0)
    master.pulse("SI01")
    master.execute(ENABLE, 0, 1)
    for axis, duty in ((1, 100), (2, 50)):
        master.execute(DEFINE, 0, 24, 0, DUTY, 1, axis)
        assert _word(master, 24) == duty
    for enabled, shown in ((0, 0), (1, 50)):
        master.execute(ENABLE, 0, enabled)
        assert _word(master, 24) == shown


def test_definitions_and_validity_survive_a_power_cycle() -> None:
    """Rule: real-time-stored."""
    master = _master()
    master.execute(DEFINE, 0, 24, 0, DUTY, 1, 1)
    master.execute(ENABLE, 0, 1)
    master.robot.inject("power_cycle")
    master.run(500)
    master.drop("SI00")
    master.pulse("SI16")
    master.pulse("SI01")
    assert _word(master, 24) == 100
    assert master.execute(READ, 0, 24)[2:7] == (24, 0, DUTY, 1, 1)


def test_without_the_extended_area_definitions_are_kept_without_effect() -> None:
    """Rule: real-time-stored."""
    master = _master(size=48)
    master.pulse("SI01")
    assert master.execute(DEFINE, 0, 24, 0, DUTY, 1, 1) == NORMAL_END
    assert master.execute(ENABLE, 0, 1) == NORMAL_END
    assert master.execute(READ, 0, 24)[2:7] == (24, 0, DUTY, 1, 1)
    assert len(master.so) == 48


def test_a_word_without_definition_answers_item_0() -> None:
    """Rule: real-time-items."""
    assert _master().execute(READ, 0, 127) == (0x0200, 0, 127, *(0,) * 13)


def test_items_without_a_quantity_in_the_configuration_show_0() -> None:
    """The word of such an item shows 0, and the item's options are not checked.

    Rule: real-time-items.
    """
    master = _master()
    for item in (1, 45):
        assert master.execute(DEFINE, 0, 24, 0, item, 0xFFFF, 9) == NORMAL_END
        assert master.execute(READ, 0, 24)[4:7] == (item, 0xFFFF, 9)
    master.execute(ENABLE, 0, 1)
    assert _word(master, 24) == 0


@pytest.mark.parametrize("options", [(0, 1), (1, 0), (1, 3), (3, 1), (5, 1), (2, 2)])
def test_real_time_output_of_an_axis_that_does_not_exist_is_refused(
    options: tuple[int, int],
) -> None:
    """Rule: real-time-stored."""
    master = _master(no_axis_alarm="9.1")
    assert master.execute(DEFINE, 0, 24, 0, DUTY, *options) == abnormal_end("9.1")
    assert master.execute(READ, 0, 24)[4] == 0


def test_every_quantity_is_shown_with_its_sign_and_its_upper_word() -> None:
    """Axis 2 of robot 1 is at -70000 pulses (0xFFFE EE90) and holds -10 % of the maximum torque.

    Rule: real-time-items.
    """
    items = dict(enumerate(QUANTITIES, 1))
    master = _master(real_time_items=items)
    master.pulse("SI01")
    for item in items:
        assert master.execute(DEFINE, 0, 23 + item, 0, item, 1, 2) == NORMAL_END
    master.robot.positions[1] = -70_000
    master.run(10)
    master.robot.machine.data.accumulated.reset_motors((1,), 3)
    master.robot.positions[1] += 70_000_000
    master.run(10)
    master.robot.positions[1] = -70_000
    master.execute(ENABLE, 0, 1)
    shown = {name: _word(master, 23 + item) for item, name in items.items()}
    seconds = master.now_us // 1_000_000
    assert shown == {
        "motor_duty": 50,
        "motor_duty.high": 0,
        "torque_of_max": 0xFFF6,
        "torque_of_max.high": 0xFFFF,
        "torque_of_rated": 0xFFCE,
        "torque_of_rated.high": 0xFFFF,
        "position_pulses": 0xEE90,
        "position_pulses.high": 0xFFFE,
        "servo_state": 1,
        "servo_state.high": 0,
        "servo_on_count": 1,
        "servo_on_count.high": 0,
        "servo_on_time": shown["servo_on_time"],
        "servo_on_time.high": 0,
        "moving_distance": 140_000 - 2 * 65536,
        "moving_distance.high": 2,
        "power_on_count": 1,
        "power_on_count.high": 0,
        "motor_power_on_count": 1,
        "motor_power_on_count.high": 0,
        "operating_time": seconds,
        "operating_time.high": 0,
    }
    assert 0 < shown["servo_on_time"] < seconds


def test_a_robot_file_names_the_items_of_the_real_time_output(tmp_path: Path) -> None:
    """Rule: real-time-items."""
    file = tmp_path / "robot.toml"
    file.write_text('[real_time_items]\n1 = "position_pulses"\n45 = "operating_time.high"\n')
    expected = {1: "position_pulses", 45: "operating_time.high"}
    assert RobotConfig.load(file).real_time_items == expected
