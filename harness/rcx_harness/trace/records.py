"""The records of a run: JSON lines, one per PLC scan, controller cycle and broken rule."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable, Generator, Mapping, Sequence
from itertools import count
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from rcx_harness.spec.wire import AREA_SIZES, SIZE
from structured_text.bench import samples
from structured_text.bench.samples import COMPACT, FORMAT
from structured_text.errors import InputError, Violation
from structured_text.language.displayed import literal
from structured_text.output.limits import MOST_LINE_BYTES, MOST_TRACE_US, TRACE
from structured_text.output.reading import open_file

__all__ = ["CutOffError", "Cycle", "Record", "Scan", "Trace", "read_trace"]


class Scan(NamedTuple):
    """One PLC scan: the area read at its start, the area written at its end."""

    t_us: int
    scan: int
    so: bytes
    si: bytes
    vars: Mapping[str, Any] | None = None
    controller: int = 1

    def line(self) -> str:
        """Return the record as JSON. It contains `vars` only if variables are watched."""
        which = _which(self.controller)
        head = f'{{"t_us":{self.t_us},"scan":{self.scan}{which},"so":"{self.so.hex()}"'
        if self.vars is None:
            return f'{head},"si":"{self.si.hex()}"}}'
        shown = json.dumps({path: literal(value) for path, value in self.vars.items()}, **COMPACT)
        return f'{head},"si":"{self.si.hex()}","vars":{shown}}}'


class Cycle(NamedTuple):
    """One controller cycle: the input area (empty without a connection) and the output area.

    `positions` are the positions after the cycle, if they are recorded and have changed. `poses`
    are the poses of the robots (`rcx_harness.robot.shape.poses`), if they have changed. `tasks` are
    the tasks of the robot programs (`rcx_harness.robot.listing.task_places`), if they have changed.
    """

    t_us: int
    cycle: int
    rcx_si: bytes
    rcx_so: bytes
    controller: int = 1
    positions: tuple[float, ...] | None = None
    poses: tuple[Mapping[str, Any], ...] | None = None
    tasks: tuple[Mapping[str, Any], ...] | None = None

    def line(self) -> str:
        """Return the record as JSON.

        It contains positions, poses and tasks only if they have changed.
        """
        head = (
            f'{{"t_us":{self.t_us},"cycle":{self.cycle}{_which(self.controller)},'
            f'"rcx_si":"{self.rcx_si.hex()}","rcx_so":"{self.rcx_so.hex()}"'
        )
        if self.positions is not None:
            head += f',"positions":{json.dumps(self.positions, **COMPACT)}'
        if self.poses is not None:
            head += f',"poses":{json.dumps(self.poses, **COMPACT)}'
        if self.tasks is not None:
            head += f',"tasks":{json.dumps(self.tasks, **COMPACT)}'
        return head + "}"


Record = Scan | Cycle | Violation

#: The largest whole number that JavaScript (the page) represents exactly.
_LARGEST = (1 << 53) - 1
_DAY_US = 86_400_000_000
#: Progress is reported after this number of lines.
_REPORT_EVERY = 20_000

#: Pattern for the beginning of a broken rule and its name, such as `plc, scan 3: interval: `.
_RULE = re.compile(r"(?:controller \d+: )?(?:plc, scan|robot, cycle) \d+: ([a-z -]+): ")


def _which(controller: int) -> str:
    """Return the JSON entry with the controller's number. For the first controller it is empty."""
    return f',"controller":{controller}' if controller > 1 else ""


