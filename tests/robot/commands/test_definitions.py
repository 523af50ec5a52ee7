"""Commands define and read point comments, shift data and hand data."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis, Point
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, ready, text_words

WRITE_COMMENT, READ_COMMENT = 0x0104, 0x0105
WRITE_SHIFT, READ_SHIFT, WRITE_HAND, READ_HAND = 0x010C, 0x010D, 0x0110, 0x0111
TWO_ROBOTS = (Axis(), Axis(robot=2))
#: Words of the comment "WAIT ORG" as the guide prints them.
WAIT_ORG = (0x4157, 0x5449, 0x4F20, 0x4752)


@pytest.mark.parametrize("filler", ["\0", " "])
def test_the_defined_comment_is_read_back(filler: str) -> None:
    """A comment may be filled with zeros, as printed, or with spaces.

    Rule: comment-end.
    Source: remote command guide 4.3.2
    """
    master = ready()
    words = (*WAIT_ORG, *text_words("", filler)[4:])
    assert master.execute(WRITE_COMMENT, 0, 100, 0, *words) == NORMAL_END
    assert master.robot.machine.memory.comments == {100: "WAIT ORG"}
    assert master.execute(READ_COMMENT, 0, 100) == (0x0200, 0, 100, 0, *WAIT_ORG) + (0,) * 8


def test_a_key_fills_a_short_comment_with_spaces() -> None:
    """Rule: comment-end. Source: remote command guide 4.3.2."""
    master = ready(comments={50: "WAIT ORG"}, comment_filler="spaces")
    answer = master.execute(READ_COMMENT, 0, 50)
    assert answer[4:] == (*WAIT_ORG, 0x2020, 0x2020, 0x2020, 0x2020, 0, 0, 0, 0)


def test_a_comment_has_sixteen_characters() -> None:
    """The second character of a word is in its higher byte.

    Spaces at the start and within the text stay.

    Source: remote command guide 4.3.2
    """
    master = ready()
    words = text_words(" ~!2345678 ABCD~", "\0")
    assert (words[0], words[7]) == (0x7E20, 0x7E44)
    assert master.execute(WRITE_COMMENT, 0, 29999, 0, *words) == NORMAL_END
    assert master.execute(READ_COMMENT, 0, 29999)[4:] == words + (0,) * 4


def test_points_and_comments_are_defined_independently() -> None:
    """Rule: undefined-data. Source: remote command guide 4.3.2."""
    master = ready(points={1: Point()})
    assert master.execute(READ_COMMENT, 0, 1) == (0x0200, 0, 1) + (0,) * 13
    assert master.execute(WRITE_COMMENT, 0, 2, 0, *WAIT_ORG) == NORMAL_END
    assert master.execute(READ_COMMENT, 0, 2)[4:8] == WAIT_ORG
    assert 2 not in master.robot.points


def test_shifts_0_and_39_hold_32_bits_on_four_axes() -> None:
    """Source: remote command guide 4.3.4."""
    master = ready()
    every = {number: long_words(-(2**31), 2**31 - 1, number, -number) for number in (0, 39)}
    for number, extremes in every.items():
        assert master.execute(WRITE_SHIFT, 0, number, 0, *extremes) == NORMAL_END
    for number, extremes in every.items():
        assert master.execute(READ_SHIFT, 0, number)[4:12] == extremes


def test_each_robot_has_its_own_hands() -> None:
    """Rule: hand-robot. Source: remote command guide 4.3.5."""
    master = ready(axes=TWO_ROBOTS)
    first, second = long_words(1, 2, 3, 0), long_words(4, 5, 6, 1)
    assert master.execute(0x1000 | WRITE_HAND, 0, 31, 0, *first) == NORMAL_END
    assert master.execute(0x2000 | WRITE_HAND, 0, 31, 0, *second) == NORMAL_END
    assert master.execute(0x1000 | READ_HAND, 0, 31)[2:12] == (31, 1, *first)
    assert master.execute(0x2000 | READ_HAND, 0, 31)[2:12] == (31, 2, *second)


@pytest.mark.parametrize("scara", [(), (1,)])
@pytest.mark.parametrize("on_r_axis", [0, 1])
def test_hand_data_are_read_back_unchanged(scara: tuple[int, ...], on_r_axis: int) -> None:
    """Rule: hand-data. Source: remote command guide 4.3.5."""
    master = ready(scara_robots=scara)
    data = long_words(-(2**31), 2**31 - 1, -1, on_r_axis)
    assert master.execute(WRITE_HAND, 0, 0, 0, *data) == NORMAL_END
    assert master.execute(READ_HAND, 0, 0)[4:12] == data
    assert master.robot.machine.memory.hand(1, 0).on_r_axis is bool(on_r_axis)


@pytest.mark.parametrize(
    ("write", "read", "zero"),
    [
        pytest.param(WRITE_COMMENT, READ_COMMENT, None, id="comment"),
        pytest.param(WRITE_SHIFT, READ_SHIFT, 0, id="shift"),
        pytest.param(WRITE_HAND, READ_HAND, 0, id="hand"),
    ],
)
def test_reading_undefined_data_gives_0_or_an_alarm(
    write: int, read: int, zero: int | None
) -> None:
    """Shift 0 and hand 0 never cause an alarm. The command that reads a hand names its robot.

    Rule: undefined-data.
    Source: remote command guide 4.3.2, 4.3.4, 4.3.5
    """
    robot = int(read == READ_HAND)
    assert ready().execute(read, 0, 7) == (0x0200, 0, 7, robot) + (0,) * 12
    master = ready(undefined_data_alarm="6.5")
    assert master.execute(read, 0, 7) == abnormal_end("6.5")
    if zero is not None:
        assert master.execute(read, 0, zero) == (0x0200, 0, 0, robot) + (0,) * 12
    assert master.execute(write, 0, 7) == NORMAL_END
    assert master.execute(read, 0, 7) == (0x0200, 0, 7, robot) + (0,) * 12
