"""The format of a robot file, and its reader.

The keys are the fields of RobotConfig; axes and programs are lists of tables. Stored data:

`[points.19]` with `mm` or `pulses`, `hand`, `arm1`, `arm2`; `[comments]` with `50 = "WAIT ORG"`;
`[pallets.10]` with `positions = [10, 15, 1]` and `first_point`; `[shifts]` with
`5 = [10.0, -20.0, 5.0, -18.0]` in mm; `[hands.1]` of robot 1 with `3 = [10000, -2000, 5000, 0]` as
on the wire; `[variables]` with `SGI5 = 50`; `[parameters]` with `ACCEL = 80` or one value per axis;
`[work_areas]` with `Feeder = [[100, 200], [180, 260]]`, two corners in mm.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from types import MappingProxyType
from typing import Any

from rcx_harness.robot.config.checks import (
    AREA_HINT,
    STORED,
    check_value,
    is_number,
    is_whole,
    same_name,
    shown,
)
from rcx_harness.robot.stored import AXES, COUNTS, Hand, Pallet, Point
from structured_text.errors import InputError
from structured_text.output.toml_files import check_keys

__all__ = ["NO_KEY", "read_value"]

#: Metadata of a field that is not a key of a robot file.
NO_KEY = MappingProxyType({"key": False})

_SCALE = {"mm": 1000, "pulses": 1}
_UNITS = {"mm": "numbers in mm", "pulses": "whole numbers in pulses"}
#: Greatest length of a key in a message [characters], and the end of a shortened key.
_SHOWN, _CUT = 40, "..."
#: Default limit of numbers in keys such as `points.19`. It is larger than the number of any stored
#: data.
_MANY = 100_000
#: Greatest number in stored data, before the check of its range. It is larger than any number on
#: the wire.
_MOST = 2**32


def read_value(kind: type[Any], key: str, value: Any, tables: Mapping[str, type[Any]]) -> Any:
    """Convert a TOML value to the type of the field `key` of the data class `kind`.

    `tables` maps each key that is a list of tables to the class of these tables.
    """
    check_keys([key], [entry.name for entry in fields(kind)])
    if key in tables:
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise InputError(f"'{key}' must be tables", hint=f"write [[{key}]]")
        made = tuple(_table(tables[key], entry, key) for entry in value)
        names = [entry.name for entry in made] if key == "programs" else []
        if twice := [name for number, name in enumerate(names) if name in names[:number]]:
            raise same_name(twice[0])
        return made
    if key in STORED:
        return _stored(key, value)
    if key == "real_time_items":
        return _items(key, value)
    if key == "work_areas":
        return _areas(key, value)
    return tuple(value) if isinstance(value, list) else value


def _table(kind: type[Any], entry: dict[str, Any], key: str) -> Any:
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in entry.items()}
    declared = {one.name: str(one.type) for one in fields(kind) if one.metadata.get("key", True)}
    check_keys(values, declared, within=f" in [[{key}]]")
    for name, value in values.items():
        check_value(name, declared[name], value)
    return kind(**values)


def _items(key: str, value: Any) -> dict[int, str]:
    """Read `real_time_items`: a table of item numbers and names."""
    hint = f'write 13 = "motor_duty" in [{key}]'
    if not isinstance(value, dict):
        raise InputError(f"'{key}' must be a table", hint=hint)
    return dict(_numbered(key, value, "an item number", hint))


def _areas(key: str, value: Any) -> dict[str, Any]:
    """Read `work_areas`: a table of names and pairs of corners."""
    if not isinstance(value, dict):
        raise InputError(f"'{key}' must be a table", hint=f"write {AREA_HINT} in [{key}]")
    return {
        name: tuple(tuple(corner) if isinstance(corner, list) else corner for corner in corners)
        if isinstance(corners, list)
        else corners
        for name, corners in value.items()
    }


def _stored(key: str, value: Any) -> dict[Any, Any]:
    """Convert the value of a stored data key of a robot file to its type in RobotConfig."""
    tables = {"points": "[points.19]", "pallets": "[pallets.10]", "hands": "[hands.1]"}
    if not isinstance(value, dict):
        kind = "tables" if key in tables else "a table"
        raise InputError(f"'{key}' must be {kind}", hint=f"write {tables.get(key, f'[{key}]')}")
    if key in ("variables", "parameters"):
        return {name: tuple(v) if isinstance(v, list) else v for name, v in value.items()}
    if key == "hands":
        robots = _numbered(key, value, "a robot's table", "write [hands.1] to [hands.4]")
        return {
            (robot, number): hand
            for robot, hands in robots
            for number, hand in _hands(robot, hands)
        }
    last = f"write [{key}.0] to [{key}.{COUNTS[key] - 1}]"
    entries = _numbered(key, value, f"a {key[:-1]}", last, COUNTS[key])
    return {number: _READERS[key](f"{key}.{number}", entry) for number, entry in entries}


def _numbered(
    key: str, table: Mapping[str, Any], what: str, hint: str = "", count: int = _MANY
) -> Iterator[tuple[int, Any]]:
    """Yield the entries of a table with numbers as its keys."""
    seen: set[int] = set()
    for text, entry in table.items():
        digits = text.lstrip("0") or "0"
        decimal = text.isascii() and text.isdecimal() and len(digits) <= len(str(count))
        path = f"{key}.{text}" if len(text) <= _SHOWN else f"{key}.{text[:_SHOWN]}{_CUT}"
        if not decimal or int(digits) >= count:
            raise InputError(f"'{path}' is not {what}", hint=hint)
        number = int(digits)
        if number in seen:
            raise InputError(
                f"'{path}' gives {key}.{number} a second time", hint="remove one of them"
            )
        seen.add(number)
        yield number, entry


def _point(key: str, entry: Any) -> Point:
    _check_keys(key, entry, ("mm", "pulses", "hand", "arm1", "arm2"))
    given = [unit for unit in _SCALE if unit in entry]
    if len(given) != 1:
        raise InputError(f"'{key}' needs either mm = [...] or pulses = [...]")
    data = _numbers(key, entry[given[0]], AXES, _SCALE[given[0]], _UNITS[given[0]])
    rest = {name: value for name, value in entry.items() if name not in _SCALE}
    return Point(data, mm=given[0] == "mm", **rest)


def _comment(key: str, entry: Any) -> str:
    if not isinstance(entry, str):
        raise InputError(f"'{key}' must be a text", hint='write 50 = "WAIT ORG" in [comments]')
    return entry


def _pallet(key: str, entry: Any) -> Pallet:
    _check_keys(key, entry, ("positions", "first_point"))
    positions, first = entry.get("positions"), entry.get("first_point")
    three = isinstance(positions, list) and len(positions) == 3 and all(map(is_whole, positions))
    if not three or not is_whole(first):
        raise InputError(f"'{key}' needs positions = [nx, ny, nz] and first_point = number")
    nx, ny, nz = positions
    return Pallet(nx, ny, nz, first)


def _hands(robot: int, entry: Any) -> Iterator[tuple[int, Hand]]:
    key = f"hands.{robot}"
    if not isinstance(entry, dict):
        hint = f"write [{key}], then for example 3 = [10000, -2000, 5000, 0]"
        raise InputError(f"'{key}' must be a table", hint=hint)
    last = f"they are 0 to {COUNTS['hands'] - 1}"
    for number, data in _numbered(key, entry, "a hand", last, COUNTS["hands"]):
        wire = _numbers(f"{key}.{number}", data, 4, 1, "integers as on the wire")
        yield number, Hand(wire)  # type: ignore[arg-type]


_READERS: dict[str, Callable[[str, Any], Any]] = {
    "points": _point,
    "comments": _comment,
    "pallets": _pallet,
    "shifts": lambda key, entry: _numbers(key, entry, 4, 1000, "numbers in mm"),
}


def _check_keys(key: str, entry: Any, known: tuple[str, ...]) -> None:
    if not isinstance(entry, dict):
        raise InputError(f"'{key}' must be a table", hint=f"write [{key}]")
    for name in entry:
        check_keys([name], known, within=f" in '{key}'")


def _numbers(key: str, value: Any, most: int, scale: int, what: str) -> tuple[int, ...]:
    right = is_whole if scale == 1 else is_number
    if not isinstance(value, list) or len(value) > most or not all(map(right, value)):
        raise InputError(f"'{key}' needs at most {most} {what}")
    for part in value:
        if abs(part) > _MOST:
            raise InputError(f"'{key}' cannot be {shown(part)}", hint="use 32 bit numbers")
    return tuple([round(part * scale) for part in value] + [0] * (most - len(value)))
