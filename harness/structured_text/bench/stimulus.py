"""A stimulus file (TOML): variables to set and events of the PLC, each at its time."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from datetime import timedelta
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from structured_text.bench.bench import Bench
from structured_text.bench.events import EVENTS, checked, opposite
from structured_text.engines.conditions import Condition, conditions
from structured_text.errors import COMMAND, InputError, Violation
from structured_text.language.types import ArrayType, ElementaryType, StructType, Type
from structured_text.output.toml_files import check_keys, load_toml, toml_text
from structured_text.output.units import parse_us

__all__ = ["PLC", "Entry", "Stimulus", "event_of", "listed", "typed"]

_ENTRY = re.compile(r"^\s*(?:\[\[\s*at\s*\]\]|(?:at\s*=\s*\[\s*)?\{[^#]*\btime\b)")
#: Prefix of the names of the events of a PLC. The key `plc` omits the prefix.
PLC = "plc_"

_Made = TypeVar("_Made", bound="Entry")
_Read = TypeVar("_Read", bound="Stimulus")


@dataclass(frozen=True, eq=False)
class Entry:
    """One `[[at]]` table.

    Attributes:
        t_us: Time from the start of the run.
        values: Variables to set, by path.
        events: Events of the PLC: name and arguments.
        held_us: Time after which the entry's BOOL values and events are undone; None if they
            remain.
        expect: Conditions that must hold just before the values are set, see `engines.conditions`.
    """

    keys: ClassVar[tuple[str, ...]] = ("time", "set", "plc", "for", "expect")
    """The keys that an `[[at]]` table may have."""
    opposite: ClassVar[Callable[..., tuple[str, dict[str, Any]]]] = staticmethod(opposite)
    """The function that returns the event which ends a given event."""
    lasting: ClassVar[str] = "set or plc"
    """The keys that `for` can be combined with; used in messages."""

    t_us: int
    line: int = 0
    values: Mapping[str, Any] = field(default_factory=dict)
    events: tuple[tuple[str, Mapping[str, Any]], ...] = ()
    held_us: int | None = None
    expect: tuple[str, ...] = ()

    @classmethod
    def of(cls: type[_Made], table: Mapping[str, Any], line: int) -> _Made:
        """Read an `[[at]]` table; raise InputError if it contains an error."""
        for key in table:
            if key not in cls.keys:
                cls.refuse(key)
        if "time" not in table:
            raise InputError("the entry has no time", hint='write time = "100ms"')
        if not isinstance(table["time"], str):
            raise InputError("time is not a text", hint='write time = "100ms"')
        values = table.get("set", {})
        if not isinstance(values, dict):
            raise InputError("set is not a table", hint='write set = { "Main.Go" = true }')
        names = [path.upper() for path in values]
        if twice := [path for path in values if names.count(path.upper()) > 1]:
            hint = "remove one of them: upper and lower case are the same name"
            raise InputError(f"{twice[0]} is set twice, also as {twice[1]}", hint=hint)
        events = cls.events_of(table)
        t_us, more = parse_us(table["time"]), cls.more_of(table)
        held_us = cls._held(table, values, events)
        return cls(t_us, line, values, tuple(events), held_us, _conditions(table), **more)

    @classmethod
    def refuse(cls, key: str) -> None:
        """Raise InputError for an unknown key."""
        near = get_close_matches(key, cls.keys, n=1)
        hint = f"did you mean {near[0]}" if near else "keys are " + ", ".join(cls.keys)
        raise InputError(f"unknown key {key!r}", hint=hint)

    @classmethod
    def events_of(cls, table: Mapping[str, Any]) -> list[tuple[str, Mapping[str, Any]]]:
        """Return the events of a table."""
        names = {name.removeprefix(PLC): name for name in EVENTS}
        return [event_of(one, "plc", names) for one in listed(table, "plc")]

    @classmethod
    def more_of(cls, table: Mapping[str, Any]) -> dict[str, Any]:
        """Return the further attributes of an entry that a subclass reads from the table."""
        del table
        return {}

    @classmethod
    def _held(
        cls,
        table: Mapping[str, Any],
        values: Mapping[str, Any],
        events: list[tuple[str, Mapping[str, Any]]],
    ) -> int | None:
        """Return the duration of the entry (`for`) in microseconds; None if it has no `for`."""
        given = table.get("for")
        if given is None:
            return None
        if not isinstance(given, str):
            raise InputError("for is not a text", hint='write for = "100ms"')
        for path, value in values.items():
            if not isinstance(value, bool):
                hint = "set the other value in a later entry"
                raise InputError(
                    f"'for' works with true and false only, not with {path}", hint=hint
                )
        for event, args in events:
            cls.opposite(event, args)
        if not values and not events:
            raise InputError(f"'for' needs {cls.lasting} in the same entry")
        held_us = parse_us(given)
        if not held_us:
            raise InputError("'for' must be longer than 0", hint='write for = "100ms"')
        return held_us

    def parts(self: _Made) -> list[_Made]:
        """Return the entry without its duration, and a second entry for the end of the duration."""
        if self.held_us is None:
            return [self]
        return [replace(self, held_us=None), self.end(self.t_us + self.held_us)]

    def end(self: _Made, t_us: int) -> _Made:
        """Return the entry that undoes values and events at `t_us`."""
        values = {path: not value for path, value in self.values.items()}
        events = tuple(self.opposite(event, args) for event, args in self.events)
        return type(self)(t_us, self.line, values, events)

    def apply(self, bench: Any) -> None:
        """Set the values and trigger the events of the entry now; `end` undoes them."""
        self.set_values(bench)
        for event, args in self.events:
            bench.inject(event, **args)

    def attempt(self, bench: Any) -> None:
        """Check that the entry is possible, and set its values.

        Raise InputError if it is impossible.
        """
        self.set_values(bench)
        for event, args in self.events:
            checked(EVENTS, event, args)

    def set_values(self, bench: Bench) -> None:
        """Set the variables of the entry."""
        for path, value in self.values.items():
            bench[path] = typed(bench, path, value)


class Stimulus:
    """The entries of a file, in order of time.

    Entries of equal time keep the order of the file.
    """

    entry: ClassVar[type[Entry]] = Entry
    """The class of the entries; a subclass can use another class."""

    def __init__(self, file: Path, entries: Sequence[Any]) -> None:
        self.file = file
        self.entries: list[Any] = sorted(entries, key=lambda entry: entry.t_us)

    @classmethod
    def load(cls: type[_Read], path: str | Path) -> _Read:
        """Read a stimulus file.

        Raises:
            InputError: The file is unreadable or not TOML, or an entry is wrong; the error has its
                line.
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
                entries.append(cls.entry.of(one, line))
        return cls(file, entries)

    def late(self, end_us: int) -> str:
        """Return a line on entries that a run of `end_us` does not reach, or an empty text."""
        number = sum(entry.t_us >= end_us for entry in self.entries)
        if not number:
            return ""
        entries = "1 entry" if number == 1 else f"{number} entries"
        verb = "is" if number == 1 else "are"
        return f"{entries} of {self.file} {verb} at or after the end ({end_us / 1e6:g} s)"

    def schedule(self, bench: Bench) -> None:
        """Check all entries, then schedule them in `bench`.

        Raises:
            InputError: A path, value, event or signal does not exist.
        """
        self.check(bench)
        expected = self._expected(bench)
        for one in self.entries:
            if one in expected:
                bench.at(one.t_us, partial(_judge, bench, expected[one]))
            for part in one.parts():
                bench.at(part.t_us, partial(part.apply, bench))

    def check(self, bench: Bench) -> None:
        """Try the entries on the state of `bench`, and undo them.

        Raises:
            InputError: A path, value, event or signal does not exist.
        """
        with bench.trying():
            for entry in self.entries:
                with _at_line(self.file, entry.line):
                    entry.attempt(bench)
                    conditions(bench.program, entry.expect)

    def _expected(self, bench: Bench) -> dict[Entry, list[Condition]]:
        """Return each entry that has `expect` conditions, with the compiled conditions."""
        found = {}
        for entry in self.entries:
            if entry.expect:
                with _at_line(self.file, entry.line):
                    found[entry] = conditions(bench.program, entry.expect)
        return found


