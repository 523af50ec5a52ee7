"""A log that runs for days stays small, even with a noisy master."""

from __future__ import annotations

import pytest

from rcx_harness.bridge.core import State
from rcx_harness.bridge.run import news_lines
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.serve.lines import Lines
from served import ServedHost
from structured_text.output.throttle import Throttle

SECOND_US = 1_000_000


def test_a_few_lines_pass_as_they_come() -> None:
    throttle = Throttle()
    assert throttle.let_pass("a", ["one", "one", "two"], 0) == ["one", "one", "two"]
    assert throttle.let_pass("a", [], 1) == []


def test_of_a_flood_thirty_pass_and_then_one_in_five_seconds_with_the_count() -> None:
    throttle = Throttle()
    assert throttle.let_pass("a", ["x"] * 100, 0) == ["x"] * 30
    assert throttle.let_pass("a", ["x"] * 10, 5 * SECOND_US - 1) == []
    assert throttle.let_pass("a", [], 5 * SECOND_US) == ["x (repeated 80 times)"]
    assert throttle.let_pass("a", ["y"], 9 * SECOND_US) == []
    assert throttle.let_pass("a", [], 10 * SECOND_US) == ["y"]
    assert throttle.let_pass("a", ["p", "q"], 14 * SECOND_US) == []
    (line,) = throttle.let_pass("a", [], 15 * SECOND_US)
    assert line == "q (the latest of 2, the others are not shown)"


def test_noise_of_one_kind_hides_nothing_of_another() -> None:
    throttle = Throttle()
    throttle.let_pass("noise", ["x"] * 100, 0)
    assert throttle.let_pass("alarm", ["12.600"], 0) == ["12.600"]


def test_after_a_quiet_time_lines_pass_again() -> None:
    throttle = Throttle()
    throttle.let_pass("a", ["x"] * 30, 0)
    assert throttle.let_pass("a", ["z"] * 40, 3600 * SECOND_US) == ["z"] * 30


@pytest.mark.exhaustive
def test_a_noisy_master_leaves_little_in_the_log() -> None:
    """A master that reconnects and breaks rules for ten minutes leaves less than 1000 lines."""
    served = ServedHost()
    lines = Lines([served])
    written = lines.new()
    for turn in range(2400):  # a check every 250 ms
        served.network.become(OwnerState.IDLE if turn % 2 else OwnerState.RUN)
        served.network.send(bytes([0, 0]) + bytes(30) + bytes([0x41 ^ turn % 4, 0]) + bytes(14))
        served.run(5)
        served.status = type(served.status)(**{**vars(served.status), "t_us": turn * 250_000})
        written += lines.new()
    kinds = 6
    assert 60 < len(written) <= kinds * (30 + 600 // 5) + 10
    assert any(" times)" in line or "the latest of " in line for line in written)


def test_the_bridge_counts_a_robot_that_comes_and_goes() -> None:
    throttle = Throttle()
    news = [(100.0 + turn / 100, State.NO_ROBOT, "lost") for turn in range(1000)]
    lines = news_lines(news, 100.0, 110.1, throttle, quiet=True)
    assert len(lines) == 30 + 2
    assert lines[0] == f"     0.000 s  {State.NO_ROBOT.value}: lost"
    assert lines[-1].endswith(" times)")
