"""Stored data are read from a virtual controller, saved in a file, and written back."""

from __future__ import annotations

import csv
import itertools
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from probed_robot import StationLine
from rcx_harness.look.points.carry import Carrier, RefusedError
from rcx_harness.look.points.stored import (
    Key,
    Stored,
    as_csv,
    as_toml,
    from_toml,
    shown,
    without_foreign,
)
from rcx_harness.look.probe.line import LostError
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import Axis
from rcx_harness.robot.stored import Hand, Pallet, Point
from rcx_harness.spec.wire import CYCLE_US
from structured_text.errors import InputError

#: Data with the largest numbers, both units, all flags, and texts that need quotes in a file.
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
def test_only_stored_data_are_read(filler: str) -> None:
    """Source: guide 4.3.1 to 4.3.5."""
    found = _read(**_CONFIG, comment_filler=filler)
    assert found.of("points") == {(0, n): point for n, point in _CONFIG["points"].items()}
    assert found.of("comments") == {(0, n): text for n, text in _CONFIG["comments"].items()}
    assert found.of("pallets") == {(0, 2): Pallet(10, 15, 1, 100)}
    assert found.of("shifts") == {(0, 0): (0,) * 4, (0, 1): (1, -2, 3, -4), (0, 2): (0,) * 4}
    hands = found.of("hands")
    assert len(hands) == 8
    assert (hands[1, 2], hands[2, 3]) == (Hand((100, -1, 2, 0)), Hand((7, 8, 9, 1)))


def test_a_file_returns_the_data_that_were_written_to_it(tmp_path: Path) -> None:
    """Data that are read back from a file are equal to the written data, to the last digit.

    The file is a robot file.
    """
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


@pytest.mark.parametrize("filler", ["zeros", "spaces"])
@pytest.mark.parametrize(
    ("text", "found"), [(" A", " A"), ("A\t", "A\t"), ("A\0B", "A\0B"), ("", None)]
)
def test_only_the_filler_after_a_comment_is_removed(
    text: str, found: str | None, filler: str
) -> None:
    """Source: guide 4.3.2."""
    line = StationLine(RobotConfig(comment_filler=filler))
    line.controller.machine.memory.comments[1] = text
    key = ("comments", 0, 1)
    assert Carrier(line).read([key], _quiet).values.get(key) == found


def test_a_comment_with_a_byte_beyond_ascii_is_read_as_it_is() -> None:
    """A comment with a byte above 16#7F is read without a change.

    A virtual controller has no such comment, so the test sets bit 7 of the first letter.
    """
    line, key = StationLine(RobotConfig(comments={1: "1 A"})), ("comments", 0, 1)
    read = line.read

    def katakana() -> bytes:
        area = bytearray(read())
        area[8] |= 0x80 * (area[1] == 2)
        return bytes(area)

    line.read = katakana  # type: ignore[method-assign]
    found = Carrier(line).read([key], _quiet)
    assert found.values == {key: "\xb1 A"}
    assert without_foreign(found) == (Stored(), [1])


