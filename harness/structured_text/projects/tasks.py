"""The tasks of a project, translated to a CONFIGURATION."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from structured_text.projects.model import Lines, Piece, Project, Unit, made
from structured_text.projects.numbers import interval_text

__all__ = [
    "EDGE",
    "FREE",
    "LEVEL",
    "NAME",
    "NEVER",
    "UNKNOWN",
    "ToolTask",
    "by_event",
    "configuration",
]

#: Name of the CONFIGURATION for a project that has tasks, but no configuration.
NAME = "Tasks"


#: Ways to start a task: at a rising edge of a variable, while a variable is TRUE, at the end of its
#: last run (freewheeling), or at an external event, which never occurs here.
EDGE, LEVEL, FREE, UNKNOWN = "edge", "level", "free", "unknown"

#: Part of the note on a task with an event that this toolkit does not simulate.
NEVER = "it never occurs here"


@dataclass(frozen=True)
class ToolTask:
    """A task, and the programs that it calls.

    Attributes:
        name: Name of the task in the tool; empty for programs that run in every scan.
        interval_us: Interval of the task [µs]; 0 if something else starts the task.
        priority: Priority of the task, the lowest number first; None if the file has none.
        programs: Names of instances and of their programs.
        at: Line of the task in its file.
        start: EDGE, LEVEL, FREE or UNKNOWN; empty for an interval.
        event: The variable, or the name of the event; empty if the file has none.
    """

    name: str
    interval_us: int
    priority: int | None
    programs: tuple[tuple[str, str], ...]
    file: Path
    at: int
    start: str = ""
    event: str = ""

    @property
    def unknown(self) -> str:
        """Return a note if the event of the task never occurs here; else an empty text."""
        if self.start != UNKNOWN:
            return ""
        programs = ", ".join(name for name, _ in self.programs)
        event = f"the event {self.event}" if self.event else "an event that the file does not name"
        return (
            f"{self.file}:{self.at}: {event} starts the task {self.name}; {NEVER}, "
            f"so the task does not call {programs}; give other tasks by --replace {NAME}=file.st"
        )


def by_event(tasks: Sequence[ToolTask]) -> tuple[list[ToolTask], Project]:
    """Replace each task that a variable starts by a program that runs in every scan.

    The new program calls the programs of the task at a rising edge of the variable (CODESYS:
    Event), or while the variable is TRUE (Status). A freewheeling task becomes a program that runs
    in every scan.

    Returns:
        The remaining tasks, and a project with a program for each variable and the notes. Tasks
        that an unknown event starts are left out.
    """
    found: list[ToolTask] = []
    units: list[Unit] = []
    for task in tasks:
        if task.start in (EDGE, LEVEL) and task.programs:
            name = f"{task.name}_{task.start}"
            units.append(Unit("PROGRAM", Piece(name, _caller(name, task)), task.file))
            task = replace(task, name="", programs=((name, name),))
        elif task.start == FREE:
            task = replace(task, name="")
        if task.start != UNKNOWN:
            found.append(task)
    notes = tuple(task.unknown for task in tasks if task.programs and task.unknown)
    return found, Project(tuple(units), notes)


def _caller(name: str, task: ToolTask) -> Lines:
    """Return a program that calls the programs of a task by an edge or level of its variable."""
    calls = [f"    {program}();" for _, program in task.programs]
    if task.start == LEVEL:
        texts = [f"  IF {task.event} THEN", *calls, "  END_IF;"]
    else:
        texts = [
            "  VAR",
            "    Before : BOOL;",
            "  END_VAR",
            f"  IF {task.event} AND NOT Before THEN",
            *calls,
            "  END_IF;",
            f"  Before := {task.event};",
        ]
    return made(task.at, f"PROGRAM {name}", *texts, "END_PROGRAM")


def configuration(tasks: Sequence[ToolTask]) -> Project:
    """Return a CONFIGURATION with the tasks.

    The CONFIGURATION belongs to the file of the first task.

    Tasks without programs get a note.
    """
    tasks, events = by_event(tasks)
    notes = tuple(
        f"{task.file}:{task.at}: the task {task.name} calls no program"
        for task in tasks
        if not task.programs
    )
    tasks = [task for task in tasks if task.programs]
    if not tasks:
        return events.plus(Project(notes=notes))
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
    return events.plus(Project((unit,), notes))
