"""The user's requirements on a cell: operator actions, faults, and properties."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Entry, Stimulus
from rcx_harness.cell.surroundings import OPPOSITES
from rcx_harness.verify.handshakes.stable import stable_in
from rcx_harness.verify.handshakes.standstill import standstills_in
from rcx_harness.verify.properties import Declared, declared_in, from_python
from rcx_harness.verify.recovery import Recovery, recovery_of
from structured_text.bench.stimulus import typed
from structured_text.errors import InputError, near
from structured_text.language.types import ElementaryType
from structured_text.output.reading import check_file
from structured_text.output.toml_files import check_keys, line_of, load_toml, toml_text
from structured_text.output.units import parse_us

__all__ = ["FAULTS", "Demands"]

#: Faults that can occur, by the names of events.
FAULTS = (
    *(one for one in OPPOSITES if one != "warning"),
    *("power_cycle", "alarm", "packets_lost", "packets_late", "packets_doubled", "plc_overrun"),
)
#: The TOML keys of properties. Several files may contain them.
_PROPERTIES = ("always", "eventually", "sometimes", "stable", "deadlock")
_KEYS = ("length", "operator", "faults", *_PROPERTIES, "recover")
#: The largest delay of a packet [us]. With the default of FB_WriteArea.Margin (150 ms), a delay up
#: to this value is harmless, even if all packets until the connection's time-out are lost
#: (docs/explanation/scan-model.md).
_LATE_US = 40_000
_LENGTH_US = 12_000_000


@dataclass(frozen=True)
class Demands:
    """The demands on a cell, in addition to its program.

    Attributes:
        buttons: Inputs that are pressed and released.
        switches: Inputs that are switched.
        values: Variables that are set, each with its possible values.
        faults: Names from `FAULTS`.
        late_us: The largest delay of a packet [us].
        length_us: The longest time of a storm [us].
        properties: Conditions that always hold, or that must hold within a time.
        recovery: The demanded recovery; None: no recovery is demanded.
        start: Entries of a good run that starts the cell. If empty, the recovery starts the cell.
        start_file: The file of the good run.
        places: File and line of each input of the operator, if known.
    """

    buttons: tuple[str, ...] = ()
    switches: tuple[str, ...] = ()
    values: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    faults: tuple[str, ...] = FAULTS
    late_us: int = _LATE_US
    length_us: int = _LENGTH_US
    properties: tuple[Declared, ...] = ()
    recovery: Recovery | None = None
    start: tuple[Entry, ...] = ()
    start_file: str = ""
    places: Mapping[str, tuple[str, int | None]] = field(default_factory=dict)

    @classmethod
    def load(cls, files: Sequence[Path], stimulus: Path | None = None) -> Demands:
        """Read files of demands: TOML, or Python with properties.

        Each table may occur in one file only. `stimulus` is a good run. If no file names inputs,
        the BOOL inputs in the good run are the operator's switches.
        """
        tables: dict[str, tuple[Any, Path]] = {}
        properties: list[Declared] = []
        for file in files:
            if not os.path.lexists(file):
                raise InputError("no such file", file=file)
            check_file(file)
            if file.suffix == ".py":
                properties += from_python(file)
                continue
            if file.suffix != ".toml":
                raise InputError("is neither a .toml nor a .py file", file=file)
            table = load_toml(file)
            properties += declared_in(table, file)
            properties += [*stable_in(table, file), *standstills_in(table, file)]
            check_keys(table, _KEYS, file=file, every="keys are")
            for key, value in table.items():
                if key in tables and key not in _PROPERTIES:
                    raise InputError(f"{key} is also in {tables[key][1]}", file=file)
                tables[key] = value, file
        _check_names(properties)
        start = tuple(Stimulus.load(stimulus).entries) if stimulus is not None else ()
        made: dict[str, Any] = {"properties": tuple(properties), "start": start}
        made["start_file"] = str(stimulus)
        if "operator" in tables:
            made |= _operator(*tables["operator"])
        elif start:
            made["switches"] = _switches(start)
        if "faults" in tables:
            made |= _faults(*tables["faults"])
        if "length" in tables:
            made["length_us"] = _length(*tables["length"])
        if "recover" in tables:
            value, file = tables["recover"]
            if not isinstance(value, dict):
                raise InputError("recover is not a table", file=file, hint="write [recover]")
            made["recovery"] = recovery_of(value, file)
        return cls(**made)

    def at_home(self, homes: Mapping[str, str]) -> Demands:
        """Return these demands with the original paths; `homes` maps copied files to them."""
        recovery = self.recovery
        if recovery is not None and recovery.file is not None:
            recovery = replace(recovery, file=homes.get(recovery.file, recovery.file))
        return replace(
            self,
            properties=tuple(
                replace(one, home=homes.get(str(one.file))) for one in self.properties
            ),
            recovery=recovery,
            start_file=homes.get(self.start_file, self.start_file),
            places={
                path: (homes.get(file, file), line) for path, (file, line) in self.places.items()
            },
        )

    def check(self, cell: Cell) -> None:
        """Check that the cell has all variables and controllers that the demands name."""
        Stimulus(Path(self.start_file), list(self.start)).check(cell)
        before = cell.program.snapshot()
        for path in (*self.buttons, *self.switches, *self.values):
            try:
                pressed = path in self.buttons or path in self.switches
                if pressed and cell.program.type_of(path) != ElementaryType("BOOL"):
                    raise InputError(f"{path} is not a BOOL", hint="name it under values")
                for value in self.values.get(path, ()):
                    cell.program.write(path, typed(cell, path, value))
            except InputError as error:
                file, line = self.places.get(path, (None, None))
                text = f"[operator]: {error.message}"
                raise InputError(text, file=file, line=line, hint=error.hint) from None
        cell.program.restore(before)


def _check_names(properties: Sequence[Declared]) -> None:
    seen: set[str] = set()
    for one in properties:
        if one.kind in seen:
            text = f"two properties have the name {one.name!r}"
            raise InputError(text, file=one.file, hint="rename one of them")
        seen.add(one.kind)


def _switches(start: Sequence[Entry]) -> tuple[str, ...]:
    found = {
        path: None
        for entry in start
        for path, value in entry.values.items()
        if isinstance(value, bool)
    }
    return tuple(found)


def _operator(table: Any, file: Path) -> dict[str, Any]:
    _check_keys(table, ("buttons", "switches", "values"), "operator", file)
    made: dict[str, Any] = {}
    for key in ("buttons", "switches"):
        names = table.get(key, [])
        if not isinstance(names, list) or not all(isinstance(one, str) for one in names):
            raise InputError(f"[operator]: {key} is not a list of inputs", file=file)
        made[key] = tuple(names)
    values = table.get("values", {})
    if not isinstance(values, dict) or not all(
        isinstance(one, list) and one for one in values.values()
    ):
        hint = 'write values = { "Main.Speed" = [5.0, 50.0] }'
        raise InputError("[operator]: values is not a table of lists", file=file, hint=hint)
    made["values"] = {path: tuple(several) for path, several in values.items()}
    paths = (*made["buttons"], *made["switches"], *values)
    made["places"] = {path: (str(file), _line(file, path)) for path in paths}
    return made


def _line(file: Path, path: str) -> int | None:
    """Return the number of the line below `[operator]` that names an input, or None."""
    told = False
    for number, line in enumerate(toml_text(file).splitlines(), 1):
        told = told or "operator" in line
        if told and re.search(rf"""["']{re.escape(path)}["']""", line):
            return number
    return None


def _faults(table: Any, file: Path) -> dict[str, Any]:
    _check_keys(table, ("only", "leave_out", "late"), "faults", file)
    if "only" in table and "leave_out" in table:
        raise InputError("[faults]: only and leave_out exclude each other", file=file)
    key = "only" if "only" in table else "leave_out"
    names = table.get(key, [])
    if not isinstance(names, list) or not all(isinstance(one, str) for one in names):
        raise InputError(f"[faults]: {key} is not a list of faults", file=file)
    for name in names:
        if name not in FAULTS:
            hint, line = near(name, FAULTS, "faults are"), line_of(file, f"faults.{key}")
            raise InputError(f"[faults]: unknown fault {name!r}", file=file, line=line, hint=hint)
    wanted = key == "only"
    made: dict[str, Any] = {"faults": tuple(one for one in FAULTS if (one in names) == wanted)}
    if "late" in table:
        made["late_us"] = _length(table["late"], file, "[faults]: late")
    return made


def _check_keys(table: Any, keys: Sequence[str], name: str, file: Path) -> None:
    if not isinstance(table, dict):
        raise InputError(f"{name} is not a table", file=file, hint=f"write [{name}]")
    check_keys(table, keys, f"[{name}]", file, every="keys are")


def _length(value: object, file: Path, what: str = "length") -> int:
    if not isinstance(value, str):
        raise InputError(f"{what} is not a text", file=file, hint=f'write {what} = "12s"')
    try:
        length_us = parse_us(value)
    except InputError as error:
        raise InputError(f"{what}: {error.message}", file=file, hint=error.hint) from None
    if not length_us:
        raise InputError(f"{what} is 0", file=file)
    return length_us
