"""The speed changes and the inching amount."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis, Point
from robot_master import NORMAL_END, Master, abnormal_end, powered_up, servos_on

MANUAL, AUTOMATIC, PROGRAM, INCHING = 0x038, 0x039, 0x03A, 0x027
HIGHEST = {MANUAL: 100, AUTOMATIC: 100, PROGRAM: 100, INCHING: 10000}
TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _values(master: Master, robot: int) -> dict[int, int]:
    settings = master.robot.machine.settings.of(robot)
    return {
        MANUAL: settings.manual_speed,
        AUTOMATIC: settings.auto_speed,
        PROGRAM: settings.program_speed,
        INCHING: settings.inching_amount,
    }


@pytest.mark.parametrize("code", [MANUAL, AUTOMATIC, PROGRAM, INCHING])
def test_values_are_accepted_up_to_their_limits_and_refused_beyond(code: int) -> None:
    """1 to 100 %, or 1 to 10000 for the inching amount; a refused one changes nothing.

    Source: remote command guide 4.2.14, 4.2.15, 4.2.16, 4.2.8
    """
    master = powered_up()
    for value in (1, HIGHEST[code]):
        assert master.execute(code, 0, value) == NORMAL_END
        assert _values(master, 1)[code] == value
    for value in (0, HIGHEST[code] + 1, 0xFFFF):
        assert master.execute(code, 0, value) == abnormal_end("4.2")
        assert _values(master, 1)[code] == HIGHEST[code]


def test_each_robot_has_its_own_speeds_and_amount() -> None:
    """Rule: robot-settings. Source: remote command guide 4.2.14 to 4.2.16, 4.2.8, R."""
    master = powered_up(axes=TWO_ROBOTS)
    before = _values(master, 1)
    for k, code in enumerate((MANUAL, AUTOMATIC, PROGRAM, INCHING)):
        assert master.execute(code | 0x2000, 0, 11 + k) == NORMAL_END
    assert _values(master, 2) == {MANUAL: 11, AUTOMATIC: 12, PROGRAM: 13, INCHING: 14}
    assert _values(master, 1) == before


@pytest.mark.parametrize("setting", [AUTOMATIC, PROGRAM])
def test_automatic_and_program_speed_slow_a_movement_down(setting: int) -> None:
    """100 000 pulses at 50 % of 1 000 000 pulses/s with 5 000 000 pulses/s^2.

    0.1 s up, 0.1 s at 500 000 pulses/s, 0.1 s down, and the cycle that takes the command.

    Source: remote command guide 4.2.15, 4.2.16
    """
    master = servos_on(points={19: Point((100000, 0, 0, 0, 0, 0))})
    master.execute(setting, 0, 50)
    master.send(0x0001, 0, 0, 0, 19)
    start = master.now_us
    master.finish()
    assert master.now_us - start == 305_000


def test_before_they_are_set_the_robot_file_gives_speeds_and_amount() -> None:
    """Rule: first-settings."""
    master = powered_up(manual_speed=3, auto_speed=4, program_speed=5, inching_amount=6)
    for robot in (1, 2, 3, 4):
        assert _values(master, robot) == {MANUAL: 3, AUTOMATIC: 4, PROGRAM: 5, INCHING: 6}


@pytest.mark.parametrize(("loses", "speed"), [(False, 33), (True, 7)])
def test_speeds_after_a_power_cycle(loses: bool, speed: int) -> None:
    """Rule: settings-power."""
    master = powered_up(manual_speed=7, power_loses_settings=loses)
    master.execute(MANUAL, 0, 33)
    master.robot.inject("power_cycle")
    master.run(300)
    assert _values(master, 1)[MANUAL] == speed
