"""What a virtual controller is like: all its properties in one value, and how a file gives them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.robot.config import sections
from rcx_harness.robot.config.checks import check_programs, check_value, near
from rcx_harness.robot.config.sections import Axis, RobotProgram
from rcx_harness.robot.config.stored import STORED, check_stored, read_stored
from rcx_harness.spec import load_toml

__all__ = ["RobotConfig"]

#: The keys that are lists of tables, and what each table is.
_TABLES: dict[str, type] = {"axes": Axis, "programs": RobotProgram}


@dataclass(frozen=True)
class RobotConfig(  # fields of the last one come first
    sections.Alarms,
    sections.References,
    sections.Motion,
    sections.Commands,
    sections.Programs,
    sections.DedicatedSignals,
    sections.Timing,
    sections.PowerAndLink,
    sections.StoredData,
    sections.Robot,
):
    """A virtual controller's properties; immutable, shared between snapshots."""

    def __post_init__(self) -> None:
        """Refuse values that no controller could have (InputError)."""
        for entry in fields(self):
            if entry.name in STORED:
                check_stored(entry.name, getattr(self, entry.name), len(self.axes))
            else:
                check_value(entry.name, str(entry.type), getattr(self, entry.name))
        check_programs(self.programs, self.size)

    def __deepcopy__(self, memo: object) -> RobotConfig:
        """Itself: it never changes, and snapshots are cheaper for it."""
        return self

    def axes_of(self, robot: int) -> tuple[int, ...]:
        """Indices into `axes` of robot 1 to 4; robot 0 is robot 1."""
        wanted = robot or 1
        return tuple(k for k, axis in enumerate(self.axes) if axis.robot == wanted)

    @property
    def workpieces(self) -> Mapping[int, int]:
        """Where something stands that PUSH meets: index into `axes` to pulses."""
        given = ((index, axis.workpiece) for index, axis in enumerate(self.axes))
        return {index: place for index, place in given if place is not None}

    @classmethod
    def load(cls, path: str | Path) -> RobotConfig:
        """Read a robot file: keys as the fields of this class.

        Axes are `[[axes]]` tables, programs `[[programs]]` tables; config/stored.py says how points
        and the other stored data are written.

        Raises:
            InputError: unreadable file, unknown key (near names are given) or impossible value.
        """
        file = Path(path)
        table = load_toml(file)
        try:
            return cls(**{key: _value(cls, key, value) for key, value in table.items()})
        except InputError as error:
            line = _line_of(file, error.message)
            raise InputError(error.message, file=file, line=line, hint=error.hint) from error


def _value(kind: type[Any], key: str, value: Any) -> Any:
    """A TOML value as the field `key` of the data class `kind` wants it (InputError)."""
    _known(kind, key)
    if key in _TABLES:
        if not isinstance(value, list) or not all(isinstance(entry, dict) for entry in value):
            raise InputError(f"'{key}' must be tables", hint=f"write [[{key}]]")
        return tuple(_table(_TABLES[key], entry, key) for entry in value)
    if key in STORED:
        return read_stored(key, value)
    if key == "real_time_items":
        return _items(key, value)
    return tuple(value) if isinstance(value, list) else value


def _table(kind: type[Any], entry: dict[str, Any], key: str) -> Any:
    values = {name: tuple(v) if isinstance(v, list) else v for name, v in entry.items()}
    for name, value in values.items():
        _known(kind, name, f" in [[{key}]]")
        declared = next(str(one.type) for one in fields(kind) if one.name == name)
        check_value(name, declared, value)
    return kind(**values)


def _items(key: str, value: Any) -> dict[int, str]:
    """`real_time_items`: a table of item numbers and names."""
    if not isinstance(value, dict) or not all(number.isdecimal() for number in value):
        raise InputError(f"'{key}' must be a table", hint=f'write 13 = "motor_duty" in [{key}]')
    return {int(number): name for number, name in value.items()}


def _known(kind: type[Any], key: str, where: str = "") -> None:
    names = [entry.name for entry in fields(kind)]
    if key not in names:
        raise InputError(f"unknown key '{key}'{where}", hint=near(key, names))


def _line_of(file: Path, message: str) -> int | None:
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
