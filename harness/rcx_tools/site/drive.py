"""The driver of the playground: it runs the cell of a job, and the run becomes a page.

The worker of the page calls `run` in the browser. The module imports only the harness, and nothing
else of this repository.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.trace.view.page import View
from structured_text.errors import InputError
from structured_text.output.units import format_us, parse_us

__all__ = ["STIMULUS", "Runner"]

#: File name of the stimulus in messages. Line n of this file is moment n.
STIMULUS = "stimulus"
_TOML_PLACE = re.compile(r"\(at line (\d+)")
_SLICES = 50
_KEEP = 400_000
_MOST_RULES = 20
#: Lists of variables to watch, in the order in which they are tried. The last list is empty: it is
#: for a program with another name than Main.
_WATCH = (("Main.*", "Main.*.*"), ("Main.*",), ())
_POSITIONS = "mm"
#: Suffix of robot programs that a robot file refers to.
_OF_ROBOTS = ".PGM"


class Runner:
    """Runs jobs one after the other, and returns the trace of the last run.

    Args:
        folder: Folder for the files of a job. Its old content is deleted.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._trace: list[str] = []

    def run(self, job: str, tell: Callable[[float], object]) -> str:
        """Run a job.

        Args:
            job: JSON: `name`; `files`, the texts of ST files and robot programs by name; `robots`,
                texts of robot files; `stimulus`, a list of [time in us, the other keys of the
                moment as TOML]; `scan`, `rpi` and `for`, times as users write them; `size`, `m`
                and `n` as at `Cell.build`, null for their defaults.
            tell: Function that is called with the completed fraction of the run.

        Returns:
            JSON: `page`, HTML; `told`, one line; `broken`, lines of broken rules. Or `error` with
            `message`, `hint`, and its place: `file` and `line`, `moment` of the stimulus from 0.
        """
        try:
            return json.dumps(self._run(json.loads(job), tell))
        except InputError as error:
            return json.dumps({"error": self._told(error)})
        except RecursionError:
            return json.dumps({"error": {"message": "the program is nested too deeply"}})

    def trace(self) -> str:
        """Return the trace of the last run, as `rcx run --trace` writes it."""
        return "\n".join(self._trace) + "\n"

    def _run(self, job: Mapping[str, Any], tell: Callable[[float], object]) -> dict[str, Any]:
        end_us = parse_us(job["for"])
        programs, robots = self._written(job)
        moments = self._moments(job["stimulus"])
        given: dict[str, Any] = {"scan": job["scan"], "rpi": job["rpi"], "size": job.get("size")}
        given |= {name: job[name] for name in ("m", "n") if job.get(name)}
        given |= {"robot": robots or None, "positions": _POSITIONS, "keep": _KEEP}
        with _built(programs, given) as cell:
            view = View(cell.trace.header)
            cell.trace.listen(view.take)
            Stimulus.load(moments).schedule(cell)
            for number in range(1, _SLICES + 1):
                cell.run(end_us * number // _SLICES - cell.now_us)
                tell(number / _SLICES)
            page = view.page(job["name"])
        self._trace = list(cell.trace.lines())
        return {"page": page, "told": _told(cell, end_us), "broken": list(_broken(cell))}

    def _written(self, job: Mapping[str, Any]) -> tuple[list[Path], list[Path]]:
        """Write the files of a job to an empty folder; return the ST files and the robot files."""
        shutil.rmtree(self._folder, ignore_errors=True)
        self._folder.mkdir(parents=True)
        files = [self._folder / name for name in sorted(job["files"])]
        for file in files:
            file.write_text(job["files"][file.name], encoding="utf-8")
        programs = [file for file in files if file.suffix.upper() != _OF_ROBOTS]
        robots = [self._folder / f"robot{number}.toml" for number, _ in enumerate(job["robots"], 1)]
        for file, text in zip(robots, job["robots"], strict=True):
            file.write_text(text, encoding="utf-8")
        return programs, robots

    def _moments(self, moments: Iterable[tuple[int, str]]) -> Path:
        """Write the stimulus to a file whose line n is moment n; return the path of the file."""
        file = self._folder / STIMULUS
        lines = [f'{{ time = "{t_us}us", {rest} }},' for t_us, rest in moments]
        file.write_text("at = [" + "\n".join([*lines, "]"]) + "\n", encoding="utf-8")
        return file

    def _told(self, error: InputError) -> dict[str, Any]:
        told: dict[str, Any] = {"message": error.message, "hint": error.hint}
        if error.file is None:
            return told
        file, line = Path(error.file), error.line
        if line is None and (found := _TOML_PLACE.search(error.message)):
            line = int(found[1])
        if file.name == STIMULUS:
            return told | ({} if line is None else {"moment": line - 1})
        name = file.name if file.parent == self._folder else error.file
        return told | {"file": name, "line": line}


def _built(programs: Sequence[Path], given: Mapping[str, Any]) -> Cell:
    """Return a cell that watches the first list of `_WATCH` whose variables exist."""
    *more, least = _WATCH
    for watch in more:
        try:
            return Cell.build(programs, engine="builtin", watch=watch, **given)
        except InputError as error:
            if not error.message.startswith("no variable matches"):
                raise
    return Cell.build(programs, engine="builtin", watch=least, **given)


def _told(cell: Cell, end_us: int) -> str:
    if not cell.matched:
        return "no connection: the areas of PLC and robot differ in size"
    broken = len(cell.violations)
    return (
        f"{format_us(end_us)}: {cell.scans} scans of {cell.timing.scan_us / 1000:g} ms, "
        f"{cell.commands or 'no'} remote command{'s' * (cell.commands != 1)}, "
        f"{broken or 'no'} broken rule{'s' * (broken != 1)}"
    )


def _broken(cell: Cell) -> Iterable[str]:
    for one in cell.violations[:_MOST_RULES]:
        yield f"{format_us(one.t_us)}: {one.text}"
    if (rest := len(cell.violations) - _MOST_RULES) > 0:
        yield f"and {rest} more"
