"""The separate files that a robot file names: programs (.PGM) and files with all data (.ALL)."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.robot.program import read_program, text_of
from rcx_harness.robot.program.all_file import read_all
from rcx_harness.robot.stored import PARAMETER_DEFAULTS, ROBOT_PARAMETERS, ROBOTS
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["Brought", "brought", "named_by"]

#: The key of a robot file that names a file with all data of a controller.
_DATA_FILE = "data_file"


@dataclass(frozen=True)
class Brought:
    """The content of the files that a robot file names.

    Attributes:
        programs: The entries of `[[programs]]` with the texts of their files.
        data: Stored data by their keys of RobotConfig.
        places: Maps the name of a program to the absolute path of its file, and to the number of
            lines of that file before the program.
        parameters: Maps a parameter to its values by robot or axis of the controller (from 1; 0:
            all robots or axes).
    """

    programs: tuple[Mapping[str, Any], ...] = ()
    data: Mapping[str, Mapping[Any, Any]] = field(default_factory=dict)
    places: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    parameters: Mapping[str, Mapping[int, int]] = field(default_factory=dict)

    def listed(self, axes: int) -> dict[str, tuple[int, ...]]:
        """Return the parameters, each with one value for each axis or for each robot.

        If a value is missing in the file, the factory value is used.
        """
        listed = {}
        for name, given in self.parameters.items():
            count = ROBOTS if name in ROBOT_PARAMETERS else axes
            default = given.get(0, PARAMETER_DEFAULTS.get(name, 0))
            listed[name] = tuple(given.get(place, default) for place in range(1, count + 1))
        if "WEIGHTG" in listed:  # WEIGHT and WEIGHTG both set the payload
            listed.pop("WEIGHT", None)
        return listed


def brought(file: Path, table: dict[str, Any]) -> Brought:
    """Read the files that a robot file names, and remove `data_file` from `table`.

    Raises:
        InputError: a file cannot be read, or contains an error. Only the first error is raised.
    """
    own = table.get("programs", [])
    own = own if isinstance(own, list) and all(isinstance(one, dict) for one in own) else []
    programs = [_with_text(file, entry) for entry in own]
    places = {
        str(made["name"]): (os.path.abspath(file.parent / made["file"]), 0)
        for made in programs
        if isinstance(made.get("file"), str) and made["file"]
    }
    data: dict[str, Mapping[Any, Any]] = {}
    parameters: Mapping[str, Mapping[int, int]] = {}
    if (name := table.pop(_DATA_FILE, None)) is not None:
        if not isinstance(name, str) or not name:
            hint = 'write data_file = "CELL.ALL"'
            raise InputError(f"'{_DATA_FILE}' must be the name of a file", file=file, hint=hint)
        content = read_all(file.parent / name)
        mine = {entry.get("name") for entry in programs}
        for one in content.programs:
            _check(file.parent / name, one.text, one.offset)
            if one.name not in mine:
                programs.append({"name": one.name, "text": one.text})
                places[one.name] = os.path.abspath(file.parent / name), one.offset
        keys = ("points", "comments", "shifts", "hands", "pallets", "variables")
        data = {key: getattr(content, key) for key in keys}
        parameters = content.parameters
    return Brought(tuple(programs), data, places, parameters)


def named_by(file: Path) -> list[Path]:
    """Return the paths of the files that a robot file names: programs (.PGM) and data (.ALL).

    Raises:
        InputError: the robot file cannot be read.
    """
    table = load_toml(file)
    entries = table.get("programs", [])
    given = [one.get("file") for one in entries if isinstance(one, dict)]
    names = [*given, table.get(_DATA_FILE)] if isinstance(entries, list) else []
    return [file.parent / name for name in names if isinstance(name, str) and name]


def _with_text(file: Path, entry: dict[str, Any]) -> dict[str, Any]:
    name = entry.get("file", "")
    if not isinstance(name, str) or not name:
        return entry
    if clash := [key for key in ("text", "steps", "duration") if key in entry]:
        raise InputError(f"'{clash[0]}' and 'file' exclude each other", file=file)
    text = text_of(file.parent / name)
    if not text.strip():
        hint = "write its statements, or remove the program from the robot file"
        raise InputError("the program has no statement", file=file.parent / name, hint=hint)
    _check(file.parent / name, text)
    return {"name": _name(name), **entry, "text": text}


def _check(path: Path, text: str, offset: int = 0) -> None:
    """Raise the first error of a program. The program begins in line `offset` + 1 of its file."""
    _, errors = read_program(text, path)
    if errors:
        error = errors[0]
        raise InputError(error.message, file=path, line=(error.line or 0) + offset, hint=error.hint)


def _name(file: str) -> str:
    """Return the name of a program from its file name: upper case letters, digits and _."""
    return re.sub(r"[^A-Z0-9_]", "_", Path(file).stem.upper())
