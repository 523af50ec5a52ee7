"""The commands above a PROGRAM: prove, run and sweep. They are carried out on the saved files."""

from __future__ import annotations

import json
import os
import shlex
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from structured_text.editor.diagnostics import Note
from structured_text.editor.extras import Lens
from structured_text.editor.settings import Settings
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.output.paths import real
from structured_text.output.programs import environment, run
from structured_text.projects.sources import SourceFiles

__all__ = ["lenses", "perform"]

_STIMULUS, _ROBOT = "stimulus.toml", "robot.toml"
_ACTIONS = ("prove", "run", "sweep")
_VIEW = os.path.join("out", "run.html")
_PROVED = ("proved", "noted")
#: Exit codes with a result: nothing found, and something found.
_RESULTS = (0, 1)


def lenses(path: Path, source: s.Source, sources: SourceFiles) -> list[Lens]:
    """Return the commands for each program in a file of the user."""
    if real(path) not in map(real, sources.own):
        return []
    actions = ["prove", "run"]
    if sources.lib and (path.parent / _STIMULUS).is_file():
        actions.append("sweep")
    return [
        Lens(node.at.line, action, action, (str(path), node.at.line))
        for node in source.declarations
        if isinstance(node, s.Pou) and node.kind == "PROGRAM"
        for action in actions
    ]


def perform(
    action: str,
    arguments: Sequence[Any],
    program: Sequence[Path],
    sources: SourceFiles,
    settings: Settings,
) -> list[Note]:
    """Carry out a command, and return its results as notes; the first is at the program."""
    if action not in _ACTIONS or len(arguments) != 2:
        raise InputError(f"there is no command {action}")
    path, line = Path(str(arguments[0])), int(arguments[1])
    words = [action, *map(os.path.abspath, program), *_options(action, path, sources, settings)]
    done = run(
        [sys.executable, "-m", "rcx_harness", *words],
        cwd=path.parent,
        env=environment(),
        text=True,
        encoding="utf-8",
    )
    if done.returncode not in _RESULTS:
        said = [text for text in done.stderr.splitlines() if text.strip()]
        text = said[-1] if said else f"ended with exit code {done.returncode}"
        return [Note(str(path), line, 0, f"{action}: {text}", "error", action)]
    level = "warning" if done.returncode else "information"
    at = Note(str(path), line, 0, "", level, action)
    if action == "run":
        return _ran(done.stdout, at)
    found = json.loads(done.stdout)
    return _swept(found, at) if action == "sweep" else _proved(found["properties"], at)


def _options(action: str, path: Path, sources: SourceFiles, settings: Settings) -> list[str]:
    folder = path.parent
    found: list[str] = []
    if settings.lib:
        found += ["--lib", settings.lib]
    if settings.dialect:
        found += ["--dialect", settings.dialect]
    if settings.device:
        found += ["--device", settings.device]
    for name, file in settings.replace.items():
        found += ["--replace", f"{name}={file}"]
    if not sources.lib:
        found.append("--no-robot")
    if action == "prove":
        return [*found, "--json", "-", "--out", os.path.join("out", "prove")]
    if (folder / _STIMULUS).is_file():
        found += ["--stimulus", _STIMULUS]
    if sources.lib and (folder / _ROBOT).is_file():
        found += ["--robot", _ROBOT]
    if action == "sweep":
        return [*found, "--json", "-", "--out", os.path.join("out", "sweep")]
    return [*found, "--no-show", "--view", _VIEW]


def _ran(said: str, at: Note) -> list[Note]:
    skipped = ("written: ", "matiec not found")
    lines = [line for line in said.splitlines() if line and not line.startswith(skipped)]
    return [_linked(at, f"run: {' '.join(lines) or 'done'}", Path(at.file).parent / _VIEW)]


def _proved(properties: Sequence[dict[str, Any]], at: Note) -> list[Note]:
    """Return a note on all properties, and one for each that is not proved, at its place."""
    others = [one for one in properties if one["status"] not in _PROVED]
    text = f"prove: {len(properties) - len(others)} of {len(properties)} properties proved"
    notes = [replace(at, text=text, level="information")]
    for one in others:
        file, _, line = one["at"].rpartition(":")
        place = replace(at, file=str(Path(at.file).parent / file), line=int(line)) if file else at
        text = f"prove: {one['status']}: {one['says']}"
        if one["note"]:
            text += f"; {one['note']}"
        stimulus = Path(at.file).parent / one["stimulus"] if one["stimulus"] else None
        notes.append(_linked(replace(place, level="warning"), text, stimulus))
    return notes


def _swept(found: dict[str, Any], at: Note) -> list[Note]:
    """Return a note for each kind of fault from which the cell does not recover."""
    faults = ", ".join(found["inject"])
    if not found["classes"]:
        text = f"sweep: no rule was broken by {faults} at {found['moments']} moments"
        return [replace(at, text=text)]
    notes = []
    for one in found["classes"]:
        words = shlex.split(one["command"])
        name = words[words.index("--stimulus") + 1] if "--stimulus" in words else ""
        text = f"sweep: {one['inject']} at {one['moments']} moments: {one['text']}"
        notes.append(_linked(at, text, Path(at.file).parent / name if name else None))
    return notes


def _linked(at: Note, text: str, file: Path | None) -> Note:
    """Return a note with a link to a file, if the file exists."""
    if file is None or not file.is_file():
        return replace(at, text=text)
    return replace(at, text=text, href=file.as_uri(), data={"replay": str(file)})
