"""Stimulus files (TOML): values to set and events to inject, with their times."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from datetime import timedelta
from typing import Any

from rcx_harness.cell.cell import EVENTS, Cell
from rcx_harness.cell.surroundings import EVENTS as SURROUNDINGS
from rcx_harness.cell.surroundings import check, opposite
from structured_text.bench import stimulus
from structured_text.bench.events import EVENTS as PLC_EVENTS
from structured_text.bench.stimulus import PLC, event_of, listed
from structured_text.errors import InputError
from structured_text.output.units import parse_us

__all__ = ["KEYS", "ROBOT", "Entry", "Stimulus", "entry_text", "stimulus_text"]

#: The value of the key `area` that lets the PLC read the controller's own answer again.
ROBOT = "robot"
#: Keys that an entry of a stimulus file may have.
KEYS = (
    *("time", "set", "robot", "plc", "for", "hold", "release", "area", "connected"),
    *("controller", "expect", "force", "workpieces"),
)
_MOST_DIGITS = 4


@dataclass(frozen=True, eq=False)
class Entry(stimulus.Entry):
    """One `[[at]]` table of a stimulus file.

    Attributes:
        hold: Outputs of the controller that are held at their current values.
        release: Outputs whose hold or force ends, so that the controller determines them again.
        force: Maps an output to the value to which it is forced.
        workpieces: Position [pulses] of a workpiece that stops PUSH, by the number of an axis of
            the controller, from 1; None removes the workpiece.
        area: The bytes that the PLC reads from now on instead of the controller's answer; missing
            bytes are 0. `ROBOT`: the controller's answer again. None: no change.
        connected: The connection status that the PLC's scanner shows while the PLC reads the bytes
            of `area`.
        controller: Number of the controller, from 1, to which all keys except `values` apply.
    """

    keys = KEYS
    opposite = staticmethod(opposite)
    lasting = "set, robot or plc"

    hold: tuple[str, ...] = ()
    release: tuple[str, ...] = ()
    area: bytes | str | None = None
    connected: bool = True
    controller: int = 1
    force: Mapping[str, int] = field(default_factory=dict)
    workpieces: Mapping[int, int | None] = field(default_factory=dict)

    @classmethod
    def events_of(cls, table: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
        """Return the events of an `[[at]]` table, each with its arguments."""
        names = {one: one for one in EVENTS if not one.startswith(PLC)}
        of_plc = [one.removeprefix(PLC) for one in PLC_EVENTS]
        elsewhere = {k: f'write plc = "{one}"' for one in of_plc for k in (one, PLC + one)}
        found = [event_of(one, "robot", names, elsewhere) for one in listed(table, "robot")]
        return found + super().events_of(table)

    @classmethod
    def more_of(cls, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return those attributes of an `[[at]]` table that apply to a controller."""
        return {
            "hold": _names(table, "hold"),
            "release": _names(table, "release"),
            "area": _area(table),
            "connected": _connected(table),
            "controller": _controller(table),
            "force": _forced(table),
            "workpieces": _workpieces(table),
        }

    def end(self, t_us: int) -> Entry:
        """Return the entry that undoes the values and events of this entry at `t_us`."""
        return replace(super().end(t_us), controller=self.controller)

    def apply(self, cell: Cell) -> None:
        """Apply the entry now, without waiting for its end."""
        self.set_values(cell)
        for event, args in self.events:
            cell.inject(event, controller=self.controller, **args)
        for name in self.hold:
            cell.robots[self.controller - 1].hold(name)
        for name in self.release:
            cell.robots[self.controller - 1].release(name)
        for name, value in self.force.items():
            cell.robots[self.controller - 1].force(name, value)
        for axis, pulses in self.workpieces.items():
            cell.robots[self.controller - 1].place_workpiece(axis, pulses)
        if self.area is not None:
            area = self.area if isinstance(self.area, bytes) else None
            cell.give_area(area, self.connected, controller=self.controller)

    def attempt(self, cell: Cell) -> None:
        """Check that the entry can be applied.

        The check changes values, so the caller must undo it.
        """
        self.set_values(cell)
        if self.controller > len(cell.robots):
            raise InputError(
                f"there is no controller {self.controller}; the cell has {len(cell.robots)}"
            )
        if self.events or self.hold + self.release or self.force or self.workpieces:
            cell.check_near()
        robot = cell.robots[self.controller - 1]
        for event, args in self.events:
            if event in SURROUNDINGS:
                check(event, args)
            else:
                robot.inject(event, **args)
        for name in self.hold + self.release:
            robot.hold(name)
            robot.release(name)
        for name, value in self.force.items():
            robot.force(name, value)
            robot.release(name)
        for axis, pulses in self.workpieces.items():
            robot.place_workpiece(axis, pulses)
        if isinstance(self.area, bytes):
            cell.give_area(self.area, controller=self.controller)
            cell.give_area(None, controller=self.controller)


class Stimulus(stimulus.Stimulus):
    """The entries of a file in order of time."""

    entry = Entry


