"""The sentences of chapter 5, 2, about dedicated and general-purpose inputs."""

from __future__ import annotations

from collections.abc import Callable

from chapter_cell import ChapterCell, steps_once
from robot_master import Master, powered_up

Start = Callable[..., ChapterCell]


def test_si00_off_puts_the_controller_into_the_emergency_stop_state(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(00)."""
    cell = start().servo_on()
    assert cell.execute("EmergencyStop") == 0
    assert cell.is_on("SO00", "SO02") == (True, False)
    assert cell.alarms() == ["12.600"]


def test_si00_is_kept_on_during_normal_operation(start: Start) -> None:
    """From power-on to the running program, SI(00) turns ON once and stays ON.

    Source: manual chapter 5, 2, SI(00).
    """
    cell = start()
    assert cell.execute("PowerUp") == 0
    cell.from_now()
    assert [step for step in cell.steps(0) if "SI00" in step] == ["SI00 ON"]


def test_si01_on_puts_the_servos_on_after_an_emergency_stop_was_cancelled(start: Start) -> None:
    """SI(00) ON and an alarm reset cancel the emergency stop; then SI(01) turns the servos on.

    Source: manual chapter 5, 2, SI(01)
    """
    cell = start().servo_on()
    assert cell.execute("EmergencyStop") == 0
    assert cell.execute("FromEmergency") == 0
    assert cell.is_on("SO00", "SO02") == (False, True)


def test_si01_acts_when_it_is_switched_from_off_to_on() -> None:
    """If the servos turn off while SI(01) is ON, they stay off until SI(01) turns ON again.

    Source: manual chapter 5, 2, SI(01)
    """
    master = powered_up()
    master.turn_and_wait("SI01", True)
    assert master.on("SO02")
    master.robot.inject("main_power_off")
    master.run(50)
    master.robot.inject("main_power_on")
    master.run(500)
    assert not master.on("SO02")
    master.turn_and_wait("SI01", False)
    assert not master.on("SO02")
    master.turn_and_wait("SI01", True)
    assert master.on("SO02")


def test_si01_needs_si00_on() -> None:
    """Source: manual chapter 5, 2, SI(01)."""
    master = Master()
    master.run(300)
    master.pulse("SI01")
    assert not master.on("SO02")
    master.turn_and_wait("SI00", True)
    master.pulse("SI01")
    assert master.on("SO02")


def test_si01_needs_all_emergency_stops_cancelled(start: Start) -> None:
    """If the SAFETY connector is open, SI(01) does not turn the servos on, even with SI(00) ON.

    Source: manual chapter 5, 2, SI(01)
    """
    cell = start().settle()
    cell.cell.inject("emergency_stop")
    cell.wait("SO00")
    assert cell["Robot.SI.SI00_EmergencyStop"] is True
    assert cell.execute("ServoOn") == 0x8003
    cell.cell.inject("emergency_stop_release")
    assert cell.execute("FromEmergency") == 0


def test_si06_off_stops_the_robot_program(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(06)."""
    cell = start().program()
    assert cell.execute("ProgramStop") == 0
    assert not cell.on("SO13")


def test_to_execute_the_program_si06_is_kept_on(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(06)."""
    cell = start().program()
    cell.run("2s")
    assert cell.on("SO13")
    assert [step for step in cell.steps(0) if "SI06" in step] == ["SI06 ON"]


def test_si10_on_executes_the_sequence_program(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(10)."""
    cell = start().settle()
    since = cell.from_now()
    cell["Sequence.Enable"] = True
    cell.cell.run_until(lambda: cell["Sequence.Valid"] is True, within="1s")
    assert cell.steps(since) == ["SI10 ON", "SO12 ON"]


def test_the_sequence_program_is_executed_as_long_as_si10_is_on(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(10)."""
    cell = start().settle()
    cell["Sequence.Enable"] = True
    cell.run("3s")
    assert cell.on("SO12")
    since = cell.cell.now_us
    cell["Sequence.Enable"] = False
    cell.run("500ms")
    assert cell.steps(since) == ["SI10 OFF", "SO12 OFF"]


def test_si12_on_executes_the_robot_program(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(12)."""
    cell = start().servo_on()
    assert cell.execute("AutoStart") == 0
    assert cell.robot.program.running


def test_si12_acts_when_it_is_switched_from_off_to_on() -> None:
    """If SI(12) stays ON, it does not start the program a second time.

    Source: manual chapter 5, 2, SI(12).
    """
    master = powered_up(**steps_once("SOW(3)=1", "DELAY 100", "SOW(3)=2"))
    master.turn_and_wait("SI12", True, 1000)
    assert not master.on("SO13")
    master.robot.write_port("SOW(3)", 0)
    master.run(1000)
    assert master.words[3] == 0
    master.turn_and_wait("SI12", False)
    assert master.words[3] == 0
    master.turn_and_wait("SI12", True)
    assert master.words[3] == 2


def test_si15_on_resets_the_robot_program(start: Start) -> None:
    """After SI(15), a stopped program starts at its first line.

    Source: manual chapter 5, 2, SI(15).
    """
    cell = start(**steps_once("SO(20)=1", "WAIT SI(20)=1", "SO(21)=1", "WAIT SI(20)=0")).servo_on()
    assert cell.execute("AutoStart") == 0
    assert cell.execute("ProgramStop") == 0
    cell.robot.write_port("SO(20)", 0)
    assert cell.execute("ProgramReset") == 0
    assert cell.execute("ProgramContinue") == 0
    assert cell["ReadBit.Value"] is True


def test_si15_acts_when_it_is_switched_from_off_to_on() -> None:
    """If SI(15) stays ON, it does not reset the program again.

    Source: manual chapter 5, 2, SI(15).
    """
    master = powered_up()
    master.turn_and_wait("SI15", True)
    assert master.on("SO14")
    master.turn_and_wait("SI12", True)
    assert not master.on("SO14")
    master.robot.inject("program_end")
    master.run(300)
    assert not master.on("SO14")


def test_si15_needs_the_auto_mode(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(15)."""
    cell = start(auto_mode=False).settle()
    assert cell.execute("ProgramReset") == 0x8006
    master = powered_up(auto_mode=False)
    master.pulse("SI15")
    assert not master.on("SO14")


def test_si16_on_performs_an_alarm_reset(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(16)."""
    cell = start().settle()
    cell.cell.inject("alarm", group=17, category=500)
    cell.wait("SO03")
    assert cell.execute("AlarmReset") == 0
    assert not cell.on("SO03")
    assert cell.alarms() == []


def test_si16_acts_when_it_is_switched_from_off_to_on() -> None:
    """An alarm that comes while SI(16) stays ON is not reset.

    Source: manual chapter 5, 2, SI(16).
    """
    master = powered_up()
    master.turn_and_wait("SI16", True)
    master.robot.inject("alarm", group=17, category=500)
    master.run(500)
    assert master.on("SO03")
    master.turn_and_wait("SI16", False)
    assert master.on("SO03")
    master.turn_and_wait("SI16", True)
    assert not master.on("SO03")


def test_alarms_that_si16_does_not_clear_need_a_power_restart(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(16)."""
    cell = start().settle()
    cell.cell.inject("alarm", group=12, category=900)
    cell["AlarmReset.Timeout"] = "T#1s"
    cell.wait("SO03")
    assert cell.execute("AlarmReset") == 0x8010
    cell.cell.inject("power_cycle")
    cell.run("2s")
    assert cell.is_on("SO01", "SO03") == (True, False)


def test_a_robot_program_refers_to_the_value_of_an_si_port(start: Start) -> None:
    """Source: manual chapter 5, 2, SI(20) to SI(157)."""
    cell = start(**steps_once("A=SI(157)", "B=SI15()"))
    cell["WriteBit.Port"] = 157
    cell["Bit"] = True
    cell.run_short_program()
    assert cell.robot.program.variables == {"A": 1, "B": 0x80}


def test_a_robot_program_waits_for_a_general_purpose_input(start: Start) -> None:
    """The program continues when the input is ON, as in WAIT SI(20)=1.

    Source: manual chapter 5, 2, SI(20) to SI(157).
    """
    cell = start(**steps_once("WAIT SI(20)=1", "SO(20)=1")).servo_on()
    assert cell.execute("AutoStart") == 0
    cell.run("1s")
    assert cell["ReadBit.Value"] is False
    cell["Bit"] = True
    cell.run("50ms")
    assert cell["ReadBit.Value"] is True
    assert not cell.on("SO13")
