"""The tool `explain_trace`: what happened in a recording, as a list of events."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from rcx_harness.assistant.call import Answer, Call
from rcx_harness.assistant.limits import MOST_EVENTS
from rcx_harness.look.judge.judge import JudgeOptions, judge
from rcx_harness.spec import signals
from rcx_harness.trace import Cycle, Scan, Violation, read_trace
from rcx_harness.trace.explaining import unanswered
from rcx_harness.trace.tasks import statement_of, task_text
from structured_text.errors import InputError
from structured_text.output.units import format_us, parse_us

__all__ = ["explain_trace", "state_at_the_end"]

_WINDOW = "1s"
#: If a variable has more changes than this, they are one event.
_OFTEN = 20


class _Change(NamedTuple):
    """A change of a variable or of a task of a robot program."""

    name: str
    text: str
    value: str


@dataclass
class _State:
    """Hold what a controller and the program show at a time."""

    areas: dict[int, tuple[bytes, bytes]] = field(default_factory=dict)
    values: dict[str, str] = field(default_factory=dict)
    tasks: dict[int, list[str]] = field(default_factory=dict)

    def take(self, record: Scan | Cycle, header: Mapping[str, Any]) -> list[_Change]:
        """Take the values of a record, and return its changes of variables and tasks."""
        who = f"controller {record.controller}: " if record.controller > 1 else ""
        changes: list[_Change] = []
        if isinstance(record, Scan):
            self.areas[record.controller] = record.so, record.si
            for name, value in (record.vars or {}).items():
                before, now = self.values.get(name), str(value)
                self.values[name] = now
                if before is not None and before != now:
                    changes.append(_Change(name, f"changes from {before} to {now}", now))
        elif record.tasks is not None:
            programs = header.get("programs") or []
            listed = programs[record.controller - 1] if len(programs) >= record.controller else []
            texts = [task_text(task, statement_of(listed, task)) for task in record.tasks]
            self.tasks[record.controller] = texts
            changes += [_Change(f"{who}task", text, text) for text in texts]
        return changes

    def shown(self) -> dict[str, Any]:
        """Return the state for an answer."""
        return {
            "signals_on": _on(self.areas),
            "tasks": [text for number in sorted(self.tasks) for text in self.tasks[number]],
            "watched": dict(self.values),
        }


def explain_trace(call: Call) -> Answer:
    """Explain a recording: events, broken rules, the state at a time, and missing answers."""
    file = call.path(call.given["trace"])
    at_us = _time(call, "at")
    window_us = parse_us(call.given.get("window", _WINDOW))
    from_us, until_us = 0, None
    if at_us is not None:
        from_us, until_us = max(0, at_us - window_us), at_us + window_us
    events = _changes(file, from_us, until_us)
    told: list[str] = []
    found = judge(JudgeOptions(file=file, from_us=from_us, until_us=until_us), told.append)
    if at_us is not None and at_us > found.last_us:
        text = f"ends at {format_us(found.last_us)}, before {format_us(at_us)}"
        raise InputError(text, file=file, hint="use an earlier time")
    events += [(_when(line), line.split(" s  ", 1)[1].strip()) for line in told]
    events.sort(key=lambda event: event[0])
    shown = _nearest(events, at_us)
    end_us = found.last_us if at_us is None else at_us
    state, ever_on = _state(file, end_us)
    missing = sorted(unanswered(ever_on))
    names = [f"{name} {signals().find(name).title}" for name in missing]
    data = {
        "controllers": sorted(found.followers),
        "end_us": found.last_us,
        "events": [{"t_us": t_us, "text": text} for t_us, text in shown],
        "events_left_out": len(events) - len(shown),
        "missing_signals": names,
        "state": state,
        "state_at_us": end_us,
        "trace": file.as_posix(),
        "violation_count": found.count,
    }
    lines = [f"{t_us / 1e6:.6f} s  {text}" for t_us, text in shown]
    lines += [f"at {end_us / 1e6:.6f} s ON: {', '.join(state['signals_on']) or 'nothing'}"]
    lines += [f"never ON, although it is needed: {name}" for name in names]
    lines += [f"{found.count or 'no'} broken rule{'' if found.count == 1 else 's'}"]
    return Answer(data, "\n".join(lines))


def state_at_the_end(trace: Path) -> list[str]:
    """Return the dedicated signals that are ON at the end of a trace, with their names."""
    areas: dict[int, tuple[bytes, bytes]] = {}
    _, records = read_trace(trace)
    for record in records:
        if isinstance(record, Scan):
            areas[record.controller] = record.so, record.si
    return _on(areas)


def _time(call: Call, name: str) -> int | None:
    text = call.given.get(name)
    return None if text is None else parse_us(text)


def _when(line: str) -> int:
    """Return the time of a line of `judge` [us]."""
    return round(float(line.split(" s  ", 1)[0]) * 1e6)


def _changes(file: Path, from_us: int, until_us: int | None) -> list[tuple[int, str]]:
    """Return the broken rules, and the changes of watched variables and of robot programs.

    A variable that changes very often has one event, which would otherwise hide all others.
    """
    state, found = _State(), list[tuple[int, str]]()
    changes: dict[str, list[tuple[int, _Change]]] = {}
    header, records = read_trace(file)
    for record in records:
        shown = from_us <= record.t_us and (until_us is None or record.t_us <= until_us)
        if isinstance(record, Violation):
            found += [(record.t_us, f"broken rule: {record.text}")] if shown else []
            continue
        for change in state.take(record, header):
            if shown:
                changes.setdefault(change.name, []).append((record.t_us, change))
    for name, listed in changes.items():
        if len(listed) <= _OFTEN:
            found += [(t_us, f"{name} {change.text}") for t_us, change in listed]
            continue
        (first_us, _), (last_us, last) = listed[0], listed[-1]
        text = f"{name} changes {len(listed)} times until {format_us(last_us)}, then {last.value}"
        found.append((first_us, text))
    return found


def _state(file: Path, end_us: int) -> tuple[dict[str, Any], set[str]]:
    """Return the state at a time, and the signals that were ON up to then."""
    state, ever_on = _State(), set[str]()
    header, records = read_trace(file)
    for record in records:
        if record.t_us > end_us:
            break
        if isinstance(record, (Scan, Cycle)):
            state.take(record, header)
            ever_on.update(_codes(state.areas) if isinstance(record, Scan) else ())
    records.close()
    if not state.areas and not state.values:
        raise InputError(
            f"has no scan up to {end_us / 1e6:g} s", file=file, hint="use a later time"
        )
    return state.shown(), ever_on


def _codes(areas: Mapping[int, tuple[bytes, bytes]]) -> Iterator[str]:
    for text in _on(areas):
        yield text.rpartition(": ")[2].partition(" ")[0]


def _on(areas: Mapping[int, tuple[bytes, bytes]]) -> list[str]:
    """Return the dedicated signals that are ON, each with its title."""
    table, found = signals(), []
    for number in sorted(areas):
        who = f"controller {number}: " if number > 1 else ""
        so, si = areas[number]
        for area, listed in ((so, table.output), (si, table.input)):
            found += [
                f"{who}{one.signal} {one.title}"
                for one in listed
                if one.byte < len(area) and area[one.byte] >> one.bit & 1
            ]
    return found


def _nearest(events: list[tuple[int, str]], at_us: int | None) -> list[tuple[int, str]]:
    """Return at most the allowed number of events: the nearest to a time, or the last."""
    if len(events) <= MOST_EVENTS:
        return events
    if at_us is None:
        return events[-MOST_EVENTS:]
    order = sorted(range(len(events)), key=lambda number: abs(events[number][0] - at_us))
    return [events[number] for number in sorted(order[:MOST_EVENTS])]
