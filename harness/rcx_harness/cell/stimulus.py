"""A stimulus file: what is set and what befalls the robot, at which time (TOML)."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import timedelta
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import EVENTS, Cell
from rcx_harness.cell.surroundings import EVENTS as SURROUNDINGS
from rcx_harness.cell.surroundings import check, opposite
from rcx_harness.robot import Violation
from structured_text.engines.conditions import Condition, conditions
from structured_text.errors import InputError
from structured_text.language.types import ArrayType, ElementaryType, StructType, Type
from structured_text.output.toml_files import check_keys, load_toml, toml_text
from structured_text.units import parse_us

__all__ = ["KEYS", "ROBOT", "Entry", "Stimulus", "entry_text", "stimulus_text", "typed"]

#: As an `area`: the controller's own answer.
ROBOT = "robot"
#: Of an entry.
KEYS = (
    *("time", "set", "robot", "plc", "for", "hold", "release", "area", "connected"),
    *("controller", "expect", "force", "workpieces"),
)
_ENTRY = re.compile(r"^\s*(?:\[\[\s*at\s*\]\]|(?:at\s*=\s*\[\s*)?\{[^#]*\btime\b)")
_MOST_DIGITS = 4
#: How the events of a PLC begin; the key `plc` leaves that out.
_PLC = "plc_"


@dataclass(frozen=True, eq=False)
class Entry:
    """One `[[at]]` table.

    Attributes:
        t_us: When, from the start of the run.
        line: Where it stands in the file.
        values: Variables to set, by path.
        events: What befalls the robot or the link: name and arguments.
        hold: Outputs of the controller that stay as they are.
        release: Outputs that follow the controller again.
        force: Outputs that have these values, whatever their state.
        workpieces: By number of an axis of the controller, from 1: where something stands that
            PUSH meets [pulses]; None: nothing any more.
        area: What the PLC reads from now on instead of the controller's answer: bytes of its input
            area, those left out 0; `ROBOT` for the controller's answer again; None: as before.
        connected: What the PLC's scanner says of the connection while it reads such bytes.
        controller: Which of the cell's controllers all but `values` is for, from 1.
        held_us: After so long the values, all of type BOOL, and the events are taken back; None:
            they stay.
        expect: Conditions that hold now, just before all this: see `engines.conditions`.
    """

    t_us: int
    line: int = 0
    values: Mapping[str, Any] = field(default_factory=dict)
    events: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    hold: tuple[str, ...] = ()
    release: tuple[str, ...] = ()
    area: bytes | str | None = None
    connected: bool = True
    controller: int = 1
    held_us: int | None = None
    expect: tuple[str, ...] = ()
    force: Mapping[str, int] = field(default_factory=dict)
    workpieces: Mapping[int, int | None] = field(default_factory=dict)

    def parts(self) -> list[Entry]:
        """This without an end; and where it has one, that."""
        if self.held_us is None:
            return [self]
        end = Entry(
            self.t_us + self.held_us,
            self.line,
            {path: not value for path, value in self.values.items()},
            tuple(opposite(event, args) for event, args in self.events),
            controller=self.controller,
        )
        return [replace(self, held_us=None), end]

    def apply(self, cell: Cell) -> None:
        """Let it happen, now; its end is not waited for."""
        for path, value in self.values.items():
            cell[path] = typed(cell, path, value)
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


class Stimulus:
    """The entries of a file, in order of time.

    Args:
        file: The file they come from, for messages.
        entries: The entries; those of equal time keep the order of the file.
    """

    def __init__(self, file: Path, entries: list[Entry]) -> None:
        self.file = file
        self.entries = sorted(entries, key=lambda entry: entry.t_us)

    @classmethod
    def load(cls, path: str | Path) -> Stimulus:
        """Read a stimulus file.

        Raises:
            InputError: unreadable, not TOML, or an entry that is wrong, with its line.
        """
        file = Path(path)
        table = load_toml(file)
        check_keys(table, ["at"], file=file)
        tables = table.get("at", [])
        if not isinstance(tables, list) or not all(isinstance(one, dict) for one in tables):
            raise InputError("'at' is not a list of tables", file=file, hint="write [[at]]")
        lines = _entry_lines(file)
        entries = []
        for number, one in enumerate(tables):
            line = lines[number] if number < len(lines) else 1
            with _at_line(file, line):
                entries.append(_entry(one, line))
        return cls(file, entries)

    def late(self, end_us: int) -> str:
        """One line if there are entries that a run of `end_us` does not come to; else empty."""
        number = sum(entry.t_us >= end_us for entry in self.entries)
        if not number:
            return ""
        entries = "1 entry" if number == 1 else f"{number} entries"
        verb = "is" if number == 1 else "are"
        return f"{entries} of {self.file} {verb} at or after the end ({end_us / 1e6:g} s)"

    def schedule(self, cell: Cell) -> None:
        """Let the entries happen in `cell`, after all were tried.

        Raises:
            InputError: a path, value, event or signal that does not exist.
        """
        self.check(cell)
        expected = self._expected(cell)
        for one in self.entries:
            if one in expected:
                cell.at(one.t_us, partial(_judge, cell, expected[one]))
            for part in one.parts():
                cell.at(part.t_us, partial(part.apply, cell))

    def check(self, cell: Cell) -> None:
        """Try the entries on the state of `cell`, and take them back.

        Raises:
            InputError: a path, value, event or signal that does not exist.
        """
        before = cell.program.snapshot(), [robot.snapshot() for robot in cell.robots]
        try:
            for entry in self.entries:
                with _at_line(self.file, entry.line):
                    _try(entry, cell)
                    conditions(cell.program, entry.expect)
        finally:
            cell.program.restore(before[0])
            for robot, state in zip(cell.robots, before[1], strict=True):
                robot.restore(state)

    def _expected(self, cell: Cell) -> dict[Entry, list[Condition]]:
        """What entries expect, ready to be asked."""
        found = {}
        for entry in self.entries:
            if entry.expect:
                with _at_line(self.file, entry.line):
                    found[entry] = conditions(cell.program, entry.expect)
        return found


def _judge(cell: Cell, expected: list[Condition]) -> None:
    """Report what does not hold now."""
    for one in expected:
        if not one.holds():
            text = f"plc, scan {cell.scans}: expect: {one.text} does not hold"
            cell.report([Violation(cell.now_us, "expect", text)])


@contextmanager
def _at_line(file: Path, line: int) -> Iterator[None]:
    """Say of every error in which entry of the file it is."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message, file=file, line=line, hint=error.hint) from None


