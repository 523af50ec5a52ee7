"""The tasks of a project, translated to a CONFIGURATION."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.projects.model import Piece, Project, Unit, made
from structured_text.projects.numbers import interval_text

__all__ = ["NAME", "ToolTask", "configuration"]

#: Name of the CONFIGURATION for a project that has tasks, but no configuration.
NAME = "Tasks"


@dataclass(frozen=True)
class ToolTask:
    """A task, and the programs that it calls.

    Attributes:
        name: Its name in the tool; empty for programs that run in every scan.
        interval_us: Its interval [µs].
        priority: Its priority, the lowest number first; None if the file has none.
        programs: Names of instances and of their programs.
        at: Its line in that file.
    """

    name: str
    interval_us: int
    priority: int | None
    programs: tuple[tuple[str, str], ...]
    file: Path
    at: int


def configuration(tasks: Sequence[ToolTask]) -> Project:
    """Return a CONFIGURATION with the tasks; it belongs to the file of the first task.

    Tasks without programs get a note.
    """
    notes = tuple(
        f"{task.file}:{task.at}: the task {task.name} calls no program"
        for task in tasks
        if not task.programs
    )
    tasks = [task for task in tasks if task.programs]
    if not tasks:
        return Project(notes=notes)
    first = tasks[0]
    lines = [*made(first.at, f"CONFIGURATION {NAME}", "  RESOURCE Plc ON PLC")]
    for task in tasks:
        at = task.at if task.file == first.file else first.at
        if task.name:
            priority = "" if task.priority is None else f", PRIORITY := {task.priority}"
            interval = interval_text(task.interval_us)
            lines += made(at, f"    TASK {task.name}(INTERVAL := {interval}{priority});")
    for task in tasks:
        at = task.at if task.file == first.file else first.at
        given = f" WITH {task.name}" if task.name else ""
        lines += [
            line
            for instance, program in task.programs
            for line in made(at, f"    PROGRAM {instance}{given} : {program};")
        ]
    lines += made(first.at, "  END_RESOURCE", "END_CONFIGURATION")
    unit = Unit("CONFIGURATION", Piece(NAME, tuple(lines)), first.file)
    return Project((unit,), notes)
