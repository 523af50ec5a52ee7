"""A recording of all inputs of a program in a test, scan by scan, for replay in the debugger.

A program depends only on its inputs, on what a test sets, and on the time. With the same inputs it
behaves the same way, without the devices around it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from datetime import date, datetime, time, timedelta
from itertools import groupby, pairwise
from typing import Any, NamedTuple

from structured_text.debug.devices import Devices
from structured_text.debug.machine import Finding, builtin_of
from structured_text.engines.base import Program, Value

__all__ = ["COMPACT", "Recorded", "Tape"]

#: Arguments of `json.dumps` for each line of a recording.
COMPACT: dict[str, Any] = {"separators": (",", ":"), "ensure_ascii": False}


class _Scan(NamedTuple):
    """A recorded scan.

    It has the previous scan, its own time, and the numbers of the actions before it.
    """

    before: _Scan | None
    t_us: int
    done: tuple[int, ...]


class _Marked(NamedTuple):
    """A snapshot of the program, with the recording up to the snapshot."""

    snapshot: object
    last: _Scan | None
    done: tuple[int, ...]


class Recorded:
    """A program that records its scans and all writes; other calls go to the wrapped program.

    `restore` also discards the recording since the snapshot.
    """

    def __init__(self, program: Program) -> None:
        self.program, self.engine = program, program.engine
        self.read, self.reader, self.read_bytes = program.read, program.reader, program.read_bytes
        self._last: _Scan | None = None
        self._done: list[int] = []
        self._numbers: dict[Any, int] = {}
        self._deeds: list[list[Any]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(self.program, name)

    def scan(self, now_us: int) -> None:
        """Run a scan and record it; see `engines.base.Program`."""
        self._last = _Scan(self._last, now_us, tuple(self._done))
        self._done.clear()
        self.program.scan(now_us)

    def write(self, path: str, value: Value) -> None:
        """Write a variable and record it; see `engines.base.Program`."""
        self.program.write(path, value)
        self._note(("set", path, type(value), _key(value)), "set", path, value)

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """Write bytes and record them; see `engines.base.Program`."""
        self.program.write_bytes(path, data, start)
        self._note(("bytes", path, start, data), "bytes", path, data, start)

    def _note(self, key: Any, *deed: Any) -> None:
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = len(self._deeds)
            self._deeds.append(list(deed))
        self._done.append(number)

    def snapshot(self) -> object:
        """Return a snapshot of the program and of the recording; see `engines.base.Program`."""
        return _Marked(self.program.snapshot(), self._last, tuple(self._done))

    def restore(self, snapshot: object) -> None:
        """Restore program and recording; see `engines.base.Program`."""
        assert isinstance(snapshot, _Marked), "not a snapshot of this program"
        self.program.restore(snapshot.snapshot)
        self._last, self._done = snapshot.last, list(snapshot.done)

    def lines(self) -> Iterator[str]:
        """Yield the lines of the file of this recording, except the first line."""
        scans: list[_Scan] = []
        last = self._last
        while last is not None:
            scans.append(last)
            last = last.before
        scans.reverse()
        used = {number for one in scans for number in one.done} | set(self._done)
        for number in sorted(used):
            deed = [_literal(part) for part in self._deeds[number]]
            yield json.dumps({"deed": number, "is": deed}, **COMPACT)
        steps = [0, *(b.t_us - a.t_us for a, b in pairwise(scans))][: len(scans)]
        alike = groupby(zip(scans, steps, strict=True), key=lambda pair: (pair[0].done, pair[1]))
        for (done, step), group in alike:
            some = [one for one, _ in group]
            entry = {"t_us": some[0].t_us, "scans": len(some), "every_us": step, "done": done}
            yield json.dumps(entry, **COMPACT)
        if self._done:
            yield json.dumps({"after": self._done}, **COMPACT)


def _key(value: Any) -> Any:
    try:
        hash(value)
    except TypeError:
        return json.dumps(_literal(value), **COMPACT)
    # -0.0 and 0.0 are equal and have the same hash, so the key must distinguish them
    return str(value) if isinstance(value, float) else value


def _literal(value: Any) -> Any:
    """Return a value in a form that JSON can store."""
    if isinstance(value, bytes):
        return {"hex": value.hex()}
    if isinstance(value, timedelta):
        return {"us": value // timedelta(microseconds=1)}
    if isinstance(value, (datetime, date, time)):
        return {type(value).__name__: value.isoformat()}
    if isinstance(value, Mapping):
        return {"fields": {name: _literal(one) for name, one in value.items()}}
    if isinstance(value, (list, tuple)):
        return [_literal(one) for one in value]
    return value


_MADE: dict[str, Callable[[Any], Any]] = {
    "hex": bytes.fromhex,
    "us": lambda us: timedelta(microseconds=us),
    "datetime": datetime.fromisoformat,
    "date": date.fromisoformat,
    "time": time.fromisoformat,
}


def _value(found: Any) -> Any:
    """Return the original of a value that `_literal` has converted for JSON."""
    if isinstance(found, list):
        return [_value(one) for one in found]
    if isinstance(found, dict):
        ((kind, inner),) = found.items()
        if kind == "fields":
            return {name: _value(one) for name, one in inner.items()}
        return _MADE[kind](inner)
    return found


class Tape:
    """A recording as a `Machine` of the debugger.

    The program runs on the built-in engine and has not run its first scan. `lines` must not contain
    the first line of the recording's file.
    """

    devices: Devices | None = None

    def __init__(
        self,
        program: Program,
        lines: Sequence[Mapping[str, Any]],
        violations: Sequence[Finding],
    ) -> None:
        self.program = builtin_of(program)
        self.violations: list[Finding] = []
        self._found = list(violations)
        self._deeds: dict[int, list[Any]] = {}
        self._scans: list[tuple[int, list[int]]] = []
        self._after: list[int] = []
        self._done = 0
        for one in lines:
            if "deed" in one:
                self._deeds[one["deed"]] = [_value(part) for part in one["is"]]
            elif "after" in one:
                self._after = one["after"]
            else:
                for number in range(one["scans"]):
                    t_us = one["t_us"] + number * one["every_us"]
                    self._scans.append((t_us, one["done"]))

    @property
    def length(self) -> int:
        """Return the number of recorded scans."""
        return len(self._scans)

    @property
    def ended(self) -> str:
        """Return the reason why no further scan can run, or an empty text."""
        return "" if self._done < len(self._scans) else "the end of the recording"

    @property
    def scans(self) -> int:
        """Return the number of scans that have run."""
        return self._done

    @property
    def now_us(self) -> int:
        """Return the time of the last scan in microseconds."""
        return self._scans[self._done - 1][0] if self._done else 0

    def scan(self) -> None:
        """Repeat the recorded actions before the next scan, then run this scan."""
        t_us, done = self._scans[self._done]
        self._do(done)
        with self.watched(t_us):
            self.program.scan(t_us)
            self._done += 1
        if self._done == len(self._scans):
            self._do(self._after)
        known = len(self.violations)
        next_us = self._scans[self._done][0] if self._done < len(self._scans) else None
        for one in self._found[known:]:
            if next_us is not None and one.t_us >= next_us:
                break
            self.violations.append(one)

    @contextmanager
    def watched(self, t_us: int) -> Iterator[None]:
        """Surround a scan at the time `now_us`; a subclass can observe the scan here."""
        del t_us
        yield

    def _do(self, numbers: Sequence[int]) -> None:
        for number in numbers:
            kind, path, *rest = self._deeds[number]
            if kind == "set":
                self.program.write(path, rest[0])
            else:
                self.program.write_bytes(path, *rest)

    def snapshot(self) -> Any:
        """Return the state between two scans."""
        return self.program.snapshot(), self._done, len(self.violations)

    def restore(self, snapshot: Any) -> None:
        """Restore the state from `snapshot`."""
        program, self._done, found = snapshot
        self.program.restore(program)
        del self.violations[found:]

    def close(self) -> None:
        """Do nothing: a recording holds no resources."""