def _entry_lines(file: Path) -> list[int]:
    lines = toml_text(file).splitlines()
    return [number for number, line in enumerate(lines, start=1) if _ENTRY.match(line)]


def _entry(table: Mapping[str, Any], line: int) -> Entry:
    check_keys(table, KEYS, every="keys are")
    if "time" not in table:
        raise InputError("the entry has no time", hint='write time = "100ms"')
    if not isinstance(table["time"], str):
        raise InputError("time is not a text", hint='write time = "100ms"')
    values = table.get("set", {})
    if not isinstance(values, dict):
        raise InputError("set is not a table", hint='write set = { "Main.Go" = true }')
    names = [path.upper() for path in values]
    if twice := [path for path in values if names.count(path.upper()) > 1]:
        hint = "names of Structured Text do not differ by case"
        raise InputError(f"{twice[0]} is set twice, as {twice[1]}, too", hint=hint)
    events = [_event(one, "robot") for one in _listed(table, "robot")]
    events += [_event(one, "plc") for one in _listed(table, "plc")]
    return Entry(
        parse_us(table["time"]),
        line,
        values,
        tuple(events),
        _names(table, "hold"),
        _names(table, "release"),
        _area(table),
        _connected(table),
        _controller(table),
        _held(table, values, events),
        _conditions(table),
        _forced(table),
        _workpieces(table),
    )


