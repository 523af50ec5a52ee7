"""The sentences of chapter 5, 2, about dedicated and general-purpose outputs."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell, steps_once

Start = Callable[..., ChapterCell]


def test_so00_is_on_in_the_emergency_stop_state(start: Start) -> None:
    """The cause of the emergency stop does not matter. Source: manual chapter 5, 2, SO(00)."""
    cell = start().settle()
    assert not cell.on("SO00")
    cell["CellSafe"] = False
    cell.wait("SO00")
    cell["CellSafe"] = True
    cell.wait("SO00", False)
    cell.cell.inject("emergency_stop")
    cell.wait("SO00")
    cell.cell.inject("emergency_stop_release")
    cell.wait("SO00", False)


def test_so01_is_on_in_the_normal_state(start: Start) -> None:
    """SO(01) is OFF until the controller has booted. Source: manual chapter 5, 2, SO(01)."""
    cell = start(booted=False)
    cell.run("150ms")
    assert cell["Connected"] is False
    assert not cell.on("SO01")
    cell.wait("SO01")


def test_so02_is_on_while_the_motors_have_power(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(02)."""
    cell = start().settle()
    assert not cell.on("SO02")
    assert cell.execute("ServoOn") == 0
    assert cell.on("SO02")
    cell.cell.inject("main_power_off")
    cell.wait("SO02", False)
    cell.run("20ms")
    assert not cell.robot.machine.servo_on


def test_so03_is_on_when_a_serious_error_has_occurred(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(03)."""
    cell = start().servo_on()
    assert not cell.on("SO03")
    cell.cell.inject("alarm", group=17, category=500)
    cell.cell.run_until(lambda: cell["Status.AlarmRaised"] is True, within="100ms")
    assert cell.on("SO03")


def test_so04_is_on_with_main_power_and_servo_on_enabled(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(04)."""
    cell = start().settle()
    assert cell.on("SO04")
    cell.cell.inject("main_power_off")
    cell.wait("SO04", False)
    assert cell.execute("ServoOn") == 0x8005
    cell.cell.inject("main_power_on")
    cell.wait("SO04")
    assert cell.execute("ServoOn") == 0


def test_so04_goes_off_at_a_serious_error(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(04)."""
    cell = start().settle()
    cell.cell.inject("alarm", group=17, category=500)
    cell.wait("SO04", False)
    assert cell.on("SO03")


def test_so10_is_on_in_auto_mode(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(10)."""
    cell = start(auto_mode=False).settle()
    assert not cell.on("SO10")
    cell.cell.inject("auto_mode")
    cell.wait("SO10")


def test_so10_is_off_in_any_other_mode(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(10)."""
    cell = start().settle()
    assert cell.on("SO10")
    cell.cell.inject("manual_mode")
    cell.cell.run_until(lambda: cell["Status.AutoLost"] is True, within="100ms")
    assert not cell.on("SO10")
    assert cell.execute("AutoStart") == 0x8006


def test_so11_is_on_when_the_robot_has_completed_its_return_to_origin(start: Start) -> None:
    """SO(11) needs the origin of all axes of the robot. Source: manual chapter 5, 2, SO(11)."""
    cell = start(origin_complete=False, di17_mode="ABS").servo_on()
    assert not cell.on("SO11")
    assert cell.return_to_origin("ORIGIN_ABSOLUTE") == 0x8010
    assert not cell.on("SO11")
    assert cell.return_to_origin("ORIGIN_INCREMENTAL") == 0
    assert cell.on("SO11")


def test_so12_is_on_while_the_sequence_program_is_executed(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(12)."""
    cell = start().settle()
    assert not cell.on("SO12")
    cell["Sequence.Enable"] = True
    cell.wait("SO12")
    cell["Sequence.Enable"] = False
    cell.wait("SO12", False)


def test_so13_is_on_while_the_robot_program_is_executed(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(13)."""
    cell = start().servo_on()
    assert not cell.on("SO13")
    assert cell.execute("AutoStart") == 0
    assert cell.on("SO13")
    cell.cell.inject("program_end")
    cell.cell.run_until(lambda: cell["Status.ProgramEnded"] is True, within="100ms")
    assert not cell.on("SO13")


def test_so14_goes_on_when_the_robot_program_has_been_reset(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(14)."""
    cell = start().settle()
    assert not cell.on("SO14")
    assert cell.execute("ProgramReset") == 0
    assert cell.on("SO14")


def test_so14_goes_off_when_the_robot_program_starts(start: Start) -> None:
    """Source: manual chapter 5, 2, SO(14)."""
    cell = start().settle()
    assert cell.execute("ProgramReset") == 0
    assert cell.execute("AutoStart") == 0
    assert cell.is_on("SO13", "SO14") == (True, False)


def test_so15_is_on_when_there_is_a_warning(start: Start) -> None:
    """A warning is not an alarm. Source: manual chapter 5, 2, SO(15)."""
    cell = start().settle()
    cell.cell.inject("warning")
    cell.cell.run_until(lambda: cell["Status.WarningRaised"] is True, within="100ms")
    assert cell.is_on("SO15", "SO03") == (True, False)
    cell.cell.inject("warning_clear")
    cell.wait("SO15", False)


@pytest.mark.parametrize(
    ("steps", "on"),
    [
        (("SO(20)=1",), True),
        (("SO2()=1",), True),
        (("SET SO(20)",), True),
        (("OUT SO(20)",), True),
        (("SO(20)=1", "SO(20)=0"), False),
        (("SET SO(20)", "RESET SO(20)"), False),
        (("OUT SO(20),100", "DELAY 150"), False),
    ],
)
def test_a_general_purpose_output_follows_assignment_set_reset_and_out(
    start: Start, steps: tuple[str, ...], on: bool
) -> None:
    """Source: manual chapter 5, 2, SO(20) to SO(157)."""
    cell = start(**steps_once(*steps))
    cell.run_short_program()
    cell.run("300ms")
    assert cell["ReadBit.Valid"] is True
    assert cell["ReadBit.Value"] is on


def test_each_of_the_outputs_so20_to_so157_reaches_the_master(start: Start) -> None:
    """Each of the 96 outputs that the robot writes is read by the PLC.

    Source: manual chapter 5, 2, SO(20) to SO(157) and note
    """
    cell = start().settle()
    tens = [*range(2, 8), *range(10, 16)]
    numbers = [10 * port + bit for port in tens for bit in range(8)]
    assert len(numbers) == 96
    for number in numbers:
        cell.robot.write_port(f"SO({number})", 1)
        cell["ReadBit.Port"] = number
        cell.run("30ms")
        assert cell["ReadBit.Value"] is True
        cell.robot.write_port(f"SO({number})", 0)
