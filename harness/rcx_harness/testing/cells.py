"""The cells of a test: built from its settings, checked, shown in its report, and closed."""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Callable, Mapping
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import structured_text
from rcx_harness.cell import Cell, CellTimeout
from rcx_harness.robot import Violation
from rcx_harness.testing.evidence import (
    broken_rules,
    chart_of,
    state_of,
    watched_of,
    write_files,
)
from rcx_harness.testing.settings import artifacts, settings_of
from rcx_harness.verify.debug.recording import write_recording
from structured_text.debug.recording import Recorded
from structured_text.engines.base import Program
from structured_text.errors import InputError
from structured_text.output.units import format_us
from structured_text.testing.settings import project

__all__ = ["Build", "Cells", "folder_of", "shorten"]

#: Type of the fixture `rcx_build`: a function with the options of a cell that returns the cell.
Build = Callable[..., Cell]

_FILES = re.compile(r"(chart|trace|view|recording)(-\d+)?\.(svg|jsonl|html)")
_LONGEST = 80
#: Times of a cell. A message about a time begins with the given words (clocks.py).
_TIMES = {"scan": "the scan", "rpi": "the RPI", "jitter": "the jitter", "timeout": "the time-out"}
#: Folders of the packages of the harness, whose frames tracebacks hide.
_PACKAGES = (Path(__file__).resolve().parents[1], Path(structured_text.__file__).resolve().parent)


class Cells:
    """All cells that one test has built."""

    def __init__(self, item: pytest.Item, temporary: pytest.TempPathFactory) -> None:
        self._item = item
        self._temporary = temporary
        self._cells: list[Cell] = []
        self._recorded: list[tuple[Recorded, Mapping[str, Any]]] = []
        self._failed = ""
        self._told: list[int] = []
        self._attached = False
        self._evidence: list[tuple[str, str]] | None = None
        self._files: list[Path] = []
        self._forget_last_run()

    def build(self, **changes: Any) -> Cell:
        """Build a cell from the settings of the test. `changes` replace some settings."""
        settings = settings_of(self._item, changes)
        recorded: list[Recorded] = []
        try:
            cell = Cell.build(**settings, through=partial(_recording, recorded))
        except InputError as error:
            _hint_at_units(error, settings)
            raise
        for text in cell.mistakes:
            self._item.warn(pytest.PytestWarning(text))
        self._cells.append(cell)
        self._recorded.append((recorded[0], settings))
        self._told.append(0)
        return cell

    def broken(self) -> str:
        """Return a text about forbidden violations since the last call. Empty if there are none."""
        found: list[Violation] = []
        for number, cell in enumerate(self._cells):
            found += cell.violations[self._told[number] :]
            self._told[number] = len(cell.violations)
        found = [one for one in found if not self._allowed(one)]
        if not found:
            return ""
        what = "a rule was broken" if len(found) == 1 else f"{len(found)} times a rule was broken"
        lines = [f"  {format_us(one.t_us):>14}  {one.text}" for one in found]
        rules = ", ".join(f'"{rule}"' for rule in dict.fromkeys(one.rule for one in found))
        hint = f"(a test that means it to: @pytest.mark.allow_violations({rules}))"
        return "\n".join([f"rcx: {what}:", *lines, hint])

    def finish(self) -> str:
        """Close all cells.

        Returns:
            The result of the last call of `broken`.
        """
        broken = self.broken()
        try:
            if broken:
                self._failed = broken.splitlines()[1].strip()
                self._collect()
        finally:
            for cell in self._cells:
                cell.close()
        return broken

    def attach(self, report: pytest.TestReport) -> None:
        """Add chart, variables and file names to a report. Only the first call has an effect."""
        if self._attached or not self._cells:
            return
        self._attached = True
        self._failed = self._failed or _first_line(report)
        report.sections += self._collect()
        named: list[tuple[str, object]] = [(f"rcx_{path.stem}", str(path)) for path in self._files]
        report.user_properties += named
        # a JUnit report reads these texts at the end of the test
        self._item.user_properties += named
        if self._item.config.pluginmanager.hasplugin("html"):
            _attach_html(report, self._files)

    def _collect(self) -> list[tuple[str, str]]:
        """Return titles and texts for the report. The first call also writes the files."""
        if self._evidence is None:
            self._evidence = []
            for number, cell in enumerate(self._cells, 1):
                of = f" {number} of {len(self._cells)}" if len(self._cells) > 1 else ""
                self._evidence += self._of_one(cell, f"cell{of}")
            self._evidence.append(("rcx: files", self._write()))
        return self._evidence

    def _of_one(self, cell: Cell, name: str) -> list[tuple[str, str]]:
        sections = [(f"rcx: timing chart of the {name}", chart_of(cell))]
        if not cell.closed:
            sections.append((f"rcx: variables of the {name}", state_of(cell)))
        if watched := watched_of(cell):
            sections.append((f"rcx: watched variables of the {name}", watched))
        if cell.violations:
            sections.append((f"rcx: broken rules in the {name}", broken_rules(cell)))
        return sections

    def _write(self) -> str:
        folder = self._folder()
        try:
            for number, cell in enumerate(self._cells, 1):
                suffix = f"-{number}" if len(self._cells) > 1 else ""
                self._files += write_files(cell, folder, self._item.nodeid, suffix)
                self._files.append(self._write_recording(number, folder, suffix))
        except InputError as error:
            return str(error)
        return "\n".join(_short(path) for path in self._files)

    def _write_recording(self, number: int, folder: Path, suffix: str) -> Path:
        """Write the recording of the failed test, which `rcx debug` can open."""
        recorded, settings = self._recorded[number - 1]
        file, test = folder / f"recording{suffix}.jsonl", self._item.nodeid
        home, cell = project(self._item.config), self._cells[number - 1]
        write_recording(file, recorded, cell, settings, home, test, self._failed)
        return file

    def _folder(self) -> Path:
        named = self._named_folder()
        if named is not None:
            return named
        return self._temporary.mktemp("rcx-" + _file_name(self._item.name)[:30])

    def _named_folder(self) -> Path | None:
        """Return the test's folder below the folder for failures.

        None if the user has set no folder.
        """
        parent = artifacts(self._item.config)
        if parent is None:
            return None
        return parent.joinpath(folder_of(self._item))

    def _forget_last_run(self) -> None:
        """Remove the files of an earlier failure of this test, because the test may pass now."""
        folder = self._named_folder()
        if folder is None or not folder.is_dir():
            return
        for path in folder.iterdir():
            if _FILES.fullmatch(path.name):
                path.unlink(missing_ok=True)
        if not any(folder.iterdir()):
            folder.rmdir()

    def _allowed(self, violation: Violation) -> bool:
        """Return whether a marker allows the rule of this violation, or all rules."""
        markers = self._item.iter_markers("allow_violations")
        return any(not marker.args or violation.rule in marker.args for marker in markers)


