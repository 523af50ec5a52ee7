"""Controller cycles run on a grid of real time."""

from __future__ import annotations

from rcx_harness.serve.station_process import Pace


def test_the_first_cycle_is_due_at_once_and_is_the_controllers_time_0() -> None:
    pace = Pace(7_000_123, 5000)
    assert pace.wait_us(7_000_123) == 0
    assert pace.take(7_000_123) == 0
    assert pace.wait_us(7_000_123) == 5000


def test_a_late_wake_up_does_not_shift_the_cycles_to_come() -> None:
    pace = Pace(0, 5000)
    pace.take(0)
    assert pace.take(5900) == 5000
    assert pace.wait_us(5900) == 4100
    assert pace.take(10_050) == 10_000


def test_missed_cycles_are_left_out_and_counted_not_made_up_for() -> None:
    pace = Pace(0, 5000)
    pace.take(0)
    assert pace.take(23_400) == 20_000, "time stays a whole number of cycles"
    assert (pace.cycles, pace.skipped) == (2, 3)
    assert pace.wait_us(23_400) == 1600, "cycles come in a burst"


def test_a_long_run_has_no_drift() -> None:
    pace = Pace(0, 5000)
    now_us = 0
    for _ in range(10_000):
        now_us += pace.wait_us(now_us)
        last = pace.take(now_us)
        now_us += 170  # time for the work of a cycle and a late wake-up
    assert last == 9999 * 5000
    assert (pace.cycles, pace.skipped) == (10_000, 0)
