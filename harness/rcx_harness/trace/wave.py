"""VCD files of runs for wave viewers: all dedicated bits and words, as PLC and controller see them.

The file also has the watched variables by their paths, the positions (if they are recorded), and
the task and current line of each robot program.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from datetime import timedelta
from pathlib import Path
from typing import Any, TextIO, cast

from vcd import VCDWriter
from vcd.writer import Variable

from rcx_harness.spec import Signal, signals
from rcx_harness.trace.records import Cycle, Record, Scan, Trace
from rcx_harness.watch.wire import word
from structured_text.bench import samples
from structured_text.language.displayed import Changed, Part, value_text
from structured_text.language.types import ElementaryType, Type
from structured_text.output.files import OutputFile

__all__ = ["Wave"]

_WORDS = 16
#: Number of bits of each whole number type. Negative numbers are in two's complement.
_BITS = {
    "BOOL": 1,
    **dict.fromkeys(("BYTE", "SINT", "USINT"), 8),
    **dict.fromkeys(("WORD", "INT", "UINT"), 16),
    **dict.fromkeys(("DWORD", "DINT", "UDINT"), 32),
    **dict.fromkeys(("LWORD", "LINT", "ULINT"), 64),
}
_UNSIGNED = ("BOOL", "BYTE", "WORD", "DWORD", "LWORD")
_MILLISECOND = timedelta(milliseconds=1)


class _Area:
    """The VCD variables of one area, in one scope."""

    def __init__(
        self, writer: VCDWriter, scope: str, prefix: str, bits: tuple[Signal, ...]
    ) -> None:
        self._writer = writer
        self._before = b""
        self._bits = [
            (one.byte, one.bit, writer.register_var(scope, one.name, "wire", size=1, init=0))
            for one in bits
        ]
        self._words: list[Variable[int]] = [
            writer.register_var(scope, f"{prefix}{k:02}", "wire", size=16, init=0)
            for k in range(_WORDS)
        ]

    def take(self, t_us: int, area: bytes) -> None:
        """Record the changes of an area. Without a connection nothing is recorded."""
        if not area or area == self._before:
            return
        before = self._before or bytes(len(area))
        for byte, bit, variable in self._bits:
            new = area[byte] >> bit & 1
            if new != before[byte] >> bit & 1:
                self._writer.change(variable, t_us, new)
        if area[: 2 * _WORDS] != before[: 2 * _WORDS]:
            for k, variable in enumerate(self._words):
                value = word(area, 2 * k)
                if value != word(before, 2 * k):
                    self._writer.change(variable, t_us, value)
        self._before = area


class _Values:
    """The watched variables, in scopes that follow their paths, below `variables`.

    BOOLs and bit strings are wires, whole numbers are integers, REAL and LREAL are real numbers,
    and durations are real numbers in ms. All other values are texts, such as the member names of an
    enumeration.
    """

    def __init__(self, writer: VCDWriter, watched: Mapping[str, Type]) -> None:
        self._writer = writer
        self._changed = Changed(watched)
        every = {part.path: part for within in self._changed.parts.values() for part in within}
        self._known = {name: self._register(part) for name, part in every.items()}

    def _register(self, part: Part) -> tuple[Variable[Any], Callable[[Any], Any]]:
        *scope, last = part.path.split(".")
        form, size, shown = _form(part.type)
        return self._writer.register_var(("variables", *scope), last, form, size), shown

    def take(self, t_us: int, values: Mapping[str, Any]) -> None:
        """Record the changes of the watched variables in a scan."""
        for part, value in self._changed.take(values):
            variable, shown = self._known[part.path]
            self._writer.change(variable, t_us, shown(value))


class _Programs:
    """The robot programs of one controller. Each program is a scope with line, task and state.

    While a program is not registered in a task, line and task are 0 and the state is empty.
    """

    def __init__(self, writer: VCDWriter, scope: str, names: Iterable[str]) -> None:
        self._writer = writer
        self._known: dict[str, tuple[Variable[Any], ...]] = {
            name: (
                writer.register_var((scope, name), "line", "integer", size=32, init=0),
                writer.register_var((scope, name), "task", "integer", size=32, init=0),
                writer.register_var((scope, name), "state", "string", init=""),
            )
            for name in dict.fromkeys(names)
        }

    def take(self, t_us: int, tasks: Iterable[Mapping[str, Any]]) -> None:
        """Record the changes of all programs."""
        places = {task["program"]: task for task in tasks}
        for name, variables in self._known.items():
            task = places.get(name, {})
            values = (task.get("line", 0), task.get("task", 0), task.get("state", ""))
            for variable, value in zip(variables, values, strict=True):
                self._writer.change(variable, t_us, value)


def _form(kind: Type) -> tuple[str, int | None, Callable[[Any], Any]]:
    """Return the VCD type of a variable, its number of bits, and its conversion."""
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name in _BITS:
        return "wire" if name in _UNSIGNED else "integer", _BITS[name], int
    if name in ("REAL", "LREAL"):
        return "real", 64, float
    if name in ("TIME", "LTIME"):
        return "real", 64, lambda value: value / _MILLISECOND
    return "string", 1, lambda value: _readable(kind, value)


def _readable(kind: Type, value: Any) -> str:
    """Return a text in ASCII, the character set of a wave file."""
    shown = value if isinstance(value, str) else value_text(kind, value)
    return shown.encode("unicode_escape").decode("ascii")


def _which(controllers: int) -> list[str]:
    """Return the endings of the scope names for each controller."""
    return ["", *(f"_{k}" for k in range(2, controllers + 1))][:controllers]


class Wave:
    """The writer of a VCD file during a run. Pass `take` to `Trace.listen`.

    Args:
        controllers: Number of controllers, possibly 0. Scope names contain the number of the
            controller, except for the first.
        trace: A trace. Its watched variables and positions are written as well.
    """

    def __init__(
        self, path: str | Path, controllers: int = 1, trace: samples.Trace[Any] | None = None
    ) -> None:
        self._file = OutputFile(path, "ascii")
        # The file contains no date and no version, so that the same run gives the same bytes.
        self._writer = VCDWriter(
            cast(TextIO, self._file), timescale="1 us", date="", version="rcx", comment=""
        )
        table = signals()
        self._plc: list[tuple[_Area, _Area]] = []
        self._robot: list[tuple[_Area, _Area]] = []
        for which in _which(controllers):
            for sides, scope in ((self._plc, f"plc{which}"), (self._robot, f"robot{which}")):
                so = _Area(self._writer, scope, "SOW", table.output)
                sides.append((so, _Area(self._writer, scope, "SIW", table.input)))
        watched = trace.watched if trace is not None else {}
        self._values = _Values(self._writer, watched) if watched else None
        self._axes = [
            [self._axis(f"positions{which}", title) for title in titles]
            for which, titles in zip(
                _which(controllers), trace.axes if isinstance(trace, Trace) else (), strict=False
            )
        ]
        programs = trace.programs if isinstance(trace, Trace) else ()
        self._programs = [
            _Programs(self._writer, f"programs{which}", [one["name"] for one in every])
            for which, every in zip(_which(controllers), programs, strict=False)
        ]
        self._broken = self._writer.register_var("rules", "broken", "integer", size=32, init=0)
        self._count = 0
        self._end_us = 0

    def _axis(self, scope: str, title: str) -> Variable[float]:
        name = re.sub(r"\W+", "_", title).strip("_")
        return self._writer.register_var(scope, name, "real", size=64)

    def take(self, record: Record) -> None:
        """Write the changes of the next record of the run."""
        self._end_us = record.t_us
        if isinstance(record, Scan):
            if self._plc:
                so, si = self._plc[record.controller - 1]
                so.take(record.t_us, record.so)
                si.take(record.t_us, record.si)
            if self._values is not None and record.vars is not None:
                self._values.take(record.t_us, record.vars)
        elif isinstance(record, Cycle):
            so, si = self._robot[record.controller - 1]
            si.take(record.t_us, record.rcx_si)
            so.take(record.t_us, record.rcx_so)
            if self._axes and record.positions is not None:
                axes = self._axes[record.controller - 1]
                for variable, value in zip(axes, record.positions, strict=True):
                    self._writer.change(variable, record.t_us, value)
            if self._programs and record.tasks is not None:
                self._programs[record.controller - 1].take(record.t_us, record.tasks)
        else:
            self._count += 1
            self._writer.change(self._broken, record.t_us, self._count)

    def close(self) -> None:
        """Write the last time and close the file."""
        if not self._file.closed:
            self._writer.close(self._end_us)
            self._file.close()
