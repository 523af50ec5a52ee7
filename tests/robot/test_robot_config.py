"""Robot files are read, and wrong contents are refused."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.robot import Axis, Point, RobotConfig, RobotProgram
from rcx_harness.robot.config.checks import STORED
from structured_text.errors import InputError

GOOD = """\
size = 256
servo_on_delay = [10, 40]
command_delay = 25
skip_run_status = "never"
minor_alarms = ["12.400", "1.5"]

[[axes]]
pulses_per_mm = 200
soft_high = 5000
type = "semi_absolute"
origin_method = "stroke_end"

[[axes]]
robot = 2

[[axes]]
robot = 1

[[programs]]
name = "PICK"
duration = 750
loop = false

[[programs]]
steps = ["WAIT SI(20)=1", "SOD(24)=69905"]

[points.19]
mm = [10.0, -0.123]
hand = 1

[points.20]
pulses = [7]
"""


def _load(tmp_path: Path, text: str) -> RobotConfig:
    file = tmp_path / "robot.toml"
    file.write_text(text, encoding="utf-8")
    return RobotConfig.load(file)


def test_a_robot_file_sets_the_keys_that_it_contains(tmp_path: Path) -> None:
    config = _load(tmp_path, GOOD)
    assert config.size == 256
    assert config.servo_on_delay == (10, 40)
    assert config.command_delay == 25
    assert config.min_interval == RobotConfig().min_interval
    assert config.axes == (
        Axis(type="semi_absolute", origin_method="stroke_end", pulses_per_mm=200, soft_high=5000),
        Axis(robot=2),
        Axis(),
    )
    assert config.axes_of(0) == config.axes_of(1) == (0, 2)
    assert config.axes_of(2) == (1,)
    assert config.programs == (
        RobotProgram("PICK", 750, loop=False),
        RobotProgram(steps=("WAIT SI(20)=1", "SOD(24)=69905")),
    )
    assert config.points == {
        19: Point((10000, -123, 0, 0, 0, 0), mm=True, hand=1),
        20: Point((7, 0, 0, 0, 0, 0)),
    }


@pytest.mark.parametrize(
    ("text", "line", "message", "hint"),
    [
        ("size = 48\nservo_on_dellay = 3", 2, "unknown key 'servo_on_dellay'", "servo_on_delay"),
        ("[[axes]]\nsoft_hi = 3", 2, "unknown key 'soft_hi' in [[axes]]", "soft_high"),
        ("delays = 3", 1, "unknown key 'delays'", "command_delay, servo_on_delay, sequence_delay"),
        ("[[programs]]\nwork = 3", 2, "'work'", "there are name, duration, loop, steps"),
        ("size = 64", 1, "'size' cannot be 64", "48 or 256"),
        ("size = 48.0", 1, "'size' cannot be 48.0", "48 or 256"),
        ("auto_mode = 1", 1, "'auto_mode' cannot be 1", "true or false"),
        ("servo_on_delay = -1", 1, "'servo_on_delay' cannot be -1", "milliseconds"),
        ("servo_on_delay = [9, 3]", 1, "'servo_on_delay' cannot be (9, 3)", "shortest"),
        ('servo_on_delay = "5ms"', 1, "'servo_on_delay' cannot be '5ms'", "milliseconds"),
        ("min_interval = nan", 1, "'min_interval' cannot be nan", "from 0 on"),
        ('skip_run_status = "no"', 1, "'skip_run_status' cannot be 'no'", "never or short"),
        ('format_alarm = "4"', 1, "'format_alarm' cannot be '4'", '"12.600"'),
        ("minor_alarms = [12.4]", 1, "'minor_alarms' cannot be 12.4", '"12.600"'),
        ("axes = 4", 1, "'axes' must be tables", "[[axes]]"),
        ("axes = []", 1, "'axes' cannot be 0", "1 to 6 for robot 1"),
        ("[[axes]]\nmax_speed = 0", 2, "'max_speed' cannot be 0", "above 0"),
        ("scara_robots = [1, 5]", 1, "'scara_robots' cannot be (1, 5)", "numbers 1 to 4"),
        ("scara_robots = 1", 1, "'scara_robots' cannot be 1", "a list of robot numbers"),
        ("[[axes]]\nsoft_low = 2000000", 2, "'soft_low' cannot be 2000000", "below soft_high"),
        ("[[programs]]\nduration = 0", 2, "'duration' cannot be 0", "above 0"),
        ('[[programs]]\nname = "Main"', 2, "'name' cannot be 'Main'", "upper case letters"),
        ('[[programs]]\nname = "A B"', 2, "'name' cannot be 'A B'", "digits and _"),
        ('[[programs]]\nname = ""', 2, "'name' cannot be ''", "upper case letters"),
        ('[[axes]]\ntype = "abs"', 2, "'type' cannot be 'abs'", "absolute"),
        (
            '[[programs]]\nsteps = ["SO(20)"]',
            2,
            "step 1 of 'steps': cannot read 'SO(20)'",
            "WAIT SI",
        ),
        ('[[programs]]\nsteps = "SO(20)=1"', 2, "'steps' cannot be 'SO(20)=1'", "list of texts"),
        ('di17_mode = "ORG"', 1, "'di17_mode' cannot be 'ORG'", "ABS or ABS/ORG"),
        ("programs = []", 1, "'programs' cannot be ()", "at least one"),
        ('[real_time_items]\n0 = "motor_duty"', 1, "'real_time_items' cannot be 0", "1 to 45"),
        ('[real_time_items]\n46 = "motor_duty"', 1, "'real_time_items' cannot be 46", "1 to 45"),
        ('[real_time_items]\n1 = "motor_dutty"', 1, "cannot have 'motor_dutty'", "motor_duty"),
        ("[real_time_items]\n1 = 5", 1, "'real_time_items' cannot have 5", "motor_duty"),
        ("[real_time_items]\nx = 'motor_duty'", 2, "'real_time_items.x' is not an", "write 13"),
        ("real_time_items = 5", 1, "'real_time_items' must be a table", "write 13"),
        ("option_slots = [1, 2, 3]", 1, "'option_slots' cannot be (1, 2, 3)", "4 unit numbers"),
        ("option_slots = [0, 0, 0, 65536]", 1, "'option_slots' cannot be", "4 unit numbers"),
        ("option_slots = 5", 1, "'option_slots' cannot be 5", "4 unit numbers"),
        ('name_filler = "none"', 1, "'name_filler' cannot be 'none'", "zeros or spaces"),
        *(
            (f"clock = {clock!r}", 1, "'clock' cannot be", "2014-01-01 10:59:59")
            for clock in ("2014-01-01", "2014-02-30 10:00:00", "1999-12-31 23:59:59", 14)
        ),
        ("points = 3", 1, "'points' must be tables", "[points.19]"),
        ("[points.30000]\nmm = [1]", 1, "'points.30000' is not a point", "29999"),
        ("[points.1]\nmmm = [1]", 2, "unknown key 'mmm' in 'points.1'", "mm"),
        ("[points.1]\nhand = 1", 1, "'points.1' needs either mm", ""),
        ("[points.1]\nmm = [inf]", 1, "'points.1' needs at most 6", ""),
        ("[points.1]\nmm = [1,2,3,4,5,6,7]", 1, "'points.1' needs at most 6 numbers", ""),
        ("[points.1]\npulses = [1]\nhand = 3", 3, "'points.1.hand' cannot be 3", "hand 0, 1 or 2"),
        ("[points.1]\npulses = [3000000000]", 1, "'points.1' cannot be 3000000000", "32 bit"),
    ],
)
def test_a_wrong_robot_file_is_refused(
    tmp_path: Path, text: str, line: int, message: str, hint: str
) -> None:
    with pytest.raises(InputError) as caught:
        _load(tmp_path, text)
    assert message in caught.value.message
    assert hint in caught.value.hint
    assert caught.value.line == line
    assert caught.value.file == str(tmp_path / "robot.toml")


_WRONG_VALUES = ["nan", "inf", "-inf", "-1.5", "1e308", "9" * 30, "9" * 5_000, "0x" + "F" * 5_000]
_WRONG_VALUES += [
    "[nan]",
    "[[1]]",
    "{}",
    "{1 = nan}",
    "[{x = 1}]",
    "[true, 1]",
    "1979-05-27",
    "[" * 2_000,
]
_QUICK_VALUES = ["9" * 30, "[[1]]", "{}", "1979-05-27"]


@pytest.mark.exhaustive(but=["robot-[[1]]", "axes-{}", "programs-1979-05-27"])
@pytest.mark.parametrize(
    "value",
    [
        pytest.param(value, marks=[] if value in _QUICK_VALUES else pytest.mark.exhaustive)
        for value in _WRONG_VALUES
    ],
    ids=lambda value: value[:12],
)
@pytest.mark.parametrize(
    ("table", "keys"),
    [
        ("", [one.name for one in fields(RobotConfig)]),
        ("[[axes]]\n", [one.name for one in fields(Axis)]),
        ("[[programs]]\n", [one.name for one in fields(RobotProgram)]),
    ],
    ids=["robot", "axes", "programs"],
)
def test_every_key_refuses_a_value_of_another_kind(
    tmp_path: Path, table: str, keys: list[str], value: str
) -> None:
    """Every key refuses a value of a wrong type with a short message.

    An exception is an empty table, if the key takes tables.
    """
    for key in keys:
        empty = value == "{}" and key in (*STORED, "real_time_items", "work_areas")
        said = ""
        try:
            _load(tmp_path, f"{table}{key} = {value}\n")
        except InputError as error:
            said = str(error)
        assert bool(said) is not empty, f"{table}{key} takes {value:.40}"
        assert len(said) < 1_000


@pytest.mark.parametrize(("value", "line"), [("9" * 5_000, 2), ("[" * 2_000, 2)])
def test_a_value_too_long_is_refused_with_its_line(tmp_path: Path, value: str, line: int) -> None:
    with pytest.raises(
        InputError, match="a number with too many digits, or lists nested too deeply"
    ) as caught:
        _load(tmp_path, f"size = 48\nauto_speed = {value}\n")
    assert caught.value.line == line


def test_a_file_that_is_not_toml_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"not valid TOML.*line 1"):
        _load(tmp_path, "size == 48")


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.toml: cannot be read"):
        RobotConfig.load(tmp_path / "none.toml")
    with pytest.raises(InputError, match="is a folder, not a file"):
        RobotConfig.load(tmp_path)


@pytest.mark.parametrize(
    "values",
    [
        {"size": 47},
        {"boot_time": (5, 1)},
        {"pendant_alarm": "x"},
        {"axes": (Axis(motor_rotation=3),)},
        {"axes": (Axis(workpiece=2**31),)},
        {"axes": (Axis(max_acceleration=0),)},
    ],
)
def test_a_wrong_value_in_python_is_refused_too(values: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        RobotConfig(**values)


def test_the_points_of_the_manuals_examples_are_there_without_a_robot_file() -> None:
    """Rule: example-points.

    The position of point 19 (chapter 2), and all hand systems and arm rotations, are assumed.

    Source: guide, 4.3.1 (point 50: 10.000, -20.000, 5.000, -18.000 mm), 4.2.1 (point 100)
    """
    assert RobotConfig().points == {
        19: Point((120_000, -45_000, 30_000, 0, 0, 0), mm=False),
        50: Point((10_000, -20_000, 5_000, -18_000, 0, 0), mm=True),
        100: Point((123_456, -123, 0, 0, 0, 0), mm=False),
    }
    assert not RobotConfig(points={}).points
