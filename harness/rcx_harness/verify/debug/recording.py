"""Recordings of cells: files with all inputs of a program in a test, which a debugger replays.

A recording contains the inputs and a digest of each source file.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.image import Image, find_image
from rcx_harness.cell.sources import source_files
from rcx_harness.robot import Violation
from rcx_harness.verify.debug.around import live_input, scopes
from rcx_harness.verify.debug.telegrams import Telegrams
from rcx_harness.watch.image_source import reads_located
from structured_text.debug.machine import Scope
from structured_text.debug.recording import COMPACT, Recorded, Tape
from structured_text.engines.base import Program
from structured_text.engines.load import build
from structured_text.errors import InputError
from structured_text.language.source import source_text
from structured_text.output.files import replace_files
from structured_text.output.limits import OTHER
from structured_text.output.reading import file_bytes, open_file

__all__ = ["FORMAT", "CellTape", "is_recording", "opened", "write_recording"]

#: First entry of the first line of a recording.
FORMAT = "rcx-recording/1"


def _digest(lines: Sequence[str]) -> str:
    """Return a digest of all lines except the first line.

    The digest reveals lost and changed lines.
    """
    return hashlib.sha256("\n".join(lines).encode()).hexdigest()


# --- writing ------------------------------------------------------------------------------------


def _digests(files: Sequence[Path], folder: Path) -> dict[str, str]:
    """Return the digest of each source file, by the name of the file."""
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
    """Write the recording of a cell's program.

    The cell may already be closed. `settings` are the arguments with which `Cell.build` built the
    cell. Files below `folder` are named relative to it. `failed` is the reason of the failure in
    one line.
    """
    given = settings["program"]
    named = [given] if isinstance(given, (str, Path)) else given
    replace = settings.get("replace") or {}
    lib = settings.get("lib")
    device = settings.get("device") or ""
    sources = source_files(list(named), lib, replace, settings.get("dialect"), device)
    head = {
        "format": FORMAT,
        "test": test,
        "failed": failed,
        "engine": recorded.engine,
        "dialect": sources.dialect,
        "device": device,
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
    lines = [json.dumps(head, **COMPACT), *rest, ""]
    replace_files({file: "\n".join(lines)})


# --- reading ------------------------------------------------------------------------------------


def is_recording(file: Path) -> bool:
    """Return whether a file has the beginning of a recording."""
    try:
        with open_file(file, OTHER) as stream:
            return stream.read(len(FORMAT) + 12).startswith(b'{"format":"rcx-recording/')
    except InputError:
        return False


def opened(file: Path) -> tuple[CellTape, str, str]:
    """Return the program of a recording at its start.

    Returns:
        The program, a notice for the user, and the reason of the failure at the end of the test.

    Raises:
        InputError: The file is not a recording, or its sources have changed since. One message
            covers all sources.
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
        sources = source_files(given, lib, replace, head["dialect"], head.get("device", ""))
        _check(head["files"], _digests(sources.all, folder), file)
        program = build(sources.all, "builtin").program
        violations = [Violation(t_us, rule, text) for t_us, rule, text in head["violations"]]
        tape = CellTape(program, rest, [tuple(one) for one in head["areas"]], violations)
        test, failed, engine = head["test"], head["failed"], head["engine"]
    except (KeyError, TypeError, ValueError, IndexError, AttributeError, RecursionError):
        raise InputError("the recording is damaged", file=file, hint="run the test again") from None
    notice = f"{test}: {tape.length} scans, from their end you can go back"
    if engine != "builtin":
        notice += f"; recorded on {engine}, run again on the built-in engine"
    return tape, notice, failed or "the end of the recording"


def _folder(head: Mapping[str, Any]) -> Path:
    """Return the current folder if it has the sources, else the folder of the recorded test."""
    here = Path.cwd()
    return here if all((here / one).exists() for one in head["program"]) else Path(head["folder"])


def _check(before: Mapping[str, str], after: Mapping[str, str], file: Path) -> None:
    """Raise InputError if sources have changed; the library may be in another folder."""
    if list(before.values()) == list(after.values()):
        return
    changed = [name for name in before if after.get(name) != before[name]]
    changed += [name for name in after if name not in before]
    more = f" and {len(changed) - 1} more" if len(changed) > 1 else ""
    text = f"{changed[0]}{more} changed since this was recorded" if changed else "sources changed"
    raise InputError(text, file=file, hint="run the test again")


class CellTape(Tape):
    """The recorded program of a cell, which the debugger replays.

    Args:
        lines: All lines of the recording except the first line.
        areas: Size, m and n of each controller's areas.
    """

    def __init__(
        self,
        program: Program,
        lines: Sequence[Mapping[str, Any]],
        areas: Sequence[tuple[int, ...]],
        violations: Sequence[Violation],
    ) -> None:
        super().__init__(program, lines, violations)
        located = reads_located(self.program.module.project)
        self._images: Sequence[Image] = [
            find_image(program, size=size, m=m, n=n, located=located) for size, m, n in areas
        ]
        self.telegrams: Sequence[Telegrams] = [Telegrams(size) for size, _, _ in areas]
        self.around: Sequence[Scope] = scopes(self.program, self._images, self.telegrams)

    @contextmanager
    def watched(self, t_us: int) -> Iterator[None]:
        """Record the telegrams of the scan that runs inside this context."""
        areas = [live_input(one, self.program, len(one.get())) for one in self._images]
        yield
        for telegrams, so, image in zip(self.telegrams, areas, self._images, strict=True):
            telegrams.take(t_us, so, image.get())

    def snapshot(self) -> Any:
        """Return a snapshot of the program between two scans."""
        return super().snapshot(), [one.snapshot() for one in self.telegrams]

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the program."""
        tape, telegrams = snapshot
        super().restore(tape)
        for one, state in zip(self.telegrams, telegrams, strict=True):
            one.restore(state)

    def inject(self, event: str, device: int) -> None:
        """Raise InputError, because a recording has no robot."""
        hint = "launch the program itself to inject events into the robot"
        raise InputError("a recording has no robot", hint=hint)
