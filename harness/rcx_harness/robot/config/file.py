"""How a robot file is written, and where in it a mistake stands.

Its keys are the fields of RobotConfig; axes and programs are lists of tables. Stored data:

`[points.19]` with `mm` or `pulses`, `hand`, `arm1`, `arm2`; `[comments]` with `50 = "WAIT ORG"`;
`[pallets.10]` with `positions = [10, 15, 1]` and `first_point`; `[shifts]` with
`5 = [10.0, -20.0, 5.0, -18.0]` in mm; `[hands.1]` of robot 1 with `3 = [10000, -2000, 5000, 0]` as
on the wire; `[variables]` with `SGI5 = 50`; `[parameters]` with `ACCEL = 80` or one value per axis;
`[work_areas]` with `Feeder = [[100, 200], [180, 260]]`, two corners in mm.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config.checks import (
    AREA_HINT,
    STORED,
    check_value,
    is_number,
    is_whole,
    near,
)
from rcx_harness.robot.stored import AXES, COUNTS, Hand, Pallet, Point

__all__ = ["line_of", "read_value"]

_SCALE = {"mm": 1000, "pulses": 1}


def read_value(kind: type[Any], key: str, value: Any, tables: Mapping[str, type[Any]]) -> Any:
    """A TOML value as the field `key` of the data class `kind` wants it.

    Args:
        kind: The class whose fields are the keys.
        key: The key.
        value: The value under that key.
        tables: Classes of the keys that are lists of tables.

    Raises:
        InputError: unknown key, or a value that is written otherwise; the key is in single quotes.
    """
    _known(key, (entry.name for entry in fields(kind)))
    if key in tables:
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise InputError(f"'{key}' must be tables", hint=f"write [[{key}]]")
        return tuple(_table(tables[key], entry, key) for entry in value)
    if key in STORED:
        return _stored(key, value)
    if key == "real_time_items":
        return _items(key, value)
    if key == "work_areas":
        return _areas(key, value)
    return tuple(value) if isinstance(value, list) else value


def line_of(file: Path, message: str) -> int | None:
    """The line with the key that the message has in single quotes, as tomllib does not tell."""
    quoted = re.search(r"'([\w.]+)'", message)
    if not quoted:
        return None
    lines = file.read_text(encoding="utf-8").splitlines()
    key = quoted[1]
    while key:
        pattern = re.compile(rf"^\s*(\[+\s*)?{re.escape(key)}\b")
        for number, line in enumerate(lines, 1):
            if pattern.match(line):
                return number
        key = key.rpartition(".")[0]  # `comments.50` stands in the table [comments]
    return None


def _table(kind: type[Any], entry: dict[str, Any], key: str) -> Any:
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in entry.items()}
    declared = {one.name: str(one.type) for one in fields(kind)}
    for name, value in values.items():
        _known(name, declared, f" in [[{key}]]")
        check_value(name, declared[name], value)
    return kind(**values)


def _items(key: str, value: Any) -> dict[int, str]:
    """`real_time_items`: a table of item numbers and names."""
    if not isinstance(value, dict) or not all(number.isdecimal() for number in value):
        raise InputError(f"'{key}' must be a table", hint=f'write 13 = "motor_duty" in [{key}]')
    return {int(number): name for number, name in value.items()}


def _areas(key: str, value: Any) -> dict[str, Any]:
    """`work_areas`: a table of names and pairs of corners."""
    if not isinstance(value, dict):
        raise InputError(f"'{key}' must be a table", hint=f"write {AREA_HINT} in [{key}]")
    return {
        name: tuple(tuple(corner) if isinstance(corner, list) else corner for corner in corners)
        if isinstance(corners, list)
        else corners
        for name, corners in value.items()
    }


def _known(key: str, known: Iterable[str], where: str = "") -> None:
    names = list(known)
    if key not in names:
        raise InputError(f"unknown key '{key}'{where}", hint=near(key, names))


def _stored(key: str, value: Any) -> dict[Any, Any]:
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


def _number(key: str, text: str) -> int:
    if not text.isdecimal() or int(text) >= COUNTS[key]:
        what = f"'{key}.{text}' is not a {key[:-1]}"
        raise InputError(what, hint=f"write [{key}.0] to [{key}.{COUNTS[key] - 1}]")
    return int(text)


def _point(key: str, entry: Any) -> Point:
    _check_keys(key, entry, ("mm", "pulses", "hand", "arm1", "arm2"))
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
    _check_keys(key, entry, ("positions", "first_point"))
    positions, first = entry.get("positions"), entry.get("first_point")
    three = isinstance(positions, list) and len(positions) == 3 and all(map(is_whole, positions))
    if not three or not is_whole(first):
        raise InputError(f"'{key}' needs positions = [nx, ny, nz] and first_point = number")
    nx, ny, nz = positions
    return Pallet(nx, ny, nz, first)


def _hands(key: str, entry: Any) -> list[tuple[tuple[int, int], Hand]]:
    robot = key.partition(".")[2]
    if not robot.isdecimal() or not isinstance(entry, dict):
        raise InputError(f"'{key}' is not a robot's table", hint="write [hands.1] to [hands.4]")
    hands = []
    for number, data in entry.items():
        name, what = f"{key}.{number}", "integers as on the wire"
        wire = _numbers(name, data, 4, 1, what)
        if not all(map(is_whole, data)):
            raise InputError(f"'{name}' needs at most 4 {what}")
        hands.append(((int(robot), _number("hands", number)), Hand(wire)))  # type: ignore[arg-type]
    return hands


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
        _known(name, known, f" in '{key}'")


def _numbers(key: str, value: Any, most: int, scale: int, what: str) -> tuple[int, ...]:
    if not isinstance(value, list) or len(value) > most or not all(map(is_number, value)):
        raise InputError(f"'{key}' needs at most {most} {what}")
    return tuple([round(part * scale) for part in value] + [0] * (most - len(value)))