def _forced(table: Mapping[str, Any]) -> dict[str, int]:
    given = table.get("force", {})
    if not isinstance(given, dict) or not all(type(value) is int for value in given.values()):
        raise InputError(
            "force must be a table of outputs and values", hint='write force = { "SO(20)" = 1 }'
        )
    return given


def _workpieces(table: Mapping[str, Any]) -> dict[int, int | None]:
    given = table.get("workpieces", {})
    hint = 'write workpieces = { 3 = 90000 }, or { 3 = "none" }: by axis, in pulses'
    if not isinstance(given, dict):
        raise InputError("workpieces is not a table", hint=hint)
    found: dict[int, int | None] = {}
    for axis, pulses in given.items():
        if not (axis.isascii() and axis.isdecimal() and len(axis) < _MOST_DIGITS):
            raise InputError(f"workpieces has no axis {axis:.20}", hint=hint)
        if pulses != "none" and type(pulses) is not int:
            raise InputError(f"the workpiece of axis {axis} needs a position or none", hint=hint)
        if int(axis) in found:
            raise InputError(f"workpieces has axis {int(axis)} twice", hint=hint)
        found[int(axis)] = None if pulses == "none" else pulses
    return found


def _area(table: Mapping[str, Any]) -> bytes | str | None:
    given = table.get("area")
    if given is None or given == ROBOT:
        return given
    try:
        return bytes.fromhex(given)
    except (TypeError, ValueError):
        raise InputError(
            f"area is {given!r}, which is not hexadecimal",
            hint=f'write area = "0002 0000", two digits each, or area = "{ROBOT}"',
        ) from None


def _connected(table: Mapping[str, Any]) -> bool:
    given = table.get("connected", True)
    if not isinstance(given, bool):
        raise InputError("connected is not true or false", hint="write connected = false")
    if "connected" in table and table.get("area", ROBOT) == ROBOT:
        raise InputError(
            "connected can be used only together with area",
            hint='write robot = "link_down" to unplug the controller',
        )
    return given


def _controller(table: Mapping[str, Any]) -> int:
    given = table.get("controller", 1)
    if not isinstance(given, int) or isinstance(given, bool) or given < 1:
        raise InputError("controller is not a number from 1", hint="write controller = 2")
    return given


def _names(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    names = listed(table, key)
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} is not a signal", hint=f'write {key} = "SO02"')
    return tuple(names)


def stimulus_text(entries: Iterable[Entry], about: str = "") -> str:
    """Return the text of a stimulus file with a line for each entry.

    The entries must be in order of time. `about` becomes a comment at the beginning of the file.
    """
    lines = [f"# {line}".rstrip() for line in about.splitlines()]
    lines += ["at = [", *(f"  {entry_text(entry)}," for entry in entries), "]"]
    return "\n".join(lines) + "\n"


def entry_text(entry: Entry) -> str:
    """Return the text of an entry as an inline table of TOML."""
    keys: dict[str, Any] = {"time": _time_text(entry.t_us)}
    if entry.values:
        keys["set"] = dict(entry.values)
    for key, ours in (("robot", False), ("plc", True)):
        named = [
            {"event": name.removeprefix(PLC), **args} if args else name.removeprefix(PLC)
            for name, args in entry.events
            if name.startswith(PLC) == ours
        ]
        if named:
            keys[key] = named[0] if len(named) == 1 else named
    if entry.held_us is not None:
        keys["for"] = _time_text(entry.held_us)
    for key in ("hold", "release", "expect"):
        if several := getattr(entry, key):
            keys[key] = several[0] if len(several) == 1 else list(several)
    if entry.force:
        keys["force"] = dict(entry.force)
    if entry.workpieces:
        places = entry.workpieces.items()
        keys["workpieces"] = {str(k): "none" if at is None else at for k, at in places}
    if entry.area is not None:
        keys["area"] = _hex(entry.area) if isinstance(entry.area, bytes) else entry.area
        if not entry.connected:
            keys["connected"] = False
    if entry.controller > 1:
        keys["controller"] = entry.controller
    return _toml(keys)


def _hex(area: bytes) -> str:
    """Return the bytes as groups of four hexadecimal digits, without trailing zero words."""
    used = max(1, len(area.rstrip(bytes(1))))
    return area[: used + used % 2].hex(" ", 2)


def _time_text(t_us: int) -> str:
    return f"{t_us}us" if t_us % 1000 else f"{t_us // 1000}ms"


def _toml(value: Any) -> str:
    if isinstance(value, Mapping):
        pairs = (f"{_key(name)} = {_toml(one)}" for name, one in value.items())
        return f"{{ {', '.join(pairs)} }}"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, timedelta):
        return f'"{_time_text(parse_us(value))}"'
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return json.dumps(value, ensure_ascii=False)


def _key(name: str) -> str:
    return name if re.fullmatch(r"\w+", name, re.ASCII) else json.dumps(name, ensure_ascii=False)