def _listed(table: Mapping[str, Any], key: str) -> list[Any]:
    given = table.get(key, [])
    return given if isinstance(given, list) else [given]


def _held(
    table: Mapping[str, Any], values: Mapping[str, Any], events: list[tuple[str, Any]]
) -> int | None:
    """How long it lasts, if that is said."""
    given = table.get("for")
    if given is None:
        return None
    if not isinstance(given, str):
        raise InputError("for is not a text", hint='write for = "100ms"')
    for path, value in values.items():
        if not isinstance(value, bool):
            hint = "set it back in an entry of its own"
            raise InputError(f"'for' is for inputs that are true or false, not {path}", hint=hint)
    for event, args in events:
        opposite(event, args)
    if not values and not events:
        raise InputError("'for' goes with set, robot or plc")
    held_us = parse_us(given)
    if not held_us:
        raise InputError("'for' is a time longer than 0", hint='write for = "100ms"')
    return held_us


def _forced(table: Mapping[str, Any]) -> dict[str, int]:
    given = table.get("force", {})
    if not isinstance(given, dict) or not all(type(value) is int for value in given.values()):
        raise InputError("force is not outputs with values", hint='write force = { "SO(20)" = 1 }')
    return given


def _workpieces(table: Mapping[str, Any]) -> dict[int, int | None]:
    given = table.get("workpieces", {})
    hint = 'write workpieces = { 3 = 90000 }, or { 3 = "none" }: by axis, in pulses'
    if not isinstance(given, dict):
        raise InputError("workpieces are not a table", hint=hint)
    found: dict[int, int | None] = {}
    for axis, pulses in given.items():
        if not (axis.isascii() and axis.isdecimal() and len(axis) < _MOST_DIGITS):
            raise InputError(f"workpieces has no axis {axis:.20}", hint=hint)
        if pulses != "none" and type(pulses) is not int:
            raise InputError(f"workpieces of axis {axis} is not a place", hint=hint)
        if int(axis) in found:
            raise InputError(f"workpieces has axis {int(axis)} twice", hint=hint)
        found[int(axis)] = None if pulses == "none" else pulses
    return found


def _conditions(table: Mapping[str, Any]) -> tuple[str, ...]:
    found = _listed(table, "expect")
    if not all(isinstance(one, str) for one in found):
        raise InputError("expect is no condition", hint='write expect = "Main.Parts > 3"')
    return tuple(found)


def _area(table: Mapping[str, Any]) -> bytes | str | None:
    given = table.get("area")
    if given is None or given == ROBOT:
        return given
    try:
        return bytes.fromhex(given)
    except (TypeError, ValueError):
        raise InputError(
            f"area is {given!r}, which is no bytes in hexadecimal",
            hint=f'write area = "0002 0000", two digits each, or area = "{ROBOT}"',
        ) from None


def _connected(table: Mapping[str, Any]) -> bool:
    given = table.get("connected", True)
    if not isinstance(given, bool):
        raise InputError("connected is not true or false", hint="write connected = false")
    if "connected" in table and table.get("area", ROBOT) == ROBOT:
        raise InputError(
            "connected goes with the bytes of an area",
            hint='write robot = "link_down" to unplug the controller',
        )
    return given


def _controller(table: Mapping[str, Any]) -> int:
    given = table.get("controller", 1)
    if not isinstance(given, int) or isinstance(given, bool) or given < 1:
        raise InputError("controller is not a number from 1", hint="write controller = 2")
    return given


