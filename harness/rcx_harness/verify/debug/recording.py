"""All that a program was given in a run, scan by scan: recorded in a test, replayed in a debugger.

A program sees its inputs, what a test sets, and the time; with these it does the same again,
without a robot. A recording has them and a digest of each source.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date, datetime, time, timedelta
from itertools import groupby, pairwise
from pathlib import Path
from typing import Any, NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cell.image import Image, find_image
from rcx_harness.cell.sources import source_files
from rcx_harness.robot import Violation
from rcx_harness.verify.debug.machine import builtin_of, live_input
from rcx_harness.verify.debug.telegrams import Telegrams
from rcx_harness.watch.image_source import reads_located
from structured_text.engines.base import Program, Value
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.language.source import source_text
from structured_text.output.files import replace_files
from structured_text.output.limits import OTHER
from structured_text.output.reading import file_bytes, open_file

__all__ = ["FORMAT", "Recorded", "Tape", "is_recording", "opened", "write_recording"]

#: First entry of the first line.
FORMAT = "rcx-recording/1"

_COMPACT: dict[str, Any] = {"separators": (",", ":"), "ensure_ascii": False}


class _Scan(NamedTuple):
    """A scan: the one before it, its time, and the numbers of what was done before it."""

    before: _Scan | None
    t_us: int
    done: tuple[int, ...]


class _Marked(NamedTuple):
    """A snapshot, and what was recorded until then."""

    snapshot: object
    last: _Scan | None
    done: tuple[int, ...]


class Recorded:
    """A program that records what is done with it; everything else goes through.

    A run that is set back to a snapshot forgets what was recorded since.

    Args:
        program: The program, on any engine.
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
        """See `engines.base.Program`."""
        self._last = _Scan(self._last, now_us, tuple(self._done))
        self._done.clear()
        self.program.scan(now_us)

    def write(self, path: str, value: Value) -> None:
        """See `engines.base.Program`."""
        self.program.write(path, value)
        self._note(("set", path, type(value), _key(value)), "set", path, value)

    def write_bytes(self, path: str, data: bytes, start: int = 0) -> None:
        """See `engines.base.Program`."""
        self.program.write_bytes(path, data, start)
        self._note(("bytes", path, start, data), "bytes", path, data, start)

    def _note(self, key: Any, *deed: Any) -> None:
        number = self._numbers.get(key)
        if number is None:
            number = self._numbers[key] = len(self._deeds)
            self._deeds.append(list(deed))
        self._done.append(number)

    def snapshot(self) -> object:
        """See `engines.base.Program`."""
        return _Marked(self.program.snapshot(), self._last, tuple(self._done))

    def restore(self, snapshot: object) -> None:
        """See `engines.base.Program`."""
        assert isinstance(snapshot, _Marked), "not a snapshot of this program"
        self.program.restore(snapshot.snapshot)
        self._last, self._done = snapshot.last, list(snapshot.done)

    def lines(self) -> Iterator[str]:
        """What was recorded, as the lines of a file behind the first."""
        scans: list[_Scan] = []
        last = self._last
        while last is not None:
            scans.append(last)
            last = last.before
        scans.reverse()
        used = {number for one in scans for number in one.done} | set(self._done)
        for number in sorted(used):
            deed = [_literal(part) for part in self._deeds[number]]
            yield json.dumps({"deed": number, "is": deed}, **_COMPACT)
        steps = [0, *(b.t_us - a.t_us for a, b in pairwise(scans))][: len(scans)]
        alike = groupby(zip(scans, steps, strict=True), key=lambda pair: (pair[0].done, pair[1]))
        for (done, step), group in alike:
            some = [one for one, _ in group]
            entry = {"t_us": some[0].t_us, "scans": len(some), "every_us": step, "done": done}
            yield json.dumps(entry, **_COMPACT)
        if self._done:
            yield json.dumps({"after": self._done}, **_COMPACT)


def _key(value: Any) -> Any:
    try:
        hash(value)
    except TypeError:
        return json.dumps(_literal(value), **_COMPACT)
    # -0.0 and 0.0 are one key, and not one value.
    return str(value) if isinstance(value, float) else value