def _judge(bench: Bench, expected: list[Condition]) -> None:
    """Report each `expect` condition that does not hold now as a broken rule."""
    for one in expected:
        if not one.holds():
            text = f"plc, scan {bench.scans}: expect: {one.text} does not hold"
            bench.report([Violation(bench.now_us, "expect", text)])


@contextmanager
def _at_line(file: Path, line: int) -> Iterator[None]:
    """Add file and line of an entry to every InputError."""
    try:
        yield
    except InputError as error:
        raise InputError(error.message, file=file, line=line, hint=error.hint) from None


def _entry_lines(file: Path) -> list[int]:
    lines = toml_text(file).splitlines()
    return [number for number, line in enumerate(lines, start=1) if _ENTRY.match(line)]


def listed(table: Mapping[str, Any], key: str) -> list[Any]:
    """Return the values of a key as a list, even if the key has only one value."""
    given = table.get(key, [])
    return given if isinstance(given, list) else [given]


def _conditions(table: Mapping[str, Any]) -> tuple[str, ...]:
    found = listed(table, "expect")
    if not all(isinstance(one, str) for one in found):
        raise InputError("expect is not a condition", hint='write expect = "Main.Parts > 3"')
    return tuple(found)


def event_of(
    given: object, key: str, names: Mapping[str, str], elsewhere: Mapping[str, str] | None = None
) -> tuple[str, Mapping[str, Any]]:
    """Return name and arguments of an event from the file.

    Raise InputError if there is no event of this name. `names` maps the names in the file to the
    full names of events. `elsewhere` contains hints for events that belong under another key.
    """
    args: dict[str, Any] = {}
    if isinstance(given, dict):
        args = dict(given)
        given = args.pop("event", None)
    example, more = ("run", 'start = "cold"') if key == "plc" else ("alarm", "group = 12")
    if not isinstance(given, str):
        hint = f'write {key} = "{example}", or {{ event = "{example}", {more} }}'
        raise InputError(f"{key} is not an event", hint=hint)
    if given not in names:
        near = get_close_matches(given, names, n=3)
        hint = (
            f"did you mean {' or '.join(near)}"
            if near
            else f"{COMMAND} run --help lists the events"
        )
        hint = (elsewhere or {}).get(given, hint)
        raise InputError(f"unknown event {given!r}", hint=hint)
    return names[given], args


def typed(bench: Bench, path: str, value: Any) -> Any:
    """Convert texts to durations where the type is TIME or LTIME; TOML has no durations.

    Arrays and structures are converted element by element.
    """
    if not isinstance(value, (str, list, Mapping)):
        return value
    return _typed(bench.program.type_of(path), value)


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
        # The value of an array with several dimensions is a list of rows.
        return [_typed(kind if isinstance(part, list) else kind.element, part) for part in value]
    return value
