"""Every figure of a robot model agrees with a second, independent reading of the data sheets."""

from __future__ import annotations

import math

import pytest

from rcx_harness.spec.robots import robot_models

#: Soft limits of axes 1 and 2 (degrees, both directions) and of Z (mm), speeds of both arms
#: together (m/s), of Z (mm/s) and of R (degrees/s), motors (W), moment of inertia (kg m^2), load
#: (kg).
SHEETS = {
    "YK400XEC": (132, 145, 150, 6.0, 1100, 2600, (200, 100, 100, 100), 0.05, 4),
    "YK510XEC": (134, 147.5, 200, 7.8, 2000, 2600, (400, 200, 200, 200), 0.3, 10),
    "YK610XEC": (134, 147.5, 200, 8.6, 2000, 2600, (400, 200, 200, 200), 0.3, 10),
    "YK710XEC": (134, 147.5, 200, 9.5, 2000, 2600, (400, 200, 200, 200), 0.3, 10),
    "YK1200XG": (125, 150, 400, 7.7, 1600, 660, (950, 400, 750, 400), 2.45, 50),
    # Limits from the public driver; speeds, motors and loads from the YK400XEC.
    "YK400XE": (132, 150, 150, 6.0, 1100, 2600, (200, 100, 100, 100), 0.05, 4),
}
#: Standard cycle times [s] by load [kg].
CYCLES = {
    "YK400XE": (),
    "YK400XEC": ((2, 0.45),),
    "YK510XEC": ((2, 0.42),),
    "YK610XEC": ((2, 0.44),),
    "YK710XEC": ((2, 0.49),),
    "YK1200XG": ((5, 0.61), (2, 0.55), (40, 0.92)),
    "SXYX": (),
}


@pytest.mark.parametrize("name", SHEETS)
def test_a_scara_robot_has_the_figures_of_its_sheet(name: str) -> None:
    """Rule: robot-figures, robot-speeds.

    Source: the maker's data sheets, as a public data set quotes them
    """
    first, second, z, xy, down, turn, power, inertia, payload = SHEETS[name]
    model = robot_models()[name]
    limits = [(joint.low, joint.high) for joint in model.joints]
    assert limits == [(-first, first), (-second, second), (0, z), (-360, 360)]
    arm1, arm2 = (arm / 1000 for arm in model.arms)
    speeds = [joint.speed for joint in model.joints]
    both = math.radians(speeds[0]) * (arm1 + arm2) + math.radians(speeds[1]) * arm2
    assert both == pytest.approx(xy)
    assert speeds[2:] == [down, turn]
    assert tuple(joint.power for joint in model.joints) == power
    assert model.payload == payload
    assert [joint.largest for joint in model.joints] == [payload, payload, payload, inertia]


def test_the_soft_limits_of_the_public_driver_have_its_pulses() -> None:
    """Rule: robot-figures.

    Source: joints_ranges of the ROS 2 driver for an RCX340 with a YK400XE
    """
    pulses = [
        (joint.zero + joint.low * joint.pulses_per_unit,
         joint.zero + joint.high * joint.pulses_per_unit)
        for joint in robot_models()["YK400XE"].joints
    ]  # fmt: skip
    driver = [(-385506, 380555), (-437972, 439198), (-1707, 250000), (-245760, 245760)]
    assert [pytest.approx(both, abs=0.01) for both in driver] == pulses


@pytest.mark.parametrize("name", CYCLES)
def test_a_robot_has_the_cycle_times_of_its_sheet(name: str) -> None:
    """Rule: robot-figures."""
    assert robot_models()[name].cycles == CYCLES[name]


def test_the_cartesian_robot_has_the_figures_of_its_assumption() -> None:
    """Rule: robot-figures."""
    model = robot_models()["SXYX"]
    assert [(joint.low, joint.high) for joint in model.joints] == [(0, 650), (0, 450), (0, 150)]
    assert [joint.speed for joint in model.joints] == [1200, 1200, 600]
    assert [joint.power for joint in model.joints] == [100, 100, 100]
    assert [joint.own for joint in model.joints] == [25, 20, 20]
    assert model.payload == 5
