"""Programs and the sequence program start, stop and end (chapter 5)."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import RobotProgram
from robot_master import powered_up, servos_on


def test_program_reset_and_start_need_auto_mode() -> None:
    """Rule: program-reset, manual-mode. Source: manual chapter 5, 2, SI(15) and SO(10)."""
    master = servos_on()
    master.pulse("SI12")
    master.robot.inject("manual_mode")
    master.run(10)
    assert (master.on("SO10"), master.on("SO13")) == (False, False)
    master.pulse("SI15")
    master.pulse("SI12")
    assert (master.on("SO14"), master.on("SO13")) == (False, False)
    master.robot.inject("auto_mode")
    master.pulse("SI15")
    assert (master.on("SO10"), master.on("SO14")) == (True, True)


def test_an_emergency_stop_stops_the_program() -> None:
    """After the emergency stop, the program runs again only after an alarm reset and servo ON.

    Rule: program-emergency.
    Source: manual chapter 5, 3.3, note
    """
    master = servos_on()
    master.pulse("SI12")
    master.turn_and_wait("SI00", False)
    states = (master.on("SO13"), master.on("SO02"), master.on("SO03"))
    assert states == (False, False, True)
    master.turn_and_wait("SI00", True)
    master.pulse("SI12")
    assert not master.on("SO13")
    master.pulse("SI16")
    master.pulse("SI01")
    master.pulse("SI12")
    assert master.on("SO13")


def test_a_program_that_does_not_loop_ends_after_its_duration() -> None:
    """Time in a stop does not count for the duration. Rule: program-length."""
    program = RobotProgram(duration=500, loop=False)
    master = servos_on(programs=(program,), program_start_delay=0, program_stop_delay=0)
    master.turn_and_wait("SI12", True, 200)
    master.turn_and_wait("SI06", False, 1000)
    master.turn_and_wait("SI12", False, 200)
    master.turn_and_wait("SI06", True, 200)
    master.turn_and_wait("SI12", True, 295)
    assert master.on("SO13")
    master.run(10)
    assert not master.on("SO13")


@pytest.mark.parametrize(
    ("config", "running"),
    [({}, True), ({"program_needs_servo": True}, False)],
)
def test_a_key_decides_whether_a_program_needs_the_servos(
    config: dict[str, Any], running: bool
) -> None:
    """Rule: program-servo."""
    master = powered_up(**config)
    master.pulse("SI12")
    assert master.on("SO13") is running


@pytest.mark.parametrize(("knob", "running"), [(False, True), (True, False)])
def test_a_key_decides_whether_a_running_program_can_be_reset(knob: bool, running: bool) -> None:
    """Rule: program-reset-running."""
    master = powered_up(reset_while_running=knob)
    master.pulse("SI12")
    master.pulse("SI15")
    assert master.on("SO13") is running
    assert master.on("SO14") is not running


def test_the_end_of_the_program_can_be_injected() -> None:
    """Rule: program-length."""
    master = powered_up()
    master.pulse("SI12")
    master.robot.inject("program_end")
    master.run(5)
    assert not master.on("SO13")


def test_the_sequence_program_runs_while_si10_is_on() -> None:
    """Rule: sequence, sequence-program. Source: manual chapter 5, 2, SI(10) and SO(12)."""
    master = powered_up()
    master.turn_and_wait("SI10", True)
    assert master.on("SO12")
    master.turn_and_wait("SI10", False)
    assert not master.on("SO12")
    without = powered_up(sequence_program=False)
    without.turn_and_wait("SI10", True)
    assert not without.on("SO12")
