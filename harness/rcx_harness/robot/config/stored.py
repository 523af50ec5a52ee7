"""What a robot file presets of the stored data: how it is written, and what it may be.

`[points.19]` with `mm` or `pulses`, `hand`, `arm1`, `arm2`; `[comments]` with `50 = "WAIT ORG"`;
`[pallets.10]` with `positions = [10, 15, 1]` and `first_point`; `[shifts]` with
`5 = [10.0, -20.0, 5.0, -18.0]` in mm; `[hands.1]` of robot 1 with `3 = [10000, -2000, 5000, 0]` as
on the wire; `[variables]` with `SGI5 = 50`; `[parameters]` with `ACCEL = 80` or one value per axis.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config.checks import expect, is_number, near
from rcx_harness.robot.stored import (
    AXES,
    COUNTS,
    PALLET_POINTS,
    ROBOT_PARAMETERS,
    ROBOTS,
    Hand,
    Pallet,
    Point,
    fits_integer,
    parameter_names,
    parameter_ranges,
    single,
    variable_number,
)

__all__ = ["STORED", "check_stored", "read_stored"]

STORED = ("points", "comments", "pallets", "shifts", "hands", "variables", "parameters")
_SCALE = {"mm": 1000, "pulses": 1}


def read_stored(key: str, value: Any) -> dict[Any, Any]:
    """One of the STORED keys of a robot file, as RobotConfig wants it.

    Raises:
        InputError: it is not written as the module's head says; the key is in single quotes.
    """
    tables = {"points": "[points.19]", "pallets": "[pallets.10]", "hands": "[hands.1]"}
    if not isinstance(value, dict):
        kind = "tables" if key in tables else "a table"
        raise InputError(f"'{key}' must be {kind}", hint=f"write {tables.get(key, f'[{key}]')}")
    if key in ("variables", "parameters"):
        return {name: tuple(v) if isinstance(v, list) else v for name, v in value.items()}
    if key == "hands":
        return dict(
            pair for robot, hands in value.items() for pair in _hands(f"hands.{robot}", hands)
        )
    return {
        _number(key, number): _READERS[key](f"{key}.{number}", v) for number, v in value.items()
    }


def check_stored(key: str, value: Any, axes: int) -> None:
    """Refuse stored data that no controller could have.

    Args:
        key: One of STORED.
        value: What RobotConfig holds under that key.
        axes: How many axes the controller has.

    Raises:
        InputError: the key and what may stand there.
    """
    for number, entry in value.items():
        if key == "variables":
            _check_variable(number, entry)
        elif key == "parameters":
            _check_parameter(number, entry, axes)
        elif key == "hands":
            robot, hand = number
            name = f"hands.{robot}.{hand}"
            expect(1 <= robot <= ROBOTS, name, robot, f"robot 1 to {ROBOTS}")
            _check_number(name, "hands", hand)
            _check_wire(name, entry.data, 4)
            expect(entry.data[3] in (0, 1), name, entry.data[3], "data 4 is 0 or 1")
        else:
            name = f"{key}.{number}"
            _check_number(name, key, number)
            _CHECKS[key](name, entry)


def _number(key: str, text: str) -> int:
    if not text.isdecimal() or int(text) >= COUNTS[key]:
        what = f"'{key}.{text}' is not a {key[:-1]}"
        raise InputError(what, hint=f"write [{key}.0] to [{key}.{COUNTS[key] - 1}]")
    return int(text)


def _point(key: str, entry: Any) -> Point:
    _known(key, entry, ("mm", "pulses", "hand", "arm1", "arm2"))
    given = [unit for unit in _SCALE if unit in entry]
    if len(given) != 1:
        raise InputError(f"'{key}' needs either mm = [...] or pulses = [...]")
    data = _numbers(key, entry[given[0]], AXES, _SCALE[given[0]], f"numbers in {given[0]}")
    rest = {name: value for name, value in entry.items() if name not in _SCALE}
    return Point(data, mm=given[0] == "mm", **rest)


def _comment(key: str, entry: Any) -> str:
    if not isinstance(entry, str):
        raise InputError(f"'{key}' must be a text", hint='write 50 = "WAIT ORG" in [comments]')
    return entry


def _pallet(key: str, entry: Any) -> Pallet:
    _known(key, entry, ("positions", "first_point"))
    positions, first = entry.get("positions"), entry.get("first_point")
    three = isinstance(positions, list) and len(positions) == 3 and all(map(_is_whole, positions))
    if not three or not _is_whole(first):
        raise InputError(f"'{key}' needs positions = [nx, ny, nz] and first_point = number")
    nx, ny, nz = positions
    return Pallet(nx, ny, nz, first)


def _shift(key: str, entry: Any) -> tuple[int, ...]:
    return _numbers(key, entry, 4, 1000, "numbers in mm")


def _hands(key: str, entry: Any) -> list[tuple[tuple[int, int], Hand]]:
    robot = key.partition(".")[2]
    if not robot.isdecimal() or not isinstance(entry, dict):
        raise InputError(f"'{key}' is not a robot's table", hint="write [hands.1] to [hands.4]")
    hands = []
    for number, data in entry.items():
        name, what = f"{key}.{number}", "integers as on the wire"
        wire = _numbers(name, data, 4, 1, what)
        if not all(map(_is_whole, data)):
            raise InputError(f"'{name}' needs at most 4 {what}")
        hands.append(((int(robot), _number("hands", number)), Hand(wire)))  # type: ignore[arg-type]
    return hands


_READERS: dict[str, Callable[[str, Any], Any]] = {
    "points": _point,
    "comments": _comment,
    "pallets": _pallet,
    "shifts": _shift,
}


def _known(key: str, entry: Any, known: tuple[str, ...]) -> None:
    if not isinstance(entry, dict):
        raise InputError(f"'{key}' must be a table", hint=f"write [{key}]")
    for name in entry:
        if name not in known:
            raise InputError(f"unknown key '{name}' in '{key}'", hint=near(name, known))


def _numbers(key: str, value: Any, most: int, scale: int, what: str) -> tuple[int, ...]:
    if not isinstance(value, list) or len(value) > most or not all(map(is_number, value)):
        raise InputError(f"'{key}' needs at most {most} {what}")
    return tuple([round(part * scale) for part in value] + [0] * (most - len(value)))


def _check_number(name: str, key: str, number: Any) -> None:
    right = _is_whole(number) and 0 <= number < COUNTS[key]
    expect(right, name, number, f"0 to {COUNTS[key] - 1}")


def _check_point(name: str, point: Point) -> None:
    _check_wire(name, point.data, AXES)
    expect(point.hand in (0, 1, 2), name, point.hand, "hand 0, 1 or 2")
    for turn in (point.arm1, point.arm2):
        expect(turn in (-1, 0, 1), name, turn, "arm rotation -1, 0 or 1")


def _check_comment(name: str, text: str) -> None:
    right = len(text) <= 16 and all(" " <= character <= "~" for character in text)
    expect(right, name, text, "up to 16 characters from 16#20 to 16#7E")


def _check_pallet(name: str, pallet: Pallet) -> None:
    for count in (pallet.nx, pallet.ny, pallet.nz, pallet.count):
        expect(1 <= count <= 32767, name, count, "1 to 32767 work positions, also in all")
    last = COUNTS["points"] - PALLET_POINTS
    expect(0 <= pallet.first <= last, name, pallet.first, f"first point 0 to {last}")


def _check_shift(name: str, shift: tuple[int, ...]) -> None:
    _check_wire(name, shift, 4)


_CHECKS: Mapping[str, Callable[[str, Any], None]] = {
    "points": _check_point,
    "comments": _check_comment,
    "pallets": _check_pallet,
    "shifts": _check_shift,
}


def _check_variable(name: str, value: Any) -> None:
    number = variable_number(name)
    expect(number is not None, "variables", name, "SGI0 to SGI31, SGR0 to SGR31")
    if name.startswith("SGI"):
        expect(_is_whole(value) and fits_integer(value), name, value, "a 32 bit integer")
    else:
        right = is_number(value) and abs(single(value)) < float("inf")
        expect(right, name, value, "a number of single precision")


def _check_parameter(name: str, value: Any, axes: int) -> None:
    known = tuple(parameter_names().values())
    if name not in known:
        raise InputError(f"unknown key '{name}' in [parameters]", hint=near(name, known))
    low, high = parameter_ranges()[name]
    each = value if isinstance(value, tuple) else (value,)
    for one in each:
        expect(_is_whole(one) and low <= one <= high, name, one, f"{low} to {high}")
    count = ROBOTS if name in ROBOT_PARAMETERS else axes
    owner = "robot" if name in ROBOT_PARAMETERS else "axis"
    listed = not isinstance(value, tuple) or len(value) == count
    expect(listed, name, value, f"one number, or {count}: one per {owner}")


def _check_wire(name: str, data: Any, count: int) -> None:
    expect(len(data) == count, name, data, f"{'six' if count == AXES else 'four'} numbers")
    for value in data:
        expect(_is_whole(value) and fits_integer(value), name, value, "32 bit numbers")


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)
