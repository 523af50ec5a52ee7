"""Robot models that a robot file can name have the axes and accelerations of their data sheets."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from movements import NORMAL, mover, way_of
from rcx_harness import spec
from rcx_harness.robot import Axis, Point, RobotConfig
from rcx_harness.robot.schedule import AxisLimits, Schedule
from rcx_harness.spec.robots import law, robot_models
from robot_master import abnormal_end
from structured_text.errors import InputError

PTP, ARM = 0x1001, 0x103D


def _load(folder: Path, text: str) -> RobotConfig:
    file = folder / "robot.toml"
    file.write_text(text, encoding="utf-8")
    return RobotConfig.load(file)


def test_the_yk400xe_has_the_pulses_and_limits_of_the_public_driver() -> None:
    """Axis 1 has the range of -385506 to 380555 pulses, which is +-132 degrees.

    A degree has 2901.746 pulses, and 0 degrees is at -2475.5 pulses.

    Rule: robot-figures.
    Source: public driver of the YK400XE, joints_ranges
    """
    axes = RobotConfig(robot=("YK400XE",)).axes
    limits = [(-385506, 380555), (-437972, 439198), (-1707, 250000), (-245760, 245760)]
    assert [(axis.soft_low, axis.soft_high) for axis in axes] == limits
    assert axes[0].pulses_per_mm == pytest.approx(766_061 / 264)
    assert axes[0].zero in (-2475, -2476)
    assert axes[2].pulses_per_mm == pytest.approx(251_707 / 150)
    assert axes[3].pulses_per_mm == pytest.approx(491_520 / 720)


def test_there_are_five_scara_robots_with_a_standard_cycle_and_a_cartesian_one() -> None:
    """Rule: robot-figures. Source: the maker's data sheets, as a public data set quotes them."""
    arms = {name: model.arms for name, model in robot_models().items()}
    assert arms == {
        "YK400XE": (225, 175),
        "YK400XEC": (225, 175),
        "YK510XEC": (235, 275),
        "YK610XEC": (335, 275),
        "YK710XEC": (435, 275),
        "YK1200XG": (600, 600),
        "SXYX": (),
    }
    cycles = {name: model.cycles[0] for name, model in robot_models().items() if model.cycles}
    assert cycles == {
        "YK400XEC": (2, 0.45),
        "YK510XEC": (2, 0.42),
        "YK610XEC": (2, 0.44),
        "YK710XEC": (2, 0.49),
        "YK1200XG": (5, 0.61),
    }


@pytest.mark.parametrize(("name", "speed"), [("YK400XEC", 6.0), ("YK710XEC", 9.5)])
def test_the_stretched_arm_has_the_speed_of_the_sheet(name: str, speed: float) -> None:
    """With both axes at their highest speed, axis 1 moves both arms, and axis 2 moves arm 2.

    Rule: robot-speeds.
    """
    model = robot_models()[name]
    first, second = (math.radians(joint.speed) for joint in model.joints[:2])
    arm1, arm2 = (arm / 1000 for arm in model.arms)
    assert first * (arm1 + arm2) + second * arm2 == pytest.approx(speed)
    assert second == pytest.approx(1.475 * first)


def test_acceleration_is_power_over_speed_and_mass() -> None:
    """Z of the YK400XEC has 2.648 * 100 W / 1.1 m/s / (0.459 * 4 kg + 2 kg) = 62.76 m/s^2.

    Axis 1 has 9.111 rad/s, which is 3.644 m/s at 0.4 m, and so 2.648 * 200 / 3.644 / 3.836 / 0.4 =
    94.7 rad/s^2.

    Rule: robot-acceleration.
    """
    model = robot_models()["YK400XEC"]
    assert (law().factor, law().own_share) == (2.648, 0.459)
    assert model.joints[2].acceleration(law(), 2) == pytest.approx(62_755, rel=1e-3)
    first = math.degrees(6.0 / (0.4 + 1.475 * 0.175)) / 57.29578
    by_hand = 2.648 * 200 / (first * 0.4) / 3.836 / 0.4
    assert math.radians(model.joints[0].acceleration(law(), 2)) == pytest.approx(by_hand, rel=1e-4)


def test_a_load_makes_a_movement_longer() -> None:
    """At 1 % acceleration, Z never reaches its speed, so the time grows with sqrt(mass).

    The parameter WEIGHT is in kg. The mass is 1.836 kg, and 5.836 kg with a load of 4 kg, so the
    movement takes 1.783 times as long.

    Rule: robot-acceleration.
    """
    cycles = []
    for weight in (0, 4):
        stored = {"WEIGHT": weight, "ACCEL": 1, "DECEL": 1}
        master = mover(robot="YK400XEC", parameters=stored)
        command = spec.command("DriveDirectPulses").encode({"axes": 4, "target": 250_000}, 1)
        cycles.append(len(way_of(master, *command)))
    assert cycles[1] / cycles[0] == pytest.approx(1.783, rel=0.03)


def test_acceleration_goes_with_the_load_in_grams() -> None:
    """Z of the YK400XEC has 0.459 * 4 kg = 1.836 kg without a load, and 5.836 kg with 4 kg.

    Rule: robot-acceleration.
    """
    empty, full = (
        mover(robot="YK400XEC", parameters={"WEIGHT": weight}).robot.machine.arm(1)
        for weight in (0, 4)
    )
    ratio = empty.acceleration(2) / full.acceleration(2)
    assert ratio == pytest.approx(5.836 / 1.836, rel=1e-5)