def _recording(made: list[Recorded], program: Program) -> Program:
    """Wrap the program of a cell so that it is recorded."""
    made.append(Recorded(program))
    return made[-1]


def _first_line(report: pytest.TestReport) -> str:
    """Return the reason of a failure in one line."""
    crash = getattr(report.longrepr, "reprcrash", None)
    text = str(crash.message if crash is not None else report.longrepr or "the test failed")
    return next((line.strip() for line in text.splitlines() if line.strip()), "the test failed")


def folder_of(item: pytest.Item) -> Path:
    """Return the folder for the files of a test, which mirrors the test's path in the project."""
    file, _, name = item.nodeid.partition("::")
    names, bracket, parameter = name.partition("[")
    parts = [*file.removesuffix(".py").split("/"), *names.split("::")]
    parts[-1] += bracket + parameter
    return Path(*map(_file_name, parts))


def _hint_at_units(error: InputError, settings: Mapping[str, Any]) -> None:
    """Add a hint about the unit if a number without a unit was refused as a time."""
    for name, what in _TIMES.items():
        value = settings.get(name)
        if type(value) is int and not error.hint and error.message.startswith(f"{what} is "):
            hint = f"a bare number is microseconds; write '{value}ms'"
            raise InputError(error.message, hint=hint) from None


def _file_name(name: str) -> str:
    """Return a folder name for a part of a test's name. Different parts get different names."""
    plain = re.sub(r"[^\w.-]+", "-", name, flags=re.ASCII).strip("-")
    if plain == name and len(plain) <= _LONGEST and plain.strip("."):
        return plain
    return f"{plain[:_LONGEST]}-{hashlib.sha256(name.encode()).hexdigest()[:6]}"


def shorten(excinfo: pytest.ExceptionInfo[BaseException]) -> None:
    """Hide the frames of the harness in a traceback, except with --full-trace."""
    for entry in excinfo.traceback:
        path = entry.path
        if isinstance(path, Path) and any(map(path.is_relative_to, _PACKAGES)):
            entry.frame.f_globals["__tracebackhide__"] = _tells_the_user


def _tells_the_user(excinfo: pytest.ExceptionInfo[BaseException] | None) -> bool:
    """Return whether the user's input or test has caused the error, and not the harness."""
    return excinfo is not None and isinstance(excinfo.value, (CellTimeout, InputError))


def _short(path: Path) -> str:
    """Return the path relative to the current folder if the file is in it, else unchanged."""
    return os.path.relpath(path) if path.is_relative_to(Path.cwd()) else str(path)


def _attach_html(report: pytest.TestReport, files: list[Path]) -> None:
    """Show the charts in the report of pytest-html."""
    extras: Any = import_module("pytest_html.extras")
    shown = [
        extras.html(path.read_text(encoding="utf-8")) for path in files if path.suffix == ".svg"
    ]
    report.extras = [*getattr(report, "extras", []), *shown]  # type: ignore[attr-defined]
