"""Read the facts of a trace."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from rcx_harness.look.why.facts import Facts
from rcx_harness.robot.ports import port, value_in
from rcx_harness.spec import signals
from rcx_harness.trace import Cycle, Record, Scan, Violation, read_trace
from rcx_harness.trace.tasks import statement_of
from structured_text.errors import InputError

__all__ = ["facts_of_trace", "input_of", "take_areas"]

#: If the PLC has not made a scan for this number of periods, its program stands.
_MISSED = 20
#: The first words of an area: the command or status, and the words of the response.
_WORDS = 3


def facts_of_trace(
    file: Path, until_us: int | None, progress: Callable[[float], None] = lambda share: None
) -> Facts:
    """Read the facts of a trace up to a time.

    Raises:
        InputError: the file is not a trace, or it ends before that time.
    """
    header, records = read_trace(file, progress)
    facts = Facts()
    facts.blocks.update(_blocks(header.get("watch")))
    reader = _Reader(facts, header)
    ended = True
    for record in records:
        if until_us is not None and record.t_us > until_us:
            ended = False
            break
        reader.take(record)
    records.close()
    if not facts.controllers:
        raise InputError("has no scan and no cycle up to this time", file=file, hint=_LATER)
    changes = "only" in header  # the last record can be long before the end
    late = until_us is not None and until_us > facts.last_us + _slack(header)
    if ended and late and not changes and until_us is not None:
        text = f"ends at {facts.last_us / 1e6:.6g} s, before {until_us / 1e6:.6g} s"
        raise InputError(text, file=file, hint="use an earlier time")
    reader.end(facts.last_us if until_us is None else until_us)
    return facts


_LATER = "use a later time, or record a trace with rcx run --trace FILE"


def _slack(header: Mapping[str, Any]) -> int:
    return max(int(header.get("scan_us", 0)), int(header.get("cycle_us", 0)))


class _Reader:
    """Turns the records of a trace into facts."""

    def __init__(self, facts: Facts, header: Mapping[str, Any]) -> None:
        self._facts, self._header = facts, header
        self._scanned: int | None = None
        self._cycled: set[int] = set()

    def take(self, record: Record) -> None:
        """Take the next record."""
        facts = self._facts
        facts.last_us = max(facts.last_us, record.t_us)
        if isinstance(record, Violation):
            facts.broken.append((record.t_us, record.text))
            return
        facts.controllers.add(record.controller)
        if isinstance(record, Scan):
            self._scan(record)
        else:
            self._cycle(record)

    def end(self, t_us: int) -> None:
        """Look for a PLC whose scans have stopped before the end."""
        period = self._header.get("scan_us")
        if self._scanned is None or period is None or "only" in self._header:
            return
        if t_us - self._scanned > _MISSED * period:
            self._facts.take("0:plc", False, self._scanned)

    def _scan(self, record: Scan) -> None:
        facts, number = self._facts, record.controller
        self._scanned = record.t_us
        take_areas(facts, number, b"", record.si, record.t_us)
        if number not in self._cycled:
            take_areas(facts, number, record.so, b"", record.t_us)
        for path, value in (record.vars or {}).items():
            facts.take_path(path, value, record.t_us)

    def _cycle(self, record: Cycle) -> None:
        facts, number, t_us = self._facts, record.controller, record.t_us
        self._cycled.add(number)
        facts.take(f"{number}:link", bool(record.rcx_si), t_us)
        take_areas(facts, number, record.rcx_so, b"", t_us)
        if self._scanned is None:  # a recording of the controller alone
            take_areas(facts, number, b"", record.rcx_si, t_us)
        for name, bit in _received(record.rcx_si):
            facts.take(f"{number}:got {name}", bit, t_us)
        if record.positions is not None:
            facts.take(f"{number}:positions", record.positions, t_us)
        if record.tasks is not None:
            facts.take(f"{number}:tasks", self._tasks(record), t_us)

    def _tasks(self, record: Cycle) -> list[tuple[str, int, str, str]]:
        return [
            (
                task["program"],
                task["line"],
                task["state"],
                self._statement(record.controller, task),
            )
            for task in record.tasks or ()
        ]

    def _statement(self, controller: int, task: Mapping[str, Any]) -> str:
        """Return the statement of a task; empty if the header does not contain its program."""
        try:
            return statement_of(self._header["programs"][controller - 1], task)
        except (AttributeError, IndexError, KeyError, TypeError):
            return ""


def _received(area: bytes) -> Iterator[tuple[str, bool]]:
    for signal in signals().input if area else ():
        yield signal.signal, bool(area[signal.byte] >> signal.bit & 1)


def take_areas(facts: Facts, controller: int, so: bytes, si: bytes, t_us: int | None) -> None:
    """Take the dedicated signals and the first words of the areas; an empty area is skipped."""
    facts.controllers.add(controller)
    head = f"{controller}:"
    for area, listed in ((so, signals().output), (si, signals().input)):
        for signal in listed if area else ():
            facts.take(head + signal.signal, bool(area[signal.byte] >> signal.bit & 1), t_us)
    if so:
        words = [int.from_bytes(so[2 * k : 2 * k + 2], "little") for k in range(_WORDS)]
        facts.take(head + "status", words[0], t_us)
        facts.take(head + "answer", tuple(words), t_us)
    if si:
        facts.take(head + "code", int.from_bytes(si[:2], "little"), t_us)
        facts.take(head + "inputs", si, t_us)


def input_of(area: bytes, name: str) -> int | None:
    """Return the value of an input such as `SI(20)` in an area; None if it is not part of it."""
    try:
        place = port(name)
        place.check(len(area))
        return None if place.bank else value_in(place, area)
    except (InputError, IndexError, ValueError):
        return None


def _blocks(watch: Any) -> Iterator[tuple[str, str]]:
    """Yield path and type of each structure and block of the watched variables."""
    for path, kind in watch.items() if isinstance(watch, Mapping) else ():
        if isinstance(kind, Mapping) and "struct" in kind:
            yield path, str(kind["struct"])
            members = kind.get("members")
            if isinstance(members, Mapping):
                yield from _blocks({f"{path}.{name}": one for name, one in members.items()})