def test_points_of_one_controller_are_stored_by_another() -> None:
    """Points that are read from one controller can be written to another controller.

    The data of a definition are stored, and an old comment is removed.

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


def test_a_refused_definition_ends_the_transfer() -> None:
    """A refused definition ends the transfer. The pendant has the control authority here.

    Source: guide 3, remark.
    """
    line = StationLine(RobotConfig(pendant_authority=True))
    with pytest.raises(RefusedError, match=r"^writing pallet 2 ended in the alarm 12\.76$"):
        Carrier(line).write(Stored({("pallets", 0, 2): Pallet(1, 1, 1, 0)}), [("pallets", 0, 2)], _quiet)  # noqa: E501  # fmt: skip


@pytest.mark.parametrize(
    ("verb", "text"),
    [
        ("reading", "reading shift 1: no end within 4 s, the status was 16#0100"),
        (
            "writing",
            "writing shift 1: no end within 4 s, the status was 16#0100; "
            "it may be done, compare shows it",
        ),
    ],
)
def test_a_command_is_held_until_its_end_or_the_time_out(verb: str, text: str) -> None:
    """Source: guide 1.1, note."""
    line = StationLine(RobotConfig(command_delay=10_000.0))
    carrier = Carrier(line, timeout_us=4_000_000)
    stored = Stored({("shifts", 0, 1): (1, 2, 3, 4)})
    does = carrier.read if verb == "reading" else partial(carrier.write, stored)
    with pytest.raises(RefusedError) as error:
        does([("shifts", 0, 1)], _quiet)
    assert str(error.value) == text
    assert not any(line.read_inputs())
    assert line.now_us > 4_000_000


def test_the_transfer_waits_for_a_slow_controller() -> None:
    """Source: guide 1.1, note."""
    points = {n: Point((n, 0, 0, 0, 0, 0)) for n in (1, 2)}
    for slow in ("command_delay", "command_accept_delay", "status_reset_delay"):
        config: dict[str, Any] = {"points": points, slow: 3_500.0}
        line = StationLine(RobotConfig(**config))
        keys: list[Key] = [("points", 0, n) for n in (1, 2)]
        assert Carrier(line).read(keys, _quiet).of("points") == {(0, n): points[n] for n in (1, 2)}


def test_an_old_status_is_never_used_as_a_new_answer() -> None:
    """If the status reset takes longer than the longest wait, the old status is not used.

    Nothing more is sent.

    Source: guide 1.2, a command can be run in the ready status only.
    """
    line = StationLine(RobotConfig(status_reset_delay=3_500.0))
    carrier = Carrier(line, timeout_us=3_000_000)
    text = r"^reading point 19: the status is 16#0200 after the status reset, 3 s long$"
    with pytest.raises(RefusedError, match=text):
        carrier.read([("points", 0, 19), ("points", 0, 50)], _quiet)
    text = r"^writing point 19: the status is 16#0200 without a command, 3 s long"
    line.read = lambda: b"\x00\x02" + bytes(46)  # type: ignore[method-assign]
    with pytest.raises(RefusedError, match=text):
        carrier.write(Stored({("points", 0, 19): Point()}), [("points", 0, 19)], _quiet)


@pytest.mark.parametrize(
    ("key", "byte", "text"),
    [
        (("points", 0, 19), 4, "reading point 19: it was answered with point 18"),
        (("comments", 0, 19), 4, "reading comment 19: it was answered with point 18"),
        (("shifts", 0, 3), 4, "reading shift 3: it was answered with shift 2"),
        (("pallets", 0, 3), 4, "reading pallet 3: it was answered with pallet 2"),
        (("hands", 1, 3), 4, "reading hand 3: it was answered with hand 2"),
        (("hands", 2, 3), 6, "reading hand 3: it was answered with robot 3"),
    ],
)
def test_the_answer_of_another_number_is_refused(key: Key, byte: int, text: str) -> None:
    """Source: guide 4.3.1 to 4.3.5, m+4 of the references."""
    pallets = {3: Pallet(1, 1, 1, 0)}
    line = StationLine(RobotConfig(axes=(Axis(), Axis(robot=2)), pallets=pallets))
    read = line.read

    def other() -> bytes:
        area = bytearray(read())
        if area[1] == 2:
            area[byte] ^= 1
        return bytes(area)

    line.read = other  # type: ignore[method-assign]
    with pytest.raises(RefusedError) as error:
        Carrier(line).read([key], _quiet)
    assert str(error.value) == text


@pytest.mark.parametrize("packet_us", [5_000, 10_000, 100_000])
def test_the_data_of_a_command_are_there_before_its_code(packet_us: int) -> None:
    """The data of a command are sent in an earlier packet than its code, for two cycles.

    Source: guide 2, steps 1 and 2; guide 1.1, command data are entered before.
    """
    line = StationLine(RobotConfig())
    line.packet_us = packet_us
    written: list[tuple[int, int, bytes]] = []
    write = line.write

    def noted(area: bytes, *, run: bool = True) -> None:
        written.append((line.now_us, line.sent, area))
        write(area, run=run)

    line.write = noted  # type: ignore[method-assign]
    carrier = Carrier(line)
    carrier.read([("points", 0, n) for n in (19, 50)], _quiet)
    carrier.write(Stored({("points", 0, 1): Point()}), [("points", 0, 1)], _quiet)
    codes = 0
    for (before_us, before, data), (now_us, now, area) in itertools.pairwise(written):
        if any(area[:2]):
            codes += 1
            assert not any(data[:2])
            assert data[2:] == area[2:]
            assert now - before >= 2
            assert now_us - before_us >= 2 * CYCLE_US
    assert codes == 3


def test_packets_that_stay_away_are_a_lost_connection() -> None:
    line = StationLine(RobotConfig())
    line.packet_us = 2**40
    with pytest.raises(LostError, match="no packets are sent any more"):
        Carrier(line).read([("points", 0, 19)], _quiet)


def test_a_controller_that_is_busy_is_left_alone() -> None:
    line = StationLine(RobotConfig())
    line.read = lambda: b"\x00\x01" + bytes(46)  # type: ignore[method-assign]
    with pytest.raises(RefusedError, match="remote status 16#0100 without a command"):
        Carrier(line)


def test_a_lost_connection_is_reported() -> None:
    line = StationLine(RobotConfig())
    carrier = Carrier(line)
    line.lost_after_us = line.now_us
    with pytest.raises(LostError):
        carrier.read([("points", 0, 50)], _quiet)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("size = 48\n", "contains none of the tables points, comments, shifts, hands, pallets"),
        ("[points.30000]\nmm = [1]\n", "'points.30000' is not a point"),
        ("[points.1]\nmm = [1, 2, 3, 4, 5, 6, 7]\n", "'points.1' needs at most 6 numbers"),
        ("[comments]\n1 = 'more than sixteen letters'\n", "up to 16 characters"),
        ("[[[", "TOML"),
    ],
)
def test_a_file_without_valid_tables_gets_one_message(
    tmp_path: Path, text: str, message: str
) -> None:
    file = tmp_path / "a.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as error:
        from_toml(file)
    assert message in str(error.value)
    assert str(file) in str(error.value)


def test_only_the_tables_of_the_file_are_written(tmp_path: Path) -> None:
    """Only the tables of the file are written. Points of the manual's examples are not added."""
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
def test_values_are_shown_in_one_line(value: Any, text: str) -> None:
    assert shown(value) == text
