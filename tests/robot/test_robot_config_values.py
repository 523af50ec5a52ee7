"""Each key of a robot file has its default value and its range of numbers."""

from __future__ import annotations

from dataclasses import MISSING, fields
from typing import Any

import pytest

from rcx_harness.robot import Axis, RobotConfig, RobotProgram
from structured_text.errors import InputError

_FALSE = """
    power_clears_variables
    program_error_is_serious
    pendant_authority safety_disables_inputs program_is_reset recovery_edges
    power_on_emergency_alarm reset_in_emergency_stop servo_on_with_alarm restart_begins_anew
    emergency_stops_sequence reset_clears_warning program_needs_servo reset_while_running
    parallel_disables_si main_ends_tasks reset_clears_outputs early_command_waits end_in_tolerance
    arch_zero_is_parameter power_loses_settings position_hand motor_data_of_all_robots
    link_error_latches command_alarm_is_serious
"""
_TRUE = """
    program_error_stops_all
    booted auto_mode origin_complete sequence_program parallel_stop late_levels first_image_commands
    mp_ready_in_emergency_stop pendant_blocks_inputs safety_keeps_stops servo_off_brakes_free_axes
    motor_power_stops_program manual_mode_stops_program start_needs_auto origin_needs_servo
    origin_clears_complete power_loses_origin running_shows_all_tasks power_clears_internal_outputs
    loss_clears_inputs program_words_between_commands waiting_is_standby program_info_while_running
    strict_unused_words data_belong_to_command servo_needs_motor_power semi_absolute_is_incremental
    several_elements position_flag_bit0 newest_message_first unasked_positions_zero
    alarm_stops_servo motion_during_program
"""
_INPUT_FORMAT_ERROR = "format_alarm not_scara_alarm impossible_date_alarm"
#: Default alarms of the keys, chosen by their names in the public list: 12.75 is "Illegal remote
#: command".
_BY_NAME = {
    "undefined_code_alarm": "12.75",
    "pendant_alarm": "12.76",
    "absent_robot_alarm": "4.204",
    "no_axis_alarm": "4.205",
    "absent_controller_alarm": "4.213",
    "busy_alarm": "6.281",
    "moving_alarm": "6.282",
    "servo_off_alarm": "6.301",
    "motor_power_alarm": "6.300",
    "origin_method_alarm": "6.317",
    "absolute_reset_alarm": "6.312",
    "undefined_program_alarm": "3.203",
    "undefined_task_alarm": "6.262",
    "manual_mode_alarm": "0.20",
    "undefined_point_alarm": "6.204",
    "no_circle_alarm": "2.330",
    "undefined_pallet_alarm": "6.236",
    "work_position_alarm": "6.283",
    "point_unit_alarm": "6.205",
    "overflow_alarm": "6.252",
    "division_alarm": "6.203",
    "out_of_reach_alarm": "2.335",
    "outer_range_alarm": "2.352",
    "to_left_alarm": "2.319",
    "to_right_alarm": "2.320",
    "drive_xy_alarm": "2.337",
}
_NO_ALARM = "power_on_alarm main_power_alarm undefined_data_alarm"
#: Default times [ms] of the controller's answers and of its surroundings.
_TIMES: dict[str, float] = {
    "boot_time": 200,
    "link_error_delay": 100,
    "emergency_stop_delay": 0,
    "emergency_release_delay": 5,
    "servo_on_delay": 50,
    "alarm_reset_delay": 20,
    "program_reset_delay": 20,
    "program_start_delay": 20,
    "program_stop_delay": 5,
    "sequence_delay": 5,
    "auto_mode_delay": 0,
    "origin_time": 500,
    "command_accept_delay": 0,
    "command_delay": 10,
    "status_reset_delay": 0,
    "min_interval": 100,
    "real_time_interval": 5,
}
_OTHERS: dict[str, Any] = {
    "size": 48,
    "robot": (),
    "outer_angle": 3,
    "axes": (Axis(), Axis(), Axis(type="incremental"), Axis(type="incremental")),
    "programs": (RobotProgram(),),
    "comments": {},
    "pallets": {},
    "shifts": {},
    "hands": {},
    "work_areas": {},
    "variables": {},
    "parameters": {},
    "parallel_io": "none",
    "ip_address": "set",
    "di17_mode": "ABS/ORG",
    "idle_header": "loss",
    "name_filler": "spaces",
    "comment_filler": "zeros",
    "skip_run_status": "short",
    "changed_command_status": "run",
    "movei_start_position": "keep",
    "jog_limit": "alarm",
    "real_to_integer": "round",
    "auto_speed": 100,
    "program_speed": 100,
    "manual_speed": 20,
    "inching_amount": 100,
    "max_payload": 50,
    "scara_robots": (1, 2, 3, 4),
    "clock": "2014-01-01 10:59:59",
    "option_slots": (0x0401, 0x0100, 0, 0),
    "ivy2_unit": 0,
    "real_time_items": {13: "motor_duty"},
    "host_version": 0x0108,
    "host_revision": 0x0030,
    "fpga_version": 0x1001,
    "driver_version": 0x0101,
    "link_error_alarm": "12.551",
    "link_loss_alarm": "12.552",
    "minor_alarms": ("12.400",),
    "power_restart_alarms": ("12.762", "12.763", "12.900", "12.904"),
    "module_fault_alarms": ("12.762", "12.900", "12.904"),
    "module_error_alarms": ("12.763",),
    "cpu_fault_alarms": (),
    "alarm_history_length": 500,
    "program_statements": 100,
    "program_stack": 20,
    "tcounter_ms": 1,
    "plain_variables": "real",
    "program_type_alarm": "5.999",
    "program_stack_alarm": "5.998",
    "program_path_alarm": "5.997",
}