def _literal(value: Any) -> Any:
    """A value as JSON has it."""
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
    """What `_literal` was made of."""
    if isinstance(found, list):
        return [_value(one) for one in found]
    if isinstance(found, dict):
        ((kind, inner),) = found.items()
        if kind == "fields":
            return {name: _value(one) for name, one in inner.items()}
        return _MADE[kind](inner)
    return found


def _digest(lines: Sequence[str]) -> str:
    """Return a digest of the lines behind the first: one that is missing or changed is noticed."""
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


# --- writing ------------------------------------------------------------------------------------


def _digests(files: Sequence[Path], folder: Path) -> dict[str, str]:
    """Each source and its digest."""
    return {
        _shown(file, folder): hashlib.sha256(source_text(file).encode()).hexdigest()
        for file in files
    }


def _shown(file: Path, folder: Path) -> str:
    whole = Path(os.path.abspath(file))
    below = whole.is_relative_to(folder)
    return whole.relative_to(folder).as_posix() if below else whole.as_posix()


def write_recording(
    file: Path,
    recorded: Recorded,
    cell: Cell,
    settings: Mapping[str, Any],
    folder: Path,
    test: str,
    failed: str,
) -> None:
    """Write what a cell's program was given.

    Args:
        file: Where to.
        recorded: The program.
        cell: Built with it; it may be closed.
        settings: The arguments of `Cell.build` that it was built with.
        folder: Of the project; files below it are named from there.
        test: Its name.
        failed: What went wrong, in one line.

    Raises:
        InputError: the file cannot be written, or a source is gone.
    """
    given = settings["program"]
    named = [given] if isinstance(given, (str, Path)) else given
    replace = settings.get("replace") or {}
    lib = settings.get("lib")
    sources = source_files(list(named), lib, replace)
    head = {
        "format": FORMAT,
        "test": test,
        "failed": failed,
        "engine": recorded.engine,
        "folder": folder.as_posix(),
        "program": [_shown(Path(one), folder) for one in named],
        "lib": None if lib is None else _shown(Path(lib), folder),
        "replace": {name: _shown(Path(one), folder) for name, one in replace.items()},
        "files": _digests(sources.all, folder),
        "areas": cell.areas,
        "violations": [[one.t_us, one.rule, one.text] for one in cell.violations],
    }
    rest = list(recorded.lines())
    head["digest"] = _digest(rest)
    lines = [json.dumps(head, **_COMPACT), *rest, ""]
    replace_files({file: "\n".join(lines)})


# --- reading ------------------------------------------------------------------------------------


def is_recording(file: Path) -> bool:
    """Does a file begin as a recording does?"""
    try:
        with open_file(file, OTHER) as stream:
            return stream.read(len(FORMAT) + 12).startswith(b'{"format":"rcx-recording/')
    except InputError:
        return False


def opened(file: Path) -> tuple[Tape, str, str]:
    """The program of a recording, at its start.

    Returns:
        It; what the user should know; what went wrong in the end.

    Raises:
        InputError: no recording, or its sources have changed since; one message.
    """
    content = file_bytes(file, OTHER)
    try:
        lines = content.decode().splitlines()
    except UnicodeDecodeError:
        lines = []
    if not is_recording(file) or not lines:
        raise InputError(f"not a recording of format {FORMAT}", file=file)
    try:
        if json.loads(lines[0])["format"] != FORMAT:
            raise InputError(f"not a recording of format {FORMAT}", file=file)
        head, *rest = map(json.loads, lines)
        if head["digest"] != _digest(lines[1:]):
            raise ValueError
        folder = _folder(head)
        given = [folder / one for one in head["program"]]
        lib = None if head["lib"] is None else folder / head["lib"]
        replace = {name: folder / one for name, one in head["replace"].items()}
        sources = source_files(given, lib, replace)
        _check(head["files"], _digests(sources.all, folder), file)
        program = build(sources.all, "builtin").program
        violations = [Violation(t_us, rule, text) for t_us, rule, text in head["violations"]]
        tape = Tape(program, rest, [tuple(one) for one in head["areas"]], violations)
        test, failed, engine = head["test"], head["failed"], head["engine"]
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError):
        raise InputError("the recording is damaged", file=file, hint="run the test again") from None
    notice = f"{test}: {tape.length} scans, from their end you can go back"
    if engine != "builtin":
        notice += f"; recorded on {engine}, run again on the built-in engine"
    return tape, notice, failed or "the end of the recording"


