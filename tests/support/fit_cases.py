"""Thirty robot files with different keys, and a trial of `rcx compare --fit` on each."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from rcx_harness.look.compare.delays import DELAYS
from rcx_harness.look.compare.fit import Fit, fit
from rcx_harness.look.compare.replay import Replay
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config import Axis, RobotProgram
from rcx_harness.spec.wire import CYCLE_US
from recorded_robot import RecordedMaster, exercised

_MARK = (Axis(), Axis(origin_method="mark"), Axis(type="incremental"), Axis(type="semi_absolute"))
_STEPS = ("SO(20)=1", "WAIT SI(20)=1")
#: Descriptions of the robots. They are passed with `--robot`, and the search starts from them.
DESCRIPTIONS: dict[str, dict[str, Any]] = {
    "plain": {},
    "mark": {"axes": _MARK},
    "two robots": {"axes": (Axis(), Axis(), Axis(robot=2), Axis(robot=2))},
    "a program that ends": {"programs": (RobotProgram(duration=400.0, loop=False),)},
    "a program that waits": {"programs": (RobotProgram(steps=_STEPS),)},
    "extended": {"size": 256},
}
#: Names of descriptions, each with the keys and values that the search must find.
CASES: tuple[tuple[str, dict[str, Any]], ...] = (
    ("plain", {}),
    ("plain", {"servo_on_delay": (20.0, 120.0), "emergency_release_delay": 30.0}),
    ("plain", {"command_accept_delay": 15.0, "command_delay": 25.0, "status_reset_delay": 10.0}),
    ("plain", {"alarm_reset_delay": (5.0, 60.0), "program_reset_delay": 45.0}),
    ("plain", {"program_start_delay": 35.0, "program_stop_delay": 20.0, "sequence_delay": 15.0}),
    ("plain", {"origin_time": 700.0, "auto_mode_delay": 25.0, "emergency_stop_delay": 10.0}),
    ("plain", {"boot_time": 300.0, "link_error_latches": True, "link_error_alarm": "12.550"}),
    ("plain", {"min_interval": 50.0, "late_levels": False}),
    ("plain", {"auto_mode": False, "start_needs_auto": False}),
    ("plain", {"origin_complete": False, "origin_clears_complete": False}),
    ("plain", {"program_is_reset": True, "reset_while_running": True}),
    ("plain", {"mp_ready_in_emergency_stop": False, "reset_in_emergency_stop": True}),
    ("plain", {"recovery_edges": True, "first_image_commands": False}),
    ("plain", {"servo_on_with_alarm": True, "alarm_stops_servo": False}),
    ("plain", {"format_alarm": "4.202", "undefined_code_alarm": "12.75"}),
    ("plain", {"pendant_alarm": "12.76", "busy_alarm": "6.280", "servo_off_alarm": "6.301"}),
    ("plain", {"overflow_alarm": "6.252", "division_alarm": "6.203"}),
    ("plain", {"real_to_integer": "truncate", "several_elements": False, "max_payload": 70}),
    ("plain", {"host_version": 0x0112, "driver_version": 0x0201, "manual_speed": 35}),
    ("plain", {"option_slots": (0x0300, 0, 0, 0x0401), "clock": "2021-05-06 07:08:09"}),
    ("plain", {"skip_run_status": "always", "strict_unused_words": False}),
    ("plain", {"changed_command_status": "ready", "data_belong_to_command": False}),
    ("plain", {"link_loss_alarm": "12.553", "minor_alarms": (), "command_alarm_is_serious": True}),
    ("plain", {"power_loses_settings": True, "power_clears_internal_outputs": False}),
    ("plain", {"newest_message_first": False, "position_hand": True, "comment_filler": "spaces"}),
    ("plain", {"jog_limit": "normal", "movei_start_position": "reset", "inching_amount": 40}),
    ("mark", {"origin_method_alarm": "6.317", "semi_absolute_is_incremental": False}),
    ("two robots", {"scara_robots": (2,), "not_scara_alarm": "6.319", "program_speed": 60}),
    ("a program that ends", {"running_shows_all_tasks": False, "restart_begins_anew": True}),
    ("extended", {"emergency_stops_sequence": True, "di17_mode": "ABS", "auto_speed": 80}),
)


def recorded(description: str, values: Mapping[str, Any], seed: int = 7) -> Replay:
    """Return the recording of a controller with these values that has run all exercises."""
    master = RecordedMaster(seed, **DESCRIPTIONS[description], **values)
    exercised(master)
    return Replay(master.recording(), master.happenings)


def judged(description: str, values: Mapping[str, Any]) -> tuple[Fit, list[str]]:
    """Search a recording for the controller's values. Return the result, and texts for wrong keys.

    A key is right if its value is the robot's, or if a replay gives the same recording with both
    values. A delay may differ by less than a controller cycle.
    """
    replay = recorded(description, values)
    base = RobotConfig(**DESCRIPTIONS[description])
    found = fit(replay, base)
    wrong = [f"left: {one}" for one in found.left]
    true = replace(base, **values)
    for knob in found.knobs:
        real = getattr(true, knob.key)
        if knob.key in DELAYS:
            if getattr(found.config, knob.key) != real:
                wrong += _wrong_delay(knob.key, knob.value, real, knob.found)
        elif knob.value != real:
            changed = replace(found.config, **{knob.key: real})
            open_ended = not isinstance(real, bool | str)
            listed = open_ended or not knob.found or real in knob.others
            if replay.run(changed).differences or not listed:
                wrong.append(f"{knob.key} is {real!r}, found {knob.value!r} ({knob.why})")
    wrong += _not_decided(found, replay)
    return found, wrong


def _wrong_delay(key: str, found: Any, real: Any, seen: bool) -> list[str]:
    low, high = real if isinstance(real, tuple) else (real, real)
    least, most = found if isinstance(found, tuple) else (found, found)
    cycle_ms = CYCLE_US / 1000
    if not seen or (low <= least and most < high + cycle_ms):
        return []
    return [f"{key} is {real}, found {found}"]


def _not_decided(found: Fit, replay: Replay) -> list[str]:
    """Return a text for each key that is reported as undecided although its value matters.

    The value matters if a replay with the opposite value differs from the recording.
    """
    wrong = []
    for knob in found.knobs:
        value = getattr(found.config, knob.key)
        if not knob.found and knob.key not in DELAYS and isinstance(value, bool):
            changed: dict[str, Any] = {knob.key: not value}
            other = replace(found.config, **changed)
            if replay.run(other).differences:
                wrong.append(f"{knob.key} is decided, but reported as undecided")
    return wrong
