"""What the value of a configuration key may be."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.script import Task, script
from rcx_harness.spec.wire import AREA_SIZES

__all__ = ["alarm_code", "check_programs", "check_value", "expect", "is_number", "near"]

#: A robot program's name, as remote commands can carry it (guide 4.6.1).
_NAME = re.compile("[A-Z0-9_]+")
_CHOICES = {
    "size": AREA_SIZES,
    "parallel_io": ("none", "valid", "invalid"),
    "idle_header": ("loss", "hold"),
    "skip_run_status": ("never", "short", "always"),
    "changed_command_status": ("run", "ready"),
    "ip_address": ("set", "none", "duplicate"),
    "movei_start_position": ("keep", "reset"),
    "jog_limit": ("alarm", "normal"),
    "di17_mode": ("ABS", "ABS/ORG"),
    "type": ("absolute", "incremental", "semi_absolute"),
    "comment_filler": ("zeros", "spaces"),
    "name_filler": ("zeros", "spaces"),
    "real_to_integer": ("round", "truncate"),
    "origin_method": ("sensor", "stroke_end", "mark"),
}
_RANGES = {
    "robot": (1, 4),
    "auto_speed": (1, 100),
    "program_speed": (1, 100),
    "manual_speed": (1, 100),
    "inching_amount": (1, 10000),
    "motor_rotation": (4, 2**24),
    "robot_type": (1, 0xFFFF),
    "holding_torque": (-100, 100),
    "moving_torque": (0, 100),
    "rated_torque": (1, 100),
    "ivy2_unit": (0, 0xFFFF),
    "host_version": (0, 0xFFFF),
    "host_revision": (0, 0xFFFF),
    "fpga_version": (0, 0xFFFF),
    "driver_version": (0, 0xFFFF),
    "max_payload": (0, 2_000_000),
    "alarm_history_length": (1, 100_000),
}
_PROGRAMS = 100
#: Alarms that need not be.
_NO_ALARM = ("power_on_alarm", "main_power_alarm", "undefined_data_alarm")
#: What an alarm's key holds, or that of several.
_ALARMS = ('group and category as "12.600"', 'a list of alarms as ["12.600"]')
_POSITIVE = ("pulses_per_mm", "max_speed", "max_acceleration")
_INT32 = (-(2**31), 2**31 - 1)
#: A number that must not be 0 is at least, any number at most: a year in milliseconds.
_LEAST, _MOST = 1e-6, 365 * 86_400_000
#: Up to this length a hint lists all names [characters].
_LISTED = 200
#: Of a value a message shows so much [characters].
_SHOWN = 80


def check_value(key: str, declared: str, value: Any) -> None:
    """Refuse a value that the key cannot have.

    Args:
        key: Name of the key, for the message and the key's own limits.
        declared: The field's annotation, as written.
        value: The value.

    Raises:
        InputError: with what is allowed as the hint; the key is in single quotes.
    """
    if key in _CHOICES:
        choices = _CHOICES[key]
        right = value in choices and type(value) is type(choices[0])
        expect(right, key, value, " or ".join(map(str, choices)))
    elif declared == "Delay":
        _check_delay(key, value)
    elif declared == "bool":
        expect(isinstance(value, bool), key, value, "true or false")
    elif declared == "int | None" and value is None:
        pass
    elif declared in ("int", "int | None"):
        low, high = _RANGES.get(key, _INT32)
        expect(_whole(value, low, high), key, value, f"{low} to {high}")
    elif declared == "float":
        _check_number(key, value)
    elif key.endswith(("_alarm", "_alarms")):
        listed = declared != "str"
        expect(isinstance(value, tuple if listed else str), key, value, _ALARMS[listed])
        for number in value if listed else (value,):
            if number != "" or key not in _NO_ALARM:
                alarm_code(number, key)
    elif declared == "str":
        expect(isinstance(value, str), key, value, "a text")
    elif key == "axes":
        _check_axes(value)
    elif key == "scara_robots":
        right = isinstance(value, tuple) and all(_whole(robot, 1, 4) for robot in value)
        expect(right, key, value, "a list of robot numbers 1 to 4")
    elif key == "programs":
        expect(len(value) > 0, key, value, "at least one program")
        expect(len(value) <= _PROGRAMS, key, f"{len(value)} tables", f"{_PROGRAMS} at most")


def check_programs(programs: Any, size: int) -> None:
    """Refuse programs with steps that cannot be done on areas of `size` bytes (InputError)."""
    for program in programs:
        steps = program.steps
        texts = isinstance(steps, tuple) and all(isinstance(step, str) for step in steps)
        expect(texts, "steps", steps, 'a list of texts, such as ["WAIT SI(20)=1"]')
        for step in script(steps, size):
            number = step.number if isinstance(step, Task) else 1
            allowed = f"START 1 to START {len(programs)}"
            expect(1 <= number <= len(programs), "steps", f"START {number}", allowed)
        named = isinstance(program.name, str) and _NAME.fullmatch(program.name) is not None
        expect(named, "name", program.name, "upper case letters, digits and _")


def alarm_code(number: Any, key: str = "alarm") -> tuple[int, int]:
    """Group and category of an alarm number.

    Raises:
        InputError: not a number as `"12.600"`.
    """
    match = re.fullmatch(r"(\d{1,5})\.(\d{1,5})", number) if isinstance(number, str) else None
    code = (int(match[1]), int(match[2])) if match else (-1, -1)
    fits = all(0 <= part <= 0xFFFF for part in code)
    expect(fits, key, number, 'group and category as "12.600"')
    return code


def expect(condition: bool, key: str, value: Any, allowed: str) -> None:
    """Refuse the value of a key unless the condition holds (InputError)."""
    if not condition:
        raise InputError(f"'{key}' cannot be {_shown(value)}", hint=f"it may be {allowed}")


def _shown(value: Any) -> str:
    try:
        text = repr(value)
    except ValueError:  # Python does not write it in decimal
        return "a number of so many digits"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def is_number(value: Any) -> bool:
    """It is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < math.inf


