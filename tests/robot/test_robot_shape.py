"""The data for the drawing of a robot: arms, limits, points, pallets, work areas and the pose."""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.shape import MOST_POINTS, poses, shapes
from structured_text.errors import InputError

_FILE = """\
robot = ["YK400XE", "SXYX"]

[[axes]]
soft_high = 261157          # 90 degrees: 290.175 pulses each 0.1 degree

[points.1]
mm = [100.5, 200.0, 30.0, 45.0]

[points.2]
pulses = [0, 0, 0, 0]

[comments]
1 = "FEEDER"

[pallets.3]
positions = [2, 2, 1]
first_point = 11

[points.11]
mm = [0, 300]
[points.12]
mm = [20, 300]
[points.13]
mm = [0, 320]
[points.14]
mm = [20, 320]
[points.15]
mm = [0, 300, 10]

[pallets.4]                 # of a point that is not there
positions = [2, 1, 1]
first_point = 30

[work_areas]
Feeder = [[100, 200], [150, 260.5]]
"Tray 2" = [[0, 0, 10], [5, 5, 20]]

[hands.1]
1 = [60000, -20000, 30000, 1]

[shifts]
5 = [10.0, -20.0, 5.0, 90.0]
"""


def load(tmp_path: Path, text: str) -> Controller:
    file = tmp_path / "robot.toml"
    file.write_text(text, encoding="utf-8")
    return Controller(RobotConfig.load(file))


def test_a_shape_has_arms_limits_and_what_the_robot_file_names(tmp_path: Path) -> None:
    """The arms are 225 and 175 mm. Axis 1 goes from -132 degrees to the limit in the robot file.

    Source: spec/robots.toml, YK400XE
    """
    scara, cartesian = shapes(load(tmp_path, _FILE))
    assert (scara["robot"], scara["name"], scara["kind"]) == (1, "YK400XE", "scara")
    assert scara["arms"] == [225, 175]
    first, _, third, _ = scara["axes"]
    assert [one["unit"] for one in scara["axes"]] == ["deg", "deg", "mm", "deg"]
    assert (first["low"], third["low"], third["high"]) == (-132, 0, 150)
    # (261157 + 2475.5) pulses, at 2901.75 pulses per degree
    assert first["high"] == pytest.approx(90.85, abs=0.01)
    points = {one["number"]: one for one in scara["points"]}
    assert points[1] == {"number": 1, "name": "FEEDER", "mm": [100.5, 200.0, 30.0, 45.0]}
    # 2475.5 pulses, at 2901.75 pulses per degree
    assert points[2]["joints"][0] == pytest.approx(0.853, abs=0.001)
    corners = [[0, 300, 0], [20, 300, 0], [20, 320, 0], [0, 320, 0]]
    places = [[0, 300, 0], [20, 300, 0], [0, 320, 0], [20, 320, 0]]
    assert scara["pallets"] == [{"number": 3, "corners": corners, "places": places}]
    assert scara["areas"] == [
        {"name": "Feeder", "from": [100, 200], "to": [150, 260.5]},
        {"name": "Tray 2", "from": [0, 0, 10], "to": [5, 5, 20]},
    ]
    assert (cartesian["robot"], cartesian["kind"], "arms" in cartesian) == (2, "cartesian", False)
    limits = [(one["unit"], one["low"], one["high"]) for one in cartesian["axes"]]
    assert limits == [("mm", 0, 650), ("mm", 0, 450), ("mm", 0, 150)]


def test_the_shape_of_a_robot_without_a_model_has_only_axes_and_limits() -> None:
    (shape,) = shapes(Controller())
    assert (set(shape), shape["kind"]) == ({"robot", "kind", "axes"}, "axes")
    assert [(one["low"], one["high"]) for one in shape["axes"]] == [(-1000, 1000)] * 4


def test_a_pose_lists_only_values_that_differ_from_the_start(tmp_path: Path) -> None:
    controller = load(tmp_path, _FILE)
    controller.positions[1] = 100_000
    assert poses(controller) == [{}, {}]
    controller.positions[1] = -200_000
    settings = controller.machine.settings.of(1)
    settings.hand, settings.shift = 1, 5
    assert poses(controller) == [
        {"left": True, "shift": [10, -20, 5, 90], "hand": [60, -20, 30, 1]},
        {},
    ]


def test_a_hand_beside_the_r_axis_has_its_angle_in_degrees(tmp_path: Path) -> None:
    """Data 1 is in pulses of axis 2, which has 2923.9 pulses per degree.

    Source: remote command guide 4.3.5.
    """
    text = 'robot = "YK400XEC"\n[hands.1]\n1 = [29239, 40000, 5000, 0]\n'
    controller = load(tmp_path, text)
    controller.machine.settings.of(1).hand = 1
    assert poses(controller) == [{"hand": [10, 40, 5, 0]}]


def test_only_the_first_points_are_drawn_if_there_are_too_many(tmp_path: Path) -> None:
    text = 'robot = "SXYX"\n' + "".join(
        f"[points.{k}]\nmm = [{k}]\n" for k in range(MOST_POINTS + 5)
    )
    (shape,) = shapes(load(tmp_path, text))
    assert [one["number"] for one in shape["points"]] == list(range(MOST_POINTS))


def test_pallet_positions_are_drawn_up_to_the_limit_for_points(tmp_path: Path) -> None:
    """The first pallet has 200 positions. The second pallet is cut at the limit for all points."""
    text = "".join(f"[points.{k}]\nmm = [{k}, {k}]\n" for k in range(1, 6))
    text += "".join(f"[pallets.{k}]\npositions = [20, 10, 1]\nfirst_point = 1\n" for k in (1, 2))
    (shape,) = shapes(load(tmp_path, 'robot = "SXYX"\n' + text))
    assert [len(one["places"]) for one in shape["pallets"]] == [200, MOST_POINTS - 200]


@pytest.mark.parametrize(
    ("given", "line"),
    [
        ("work_areas = 5", 1),
        ("[work_areas]\nFeeder = 5", 2),
        ("[work_areas]\nFeeder = [[1, 2]]", 2),
        ("[work_areas]\nFeeder = [[1, 2], [1, 2, 3]]", 2),
        ("[work_areas]\nFeeder = [[1], [2]]", 2),
        ('[work_areas]\nFeeder = [[1, 2], ["a", 2]]', 2),
        ("[work_areas]\nFeeder = [[1, 2], [nan, 2]]", 2),
        (f"[work_areas]\n{'x' * 41} = [[1, 2], [3, 4]]", 1),
        ('[work_areas]\n"" = [[1, 2], [3, 4]]', 1),
        ('[work_areas]\n"a\\tb" = [[1, 2], [3, 4]]', 1),
    ],
)
def test_a_work_area_needs_two_corners(tmp_path: Path, given: str, line: int) -> None:
    with pytest.raises(InputError, match="'work_areas") as caught:
        load(tmp_path, given)
    assert caught.value.line == line
    assert caught.value.hint