def _folder(head: Mapping[str, Any]) -> Path:
    """Where the sources are: here, or where they were when the test ran."""
    here = Path.cwd()
    return here if all((here / one).exists() for one in head["program"]) else Path(head["folder"])


def _check(before: Mapping[str, str], after: Mapping[str, str], file: Path) -> None:
    """Refuse a recording of other sources; a library may lie elsewhere."""
    if list(before.values()) == list(after.values()):
        return
    changed = [name for name in before if after.get(name) != before[name]]
    changed += [name for name in after if name not in before]
    more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
    text = f"{changed[0]}{more} changed since this was recorded" if changed else "sources changed"
    raise InputError(text, file=file, hint="run the test again")


class Tape:
    """The program of a recording; see `machine.Machine`.

    Args:
        program: On the built-in engine, as it is before its first scan.
        lines: Of the recording, behind the first.
        areas: Of each controller size, m and n.
        violations: What was found wrong.
    """

    def __init__(
        self,
        program: Program,
        lines: Sequence[Mapping[str, Any]],
        areas: Sequence[tuple[int, ...]],
        violations: Sequence[Violation],
    ) -> None:
        self.program = builtin_of(program)
        located = reads_located(self.program.module.project)
        self.images: Sequence[Image] = [
            find_image(program, size=size, m=m, n=n, located=located) for size, m, n in areas
        ]
        self.telegrams: Sequence[Telegrams] = [Telegrams(size) for size, _, _ in areas]
        self.violations: list[Violation] = []
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
        """How many scans there are."""
        return len(self._scans)

    @property
    def ended(self) -> str:
        """Why there is no further scan."""
        return "" if self._done < len(self._scans) else "the end of the recording"

    @property
    def scans(self) -> int:
        """How many scans have run."""
        return self._done

    @property
    def now_us(self) -> int:
        """The time of the last scan."""
        return self._scans[self._done - 1][0] if self._done else 0

    def scan(self) -> None:
        """Do what was done before the next scan, and run it."""
        t_us, done = self._scans[self._done]
        self._do(done)
        areas = [live_input(one, self.program, len(one.get())) for one in self.images]
        self.program.scan(t_us)
        self._done += 1
        for telegrams, so, image in zip(self.telegrams, areas, self.images, strict=True):
            telegrams.take(t_us, so, image.get())
        if self._done == len(self._scans):
            self._do(self._after)
        known = len(self.violations)
        next_us = self._scans[self._done][0] if self._done < len(self._scans) else None
        for one in self._found[known:]:
            if next_us is not None and one.t_us >= next_us:
                break
            self.violations.append(one)

    def _do(self, numbers: Sequence[int]) -> None:
        for number in numbers:
            kind, path, *rest = self._deeds[number]
            if kind == "set":
                self.program.write(path, rest[0])
            else:
                self.program.write_bytes(path, *rest)

    def snapshot(self) -> Any:
        """The state between two scans."""
        states = [one.snapshot() for one in self.telegrams]
        return self.program.snapshot(), self._done, len(self.violations), states

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        program, self._done, found, telegrams = snapshot
        self.program.restore(program)
        del self.violations[found:]
        for one, state in zip(self.telegrams, telegrams, strict=True):
            one.restore(state)

    def inject(self, event: str, controller: int) -> None:
        """There is no robot in a recording."""
        hint = "launch the program itself to let something befall the robot"
        raise InputError("a recording has no robot", hint=hint)

    def close(self) -> None:
        """Nothing to free."""