def _event(given: object, key: str) -> tuple[str, Mapping[str, Any]]:
    """An event by its name in the file, those of the PLC without how they begin."""
    args: dict[str, Any] = {}
    if isinstance(given, dict):
        args = dict(given)
        given = args.pop("event", None)
    example, more = ("alarm", "group = 12") if key == "robot" else ("run", 'start = "cold"')
    if not isinstance(given, str):
        hint = f'write {key} = "{example}", or {{ event = "{example}", {more} }}'
        raise InputError(f"{key} is not an event", hint=hint)
    of_plc = {name.removeprefix(_PLC): name for name in EVENTS if name.startswith(_PLC)}
    names = of_plc if key == "plc" else {one: one for one in EVENTS if not one.startswith(_PLC)}
    if given not in names:
        near = get_close_matches(given, names, n=3)
        hint = f"did you mean {' or '.join(near)}" if near else "rcx run --help lists the events"
        if key == "robot" and given.removeprefix(_PLC) in of_plc:
            hint = f'write plc = "{given.removeprefix(_PLC)}"'
        raise InputError(f"unknown event {given!r}", hint=hint)
    return names[given], args


def _names(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    names = _listed(table, key)
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} is not a signal", hint=f'write {key} = "SO02"')
    return tuple(names)


def _try(entry: Entry, cell: Cell) -> None:
    for path, value in entry.values.items():
        cell[path] = typed(cell, path, value)
    if entry.controller > len(cell.robots):
        raise InputError(f"no controller {entry.controller}; the cell has {len(cell.robots)}")
    if entry.events or entry.hold + entry.release or entry.force or entry.workpieces:
        cell.check_near()
    robot = cell.robots[entry.controller - 1]
    for event, args in entry.events:
        if event in SURROUNDINGS:
            check(event, args)
        else:
            robot.inject(event, **args)
    for name in entry.hold + entry.release:
        robot.hold(name)
        robot.release(name)
    for name, value in entry.force.items():
        robot.force(name, value)
        robot.release(name)
    for axis, pulses in entry.workpieces.items():
        robot.place_workpiece(axis, pulses)
    if isinstance(entry.area, bytes):
        cell.give_area(entry.area, controller=entry.controller)
        cell.give_area(None, controller=entry.controller)


def typed(cell: Cell, path: str, value: Any) -> Any:
    """TOML has no durations: a TIME or LTIME is given as a text, also in arrays and structures."""
    if not isinstance(value, (str, list, Mapping)):
        return value
    return _typed(cell.program.type_of(path), value)


def _typed(kind: Type, value: Any) -> Any:
    if isinstance(value, str):
        is_text = kind != ElementaryType("TIME")
        if is_text and (kind != ElementaryType("LTIME") or "#" in value):
            return value
        return timedelta(microseconds=parse_us(value))
    if isinstance(value, Mapping) and isinstance(kind, StructType):
        fields = {name.upper(): part for name, part in kind.fields}
        return {
            name: _typed(fields[name.upper()], part) if name.upper() in fields else part
            for name, part in value.items()
        }
    if isinstance(value, list) and isinstance(kind, ArrayType):
        # Of several dimensions in rows.
        return [_typed(kind if isinstance(part, list) else kind.element, part) for part in value]
    return value


def stimulus_text(entries: Iterable[Entry], about: str = "") -> str:
    """A stimulus file of these entries, a line each.

    Args:
        entries: In order of time.
        about: A comment for its beginning.
    """
    lines = [f"# {line}".rstrip() for line in about.splitlines()]
    lines += ["at = [", *(f"  {entry_text(entry)}," for entry in entries), "]"]
    return "\n".join(lines) + "\n"


def entry_text(entry: Entry) -> str:
    """An entry as an inline table."""
    keys: dict[str, Any] = {"time": _time_text(entry.t_us)}
    if entry.values:
        keys["set"] = dict(entry.values)
    for key, ours in (("robot", False), ("plc", True)):
        named = [
            {"event": name.removeprefix(_PLC), **args} if args else name.removeprefix(_PLC)
            for name, args in entry.events
            if name.startswith(_PLC) == ours
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
    """In words; what is 0 to the end is left out."""
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