def test_tables_of_axes_change_those_of_the_model_in_their_order(tmp_path: Path) -> None:
    text = 'robot = "YK400XE"\n[[axes]]\nstart = 130000\n[[axes]]\n[[axes]]\nsoft_high = 100000\n'
    config = _load(tmp_path, text)
    plain = RobotConfig(robot=("YK400XE",)).axes
    assert config.axes[0] == replace(plain[0], start=130_000)
    assert config.axes[1] == plain[1]
    assert config.axes[2] == replace(plain[2], soft_high=100_000)
    assert config.axes[3] == plain[3]


def test_a_robot_file_adds_axes_and_robots_to_the_models(tmp_path: Path) -> None:
    """Robot 2 is the Cartesian robot.

    Axis 5 of robot 1, and robot 3, are defined by their tables.
    """
    text = 'robot = ["YK400XE", "SXYX"]\n' + "[[axes]]\n" * 4
    text += "[[axes]]\nsoft_high = 7\n[[axes]]\nrobot = 2\nstart = 5\n[[axes]]\nrobot = 3\n"
    config = _load(tmp_path, text)
    assert [axis.robot for axis in config.axes] == [1] * 4 + [2] * 3 + [1, 3]
    assert config.axes[4].start == 5
    assert config.axes[7] == Axis(soft_high=7)
    assert config.axes[8] == Axis(robot=3)
    assert [bool(config.model(robot)) for robot in (1, 2, 3, 4)] == [True, True, False, False]


def test_each_of_the_four_robots_may_have_a_model(tmp_path: Path) -> None:
    """Each of robots 1 to 4 may have the axes of a model.

    Source: remote command guide 4.2.1: a command designates robot 1 to 4.
    """
    config = _load(tmp_path, 'robot = ["SXYX", "SXYX", "SXYX", "SXYX"]\n')
    assert [axis.robot for axis in config.axes] == [1] * 3 + [2] * 3 + [3] * 3 + [4] * 3


@pytest.mark.parametrize(
    ("text", "hint"),
    [
        ('robot = "YK400"\n', "did you mean YK400XE"),
        ("robot = 400\n", "YK400XE"),
        ('robot = ["SXYX", "SXYX", "SXYX", "SXYX", "SXYX"]\n', "4 at most"),
    ],
)
def test_an_unknown_robot_is_refused_with_its_line(tmp_path: Path, text: str, hint: str) -> None:
    with pytest.raises(InputError) as caught:
        _load(tmp_path, f"size = 48\n{text}")
    assert caught.value.line == 2
    assert "'robot' cannot be" in caught.value.message
    assert hint in str(caught.value.hint)


def test_a_copy_with_another_key_keeps_its_axes(tmp_path: Path) -> None:
    config = _load(tmp_path, 'robot = "YK400XE"\n[[axes]]\nstart = 5\n')
    assert replace(config, size=256).axes == config.axes


def test_a_cartesian_model_is_no_scara_robot() -> None:
    """A Cartesian model has soft limits in mm, straight lines, and no arm designation."""
    points = {1: Point((100_000, 50_000, 20_000, 0, 0, 0), mm=True)}
    master = mover(robot="SXYX", points=points)
    assert master.execute(0x1003, 0, 0, 0, 1)[0] == NORMAL
    assert master.robot.positions == [81_920, 40_960, 16_384]
    assert master.execute(ARM, 0, 1) == abnormal_end("4.2")


def test_points_beyond_the_limits_of_a_joint_end_in_the_soft_limit() -> None:
    """At x = 0, y = -300 mm axis 1 would need an angle of 180 degrees or more from the front."""
    points = {1: Point((0, -300_000, 0, 0, 0, 0), mm=True)}
    master = mover(robot="YK400XE", points=points)
    assert master.execute(PTP, 0, 0, 0, 1) == abnormal_end("2.334")


def _even(**limits: Any) -> AxisLimits:
    even = {"places": [0, 25, 50, 75, 100], "speed": 1000, "up": 40, "down": 20}
    return AxisLimits(**{**even, **limits})


def test_on_a_straight_path_the_schedule_is_a_profile() -> None:
    """The way is 100, with half of 40/s^2 up and half of 20/s^2 down, below the highest speed.

    The peak follows from v^2 / 40 + v^2 / 20 = 100: v = 36.51. The steps of 25 round it a little.
    """
    schedule = Schedule(100, 1000, [_even()])
    assert schedule.seconds == pytest.approx(36.51 / 20 + 36.51 / 10, rel=0.05)
    shares = [schedule.share(t / 10) for t in range(100)]
    assert shares == sorted(shares)
    assert (schedule.share(0), schedule.share(99)) == (0, 1)


def test_a_schedule_is_slow_only_where_an_axis_would_be_fast() -> None:
    """In the last quarter the axis moves 9 times as fast as the path, so 100/s allow 11/s."""
    places = [0, 25, 50, 75, 300]
    schedule = Schedule(100, 50, [_even(places=places, speed=100, up=1e6, down=1e6)])
    when = [next(t for t in range(10_000) if schedule.share(t / 1000) >= s) for s in (0.5, 0.75)]
    assert when[0] < 1600
    assert schedule.seconds * 1000 - when[1] > 2000


def test_a_schedule_is_slow_where_an_axis_changes_its_rate() -> None:
    """In the middle of the path an axis stops: its rate changes by 0.04 per unit of path.

    Half of 20/s^2 allows v^2 * 0.04 = 10 there, so v = 15.81.
    """
    places = [0, 25, 50, 50, 50]
    schedule = Schedule(100, 1000, [_even(places=places), _even(places=[0, 1, 2, 3, 4])])
    middle = next(t for t in range(20_000) if schedule.share(t / 1000) >= 0.5) / 1000
    speed = (schedule.share(middle + 0.002) - schedule.share(middle - 0.002)) / 0.004 * 100
    assert speed == pytest.approx(15.81, rel=0.02)
