"""The checked project: engines compile it, and paths are resolved in it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.language.constructs import Use
from structured_text.language.dialects import IEC
from structured_text.language.objects import Objects
from structured_text.language.tree import Pou, Symbol
from structured_text.language.types import BlockType, Located, Type, Variable

__all__ = ["Project", "ScheduledInstance", "Task", "Unit", "runnable"]


@dataclass(frozen=True)
class Task:
    """A task of the configuration. A task with a lower `priority` number runs first."""

    name: str
    interval_us: int
    priority: int
    instances: tuple[str, ...]


@dataclass(frozen=True)
class ScheduledInstance:
    """A program instance that runs in every `every`-th scan, starting with the first."""

    instance: str
    every: int


@dataclass(frozen=True)
class Unit:
    """A declaration; `line` is its first line in its file.

    `kind` is TYPE, INTERFACE, FUNCTION, FUNCTION_BLOCK, PROGRAM or CONFIGURATION.
    """

    kind: str
    name: str
    file: Path
    line: int


@dataclass(frozen=True, eq=False)
class Project:
    """All checked declarations of the sources.

    Attributes:
        files: The files, each after the files that it needs (as matiec requires).
        units: The declarations, each after the declarations that it needs.
        types: Structures, arrays, enumerations and aliases by upper-case name.
        blocks: Function blocks and programs of the sources, and the standard blocks they use, by
            upper-case name.
        pous: Functions, blocks and programs with their checked bodies, by upper-case name, each
            after those that it calls.
        initial: Complete initial value of every type in `types`, by upper-case name.
        instances: Program instances by name in order of declaration. Sources without a
            CONFIGURATION and with exactly one PROGRAM have one instance, named `Main`.
        configured: Whether the sources have a CONFIGURATION.
        globals: Global variables by upper-case name, with their declared name and type.
        global_symbols: Global variables by upper-case name, with their initial values.
        lists: Lists of globals by upper-case name: the key in `globals` for each variable's name.
        located: Directly represented variables in order of declaration.
        tasks: Tasks in order of declaration.
        tick_us: Greatest common divisor of the intervals; None without tasks.
        schedule: Program instances in the order in which they run within a scan.
        objects: The inheritance between blocks and interfaces, and their methods.
        views: Whether memory is read as another type, by pointers or in a UNION.
        key: Key of the sources and their contents for `language.cache`; empty if results must not
            be cached.
        uses: Constructs beyond the portable subset.
        dialect: Name of the dialect (`language.dialects`) in which the project was read.
    """

    files: tuple[Path, ...]
    units: tuple[Unit, ...]
    types: dict[str, Type]
    blocks: dict[str, BlockType]
    pous: dict[str, Pou]
    initial: dict[str, Any]
    instances: dict[str, BlockType]
    configured: bool
    globals: dict[str, Variable]
    global_symbols: dict[str, Symbol]
    lists: dict[str, dict[str, str]]
    located: tuple[Located, ...]
    tasks: tuple[Task, ...]
    tick_us: int | None
    schedule: tuple[ScheduledInstance, ...]
    objects: Objects
    views: bool
    key: str = ""
    uses: tuple[Use, ...] = ()
    dialect: str = IEC

    @property
    def free(self) -> tuple[str, ...]:
        """Return the program instances without a task in a project with tasks."""
        bound = {name for task in self.tasks for name in task.instances}
        return tuple(name for name in self.instances if self.tasks and name not in bound)


def runnable(project: Project) -> Project:
    """Return the project if it has a program to run.

    Raise InputError if the project is a library.
    """
    if not project.instances:
        raise InputError(
            "there is no PROGRAM in the sources", hint="name the file of the program to run"
        )
    return project
