"""Checks of the values of configuration keys."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from datetime import datetime
from typing import Any

from rcx_harness.robot.program.checks import problems
from rcx_harness.robot.program.code import in_program, program_code
from rcx_harness.robot.stored import (
    AXES,
    COUNTS,
    PALLET_POINTS,
    QUANTITIES,
    ROBOT_PARAMETERS,
    ROBOTS,
    Pallet,
    Point,
    fits_integer,
    parameter_names,
    parameter_ranges,
    single,
    variable_number,
)
from rcx_harness.spec.robots import robot_models
from rcx_harness.spec.wire import AREA_SIZES
from structured_text.errors import InputError, near
from structured_text.output.toml_files import check_keys

__all__ = [
    "AREA_HINT",
    "CHOICES",
    "RANGES",
    "STORED",
    "alarm_code",
    "check_programs",
    "check_stored",
    "check_value",
    "is_number",
    "is_whole",
    "same_name",
    "shown",
]

#: The hint of a message, with an example of a work area.
AREA_HINT = "Feeder = [[100, 200], [180, 260]], two corners X, Y or X, Y, Z in mm"
_LONGEST_NAME = 40
#: The keys of a robot file that contain stored data.
STORED = ("points", "comments", "pallets", "shifts", "hands", "variables", "parameters")

#: The pattern of program names that fit into a remote command (guide, 4.6.1).
_NAME = re.compile("[A-Z0-9_]+")
CHOICES = {
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
    "plain_variables": ("real", "integer"),
    "origin_method": ("sensor", "stroke_end", "mark"),
}
RANGES = {
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
    "program_statements": (1, 10_000),
    "program_stack": (1, 1000),
    "tcounter_ms": (1, 1000),
}
_PROGRAMS = 100
#: The allowed item numbers of the real time output (guide, 4.9.1).
_ITEMS = range(1, 46)
_SLOTS = 4
#: Keys of alarms that may be empty. An empty key means that no alarm is raised.
_NO_ALARM = ("power_on_alarm", "main_power_alarm", "undefined_data_alarm")
#: The texts of hints: allowed values of a key with one alarm, and of a key with several alarms.
_ALARMS = ('group and category as "12.600"', 'a list of alarms as ["12.600"]')
_POSITIVE = ("pulses_per_mm", "max_speed", "max_acceleration")
_INT32 = (-(2**31), 2**31 - 1)
#: The limits of a positive number. The largest number is a year in milliseconds.
_LEAST, _MOST = 1e-6, 365 * 86_400_000
#: Greatest length of a value in a message [characters].
_SHOWN = 80


def check_value(key: str, declared: str, value: Any) -> None:
    """Raise InputError if the value is not allowed for the key of a robot file.

    `declared` is the text of the field's type annotation.
    """
    if key == "robot" and declared != "int":
        _check_models(key, value)
    elif key in CHOICES:
        choices = CHOICES[key]
        right = value in choices and type(value) is type(choices[0])
        _expect(right, key, value, " or ".join(map(str, choices)))
    elif declared == "Delay":
        _check_delay(key, value)
    elif declared == "bool":
        _expect(isinstance(value, bool), key, value, "true or false")
    elif declared == "int | None" and value is None:
        pass
    elif declared in ("int", "int | None"):
        low, high = RANGES.get(key, _INT32)
        _expect(is_whole(value, low, high), key, value, f"{low} to {high}")
    elif declared == "float":
        _check_number(key, value)
    elif key.endswith(("_alarm", "_alarms")):
        listed = declared != "str"
        _expect(isinstance(value, tuple if listed else str), key, value, _ALARMS[listed])
        for number in value if listed else (value,):
            if number != "" or key not in _NO_ALARM:
                alarm_code(number, key)
    elif key == "clock":
        _expect(_is_moment(value), key, value, 'date and time as "2014-01-01 10:59:59"')
    elif declared == "str":
        _expect(isinstance(value, str), key, value, "a text")
    elif key == "axes":
        _check_axes(value)
    elif key == "scara_robots":
        right = isinstance(value, tuple) and all(is_whole(robot, 1, 4) for robot in value)
        _expect(right, key, value, "a list of robot numbers 1 to 4")
    elif key == "option_slots":
        units = value if isinstance(value, tuple) else ()
        right = len(units) == _SLOTS and all(is_whole(unit, 0, 0xFFFF) for unit in units)
        _expect(right, key, value, f"{_SLOTS} unit numbers, such as [0x0401, 0, 0, 0]")
    elif key == "real_time_items":
        _check_items(key, value)
    elif key == "work_areas":
        _check_areas(key, value)
    elif key == "programs":
        _expect(len(value) > 0, key, value, "at least one program")
        _expect(len(value) <= _PROGRAMS, key, f"{len(value)} tables", f"{_PROGRAMS} at most")


def _check_areas(key: str, value: Any) -> None:
    for name, corners in value.items():
        short = isinstance(name, str) and 0 < len(name) <= _LONGEST_NAME and name.isprintable()
        _expect(short, key, name, f"names of 1 to {_LONGEST_NAME} characters")
        pair = isinstance(corners, tuple) and len(corners) == 2
        right = pair and all(
            isinstance(corner, tuple) and len(corner) in (2, 3) and all(map(is_number, corner))
            for corner in corners
        )
        _expect(right and len(corners[0]) == len(corners[1]), f"{key}.{name}", corners, AREA_HINT)


def check_stored(key: str, value: Any, axes: int) -> None:
    """Raise InputError if the stored data of a robot file are invalid."""
    seen: set[int | None] = set()
    for number, entry in value.items():
        if key == "variables":
            _check_variable(number, entry)
            one = variable_number(number)
            if one in seen:
                hint = "remove one of them"
                raise InputError(f"'variables.{number}' is given twice", hint=hint)
            seen.add(one)
        elif key == "parameters":
            _check_parameter(number, entry, axes)
        elif key == "hands":
            robot, hand = number
            name = f"hands.{robot}.{hand}"
            _expect(is_whole(robot, 1, ROBOTS), name, robot, f"robot 1 to {ROBOTS}")
            _check_place(name, "hands", hand)
            _check_wire(name, entry.data, 4)
            _expect(is_whole(entry.data[3], 0, 1), name, entry.data[3], "data 4 is 0 or 1")
        else:
            name = f"{key}.{number}"
            _check_place(name, key, number)
            _CHECKS[key](name, entry)


def check_programs(programs: Any, size: int, plain: str) -> None:
    """Raise InputError if a program is invalid for areas of `size` bytes.

    Args:
        programs: RobotProgram objects.
        size: Number of bytes of each area, 48 or 256.
        plain: Type of variables without a type character, from the key `plain_variables`.
    """
    seen = set[str]()
    for program in programs:
        _expect_steps(program.steps)
        named = isinstance(program.name, str) and _NAME.fullmatch(program.name) is not None
        _expect(named, "name", program.name, "upper case letters, digits and _")
        if program.name in seen and program.name != type(program).name:  # not the default
            raise same_name(program.name)
        seen.add(program.name)
    names = [program.name for program in programs]
    for program in programs:
        code = program_code(program, plain)
        for error in problems(code, size, names):
            raise in_program(program, error)


def _expect_steps(steps: Any) -> None:
    texts = isinstance(steps, tuple) and all(isinstance(step, str) for step in steps)
    _expect(texts, "steps", steps, 'a list of texts, such as ["WAIT SI(20)=1"]')


def same_name(name: str) -> InputError:
    """Return the error for two programs with the same name.

    Remote commands select programs by name, so names must be unique.
    """
    return InputError(
        f"'programs' has two programs named {name}", hint="give each program its own name"
    )


def alarm_code(number: Any, key: str = "alarm") -> tuple[int, int]:
    """Return the group and the category of an alarm number.

    Raises:
        InputError: the text is not an alarm number like `"12.600"`.
    """
    match = re.fullmatch(r"(\d{1,5})\.(\d{1,5})", number) if isinstance(number, str) else None
    code = (int(match[1]), int(match[2])) if match else (-1, -1)
    fits = all(0 <= part <= 0xFFFF for part in code)
    _expect(fits, key, number, 'group and category as "12.600"')
    return code


def _expect(condition: bool, key: str, value: Any, allowed: str) -> None:
    """Raise InputError for the value of a key if the condition `holds` is false."""
    if not condition:
        raise InputError(f"'{key}' cannot be {shown(value)}", hint=f"use {allowed}")


def shown(value: Any) -> str:
    """Return the text of a value for a message; a long text is shortened."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to print integers with more than 4300 digits
        return "a number with thousands of digits"
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def is_number(value: Any) -> bool:
    """Return whether the value is a finite number."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < math.inf


def is_whole(value: Any, low: float = -math.inf, high: float = math.inf) -> bool:
    """Return whether the value is an integer from `low` to `high`."""
    return isinstance(value, int) and not isinstance(value, bool) and low <= value <= high


def _check_delay(key: str, value: Any) -> None:
    pair = value if isinstance(value, tuple) else (value, value)
    right = len(pair) == 2 and all(map(is_number, pair)) and 0 <= pair[0] <= pair[1] <= _MOST
    _expect(right, key, value, f"milliseconds up to {_MOST}, or [shortest, longest]")


def _check_number(key: str, value: Any) -> None:
    if key in _POSITIVE or key == "duration":
        right = is_number(value) and _LEAST <= value <= _MOST
        _expect(right, key, value, f"a number above 0, {_LEAST:f} to {_MOST}")
    else:
        right = is_number(value) and 0 <= value <= _MOST
        _expect(right, key, value, f"a number from 0 on, up to {_MOST}")


def _check_models(key: str, value: Any) -> None:
    names = value if isinstance(value, tuple) else (value,)
    texts = all(isinstance(name, str) for name in names) and len(names) <= ROBOTS
    _expect(texts, key, value, f'a model such as "YK400XE", or a list of {ROBOTS} at most')
    for name in names:
        if name not in robot_models():
            raise InputError(f"'{key}' cannot be {shown(name)}", hint=near(name, robot_models()))


def _check_axes(axes: Any) -> None:
    for robot in {axis.robot for axis in axes} | {1}:
        count = sum(axis.robot == robot for axis in axes)
        _expect(1 <= count <= 6, "axes", count, f"1 to 6 for robot {robot}")
    for axis in axes:
        for name in _POSITIVE:
            _check_number(name, getattr(axis, name))
        _expect(1 <= axis.robot <= 4, "robot", axis.robot, "1 to 4")
        for name in ("type", "origin_method"):
            check_value(name, "str", getattr(axis, name))
        check_value("motor_rotation", "int", axis.motor_rotation)
        check_value("workpiece", "int | None", axis.workpiece)
        _expect(axis.soft_low < axis.soft_high, "soft_low", axis.soft_low, "below soft_high")


def _check_items(key: str, value: Mapping[int, Any]) -> None:
    for number, name in value.items():
        _expect(number in _ITEMS, key, number, f"an item number, {_ITEMS[0]} to {_ITEMS[-1]}")
        if name not in QUANTITIES:
            hint = near(name, QUANTITIES) if isinstance(name, str) else ", ".join(QUANTITIES)
            raise InputError(f"'{key}' cannot have {name!r}", hint=hint)


def _is_moment(value: Any) -> bool:
    try:
        return 2000 <= datetime.strptime(value, "%Y-%m-%d %H:%M:%S").year <= 2099
    except (TypeError, ValueError):
        return False


def _check_place(name: str, key: str, number: Any) -> None:
    right = is_whole(number) and 0 <= number < COUNTS[key]
    _expect(right, name, number, f"0 to {COUNTS[key] - 1}")


def _check_point(name: str, point: Point) -> None:
    _check_wire(name, point.data, AXES)
    _expect(is_whole(point.hand, 0, 2), f"{name}.hand", point.hand, "hand 0, 1 or 2")
    for arm, turn in (("arm1", point.arm1), ("arm2", point.arm2)):
        _expect(is_whole(turn, -1, 1), f"{name}.{arm}", turn, "arm rotation -1, 0 or 1")


def _check_comment(name: str, text: str) -> None:
    right = len(text) <= 16 and all(" " <= character <= "~" for character in text)
    _expect(right, name, text, "up to 16 characters from 16#20 to 16#7E")


def _check_pallet(name: str, pallet: Pallet) -> None:
    for count in (pallet.nx, pallet.ny, pallet.nz, pallet.count):
        _expect(is_whole(count, 1, 32767), name, count, "1 to 32767 work positions, also in all")
    last = COUNTS["points"] - PALLET_POINTS
    _expect(is_whole(pallet.first, 0, last), name, pallet.first, f"first point 0 to {last}")


_CHECKS: Mapping[str, Callable[[str, Any], None]] = {
    "points": _check_point,
    "comments": _check_comment,
    "pallets": _check_pallet,
    "shifts": lambda name, shift: _check_wire(name, shift, 4),
}


def _check_variable(name: str, value: Any) -> None:
    number = variable_number(name)
    _expect(number is not None, "variables", name, "SGI0 to SGI31, SGR0 to SGR31")
    if name.startswith("SGI"):
        _expect(is_whole(value) and fits_integer(value), name, value, "a 32 bit integer")
    else:
        right = is_number(value) and abs(single(value)) < float("inf")
        _expect(right, name, value, "a number of single precision")


def _check_parameter(name: str, value: Any, axes: int) -> None:
    known = tuple(parameter_names().values())
    check_keys([name], known, within=" in [parameters]")
    low, high = parameter_ranges()[name]
    each = value if isinstance(value, tuple) else (value,)
    for one in each:
        _expect(is_whole(one) and low <= one <= high, name, one, f"{low} to {high}")
    count = ROBOTS if name in ROBOT_PARAMETERS else axes
    owner = "robot" if name in ROBOT_PARAMETERS else "axis"
    listed = not isinstance(value, tuple) or len(value) == count
    _expect(listed, name, value, f"one number, or {count}: one per {owner}")


def _check_wire(name: str, data: Any, count: int) -> None:
    _expect(len(data) == count, name, data, f"{'six' if count == AXES else 'four'} numbers")
    for value in data:
        _expect(is_whole(value) and fits_integer(value), name, value, "32 bit numbers")
