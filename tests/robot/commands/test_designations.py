"""The selected shift and hand, and the arm designation."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, powered_up, servos_on

SHIFT, HAND, ARM = 0x03B, 0x03C, 0x03D
HIGHEST = {SHIFT: 39, HAND: 31, ARM: 1}
TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _values(master: Master, robot: int = 1) -> dict[int, int]:
    settings = master.robot.machine.settings.of(robot)
    return {SHIFT: settings.shift, HAND: settings.hand, ARM: settings.arm}


def test_each_robot_has_its_own_shift_hand_and_arm() -> None:
    """Rule: robot-settings. Source: remote command guide 4.2.17 to 4.2.19, R."""
    master = powered_up(axes=TWO_ROBOTS)
    for code, value in ((SHIFT, 5), (HAND, 6), (ARM, 1)):
        assert master.execute(code | 0x2000, 0, value) == NORMAL_END
    assert _values(master, 2) == {SHIFT: 5, HAND: 6, ARM: 1}
    assert _values(master, 1) == {SHIFT: 0, HAND: 0, ARM: 0}


@pytest.mark.parametrize("code", [SHIFT, HAND])
def test_a_shift_or_hand_that_was_never_defined_may_be_refused(code: int) -> None:
    """One that has been defined is selected. Rule: select-undefined."""
    master = powered_up(undefined_data_alarm="1.2")
    assert master.execute(code, 0, 3) == abnormal_end("1.2")
    assert _values(master)[code] == 0
    define = {SHIFT: 0x010C, HAND: 0x0110}[code]
    assert master.execute(define, 0, 3, 0, 1000) == NORMAL_END
    assert master.execute(code, 0, 3) == NORMAL_END
    assert _values(master)[code] == 3


def test_arm_designation_is_valid_only_when_scara_robot_is_specified() -> None:
    """Rule: arm-scara, arm-robots. Source: remote command guide 4.2.19."""
    master = powered_up(axes=TWO_ROBOTS, scara_robots=(2,), not_scara_alarm="1.9")
    assert master.execute(0x103D, 0, 1) == abnormal_end("1.9")
    assert master.execute(0x003D, 0, 1) == abnormal_end("1.9")
    assert master.execute(0x203D, 0, 1) == NORMAL_END
    assert (_values(master, 1)[ARM], _values(master, 2)[ARM]) == (0, 1)


def test_the_arm_follows_its_designation_when_the_robot_moves() -> None:
    """Rule: arm-follows."""
    master = servos_on()
    settings = master.robot.machine.settings.of(1)
    master.execute(ARM, 0, 1)
    assert settings.arm_status == 0
    master.execute(0x0001, 0, 0, 0, 19)
    assert settings.arm_status == 1


def test_before_they_are_set_shift_and_hand_are_0_and_the_arm_is_right_handed() -> None:
    """Rule: first-settings."""
    assert _values(powered_up()) == {SHIFT: 0, HAND: 0, ARM: 0}


@pytest.mark.parametrize(("loses", "left"), [(False, HIGHEST), (True, dict.fromkeys(HIGHEST, 0))])
def test_designations_after_a_power_cycle(loses: bool, left: dict[int, int]) -> None:
    """Rule: settings-power."""
    master = powered_up(power_loses_settings=loses)
    for code, highest in HIGHEST.items():
        master.execute(code, 0, highest)
    master.robot.inject("power_cycle")
    master.run(300)
    assert _values(master) == left
