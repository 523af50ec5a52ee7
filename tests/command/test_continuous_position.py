"""FB_ContinuousPosition shows the position in every scan, until the status reset command."""

from __future__ import annotations

import pytest

from jog_bench import jog_plc
from plc_bench import PlcBench

#: Words m+2 to m+30 of the guide's example in pulses: axis 1 = 20001, axis 3 = -12345.
PULSES = [0, 0, 0, 0x4E21, 0, 0, 0, 0xCFC7, 0xFFFF]


def _reading(plc: PlcBench, **pins: object) -> None:
    for name, value in pins.items():
        plc[f"Position.{name}"] = value
    plc["Position.Enable"] = True
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc["Position.Busy"]


def test_the_continuous_output_mode_is_enabled_in_bit_0() -> None:
    """The telegram has code 0xR505 (R is the robot number) and bit 0 of n+2.

    Source: guide 4.7.4.
    """
    plc = jog_plc()
    _reading(plc, RobotNumber=3)
    assert plc.words == [0x3505, 0x0001, *[0] * 14]
    assert plc["Robot.Inner.Command.Holder"] == 0x3505


def test_positions_come_with_the_command_run_status_in_every_scan() -> None:
    """In status 0x0100 the block shows a new position in every scan.

    Source: guide 4.7.4, example.
    """
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0100, PULSES, scans=1)
    assert plc["Position.Valid"]
    assert not plc["Position.Busy"]
    assert plc["Position.Pulses"] == [20001, 0, -12345, 0, 0, 0]
    plc.answer(0x0100, [*PULSES[:3], 0x4E22, *PULSES[4:]], scans=1)
    assert plc["Position.Pulses"][0] == 20002
    assert plc.words[0] == 0x0505


def test_millimetres_come_with_hand_and_arm_rotation() -> None:
    """A position in mm includes the hand system and the arm rotation, bits 2-1, 6-3, 10-7 of m+6.

    Source: remote command guide 4.7.4, millimeter units
    """
    plc = jog_plc()
    _reading(plc, Unit="UNIT_MM")
    assert plc.words[:2] == [0x0506, 0x0001]
    flags = 0x2 << 1 | 0x1 << 3 | 0xF << 7
    plc.answer(0x0100, [0, 0, flags, *PULSES[3:]], scans=1)
    assert plc["Position.PositionMm"] == pytest.approx([20.001, 0, -12.345, 0, 0, 0])
    assert plc["Position.HandSystem"] == "HAND_LEFT"
    assert (plc["Position.Arm1"], plc["Position.Arm2"]) == (1, -1)
    plc.answer(0x0100, [0, 0, 0x2 | 0x2 << 3, *PULSES[3:]], scans=1)
    assert plc["Position.HandSystem"] == "HAND_RIGHT"
    assert (plc["Position.Arm1"], plc["Position.Arm2"]) == (0, 0), (
        "the arm rotation 2 must be shown as 0"
    )


def test_a_robot_without_hand_systems_shows_none() -> None:
    """If bits 2-1 are 0, HandSystem is HAND_NONE. Source: guide 4.7.4, millimeter units."""
    plc = jog_plc()
    _reading(plc, Unit="UNIT_MM")
    plc.answer(0x0100, [0, 0, 0x2, *PULSES[3:]], scans=1)
    assert plc["Position.HandSystem"] == "HAND_RIGHT"
    plc.answer(0x0100, PULSES, scans=1)
    assert plc["Position.HandSystem"] == "HAND_NONE"


def test_the_status_reset_command_stops_the_output() -> None:
    """When Enable falls, the block ends the output with code 0x0000. Source: guide 4.7.4."""
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0100, PULSES, scans=1)
    plc.change("Position.Enable", to=False)
    assert plc.words[0] == 0
    assert not plc["Position.Valid"]
    assert not plc["Position.Error"]
    assert plc["Position.Pulses"][0] == 20001, "the last position must stay"
    plc.scan(3)
    plc["First.Code"], plc["First.Execute"] = 0x0501, True
    plc.scan(3)
    assert plc.words[0] == 0, "the block is ready only when the status is 0x0000"
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] == 0x0501, most=4)