class Trace(samples.Trace[Record]):
    """The records of a run. All records are written to a file, and the latest stay in memory.

    Args:
        path: File to write. With None the records are only in memory.
        axes: Titles of the recorded positions of each controller: `positions` in the header.
        robots: Shapes of the robots of each controller (`rcx_harness.robot.shape.shapes`): `robots`
            in the header.
        programs: Robot programs, for each controller (`rcx_harness.robot.listing.listings`);
            `programs` in the header if there are any.
        more: Further arguments, as for the trace of a bench.
    """

    def __init__(
        self,
        header: Mapping[str, Any],
        path: str | Path | None = None,
        *,
        axes: Sequence[Sequence[str]] = (),
        robots: Sequence[Sequence[Mapping[str, Any]]] = (),
        programs: Sequence[Sequence[Mapping[str, Any]]] = (),
        **more: Any,
    ) -> None:
        self.axes, self.programs = axes, programs
        last: dict[str, Any] = {"positions": [list(names) for names in axes]} if axes else {}
        if robots:
            last["robots"] = [list(every) for every in robots]
        if any(programs):
            last["programs"] = [list(every) for every in programs]
        super().__init__(header, path, last=last, **more)

    def scans(self) -> list[Scan]:
        """Return the records of PLC scans that are in memory."""
        return self._of(Scan)

    def cycles(self) -> list[Cycle]:
        """Return the records of controller cycles that are in memory."""
        return self._of(Cycle)


class CutOffError(InputError):
    """The error for a trace with an incomplete last line, because its writer was killed.

    The records before this line are valid.
    """


def read_trace(
    path: str | Path, progress: Callable[[float], None] = lambda share: None
) -> tuple[dict[str, Any], Generator[Record, None, None]]:
    """Read a trace file, record by record.

    `progress` is called repeatedly with the share of the file that has been read.

    Returns:
        The header, and an iterator over the records that reads the file step by step.

    Raises:
        InputError: the file is not readable or not of this format, or a line is not a record. The
            iterator can raise this error as well; it raises `CutOffError` if the last line is
            incomplete.
    """
    file = open_file(path, TRACE)  # the iterator closes the file
    length = max(1, os.fstat(file.fileno()).st_size)
    try:
        header = _header(_next_line(file, path, 1), path)
    except BaseException:
        file.close()
        raise
    return header, _records(file, header, path, lambda read: progress(min(1.0, read / length)))


def _header(line: bytes, path: str | Path) -> dict[str, Any]:
    if not line.strip():
        raise InputError("is empty; a trace begins with a header", file=path)
    header = _load(line, path, 1)
    given = header.get("format")
    if given == FORMAT:
        for key in ("scan_us", "cycle_us", "size"):
            value = header.get(key, 1)
            if type(value) is not int or value < 1:
                raise InputError(
                    f"{key} is {value!r:.40}, and not a number from 1", file=path, line=1
                )
        size = header.get("size", SIZE)
        if size not in AREA_SIZES:
            hint = "use 48 or 256"
            raise InputError(f"size is {size}", file=path, line=1, hint=hint)
        return header
    if str(given).startswith(FORMAT.partition("/")[0]):
        text = f"is a trace of format {given:.40}, and this version of rcx reads {FORMAT}"
        raise InputError(text, file=path, line=1, hint="read it with the version that wrote it")
    raise InputError(f"not a trace of format {FORMAT}", file=path, line=1)


def _records(
    file: BinaryIO,
    header: Mapping[str, Any],
    path: str | Path,
    progress: Callable[[int], None],
) -> Generator[Record, None, None]:
    read, latest_us = 0, 0
    order = _Order(changes=bool({"only", "by"} & header.keys()))
    with file:
        for number in count(2):
            line = _next_line(file, path, number)
            if not line:
                return
            read += len(line)
            if number % _REPORT_EVERY == 0:
                progress(read)
            try:
                record = _record(_load(line, path, number))
                if wrong := order.wrong(record):
                    hint = "the trace is damaged: record it again"
                    raise InputError(wrong, file=path, line=number, hint=hint)
                latest_us = latest_us or record.t_us + MOST_TRACE_US
                if record.t_us > latest_us:
                    raise _too_long(path, number)
                yield record
            except InputError as error:
                if line.endswith(b"\n"):
                    raise
                raise CutOffError("is cut off in this line", file=error.file, line=number) from None
            except (AttributeError, KeyError, RecursionError, TypeError, ValueError):
                raise InputError("not a record of a trace", file=path, line=number) from None


