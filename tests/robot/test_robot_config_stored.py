"""A robot file presets stored data."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rcx_harness.robot import Hand, Pallet, Point, RobotConfig
from stored_data import long_words, ready, real_words, text_words
from structured_text.errors import InputError

GOOD = """\
[points.50]
mm = [10.0, -0.0005]

[comments]
50 = "WAIT ORG"

[pallets.10]
positions = [10, 15, 1]
first_point = 100

[shifts]
5 = [10.0, -20.0, 5.0, -18.0]
6 = [0.001]

[hands.1]
3 = [10000, -2000, 5000, 1]

[hands.4]
31 = [-7]

[variables]
SGI5 = 50
SGR31 = 0.1

[parameters]
ACCEL = 80
TOLE = [10, 20, 30, 40]
WEIGHT = [1, 2, 3, 4]
"""


def _load(tmp_path: Path, text: str) -> RobotConfig:
    file = tmp_path / "robot.toml"
    file.write_text(text, encoding="utf-8")
    return RobotConfig.load(file)


def test_a_robot_file_presets_stored_data(tmp_path: Path) -> None:
    config = _load(tmp_path, GOOD)
    assert config.points == {50: Point((10000, 0, 0, 0, 0, 0), mm=True)}
    assert config.comments == {50: "WAIT ORG"}
    assert config.pallets == {10: Pallet(10, 15, 1, 100)}
    assert config.shifts == {5: (10000, -20000, 5000, -18000), 6: (1, 0, 0, 0)}
    assert config.hands == {(1, 3): Hand((10000, -2000, 5000, 1)), (4, 31): Hand((-7, 0, 0, 0))}
    assert config.variables == {"SGI5": 50, "SGR31": 0.1}
    assert config.parameters == {"ACCEL": 80, "TOLE": (10, 20, 30, 40), "WEIGHT": (1, 2, 3, 4)}


def test_the_reference_commands_answer_the_preset_data(tmp_path: Path) -> None:
    """Rule: preset-data. Source: remote command guide 4.3.2 to 4.3.5, 4.4.1, 4.4.2."""
    config = _load(tmp_path, GOOD)
    names = ("comments", "pallets", "shifts", "hands", "variables", "parameters")
    master = ready(**{name: getattr(config, name) for name in names})
    assert master.execute(0x0105, 0, 50)[4:12] == text_words("WAIT ORG", "\0")
    assert master.execute(0x0109, 0, 10)[2:7] == (10, 10, 15, 1, 100)
    assert master.execute(0x010D, 0, 5)[4:12] == long_words(10000, -20000, 5000, -18000)
    assert master.execute(0x0111, 0, 3)[4:12] == long_words(10000, -2000, 5000, 1)
    assert master.execute(0x0214, 0, 5)[4:6] == (50, 0)
    assert master.execute(0x0214, 0, 287)[4:6] == real_words(0.1)
    for axis, tolerance in enumerate((10, 20, 30, 40)):
        assert master.execute(0x0224, 0, 259, 1 << axis)[4:6] == (tolerance, 0)
        assert master.execute(0x0224, 0, 257, 1 << axis)[4:6] == (80, 0)
    assert master.execute(0x0224, 0, 1)[4:6] == (1, 0)


def _pallet(positions: str, first_point: str) -> str:
    return f"[pallets.1]\npositions = {positions}\nfirst_point = {first_point}"


@pytest.mark.parametrize(
    ("text", "line", "message", "hint"),
    [
        ("\n[points]\n1 = 2", 3, "'points.1' must be a table", "[points.1]"),
        ("[points.1]\nmm = [nan]", 1, "'points.1' needs at most 6 numbers", ""),
        ("comments = 3", 1, "'comments' must be a table", "[comments]"),
        ("\n[comments]\n1 = 2", 3, "'comments.1' must be a text", "WAIT ORG"),
        ('[comments]\n30000 = ""', 2, "'comments.30000' is not a comment", "29999"),
        ('[comments]\n1 = "12345678901234567"', 2, "'comments.1' cannot be", "16 characters"),
        ('[comments]\n1 = "\u00e4"', 2, "'comments.1' cannot be", "16#7E"),
        ("pallets = 3", 1, "'pallets' must be tables", "[pallets.10]"),
        ("[pallets.40]", 1, "'pallets.40' is not a pallet", "39"),
        ("[pallets.x]", 1, "'pallets.x' is not a pallet", "39"),
        ("[pallets.1]\nposition = 1", 2, "unknown key 'position' in 'pallets.1'", "positions"),
        ("[pallets.1]\npositions = [1, 1, 1]", 1, "'pallets.1' needs positions", ""),
        ("[pallets.1]\npositions = [1, 1]\nfirst_point = 1", 1, "'pallets.1' needs", ""),
        (_pallet("[1, 0, 1]", "1"), 1, "'pallets.1' cannot be 0", "32767"),
        (_pallet("[256, 256, 1]", "1"), 1, "'pallets.1' cannot be 65536", "32767"),
        (_pallet("[1, 1, 1]", "29996"), 1, "'pallets.1' cannot be 29996", "29995"),
        (_pallet("[1, 1, 1]", "true"), 1, "'pallets.1' needs positions", ""),
        ("[shifts]\n40 = [1]", 2, "'shifts.40' is not a shift", "39"),
        ("[shifts]\n1 = [1, 2, 3, 4, 5]", 2, "'shifts.1' needs at most 4 numbers in mm", ""),
        ("[shifts]\n1 = [3e6]", 2, "'shifts.1' cannot be 3000000000", "32 bit"),
        ("[hands.5]\n1 = [1]", 2, "'hands.5.1' cannot be 5", "robot 1 to 4"),
        ("[hands]\n1 = [1]", 2, "'hands.1' must be a table", "[hands.1]"),
        ("[hands.1]\n32 = [1]", 2, "'hands.1.32' is not a hand", "31"),
        ("[hands.1]\n1 = [0.5]", 2, "'hands.1.1' needs at most 4 integers", ""),
        ("[hands.1]\n1 = [0, 0, 0, 2]", 2, "'hands.1.1' cannot be 2", "data 4 is 0 or 1"),
        ("[points.1]\nmm = [1]\n[points.-1]\nmm = [1]", 3, "'points.-1' is not a point", "29999"),
        ('[points.1]\nmm = [1]\n[points."\u0661"]\nmm = [1]', 3, "'points.\u0661' is not", "29999"),
        (f"\n[points.{'9' * 5000}]", 2, f"'points.{'9' * 40}...' is not a point", "29999"),
        (f"\n[hands.{'9' * 5000}]", 2, f"'hands.{'9' * 40}...' is not a robot's", "[hands.4]"),
        (f"[comments]\n{'0' * 5000}9 = 3", 2, "'comments.9' must be a text", ""),
        (
            "[points.1]\npulses = [1]\n[points.01]\npulses = [2]",
            3,
            "'points.01' gives points.1",
            "",
        ),
        ("[points]\n1 = {mm = [1]}\n'001' = {mm = [1]}", 3, "'points.001' gives points.1", ""),
        (
            '[comments]\n1 = "A"\n001 = "B"',
            3,
            "'comments.001' gives comments.1 a second time",
            "remove",
        ),
        ("[shifts]\n1 = [1]\n\n01 = [2]", 4, "'shifts.01' gives shifts.1 a second time", "remove"),
        ("[hands.1]\n1 = [1]\n01 = [2]", 3, "'hands.1.01' gives hands.1.1 a second time", "remove"),
        (
            "[hands.1]\n1 = [1]\n[hands.01]\n2 = [2]",
            3,
            "'hands.01' gives hands.1 a second time",
            "remove",
        ),
        ("[pallets.1]\n[pallets.01]", 1, "'pallets.1' needs positions", ""),
        (
            "[real_time_items]\n1 = 'a'\n01 = 'b'",
            3,
            "'real_time_items.01' gives real_time",
            "remove",
        ),
        (f"[real_time_items]\n{'9' * 5000} = 'a'", 2, "'real_time_items.999", ""),
        ("[variables]\nSGI1 = 1\nSGI01 = 2", 3, "'variables.SGI01' is given twice", "remove"),
        (f"[variables]\nSGI{'9' * 5000} = 1", 1, "'variables' cannot be 'SGI99", "SGR31"),
        ("[points.1]\nmm = [1]\narm1 = 1.0", 3, "'points.1.arm1' cannot be 1.0", "-1, 0 or 1"),
        ("[points.1]\nmm = [1]\narm2 = true", 3, "'points.1.arm2' cannot be True", "-1, 0 or 1"),
        ("[points.2]\nmm = [1]\n[points.1]\nmm = [1]\nhand = 2.0", 5, "cannot be 2.0", "1 or 2"),
        ("[points.1]\nmm = [1]\nhand = true", 3, "'points.1.hand' cannot be True", "0, 1 or 2"),
        ("[points.1]\nmm = [1e308]", 1, "'points.1' cannot be 1e+308", "32 bit numbers"),
        (f"[points.1]\nmm = [0x{'F' * 5000}]", 1, "'points.1' cannot be a number with", "32 bit"),
        ("[shifts]\n1 = [-1e308]", 2, "'shifts.1' cannot be -1e+308", "32 bit numbers"),
        ("[points.1]\npulses = [1.7]", 1, "'points.1' needs at most 6 whole numbers", ""),
        ("[points.1]\npulses = [1.0]", 1, "'points.1' needs at most 6 whole numbers", ""),
        ("[hands.1]\n1 = [1, 2, 3, true]", 2, "'hands.1.1' needs at most 4 integers", ""),
        ("[variables]\nSGI32 = 1", 1, "'variables' cannot be 'SGI32'", "SGR31"),
        ("[variables]\nSGI1 = 0.5", 2, "'SGI1' cannot be 0.5", "32 bit integer"),
        ("[variables]\nSGR1 = 4e38", 2, "'SGR1' cannot be 4e+38", "single precision"),
        ("[variables]\nSGR1 = inf", 2, "'SGR1' cannot be inf", "single precision"),
        ("[parameters]\nACEL = 1", 2, "unknown key 'ACEL' in [parameters]", "ACCEL"),
        ("[parameters]\nACCEL = 0", 2, "'ACCEL' cannot be 0", "1 to 100"),
        ("[parameters]\nACCEL = [1, 2]", 2, "'ACCEL' cannot be (1, 2)", "4: one per axis"),
        ("[parameters]\nWEIGHT = [1]", 2, "'WEIGHT' cannot be (1,)", "4: one per robot"),
        ('undefined_data_alarm = "x"', 1, "'undefined_data_alarm' cannot be 'x'", "12.600"),
        ('comment_filler = "none"', 1, "'comment_filler' cannot be 'none'", "zeros or spaces"),
        ('real_to_integer = "up"', 1, "'real_to_integer' cannot be 'up'", "round or truncate"),
        ("max_payload = -1", 1, "'max_payload' cannot be -1", "0 to 2000000"),
    ],
)
def test_wrong_stored_data_are_refused(
    tmp_path: Path, text: str, line: int, message: str, hint: str
) -> None:
    with pytest.raises(InputError) as caught:
        _load(tmp_path, text)
    assert message in caught.value.message
    assert hint in caught.value.hint
    assert caught.value.line == line


@pytest.mark.parametrize(
    "values",
    [
        {"points": {30000: Point()}},
        {"points": {1: Point((0,) * 5)}},
        {"comments": {-1: ""}},
        {"pallets": {40: Pallet(1, 1, 1, 0)}},
        {"shifts": {1: (0, 0, 0)}},
        {"hands": {(0, 1): Hand()}},
        {"hands": {(1, 32): Hand()}},
        {"hands": {(1.0, 1): Hand()}},
        {"hands": {(1, 1): Hand((0, 0, 0, True))}},
        {"points": {1: Point(hand=True)}},
        {"points": {1: Point(arm1=1.0)}},  # type: ignore[arg-type]
        {"pallets": {1: Pallet(1.0, 1, 1, 0)}},  # type: ignore[arg-type]
        {"pallets": {1: Pallet(1, 1, 1, 1.0)}},  # type: ignore[arg-type]
    ],
)
def test_wrong_stored_data_in_python_are_refused_too(values: dict[str, Any]) -> None:
    with pytest.raises(InputError):
        RobotConfig(**values)
