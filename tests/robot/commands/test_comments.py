"""Point comments: 16 characters beside a point."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Point
from robot_master import NORMAL_END, abnormal_end
from stored_data import ready, text_words

WRITE, READ = 0x0104, 0x0105
#: "WAIT ORG" as printed.
WAIT_ORG = (0x4157, 0x5449, 0x4F20, 0x4752)


@pytest.mark.parametrize("filler", ["\0", " "])
def test_the_defined_comment_is_read_back(filler: str) -> None:
    """Zeros behind the text, as printed, and spaces mean the same.

    Rule: comment-end.
    Source: remote command guide 4.3.2
    """
    master = ready()
    words = (*WAIT_ORG, *text_words("", filler)[4:])
    assert master.execute(WRITE, 0, 100, 0, *words) == NORMAL_END
    assert master.robot.machine.memory.comments == {100: "WAIT ORG"}
    assert master.execute(READ, 0, 100) == (0x0200, 0, 100, 0, *WAIT_ORG) + (0,) * 8


def test_the_answer_may_be_filled_with_spaces() -> None:
    """Rule: comment-end. Source: remote command guide 4.3.2."""
    master = ready(comments={50: "WAIT ORG"}, comment_filler="spaces")
    answer = master.execute(READ, 0, 50)
    assert answer[4:12] == (*WAIT_ORG, 0x2020, 0x2020, 0x2020, 0x2020)
    assert answer[12:] == (0,) * 4


def test_a_comment_has_sixteen_characters() -> None:
    """The second of a word is in its higher byte; spaces at the start and within stay.

    Source: remote command guide 4.3.2
    """
    master = ready()
    words = text_words(" ~!2345678 ABCD~", "\0")
    assert words[0] == 0x7E20
    assert words[7] == 0x7E44
    assert master.execute(WRITE, 0, 29999, 0, *words) == NORMAL_END
    assert master.execute(READ, 0, 29999)[4:] == words + (0,) * 4


def test_a_comment_needs_no_point_and_goes_with_none() -> None:
    """Without a comment there is an empty one.

    Rule: undefined-data.
    Source: remote command guide 4.3.2
    """
    master = ready(points={1: Point()})
    assert master.execute(READ, 0, 1) == (0x0200, 0, 1) + (0,) * 13
    assert master.execute(WRITE, 0, 2, 0, *WAIT_ORG) == NORMAL_END
    assert master.execute(READ, 0, 2)[4:8] == WAIT_ORG
    assert 2 not in master.robot.points


def test_the_reference_to_no_comment_may_be_an_alarm() -> None:
    """Rule: undefined-data. Source: remote command guide 4.3.2."""
    master = ready(undefined_data_alarm="6.5")
    assert master.execute(READ, 0, 1) == abnormal_end("6.5")
    assert master.execute(WRITE, 0, 1) == NORMAL_END
    assert master.execute(READ, 0, 1) == (0x0200, 0, 1) + (0,) * 13