def test_a_block_that_is_not_called_any_more_ends_the_output_and_frees_the_channel() -> None:
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0100, PULSES, scans=1)
    plc.change("CallPosition", to=False)
    assert plc.words[0] == 0
    plc.answer(0)
    plc.give("First", 0x0501, most=5)


def test_the_continuous_mode_of_fb_remote_command_ends_at_its_timeout() -> None:
    """The continuous mode has no end status, so only the time-out can end it."""
    plc = jog_plc()
    plc["First.Code"], plc["First.Data[1]"], plc["First.Timeout"] = 0x0505, 1, "T#100ms"
    plc.scan_until(lambda: plc.words[0] == 0x0505, execute="First")
    plc.answer(0x0100, PULSES)
    plc.scan_until(lambda: bool(plc["First.Error"]), most=15)
    assert plc["First.ErrorID"] == 0x8011
    assert plc.words[0] == 0


def test_if_enable_falls_early_the_code_stays_until_the_status_changes() -> None:
    """If Enable falls early, the code stays until the status changes. Source: guide 1.1, note."""
    plc = jog_plc()
    _reading(plc)
    plc.change("Position.Enable", to=False, scans=3)
    assert plc.words[0] == 0x0505
    plc.answer(0x0100, PULSES, scans=1)
    assert plc.words[0] == 0


def test_if_enable_falls_before_the_code_is_sent_nothing_is_sent() -> None:
    plc = jog_plc()
    plc.change("Position.Enable", to=True)
    plc.change("Position.Enable", to=False, scans=5)
    assert plc.words[0] == 0
    plc.give("First", 0x0501, most=4)


def test_an_abnormal_end_is_shown_with_its_alarm_until_enable_falls() -> None:
    plc = jog_plc()
    _reading(plc)
    plc.complete(0x4000, [4, 2])
    assert plc["Position.ErrorID"] == 0x8020
    assert (plc["Position.AlarmGroup"], plc["Position.AlarmCategory"]) == (4, 2)
    plc.scan(10)
    assert plc.words[0] == 0, "the output does not start again by itself"
    assert (plc["Position.AlarmGroup"], plc["Position.AlarmCategory"]) == (4, 2)
    plc.change("Position.Enable", to=False)
    assert not plc["Position.Error"]
    assert plc["Position.AlarmGroup"] == 0


def test_a_normal_end_is_an_error() -> None:
    """Status 0x0200 gives error 16#8014, as the continuous mode has no normal end.

    Source: guide 4.7.4.
    """
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0200, PULSES, scans=1)
    assert plc["Position.ErrorID"] == 0x8014


def test_a_status_that_falls_back_to_ready_is_a_lost_command() -> None:
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0100, PULSES, scans=2)
    plc.answer(0, scans=1)
    assert plc["Position.ErrorID"] == 0x8014


def test_without_a_first_position_the_block_ends_at_timeout() -> None:
    """After the time limit the block shows 16#8011, but holds its code. Source: guide 1.1, note."""
    plc = jog_plc()
    _reading(plc, Timeout="T#100ms")
    plc.scan_until(lambda: bool(plc["Position.Error"]), most=15)
    assert plc["Position.ErrorID"] == 0x8011
    plc.scan(5)
    assert plc.words[0] == 0x0505
    plc.answer(0x0100, PULSES, scans=1)
    assert plc.words[0] == 0


@pytest.mark.parametrize("number", [-1, 5])
def test_an_illegal_robot_number_is_refused_without_a_telegram(number: int) -> None:
    """An illegal robot number gives 16#8040, and nothing is sent.

    Source: guide 4.7.4: R (0 to 4).
    """
    plc = jog_plc()
    plc["Position.RobotNumber"], plc["Position.Enable"] = number, True
    plc.scan(5)
    assert plc["Position.ErrorID"] == 0x8040
    assert plc.words[0] == 0


def test_a_lost_link_ends_the_output_and_nothing_restarts() -> None:
    plc = jog_plc()
    _reading(plc)
    plc.answer(0x0100, PULSES, scans=1)
    plc.change("Connected", to=False)
    assert plc["Position.ErrorID"] == 0x8001
    plc["Connected"] = True
    plc.answer(0, scans=40)
    assert plc.words[0] == 0