def test_a_controller_without_a_robot_file_is_the_one_of_the_list() -> None:
    """A controller without a robot file has the values of this list.

    Another test checks its points.

    Source: manual, remote command guide 4.7.1 (versions), 4.7.7 (500 messages), 4.7.13 and 4.7.14
    (date and time), 4.7.15 (slots), 4.9.1 (item 13), 4.2.1 (4.2); chapter 4, 4; chapter 5, 3
    (100 ms); public alarm list of an RCX340 (numbers by name). The rest is assumed.
    """
    mine: dict[str, Any] = dict.fromkeys(_FALSE.split(), False) | dict.fromkeys(_TRUE.split(), True)
    mine |= dict.fromkeys(_INPUT_FORMAT_ERROR.split(), "4.2") | dict.fromkeys(_NO_ALARM.split(), "")
    mine |= _BY_NAME | _TIMES
    mine |= _OTHERS
    theirs = {one.name: getattr(RobotConfig(), one.name) for one in fields(RobotConfig)}
    del theirs["points"]
    assert theirs == mine
    flags = {name for name, value in theirs.items() if isinstance(value, bool)}
    # compare types as well, because `1 == True` in Python
    assert flags == {*_FALSE.split(), *_TRUE.split()}


def test_an_axis_and_a_program_have_their_defaults() -> None:
    """The default axis reaches 1 m to both sides, with 1000 pulses/mm and no workpiece."""
    assert _defaults(Axis) == {
        "robot": 1,
        "type": "absolute",
        "origin_method": "sensor",
        "pulses_per_mm": 1_000,
        "zero": 0,
        "max_speed": 1_000_000,
        "max_acceleration": 5_000_000,
        "soft_low": -1_000_000,
        "soft_high": 1_000_000,
        "start": 0,
        "motor_rotation": 16_384,
        "robot_type": 2_000,
        "holding_torque": 0,
        "moving_torque": 10,
        "rated_torque": 20,
        "workpiece": None,
    }
    assert _defaults(RobotProgram) == {
        "name": "MAIN",
        "duration": 1_000,
        "loop": True,
        "steps": (),
        "file": "",
        "text": "",
        "path": "",  # path and offset are not keys of a robot file
        "offset": 0,
    }


def _defaults(kind: type) -> dict[str, Any]:
    every = fields(kind)
    return {one.name: one.default for one in every if one.default is not MISSING}


def _robot(key: str, value: Any) -> RobotConfig:
    given: dict[str, Any] = {key: value}
    return RobotConfig(**given)


#: Lowest and highest values of keys. Percentages are from the guide, 4.2.14 to 4.2.16, the inching
#: amount from 4.2.8. Words have 16 bits.
_OF_ROBOT = {
    "auto_speed": (1, 100),
    "program_speed": (1, 100),
    "manual_speed": (1, 100),
    "inching_amount": (1, 10_000),
    "ivy2_unit": (0, 65_535),
    "host_version": (0, 65_535),
    "host_revision": (0, 65_535),
    "fpga_version": (0, 65_535),
    "driver_version": (0, 65_535),
    "max_payload": (0, 2_000_000),
    "alarm_history_length": (1, 100_000),
}
_OF_AXIS = {
    "robot": (1, 4),
    "motor_rotation": (4, 16_777_216),
    "robot_type": (1, 65_535),
    "holding_torque": (-100, 100),
    "moving_torque": (0, 100),
    "rated_torque": (1, 100),
    "start": (-(2**31), 2**31 - 1),
    "workpiece": (-(2**31), 2**31 - 1),
}


@pytest.mark.parametrize(("key", "limits"), _OF_ROBOT.items())
def test_a_key_of_the_robot_accepts_values_up_to_its_limits(
    key: str, limits: tuple[int, int]
) -> None:
    for value in limits:
        assert getattr(_robot(key, value), key) == value
    for value in (limits[0] - 1, limits[1] + 1):
        with pytest.raises(InputError, match=f"'{key}' cannot be {value}"):
            _robot(key, value)


@pytest.mark.parametrize(("key", "limits"), _OF_AXIS.items())
def test_a_key_of_an_axis_accepts_values_up_to_its_limits(
    tmp_path: Any, key: str, limits: tuple[int, int]
) -> None:
    file = tmp_path / "robot.toml"
    for value in limits:
        file.write_text(f"[[axes]]\n[[axes]]\n{key} = {value}\n", encoding="utf-8")
        assert getattr(RobotConfig.load(file).axes[1], key) == value
    for value in (limits[0] - 1, limits[1] + 1):
        file.write_text(f"[[axes]]\n[[axes]]\n{key} = {value}\n", encoding="utf-8")
        with pytest.raises(InputError, match=f"'{key}' cannot be {value}"):
            RobotConfig.load(file)


@pytest.mark.parametrize("value", [float("inf"), float("-inf"), float("nan"), True, "5"])
@pytest.mark.parametrize("key", ["min_interval", "servo_on_delay", "variables"])
def test_a_number_that_is_not_finite_is_refused(key: str, value: Any) -> None:
    """Infinite values and NaN are refused. The value of a variable is limited only by its type."""
    given = {"SGR0": value} if key == "variables" else value
    with pytest.raises(InputError):
        _robot(key, given)
