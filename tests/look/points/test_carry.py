"""Stored data read from and written to a virtual controller, and the file between."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest

from probed_robot import StationLine
from rcx_harness.errors import InputError
from rcx_harness.look.points.carry import Carrier, RefusedError
from rcx_harness.look.points.stored import Key, Stored, as_csv, as_toml, from_toml, shown
from rcx_harness.look.probe.line import LostError
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import Axis
from rcx_harness.robot.stored import Hand, Pallet, Point

#: The largest numbers, both units, all flags, texts that a file has to quote.
_CONFIG: dict[str, Any] = {
    "axes": (*(Axis(),) * 3, Axis(robot=2)),
    "points": {
        3: Point((1, -2, 3, -4, 5, -6)),
        4: Point((8_191_999, -1, 2_000_001, 0, 0, 0), mm=True, hand=2, arm1=-1, arm2=1),
        6: Point((2**31 - 1, -(2**31), 0, 0, 0, 0)),
    },
    "comments": {4: "WAIT ORG", 5: 'a "b" \\ c, d'},
    "shifts": {1: (1, -2, 3, -4)},
    "hands": {(1, 2): Hand((100, -1, 2, 0)), (2, 3): Hand((7, 8, 9, 1))},
    "pallets": {2: Pallet(10, 15, 1, 100)},
}
_KEYS: list[Key] = [
    *(("points", 0, n) for n in range(8)),
    *(("comments", 0, n) for n in range(8)),
    *(("shifts", 0, n) for n in range(3)),
    *(("hands", robot, n) for robot in (1, 2) for n in range(4)),
    *(("pallets", 0, n) for n in range(4)),
]


def _quiet(share: float) -> None:
    assert 0 < share <= 1


def _read(**config: Any) -> Stored:
    return Carrier(StationLine(RobotConfig(**config))).read(_KEYS, _quiet)


@pytest.mark.parametrize("filler", ["zeros", "spaces"])
def test_everything_that_is_stored_is_read_and_what_is_not_is_left_out(filler: str) -> None:
    """Source: guide 4.3.1 to 4.3.5."""
    found = _read(**_CONFIG, comment_filler=filler)
    assert found.of("points") == {(0, n): point for n, point in _CONFIG["points"].items()}
    assert found.of("comments") == {(0, n): text for n, text in _CONFIG["comments"].items()}
    assert found.of("pallets") == {(0, 2): Pallet(10, 15, 1, 100)}
    assert found.of("shifts") == {(0, 0): (0,) * 4, (0, 1): (1, -2, 3, -4), (0, 2): (0,) * 4}
    hands = found.of("hands")
    assert len(hands) == 8
    assert (hands[1, 2], hands[2, 3]) == (Hand((100, -1, 2, 0)), Hand((7, 8, 9, 1)))


def test_a_file_brings_back_what_was_written_to_it(tmp_path: Path) -> None:
    """To the last digit; and it is a robot file."""
    found = _read(**_CONFIG)
    file = tmp_path / "points.toml"
    file.write_text(as_toml(found, ["head"]), encoding="utf-8")
    assert from_toml(file).values == found.values
    assert as_toml(from_toml(file), ["head"]) == file.read_text(encoding="utf-8")
    assert RobotConfig.load(file).points == _CONFIG["points"]


def test_the_file_has_the_controllers_units() -> None:
    """Source: guide 4.3.1, the example of the reference."""
    point = Point((10_000, -20_000, 5_000, -18_000, 0, -1), mm=True, hand=1)
    text = as_toml(Stored({("points", 0, 50): point, ("comments", 0, 50): "A\tB"}), ["one", "two"])
    assert text == (
        "# one\n# two\n\n[points.50]\n"
        "mm = [10.000, -20.000, 5.000, -18.000, 0.000, -0.001]\nhand = 1\n"
        '\n[comments]\n50 = "A\\u0009B"\n'
    )


def test_csv_has_a_line_for_each_point_and_each_comment() -> None:
    rows = list(csv.reader(as_csv(_read(**_CONFIG)).splitlines()))
    axes = [f"axis{k}" for k in range(1, 7)]
    assert rows[0] == ["number", "unit", *axes, "hand", "arm1", "arm2", "comment"]
    assert [row[0] for row in rows[1:]] == ["3", "4", "5", "6"]
    assert rows[1] == ["3", "pulse", "1", "-2", "3", "-4", "5", "-6", "0", "0", "0", ""]
    assert rows[2][1:5] == ["mm", "8191.999", "-0.001", "2000.001"]
    assert rows[2][8:] == ["2", "-1", "1", "WAIT ORG"]
    assert rows[3] == ["5", *[""] * 10, 'a "b" \\ c, d']


def test_what_was_read_from_one_controller_is_stored_by_another() -> None:
    """Only what a definition takes; the old comment goes.

    Source: guide 4.3
    """
    found = _read(**_CONFIG)
    config = RobotConfig(points={}, comments={7: "old"}, axes=_CONFIG["axes"])
    line = StationLine(config)
    carrier = Carrier(line)
    carrier.write(found, [*found.values, ("comments", 0, 7)], _quiet)
    assert carrier.read(_KEYS, _quiet).values == found.values
    assert line.controller.machine.memory.points == _CONFIG["points"]
    assert line.controller.machine.memory.comments[7] == ""


def test_all_dedicated_inputs_stay_off() -> None:
    """Source: manual chapter 5, 2: SI(00) OFF is an emergency stop."""
    line = StationLine(RobotConfig())
    seen: set[bytes] = set()
    write = line.write

    def noted(area: bytes, *, run: bool = True) -> None:
        seen.add(area[32:34])
        write(area, run=run)

    line.write = noted  # type: ignore[method-assign]
    carrier = Carrier(line)
    carrier.write(Stored({("points", 0, 1): Point()}), [("points", 0, 1)], _quiet)
    carrier.read([("points", 0, 1)], _quiet)
    assert seen == {bytes(2)}


def test_another_alarm_ends_it_and_names_the_point() -> None:
    line = StationLine(RobotConfig(undefined_point_alarm="4.209"))
    with pytest.raises(RefusedError, match=r"^reading point 7 ended in the alarm 4\.209$"):
        Carrier(line).read([("points", 0, 50), ("points", 0, 7)], _quiet)
    assert Carrier(line, ["4.209"]).read([("points", 0, 7)], _quiet).values == {}


def test_a_definition_that_is_refused_ends_it() -> None:
    """A pendant that has the authority. Source: guide 3, remark."""
    line = StationLine(RobotConfig(pendant_authority=True))
    with pytest.raises(RefusedError, match=r"^writing pallet 2 ended in the alarm 12\.76$"):
        Carrier(line).write(Stored({("pallets", 0, 2): Pallet(1, 1, 1, 0)}), [("pallets", 0, 2)], _quiet)  # noqa: E501  # fmt: skip


def test_a_controller_that_gives_no_end_is_not_waited_for() -> None:
    line = StationLine(RobotConfig(command_delay=10_000.0))
    with pytest.raises(RefusedError, match=r"^shift 1: no end within 3 s, status 16#0100$"):
        Carrier(line).read([("shifts", 0, 1)], _quiet)


def test_a_controller_that_is_busy_is_left_alone() -> None:
    line = StationLine(RobotConfig())
    line.read = lambda: b"\x00\x01" + bytes(46)  # type: ignore[method-assign]
    with pytest.raises(RefusedError, match="remote status 16#0100 without a command"):
        Carrier(line)


def test_a_lost_connection_is_told() -> None:
    line = StationLine(RobotConfig())
    carrier = Carrier(line)
    line.lost_after_us = line.now_us
    with pytest.raises(LostError):
        carrier.read([("points", 0, 50)], _quiet)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("size = 48\n", "has none of the tables points, comments, shifts, hands, pallets"),
        ("[points.30000]\nmm = [1]\n", "'points.30000' is not a point"),
        ("[points.1]\nmm = [1, 2, 3, 4, 5, 6, 7]\n", "'points.1' needs at most 6 numbers"),
        ("[comments]\n1 = 'more than sixteen letters'\n", "up to 16 characters"),
        ("[[[", "TOML"),
    ],
)
def test_a_file_that_is_none_gets_one_message(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "a.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        from_toml(file)
    assert message in str(error.value)
    assert str(file) in str(error.value)


def test_only_the_tables_of_the_file_count(tmp_path: Path) -> None:
    """A robot file without points does not bring the points of the manual's examples."""
    file = tmp_path / "a.toml"
    file.write_text("[comments]\n1 = 'A  '\n2 = ''\n", encoding="utf-8")
    stored = from_toml(file)
    assert stored.values == {("comments", 0, 1): "A"}
    assert stored.asked == [("comments", 0, 1), ("comments", 0, 2)]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "not defined"),
        ("A", '"A"'),
        (Point((1, 2, 3, 4, 5, 6)), "pulses = [1, 2, 3, 4, 5, 6]"),
        ((1000, 0, -1, 0), "[1.000, 0.000, -0.001, 0.000] mm"),
        (Hand((1, 2, 3, 0)), "[1, 2, 3, 0] as on the wire"),
        (Pallet(1, 2, 3, 4), "1 x 2 x 3 from point 4"),
    ],
)
def test_values_are_told_in_one_line(value: Any, text: str) -> None:
    assert shown(value) == text
