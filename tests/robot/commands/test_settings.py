"""Commands set speeds, inching amount, shift, hand and arm designation of each robot."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis, Point
from robot_master import NORMAL_END, Master, abnormal_end, powered_up, servos_on

MANUAL, AUTOMATIC, PROGRAM, INCHING = 0x038, 0x039, 0x03A, 0x027
SHIFT, HAND, ARM = 0x03B, 0x03C, 0x03D
HIGHEST = {
    MANUAL: 100, AUTOMATIC: 100, PROGRAM: 100, INCHING: 10000, SHIFT: 39, HAND: 31, ARM: 1
}  # fmt: skip
TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _values(master: Master, robot: int = 1) -> dict[int, int]:
    settings = master.robot.machine.settings.of(robot)
    speeds = settings.manual_speed, settings.auto_speed, settings.program_speed
    others = settings.inching_amount, settings.shift, settings.hand, settings.arm
    return dict(zip(HIGHEST, speeds + others, strict=True))


@pytest.mark.parametrize("code", HIGHEST)
def test_values_are_accepted_up_to_their_limits_and_refused_beyond(code: int) -> None:
    """The ranges are 1 to 100 %, amount 1 to 10000, shift 0 to 39, hand 0 to 31, arm 0 or 1.

    Source: remote command guide 4.2.8, 4.2.14 to 4.2.19
    """
    master = powered_up()
    lowest = 0 if code in (SHIFT, HAND, ARM) else 1
    for value in (lowest, HIGHEST[code]):
        assert master.execute(code, 0, value) == NORMAL_END
        assert _values(master)[code] == value
    for value in (lowest - 1 & 0xFFFF, HIGHEST[code] + 1, 0xFFFF):
        assert master.execute(code, 0, value) == abnormal_end("4.2")
        assert _values(master)[code] == HIGHEST[code]


def test_each_robot_has_its_own_settings() -> None:
    """Rule: robot-settings. Source: remote command guide 4.2.8, 4.2.14 to 4.2.19, R."""
    master = powered_up(axes=TWO_ROBOTS)
    before = _values(master)
    values = dict(zip(HIGHEST, (11, 12, 13, 14, 5, 6, 1), strict=True))
    for code, value in values.items():
        assert master.execute(code | 0x2000, 0, value) == NORMAL_END
    assert _values(master, 2) == values
    assert _values(master) == before


def test_the_robot_file_presets_speeds_and_amount_and_all_other_settings_are_0() -> None:
    """Arm 0 is right-handed. Rule: first-settings."""
    master = powered_up(manual_speed=3, auto_speed=4, program_speed=5, inching_amount=6)
    for robot in (1, 2, 3, 4):
        assert [*_values(master, robot).values()] == [3, 4, 5, 6, 0, 0, 0]


@pytest.mark.parametrize("loses", [False, True])
def test_a_key_decides_whether_settings_survive_a_power_cycle(loses: bool) -> None:
    """Rule: settings-power."""
    master = powered_up(power_loses_settings=loses)
    before = _values(master)
    for code, highest in HIGHEST.items():
        master.execute(code, 0, highest)
    master.robot.inject("power_cycle")
    master.run(300)
    assert _values(master) == (before if loses else HIGHEST)


@pytest.mark.parametrize("setting", [AUTOMATIC, PROGRAM])
def test_automatic_and_program_speed_slow_a_movement_down(setting: int) -> None:
    """A movement of 100 000 pulses runs at 50 % of 1 000 000 pulses/s with 5 000 000 pulses/s^2.

    It takes 0.1 s for acceleration, 0.1 s at constant speed and 0.1 s for braking, plus the cycle
    that accepts the command.

    Source: remote command guide 4.2.15, 4.2.16
    """
    master = servos_on(points={19: Point((100000, 0, 0, 0, 0, 0))})
    master.execute(setting, 0, 50)
    master.send(0x0001, 0, 0, 0, 19)
    start = master.now_us
    master.finish()
    assert master.now_us - start == 305_000


@pytest.mark.parametrize(("code", "define"), [(SHIFT, 0x010C), (HAND, 0x0110)])
def test_a_shift_or_hand_that_was_never_defined_may_be_refused(code: int, define: int) -> None:
    """A shift or hand that was defined can be selected with either setting.

    Rule: select-undefined.
    """
    master = powered_up(undefined_data_alarm="1.2")
    assert master.execute(code, 0, 3) == abnormal_end("1.2")
    assert _values(master)[code] == 0
    assert master.execute(define, 0, 3, 0, 1000) == NORMAL_END
    assert master.execute(code, 0, 3) == NORMAL_END
    assert _values(master)[code] == 3


def test_arm_designation_is_valid_only_when_scara_robot_is_specified() -> None:
    """Rule: arm-scara, arm-robots. Source: remote command guide 4.2.19."""
    master = powered_up(axes=TWO_ROBOTS, scara_robots=(2,), not_scara_alarm="1.9")
    assert master.execute(0x103D, 0, 1) == abnormal_end("1.9")
    assert master.execute(0x003D, 0, 1) == abnormal_end("1.9")
    assert master.execute(0x203D, 0, 1) == NORMAL_END
    assert (_values(master)[ARM], _values(master, 2)[ARM]) == (0, 1)


def test_the_arm_follows_its_designation_when_the_robot_moves() -> None:
    """Rule: arm-follows."""
    master = servos_on()
    settings = master.robot.machine.settings.of(1)
    master.execute(ARM, 0, 1)
    assert settings.arm_status == 0
    master.execute(0x0001, 0, 0, 0, 19)
    assert settings.arm_status == 1