def near(name: str, known: Iterable[str]) -> str:
    """A hint on a name that is not known: what is near, else all there are, or the nearest."""
    names = list(known)
    meant = get_close_matches(name, names)
    if meant:
        return f"did you mean {' or '.join(meant)}"
    listed = ", ".join(names)
    if len(listed) <= _LISTED:
        return f"there are {listed}"
    nearest = ", ".join(get_close_matches(name, names, cutoff=0.0))
    return f"the nearest of {len(names)} are {nearest}"


def _check_delay(key: str, value: Any) -> None:
    pair = value if isinstance(value, tuple) else (value, value)
    right = len(pair) == 2 and all(map(is_number, pair)) and 0 <= pair[0] <= pair[1] <= _MOST
    expect(right, key, value, f"milliseconds up to {_MOST}, or [shortest, longest]")


def _check_number(key: str, value: Any) -> None:
    if key in _POSITIVE or key == "duration":
        right = is_number(value) and _LEAST <= value <= _MOST
        expect(right, key, value, f"a number above 0, {_LEAST:f} to {_MOST}")
    else:
        right = is_number(value) and 0 <= value <= _MOST
        expect(right, key, value, f"a number from 0 on, up to {_MOST}")


def _whole(value: Any, low: int, high: int) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def _check_axes(axes: Any) -> None:
    for robot in {axis.robot for axis in axes} | {1}:
        count = sum(axis.robot == robot for axis in axes)
        expect(1 <= count <= 6, "axes", count, f"1 to 6 for robot {robot}")
    for axis in axes:
        for name in _POSITIVE:
            _check_number(name, getattr(axis, name))
        expect(1 <= axis.robot <= 4, "robot", axis.robot, "1 to 4")
        for name in ("type", "origin_method"):
            check_value(name, "str", getattr(axis, name))
        check_value("motor_rotation", "int", axis.motor_rotation)
        check_value("workpiece", "int | None", axis.workpiece)
        expect(axis.soft_low < axis.soft_high, "soft_low", axis.soft_low, "below soft_high")
