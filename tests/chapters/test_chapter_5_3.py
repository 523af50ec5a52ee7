"""The sentences of chapter 5, 3, about the timing charts of dedicated inputs and outputs.

The tests check the changes of inputs and outputs in the controller, in the order of the charts.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell
from robot_master import Master, powered_up

Start = Callable[..., ChapterCell]

EMERGENCY = "SO00 ON, SO02 OFF, SO03 ON"


def test_the_controller_begins_with_the_servos_off_after_power_on(start: Start) -> None:
    """Source: manual chapter 5, 3.1."""
    cell = start(booted=False).settle()
    assert cell.is_on("SO01", "SO02", "SO04") == (True, False, True)


# The caution


def test_between_two_changes_of_dedicated_inputs_there_are_100_ms_or_more(start: Start) -> None:
    """Any two changes that the blocks make reach the controller 100 ms or more apart.

    Source: manual chapter 5, 3.1, caution.
    """
    cell = start().program()
    assert cell.execute("ProgramStop") == 0
    assert cell.execute("ProgramContinue") == 0
    cell.from_now()
    before, last, gaps = bytes(2), None, []
    for one in cell.cell.trace.cycles():
        if one.rcx_si and one.rcx_si[32:34] != before:
            fallen = before[0] & ~one.rcx_si[32] & 0x41  # a stop input may turn OFF at once
            if last is not None and not fallen:
                gaps.append(one.t_us - last)
            before, last = one.rcx_si[32:34], one.t_us
    assert len(gaps) == 10  # SI06 ON; SI01, SI15, SI12 ON and OFF; SI06 ON; SI12 ON and OFF
    assert min(gaps) >= 100_000


@pytest.mark.parametrize("ms", [5, 50, 95])
def test_an_interval_that_is_too_short_is_not_recognised(ms: int) -> None:
    """Source: manual chapter 5, 3.1, caution."""
    master = powered_up()
    master.turn_and_wait("SI16", True, ms)
    master.turn_and_wait("SI01", True, 500)
    assert not master.on("SO02")
    assert [text.split(":")[0] for text in master.texts()] == ["interval"]


def test_the_interval_holds_between_changes_of_the_same_dedicated_input() -> None:
    """SI(06) turns OFF, and ON again after 90 ms. Source: manual chapter 5, 3.1, caution."""
    master = powered_up()
    master.turn_and_wait("SI06", False, 90)
    master.turn_and_wait("SI06", True, 90)
    assert not master.robot.machine.si06
    assert len(master.texts()) == 1


def test_the_interval_holds_between_changes_of_different_dedicated_inputs() -> None:
    """Two inputs in the same exchange are also too close.

    Source: manual chapter 5, 3.1, caution
    """
    master = powered_up()
    master.turn("SI01", True)
    master.turn_and_wait("SI16", True, 300)
    assert not master.on("SO02")
    assert len(master.texts()) == 1


def test_the_interval_holds_even_if_the_controller_answers_earlier(start: Start) -> None:
    """Although SO(02) is ON after 5 ms, SI(01) stays ON for 100 ms or more.

    Source: manual chapter 5, 3.1, caution
    """
    cell = start(servo_on_delay=5).servo_on()
    cell.run("300ms")
    on = [one.t_us for one in cell.cell.trace.cycles() if one.rcx_si and one.rcx_si[32] & 0x02]
    assert on[-1] + 5000 - on[0] >= 100_000


# 3.1 Servo ON and emergency stop


def test_initial_servo_on_after_power_on(start: Start) -> None:
    """SI(01) turns ON, then SO(02) turns ON, and only then SI(01) turns OFF.

    Source: manual chapter 5, 3.1, initial servo ON process
    """
    cell = start().settle()
    assert cell.steps_of("ServoOn") == ["SI01 ON", "SO02 ON", "SI01 OFF"]


def test_servo_on_is_not_answered_in_the_emergency_stop_state(start: Start) -> None:
    """In the emergency stop state, the block rejects servo ON; the controller ignores SI(01).

    Source: manual chapter 5, 3.1, initial servo ON process
    """
    cell = start()
    cell["CellSafe"] = False
    cell.run("500ms")
    assert cell.execute("ServoOn") == 0x8003
    master = Master()
    master.run(300)
    master.pulse("SI01")
    assert not master.on("SO02")


def test_servo_on_input_goes_off_after_servo_on_status_is_confirmed(start: Start) -> None:
    """Without the answer, SI(01) stays ON.

    Source: manual chapter 5, 3.1, initial servo ON process
    """
    cell = start(servo_on_delay=1000).settle()
    since = cell.from_now()
    cell["ServoOn.Execute"] = True
    cell.run("900ms")
    assert cell.steps(since) == ["SI01 ON"]
    cell.run("600ms")
    assert cell.steps(since) == ["SI01 ON", "SO02 ON", "SI01 OFF"]


def test_shift_to_emergency_stop(start: Start) -> None:
    """SI(00) turns OFF, then SO(00) and SO(03) turn ON and SO(02) turns OFF.

    Source: manual chapter 5, 3.1, shift to emergency stop
    """
    cell = start().servo_on()
    assert cell.steps_of("EmergencyStop") == ["SI00 OFF", EMERGENCY]


def test_servo_on_from_the_emergency_stop_state(start: Start) -> None:
    """The chart has eight steps. Each input is withdrawn after its answer.

    Source: manual chapter 5, 3.1, servo ON process from emergency stop status
    """
    cell = start().servo_on()
    assert cell.execute("EmergencyStop") == 0
    assert cell.steps_of("FromEmergency") == [
        "SI00 ON",
        "SO00 OFF",
        "SI16 ON",
        "SO03 OFF",
        "SI16 OFF",
        "SI01 ON",
        "SO02 ON",
        "SI01 OFF",
    ]


@pytest.mark.parametrize(
    ("delay", "last"), [("alarm_reset_delay", "SI16 ON"), ("servo_on_delay", "SI01 ON")]
)
def test_from_the_emergency_stop_state_each_input_goes_off_after_its_output_is_confirmed(
    start: Start, delay: str, last: str
) -> None:
    """SI(16) stays ON until SO(03) is OFF, and SI(01) until SO(02) is ON.

    Source: manual chapter 5, 3.1, servo ON process from emergency stop status
    """
    cell = start().servo_on()
    assert cell.execute("EmergencyStop") == 0
    cell.robot.hold("SO03" if delay == "alarm_reset_delay" else "SO02")
    since = cell.from_now()
    cell["FromEmergency.Execute"] = True
    cell.run("2s")
    assert cell.steps(since)[-1] == last
    cell.robot.release("SO03" if delay == "alarm_reset_delay" else "SO02")
    cell.wait("SO02")
    cell.from_now()
    assert cell.steps(since)[-1] == "SI01 OFF"


# 3.2 AUTO mode changeover, program reset and program execution


def test_auto_mode_needs_the_auto_input_on_and_the_manual_lock_off(start: Start) -> None:
    """SO(10) turns ON only if the AUTO input is ON and the manual lock is OFF.

    Source: manual chapter 5, 3.2, AUTO mode changeover process
    """
    cell = start(auto_mode=False).settle()
    cell["AutoMode.Enable"] = True
    cell.cell.inject("auto_input_on")
    cell.run("200ms")
    assert not cell.on("SO10")
    assert cell["AutoMode.Busy"] is True
    cell.cell.inject("manual_lock_off")
    cell.wait("SO10")
    cell.run("20ms")
    assert cell["AutoMode.Valid"] is True


def test_after_the_changeover_the_programming_box_has_no_authority(start: Start) -> None:
    """While the programming box has authority, servo ON fails although SO(10) is ON.

    Source: manual chapter 5, 3.2, AUTO mode changeover process
    """
    cell = start(pendant_authority=True).settle()
    cell["ServoOn.Timeout"] = "T#1s"
    assert cell.on("SO10")
    assert cell.execute("ServoOn") == 0x8010
    cell.cell.inject("pendant_off")
    assert cell.execute("ServoOn") == 0


def test_program_reset(start: Start) -> None:
    """SI(15) turns ON, SO(14) turns ON, SI(15) turns OFF.

    Source: manual chapter 5, 3.2, program reset process.
    """
    cell = start().servo_on()
    assert cell.steps_of("ProgramReset") == ["SI15 ON", "SO14 ON", "SI15 OFF"]


def test_program_reset_input_goes_off_after_the_reset_status_is_confirmed(start: Start) -> None:
    """Source: manual chapter 5, 3.2, program reset process."""
    cell = start(program_reset_delay=1000).settle()
    since = cell.from_now()
    cell["ProgramReset.Execute"] = True
    cell.run("900ms")
    assert cell.steps(since) == ["SI15 ON"]
    cell.run("600ms")
    assert cell.steps(since)[-1] == "SI15 OFF"


def test_program_execution(start: Start) -> None:
    """SI(12) turns ON, SO(14) turns OFF and SO(13) ON, SI(12) turns OFF.

    Source: manual chapter 5, 3.2, program execution process
    """
    cell = start().servo_on()
    assert cell.execute("ProgramReset") == 0
    assert cell.steps_of("AutoStart") == ["SI12 ON", "SO13 ON, SO14 OFF", "SI12 OFF"]


def test_auto_start_goes_off_after_the_running_output_is_confirmed(start: Start) -> None:
    """Source: manual chapter 5, 3.2 and 3.3, program execution process."""
    cell = start(program_start_delay=1000).servo_on()
    since = cell.from_now()
    cell["AutoStart.Execute"] = True
    cell.run("900ms")
    assert cell.steps(since) == ["SI12 ON"]
    cell.run("600ms")
    assert cell.steps(since)[-1] == "SI12 OFF"


@pytest.mark.parametrize(
    ("emergency", "stop", "error"),
    [(False, True, 0x8003), (True, False, 0x8007), (False, False, 0x8003)],
)
def test_the_program_cannot_be_executed_if_emergency_stop_or_stop_input_is_off(
    start: Start, emergency: bool, stop: bool, error: int
) -> None:
    """If either input is OFF, both the block and the controller refuse to start the program.

    Source: manual chapter 5, 3.2, note
    """
    cell = start()
    cell["CellSafe"], cell["StopReleased"] = emergency, stop
    cell.settle()
    assert cell.execute("AutoStart") == error
    master = Master()
    master.run(300)
    if emergency:
        master.turn_and_wait("SI00", True)
    if stop:
        master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    assert not master.on("SO13")


# 3.3 Stopping operation by a program stop


def test_program_execution_before_a_stop(start: Start) -> None:
    """SI(12) turns ON, SO(13) turns ON, SI(12) turns OFF. SO(14) was OFF already.

    Source: manual chapter 5, 3.3, program execution process
    """
    cell = start().servo_on()
    assert cell.steps_of("AutoStart") == ["SI12 ON", "SO13 ON", "SI12 OFF"]


def test_program_stop_by_the_stop_input(start: Start) -> None:
    """SI(06) turns OFF, then SO(13) turns OFF. Servos and alarms do not change.

    Source: manual chapter 5, 3.3, program stop process using stop input
    """
    cell = start().program()
    assert cell.steps_of("ProgramStop") == ["SI06 OFF", "SO13 OFF"]


def test_program_execution_after_a_stop_by_the_stop_input(start: Start) -> None:
    """SI(06), SI(12) and SO(13) turn ON, then SI(12) turns OFF. An alarm reset is not needed.

    Source: manual chapter 5, 3.3, program execution after stopping program with stop input
    """
    cell = start().program()
    cell.from_now()
    assert cell.execute("ProgramStop") == 0
    assert cell.steps_of("ProgramContinue") == ["SI06 ON", "SI12 ON", "SO13 ON", "SI12 OFF"]


def test_the_program_also_stops_at_a_transition_to_emergency_stop(start: Start) -> None:
    """The transition turns SO(03) ON and SO(02) OFF. Source: manual chapter 5, 3.3, note."""
    cell = start().program()
    since = cell.from_now()
    assert cell.execute("EmergencyStop") == 0
    assert cell.steps(since) == ["SI00 OFF", f"{EMERGENCY}, SO13 OFF"]


def test_after_an_emergency_stop_a_program_needs_alarm_reset_and_servo_on(start: Start) -> None:
    """Source: manual chapter 5, 3.3, note."""
    cell = start().program()
    assert cell.execute("EmergencyStop") == 0
    assert cell.execute("AutoStart") == 0x8003
    assert cell.execute("FromEmergency") == 0
    assert cell.is_on("SO02", "SO03", "SO13") == (True, False, False)
    assert cell.execute("AutoStart") == 0
    assert cell.on("SO13")
