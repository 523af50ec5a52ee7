"""Date and time of the controller can be set and read, and the clock runs on."""

from __future__ import annotations

import pytest

from robot_master import NORMAL_END, Master, abnormal_end, powered_up

READ_DATE, READ_TIME, SET_DATE, SET_TIME = 0x511, 0x512, 0x602, 0x603
#: Milliseconds between two commands.
DAY_MS = 24 * 3600 * 1000


def _read(master: Master, code: int) -> tuple[int, ...]:
    status, unused, *words = master.execute(code)
    assert (status, unused) == (0x0200, 0)
    assert not any(words[3:])
    return tuple(words[:3])


def _pass(master: Master, ms: int) -> None:
    """Advance virtual time at once, without running the cycles in between."""
    master.now_us += ms * 1000
    master.run(5)


def test_the_examples_set_the_date_and_the_time() -> None:
    """The commands set 2014-02-02 and 08:45:00.

    Setting the date does not change the time, and setting the time does not change the date.

    Rule: clock-set, clock.
    Source: remote command guide 4.8.1, 4.8.2
    """
    master = powered_up()
    assert master.execute(0x0602, 0, 0x000E, 2, 2) == NORMAL_END
    assert _read(master, READ_TIME) == (10, 59, 59)
    assert master.execute(0x0603, 0, 8, 0x002D, 0) == NORMAL_END
    assert _read(master, READ_TIME) == (8, 45, 0)
    assert _read(master, READ_DATE) == (14, 2, 2)


def test_the_clock_runs_from_the_second_that_was_set() -> None:
    """Rule: clock."""
    master = powered_up()
    master.send(SET_TIME, 0, 23, 59, 58)
    assert master.finish() == NORMAL_END
    set_us = master.now_us
    master.send()
    master.run(50)
    _pass(master, 960 - (master.now_us - set_us) // 1000)
    assert _read(master, READ_TIME) == (23, 59, 58)
    assert _read(master, READ_TIME) == (23, 59, 59)
    _pass(master, 1000)
    assert (_read(master, READ_DATE), _read(master, READ_TIME)) == ((14, 1, 2), (0, 0, 0))


def test_the_clock_goes_on_without_power() -> None:
    """Rule: clock."""
    master = powered_up(clock="2023-12-31 12:00:00")
    master.robot.inject("power_off")
    _pass(master, DAY_MS)
    master.robot.inject("power_on")
    master.run(500)
    assert _read(master, READ_DATE) == (24, 1, 1)
    assert _read(master, READ_TIME) == (12, 0, 1)


def test_months_have_their_length_and_the_year_99_is_followed_by_0() -> None:
    """Rule: clock."""
    for start, after in (
        ("2024-02-28", (24, 2, 29)),
        ("2023-02-28", (23, 3, 1)),
        ("2099-12-31", (0, 1, 1)),
    ):
        master = powered_up(clock=f"{start} 00:00:00")
        _pass(master, DAY_MS)
        assert _read(master, READ_DATE) == after


@pytest.mark.parametrize("date", [(24, 2, 29), (0, 1, 1), (99, 12, 31), (25, 4, 30)])
def test_dates_of_2000_to_2099_can_be_set(date: tuple[int, int, int]) -> None:
    """Source: remote command guide 4.8.1."""
    master = powered_up()
    assert master.execute(SET_DATE, 0, *date) == NORMAL_END
    assert _read(master, READ_DATE) == date


@pytest.mark.parametrize("date", [(25, 2, 29), (24, 2, 30), (25, 4, 31)])
def test_a_day_that_does_not_exist_is_refused(date: tuple[int, int, int]) -> None:
    """The command ends in an alarm, and the date does not change. Rule: clock."""
    master = powered_up(impossible_date_alarm="9.1")
    assert master.execute(SET_DATE, 0, *date) == abnormal_end("9.1")
    assert _read(master, READ_DATE) == (14, 1, 1)
