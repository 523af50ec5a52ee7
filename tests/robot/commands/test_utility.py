"""Commands of category 7 reset alarms and accumulated data.

The tests read accumulated data as real time output, with item numbers that they choose.
"""

from __future__ import annotations

import struct
from typing import Any

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, powered_up, servos_on

ALARM_RESET, MOTOR, SYSTEM, ALL = 0x604, 0x605, 0x606, 0x607
DEFINE, ENABLE = 0x701, 0x703
COUNT, TIME, DISTANCE = 1, 2, 3
POWER_ON, MOTOR_POWER, OPERATING = 1, 2, 3

MOTOR_ITEMS = {COUNT: "servo_on_count", TIME: "servo_on_time", DISTANCE: "moving_distance"}
SYSTEM_ITEMS = {
    POWER_ON: "power_on_count",
    MOTOR_POWER: "motor_power_on_count",
    OPERATING: "operating_time",
}
ITEMS = {**MOTOR_ITEMS, **{10 + item: name for item, name in SYSTEM_ITEMS.items()}}
AXES = (Axis(), Axis(), Axis(robot=2))


def _master(**config: Any) -> Master:
    """Return a master that reads accumulated data by real time output.

    Words 24 to 26 are for robot 1, axis 1; 27 to 29 for its axis 2; 30 to 32 for robot 2; 33 to 35
    for the system.
    """
    master = powered_up(size=256, real_time_items=ITEMS, axes=AXES, **config)
    motors = [(1, 1), (1, 2), (2, 1)]
    words = [(item, *motor) for motor in motors for item in MOTOR_ITEMS]
    words += [(10 + item, 0, 0) for item in SYSTEM_ITEMS]
    for word, definition in enumerate(words, 24):
        assert master.execute(DEFINE, 0, word, 0, *definition) == NORMAL_END
    assert master.execute(ENABLE, 0, 1) == NORMAL_END
    return master


def _motors(master: Master) -> list[tuple[int, int, int]]:
    master.run(10)
    return [struct.unpack_from("<3H", master.so, at) for at in (48, 54, 60)]


def _system(master: Master) -> tuple[int, int, int]:
    master.run(10)
    return struct.unpack_from("<3H", master.so, 66)


def _at_work(**config: Any) -> Master:
    """Return a robot after three servo ons, movements of 120 mm and 45 mm, and 3 s of operation."""
    master = _master(**config)
    for _ in range(2):
        master.pulse("SI01")
        master.drop("SI00")
        master.pulse("SI16")
    master.pulse("SI01")
    master.execute(0x001, 4, 0, 100, 19)
    master.execute(0x2001, 4, 0, 100, 19)
    master.run(3000)
    return master


# Alarm reset


def test_the_example_resets_the_alarms() -> None:
    """Rule: alarm-reset. Source: remote command guide 4.8.3."""
    master = _master()
    master.robot.inject("alarm")
    master.run(10)
    assert master.on("SO03")
    assert master.execute(0x0604) == NORMAL_END
    assert not master.on("SO03")


def test_an_alarm_reset_by_command_fails_during_an_emergency_stop() -> None:
    """Rule: reset-command."""
    master = _master()
    master.turn_and_wait("SI00", False)
    assert master.execute(0x0604) == abnormal_end("12.600")


# Accumulated data


def test_servo_on_count_and_time_and_moving_distance_are_accumulated_per_motor() -> None:
    """Axis 1 of robot 2 has moved as far as axis 1 of robot 1, and axis 2 has moved 45 mm.

    Rule: accumulated, accumulated-reset.
    Source: remote command guide 4.8.4
    """
    first, second, other = _motors(_at_work())
    assert (first[0], second[0], other[0]) == (3, 3, 3)
    assert (first[2], second[2], other[2]) == (120, 45, 120)
    assert 3 <= first[1] <= 6
    assert first[1] == second[1] == other[1]


def test_a_servo_that_stays_on_is_not_counted_again() -> None:
    """Axis 1 stays ON while axis 2 goes OFF and ON.

    Source: remote command guide 4.8.4, servo ON count
    """
    master = servos_on()
    counts = master.robot.machine.data.accumulated.servo_on_counts
    assert counts == [1, 1, 1, 1]
    master.execute(0x0035, 0, 0x0002)
    master.execute(0x0034, 0, 0x0002)
    assert counts == [1, 2, 1, 1]


def test_power_on_motor_power_on_and_operating_time_are_accumulated() -> None:
    """The figures survive a power cycle, and time without power does not count.

    Rule: accumulated, real-time-stored.
    Source: remote command guide 4.8.5
    """
    master = _at_work()
    before = _system(master)
    assert before[:2] == (1, 3)
    assert before[2] == master.now_us // 1_000_000
    master.robot.inject("power_off")
    master.now_us += 60_000_000
    master.run(100)
    master.robot.inject("power_off")
    master.robot.inject("power_on")
    master.run(1000)
    assert _system(master)[:2] == (2, 3)
    assert before[2] + 1 <= _system(master)[2] <= before[2] + 2
    assert _motors(master)[0][0] == 3


@pytest.mark.parametrize("item", [COUNT, TIME, DISTANCE])
@pytest.mark.parametrize(("robot", "axis", "reset"), [(0, 1, 0), (1, 2, 1), (2, 1, 2)])
def test_one_kind_of_data_of_a_motor_is_reset(item: int, robot: int, axis: int, reset: int) -> None:
    """Robot 0 means robot 1. All other data stay.

    Rule: accumulated-reset.
    Source: remote command guide 4.8.4
    """
    master = _at_work()
    before = [list(motor) for motor in _motors(master)]
    assert all(all(motor) for motor in before)
    assert master.execute(robot << 12 | MOTOR, 0, item, 1 << axis - 1) == NORMAL_END
    before[reset][item - 1] = 0
    after = [list(motor) for motor in _motors(master)]
    assert [motor[::2] for motor in after] == [motor[::2] for motor in before]
    assert (after[reset][1] == 0) is (item == TIME)


@pytest.mark.parametrize(("of_all", "zeros"), [(False, [0, 0, 120]), (True, [0, 0, 0])])
def test_without_an_axis_all_motors_are_reset(of_all: bool, zeros: list[int]) -> None:
    """The command resets all motors of the robot or, if so configured, of all robots.

    Rule: accumulated.
    Source: remote command guide 4.8.4
    """
    master = _at_work(motor_data_of_all_robots=of_all)
    assert master.execute(0x1605, 0, DISTANCE, 0) == NORMAL_END
    assert [motor[2] for motor in _motors(master)] == zeros
    assert [motor[0] for motor in _motors(master)] == [3, 3, 3]


@pytest.mark.parametrize(("robot", "item"), [(0, POWER_ON), (0, MOTOR_POWER), (2, OPERATING)])
def test_one_kind_of_system_data_is_reset(robot: int, item: int) -> None:
    """The printed example is item 1. The robot number has no effect.

    Rule: accumulated-reset, accumulated.
    Source: remote command guide 4.8.5
    """
    master = _at_work()
    assert master.execute(robot << 12 | 0x606, 0, item) == NORMAL_END
    assert [value == 0 for value in _system(master)] == [item == one for one in (1, 2, 3)]
    assert _motors(master)[0][0] == 3


def test_all_data_of_motors_and_system_are_reset_at_once() -> None:
    """Rule: accumulated-reset. Source: remote command guide 4.8.6."""
    master = _at_work()
    assert master.execute(0x0607) == NORMAL_END
    assert _motors(master) == [(0, 0, 0)] * 3
    assert _system(master) == (0, 0, 0)