class _Order:
    """The check of the order of scans and cycles in a trace, which reveals missing lines.

    Args:
        changes: Whether the trace has only records with changes, like a trace of `rcx serve`. The
            numbers of such records have gaps, and a cycle may have two changes.
    """

    def __init__(self, *, changes: bool) -> None:
        self._changes = changes
        self._last: dict[tuple[str, int], tuple[int, int]] = {}

    def wrong(self, record: Record) -> str:
        """Return a text about a record that is out of order. Empty if the order is correct."""
        if isinstance(record, Violation):
            return ""
        kind, number = "cycle", record[1]
        if isinstance(record, Scan):
            kind = "scan"
        key = kind, record.controller
        before_us, before = self._last.get(key, (0, number - 1))
        self._last[key] = record.t_us, number
        if record.t_us < before_us:
            return f"the time goes back by {(before_us - record.t_us) / 1e6:.3f} s"
        if number >= before if self._changes else number == before + 1:
            return ""
        return f"{kind} {number} follows {kind} {before}: lines are missing, or not in order"


def _too_long(path: str | Path, number: int) -> InputError:
    text = f"a time of more than {MOST_TRACE_US // _DAY_US} days"
    return InputError(text, file=path, line=number, hint="the clock of the recording has jumped")


def _next_line(file: BinaryIO, path: str | Path, number: int) -> bytes:
    """Return the next line with its line break. At the end of the file it is empty."""
    try:
        line = file.readline(MOST_LINE_BYTES + 1)
    except OSError as error:
        reason = f"cannot be read: {error.strerror}"
        raise InputError(reason, file=path, line=number) from None
    if len(line) > MOST_LINE_BYTES:
        text = f"a line of more than {MOST_LINE_BYTES >> 20} MB"
        hint = "a trace has a record in each line; watch fewer variables"
        raise InputError(text, file=path, line=number, hint=hint)
    return line


def _load(line: bytes, path: str | Path, number: int) -> dict[str, Any]:
    try:
        entry = json.loads(line, parse_constant=_no_constant)
    except (ValueError, RecursionError):
        entry = None
    if not isinstance(entry, dict):
        raise InputError("not a line of a trace", file=path, line=number)
    return entry


def _no_constant(word: str) -> None:
    """Raise ValueError for a constant that Python accepts although JSON has none, such as NaN."""
    raise ValueError(f"{word} is not a number of JSON")


def _whole(entry: Mapping[str, Any], key: str, low: int) -> int:
    """Return a value of a record, checked to be a whole number."""
    number = entry[key]
    if type(number) is not int or not low <= number <= _LARGEST:
        raise ValueError(f"{key} is not a whole number from {low}")
    return number


def _record(entry: dict[str, Any]) -> Record:
    controller = _whole(entry, "controller", 1) if "controller" in entry else 1
    t_us = _whole(entry, "t_us", 0)
    if "scan" in entry:
        if "so" not in entry and "si" not in entry:  # a trace of a program without a robot
            entry = {"so": "", "si": "", **entry}
        so, si = bytes.fromhex(entry["so"]), bytes.fromhex(entry["si"])
        values = entry.get("vars")
        if values is not None and not isinstance(values, dict):
            raise ValueError("no variables")
        return Scan(t_us, _whole(entry, "scan", 0), so, si, values, controller)
    if "cycle" in entry:
        si, so = bytes.fromhex(entry["rcx_si"]), bytes.fromhex(entry["rcx_so"])
        where = tuple(entry["positions"]) if "positions" in entry else None
        poses = tuple(map(dict, entry["poses"])) if "poses" in entry else None
        tasks = tuple(map(_task, entry["tasks"])) if "tasks" in entry else None
        return Cycle(t_us, _whole(entry, "cycle", 0), si, so, controller, where, poses, tasks)
    named = _RULE.match(entry["violation"])
    return Violation(t_us, named[1] if named else "", entry["violation"])


def _task(entry: dict[str, Any]) -> dict[str, Any]:
    """Return a task of a robot program from a record."""
    for key in ("program", "state"):
        if not isinstance(entry[key], str):
            raise ValueError(f"{key} is not a text")
    _whole(entry, "task", 1)
    _whole(entry, "line", 1)
    return entry
