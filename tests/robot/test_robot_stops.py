"""Stops may come before an answer, repeatedly, and during a start."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from rcx_harness.robot.config import Axis, RobotProgram
from robot_master import Master, powered_up, servos_on


def _history(master: Master) -> list[str]:
    return [alarm.number for alarm in master.robot.alarms.history]


def _si00_off(master: Master) -> None:
    master.turn("SI00", False)


def _si00_on(master: Master) -> None:
    master.turn("SI00", True)


def _press(master: Master) -> None:
    master.robot.inject("emergency_stop")


def _release(master: Master) -> None:
    master.robot.inject("emergency_stop_release")


@pytest.mark.parametrize("first", [(_si00_off, _si00_on), (_press, _release)])
@pytest.mark.parametrize("again", [(_si00_off, _si00_on), (_press, _release)])
@pytest.mark.parametrize("stop_delay", [0, 60])
def test_an_emergency_stop_again_before_its_release_is_answered_is_one(
    stop_delay: int,
    first: tuple[Callable[[Master], None], ...],
    again: tuple[Callable[[Master], None], ...],
) -> None:
    """An emergency stop comes again before its release is answered.

    SO(00) stays ON, and the release time counts from the last release.

    Rule: emergency-stop, emergency-release, answers.
    Source: manual chapter 5, 3.1, shift to emergency stop
    """
    master = Master(emergency_release_delay=200, emergency_stop_delay=stop_delay)
    master.run(300)
    master.turn("SI00", True)
    master.run(300)
    assert not master.on("SO00")
    first[0](master)
    master.run(150)
    first[1](master)
    master.run(150)
    again[0](master)
    for _ in range(30):  # the answer to the first release would come in these cycles
        master.run(5)
        assert master.on("SO00")
    again[1](master)
    for _ in range(39):
        master.run(5)
        assert master.on("SO00")
    master.run(10)
    assert not master.on("SO00")
    assert master.on("SO03")
    master.pulse("SI16")
    assert not master.on("SO03")


def test_both_emergency_stops_must_be_released() -> None:
    """Rule: emergency-release, emergency-terminal.

    Source: manual chapter 5, 2, SI(01): all emergency stop states are cancelled
    """
    master = servos_on()
    _press(master)
    master.turn_and_wait("SI00", False)
    _release(master)
    master.run(50)
    assert master.on("SO00")
    _press(master)
    master.turn_and_wait("SI00", True)
    assert master.on("SO00")
    _release(master)
    master.run(10)
    assert not master.on("SO00")


def test_an_emergency_stop_whose_alarm_was_reset_is_an_alarm_again_when_it_comes_again() -> None:
    """A key allows the alarm reset before the release.

    If the emergency stop then comes again, it is a new alarm.

    Rule: emergency-stop, reset-after-release.
    """
    master = servos_on(reset_in_emergency_stop=True)
    master.turn_and_wait("SI00", False)
    master.pulse("SI16")
    assert not master.on("SO03")
    master.turn_and_wait("SI00", True)
    master.turn_and_wait("SI00", False)
    assert master.on("SO03")
    assert _history(master) == ["12.600", "12.600"]


_STOPS: dict[str, Callable[[Master], None]] = {
    "SI06": lambda master: master.turn("SI06", False),
    "SI00": _si00_off,
    "terminal": _press,
    "link": lambda master: setattr(master, "connected", False),
    "main power": lambda master: master.robot.inject("main_power_off"),
    "alarm": lambda master: master.robot.inject("alarm"),
    "MANUAL": lambda master: master.robot.inject("manual_mode"),
}


@pytest.mark.parametrize("by_command", [False, True])
@pytest.mark.parametrize("stop", _STOPS)
def test_a_stop_takes_back_a_start_that_is_not_answered(stop: str, by_command: bool) -> None:
    """Even a short stop cancels the start. The program does not start by itself after the stop.

    Rule: start-withdrawn, program-stop.
    Source: manual chapter 5, 3.3: Turn OFF to stop the robot program
    """
    master = servos_on(program_start_delay=1000, emergency_stop_delay=5, program_stop_delay=5)
    if by_command:
        assert master.execute(0x0402, 0)[0] == 0x0200
    else:
        master.pulse("SI12")
    _STOPS[stop](master)
    master.run(120)
    _release(master)
    master.connected = True
    master.turn("SI00", True)
    master.run(120)
    master.turn("SI06", True)
    master.robot.inject("main_power_on")
    master.robot.inject("auto_mode")
    master.run(120)
    master.pulse("SI16")
    for _ in range(40):
        master.run(50)
        assert not master.on("SO13")
    assert "12.400" not in _history(master)  # no program ran, and no start was attempted
    master.pulse("SI12")
    master.run(1000)
    assert master.on("SO13")


def test_a_stop_that_an_emergency_stop_overtakes_does_not_stop_the_next_start() -> None:
    """Rule: answers, program-emergency, program-restart. Source: manual chapter 5, 3.3, note."""
    master = servos_on(program_stop_delay=3000)
    master.pulse("SI12")
    master.turn_and_wait("SI06", False)
    master.turn_and_wait("SI00", False)
    assert not master.on("SO13")
    master.turn_and_wait("SI00", True)
    master.turn_and_wait("SI06", True)
    master.pulse("SI16")
    master.pulse("SI01")
    master.pulse("SI12")
    for _ in range(80):
        assert master.on("SO13")
        master.run(50)


@pytest.mark.parametrize("name", ["SI01", "SI12"])
def test_an_alarm_before_the_answer_takes_the_request_back(name: str) -> None:
    """Any alarm before the answer cancels the request, even an alarm that leaves the servos on.

    Rule: alarm-stops, answers.
    """
    delays = {"servo_on_delay": 500, "program_start_delay": 500}
    master = powered_up(alarm_stops_servo=False, **delays)
    master.pulse(name)
    master.robot.inject("alarm")
    master.run(1000)
    assert not master.on("SO02" if name == "SI01" else "SO13")


@pytest.mark.parametrize("name", ["SI14", "SI17", "SI12"])
@pytest.mark.parametrize("stopped", [True, False])
def test_a_start_in_the_stop_status_is_alarm_12_400(name: str, stopped: bool) -> None:
    """Rule: stop-alarm, minor-alarms.

    Source: manual chapter 4, 4, 12.400 a: program execution or axis movement was attempted
    """
    master = servos_on()
    if stopped:
        master.turn_and_wait("SI06", False)
    master.pulse(name)
    assert _history(master) == (["12.400"] if stopped else [])
    assert not master.on("SO03")
    master.run(1500)
    if stopped:
        assert master.robot.positions == [0, 0, 0, 0]
        assert not master.on("SO13")


def test_a_return_to_origin_without_an_axis_to_move_is_no_attempt() -> None:
    """Rule: origin-model, stop-alarm."""
    master = servos_on(axes=(Axis(origin_method="mark"),))
    master.turn_and_wait("SI06", False)
    master.pulse("SI14")
    assert _history(master) == []


@pytest.mark.parametrize("command", [0, 0x0032])
def test_a_stopped_return_to_origin_is_one_alarm(command: int) -> None:
    """A stopped return-to-origin, by an input or by a command, causes one alarm.

    Rule: stop-alarm, origin-command-needs.
    Source: manual chapter 4, 4, 12.400 b
    """
    master = servos_on(origin_time=2000)
    if command:
        master.send(command)
        master.run(50)
    else:
        master.pulse("SI17")
    master.turn_and_wait("SI06", False)
    assert _history(master) == ["12.400"]
    assert not master.on("SO11")
    if command:
        assert master.words[:3] == (0x4000, 12, 400)


@pytest.mark.parametrize(("knob", "runs"), [(False, True), (True, False)])
def test_a_key_decides_whether_an_emergency_stop_ends_the_sequence_program(
    knob: bool, runs: bool
) -> None:
    """A stop never ends the sequence program. A key decides whether an emergency stop ends it.

    Rule: sequence-program.
    """
    master = servos_on(emergency_stops_sequence=knob)
    master.turn_and_wait("SI10", True)
    assert master.on("SO12")
    master.turn_and_wait("SI06", False)
    assert master.on("SO12")
    master.turn_and_wait("SI00", False)
    assert master.on("SO12") is runs
    master.turn_and_wait("SI00", True)
    assert master.on("SO12")


@pytest.mark.parametrize(
    ("auto", "starts_in_manual", "stops_in_manual"),
    [(True, False, True), (False, True, True), (False, True, False)],
)
def test_a_key_decides_whether_programs_need_auto_mode(
    auto: bool, starts_in_manual: bool, stops_in_manual: bool
) -> None:
    """A key decides whether a start needs AUTO mode, for SI(12) and for the command.

    The program reset always needs AUTO mode.

    Rule: program-mode, manual-mode, program-reset.
    Source: manual chapter 5, 2, SI(15)
    """
    config = {"start_needs_auto": auto, "manual_mode_stops_program": stops_in_manual}
    master = servos_on(manual_mode_alarm="0.20", **config)
    master.pulse("SI12")
    assert master.on("SO13")
    master.robot.inject("manual_mode")
    master.run(20)
    assert master.on("SO13") is not stops_in_manual
    if stops_in_manual:
        answer = master.execute(0x0402, 0)[:3]
        assert answer == ((0x0200, 0, 0) if starts_in_manual else (0x4000, 0, 20))
        assert master.on("SO13") is starts_in_manual
        master.drop("SI06")
        master.pulse("SI12")
        assert master.on("SO13") is starts_in_manual
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    assert not master.on("SO14")
    master.robot.inject("auto_mode")
    master.pulse("SI15")
    assert master.on("SO14")


@pytest.mark.parametrize(("anew", "line"), [(False, 3), (True, 1)])
def test_started_after_a_stop_a_program_goes_on_or_begins_anew(anew: bool, line: int) -> None:
    """Rule: program-goes-on, program-restart.

    Source: manual chapter 5, 3.3, program execution after stopping program with stop input
    """
    steps = ("WAIT SI(20)=1", "SO(20)=1", "WAIT SI(21)=1")
    master = servos_on(restart_begins_anew=anew, programs=(RobotProgram(steps=steps, loop=False),))
    master.pulse("SI12")
    master.si[34] = 1
    master.run(20)
    master.si[34] = 0
    master.drop("SI06")
    master.pulse("SI12")
    assert master.on("SO13")
    assert master.robot.program.main.line == line


@pytest.mark.parametrize(("knob", "runs"), [(False, True), (True, False)])
def test_a_start_before_the_answer_to_a_reset_prevents_it(knob: bool, runs: bool) -> None:
    """Rule: program-reset-running."""
    master = servos_on(program_reset_delay=500, program_start_delay=5, reset_while_running=knob)
    master.pulse("SI15", 120)
    master.pulse("SI12", 120)
    assert master.on("SO13")
    master.run(500)
    assert master.on("SO13") is runs
    assert master.on("SO14") is not runs


@pytest.mark.parametrize("stop", ["SI06", "SI00", "terminal"])
def test_a_movement_by_command_that_is_stopped_is_one_entry_in_the_history(stop: str) -> None:
    """A command that is ended by an active alarm does not record this alarm again.

    Rule: history, command-alarms, stop-in-motion.
    Source: remote command guide chapter 1, 1.2, code 0x4000
    """
    master = servos_on()
    master.send(0x0001, 0x0004, 0, 10, 19)
    master.run(50)
    _STOPS[stop](master)
    number = "12.400" if stop == "SI06" else "12.600"
    assert master.finish()[:3] == (0x4000, 12, int(number[3:]))
    assert _history(master) == [number]
