"""A stimulus file: what is set and what befalls the robot, at which time (TOML)."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from datetime import timedelta
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

from rcx_harness.cell.cell import EVENTS, Cell
from rcx_harness.engine.types import ElementaryType
from rcx_harness.errors import InputError
from rcx_harness.spec import load_toml
from rcx_harness.units import parse_us

__all__ = ["KEYS", "ROBOT", "Entry", "Stimulus"]

#: As an `area`: the controller's own answer.
ROBOT = "robot"
#: Of an entry.
KEYS = ("time", "set", "robot", "hold", "release", "area", "connected", "controller")
_ENTRY = re.compile(r"^\s*\[\[\s*at\s*\]\]")


@dataclass(frozen=True)
class Entry:
    """One `[[at]]` table.

    Attributes:
        t_us: When, from the start of the run.
        line: Where it stands in the file.
        values: Variables to set, by path.
        events: What befalls the robot or the link: name and arguments.
        hold: Outputs of the controller that stay as they are.
        release: Outputs that follow the controller again.
        area: What the PLC reads from now on instead of the controller's answer: bytes of its input
            area, those left out 0; `ROBOT` for the controller's answer again; None: as before.
        connected: What the PLC's scanner says of the connection while it reads such bytes.
        controller: Which of the cell's controllers all but `values` is for, from 1.
    """

    t_us: int
    line: int
    values: Mapping[str, Any]
    events: tuple[tuple[str, Mapping[str, Any]], ...]
    hold: tuple[str, ...]
    release: tuple[str, ...]
    area: bytes | str | None = None
    connected: bool = True
    controller: int = 1

    def apply(self, cell: Cell) -> None:
        """Let it happen, now."""
        for path, value in self.values.items():
            cell[path] = _typed(cell, path, value)
        for event, args in self.events:
            cell.inject(event, controller=self.controller, **args)
        for name in self.hold:
            cell.robots[self.controller - 1].hold(name)
        for name in self.release:
            cell.robots[self.controller - 1].release(name)
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
        for key in table:
            if key != "at":
                raise InputError(
                    f"unknown key {key!r}", file=file, hint="a stimulus consists of [[at]] tables"
                )
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
        """Let the entries happen in `cell`, after all were tried on its state and taken back.

        Raises:
            InputError: a path, value, event or signal that does not exist.
        """
        before = cell.program.snapshot(), [robot.snapshot() for robot in cell.robots]
        try:
            for entry in self.entries:
                with _at_line(self.file, entry.line):
                    _try(entry, cell)
        finally:
            cell.program.restore(before[0])
            for robot, state in zip(cell.robots, before[1], strict=True):
                robot.restore(state)
        for entry in self.entries:
            cell.at(entry.t_us, partial(entry.apply, cell))


@contextmanager
def _at_line(file: Path, line: int) -> Iterator[None]:
    """Say of every error in which entry of the file it is."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message, file=file, line=line, hint=error.hint) from None


def _entry_lines(file: Path) -> list[int]:
    lines = file.read_text(encoding="utf-8").splitlines()
    return [number for number, line in enumerate(lines, start=1) if _ENTRY.match(line)]


def _entry(table: Mapping[str, Any], line: int) -> Entry:
    for key in table:
        if key not in KEYS:
            near = get_close_matches(key, KEYS, n=1)
            hint = f"did you mean {near[0]}" if near else "keys are " + ", ".join(KEYS)
            raise InputError(f"unknown key {key!r}", hint=hint)
    if "time" not in table:
        raise InputError("the entry has no time", hint='write time = "100ms"')
    if not isinstance(table["time"], str):
        raise InputError("time is not a text", hint='write time = "100ms"')
    values = table.get("set", {})
    if not isinstance(values, dict):
        raise InputError("set is not a table", hint='write set = { "Main.Go" = true }')
    given = table.get("robot", [])
    events = [_event(one) for one in (given if isinstance(given, list) else [given])]
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
    )


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


def _event(given: object) -> tuple[str, Mapping[str, Any]]:
    args: dict[str, Any] = {}
    if isinstance(given, dict):
        args = dict(given)
        given = args.pop("event", None)
    if not isinstance(given, str):
        raise InputError(
            "robot is not an event",
            hint='write robot = "alarm", or { event = "alarm", group = 12 }',
        )
    if given not in EVENTS:
        near = get_close_matches(given, EVENTS, n=3)
        hint = f"did you mean {' or '.join(near)}" if near else "rcx run --help lists the events"
        raise InputError(f"unknown event {given!r}", hint=hint)
    return given, args


def _names(table: Mapping[str, Any], key: str) -> tuple[str, ...]:
    given = table.get(key, [])
    names = given if isinstance(given, list) else [given]
    if not all(isinstance(name, str) for name in names):
        raise InputError(f"{key} is not a signal", hint=f'write {key} = "SO02"')
    return tuple(names)


def _try(entry: Entry, cell: Cell) -> None:
    for path, value in entry.values.items():
        cell[path] = _typed(cell, path, value)
    if entry.controller > len(cell.robots):
        raise InputError(f"no controller {entry.controller}; the cell has {len(cell.robots)}")
    if entry.events or entry.hold + entry.release:
        cell.check_near()
    robot = cell.robots[entry.controller - 1]
    for event, args in entry.events:
        if not event.startswith("link_"):
            robot.inject(event, **args)
        elif args:
            raise InputError(f"event {event!r} takes no arguments", hint=f'write robot = "{event}"')
    for name in entry.hold + entry.release:
        robot.hold(name)
        robot.release(name)
    if isinstance(entry.area, bytes):
        cell.give_area(entry.area, controller=entry.controller)
        cell.give_area(None, controller=entry.controller)


def _typed(cell: Cell, path: str, value: Any) -> Any:
    """TOML has no durations: a TIME or LTIME is given as a text."""
    if not isinstance(value, str):
        return value
    kind = cell.program.type_of(path)
    if kind == ElementaryType("TIME") or (kind == ElementaryType("LTIME") and "#" not in value):
        return timedelta(microseconds=parse_us(value))
    return value
