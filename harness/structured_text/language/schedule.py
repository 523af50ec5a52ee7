"""The schedule of a project: its program instances, its tasks and the order in which they run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from structured_text.language import syntax as s
from structured_text.language.declare import Declarations
from structured_text.language.project import ScheduledInstance, Task
from structured_text.language.registry import Declared, Registry
from structured_text.language.scalars import TIME
from structured_text.language.tree import Pou
from structured_text.language.types import BlockType

__all__ = ["Schedule", "configure"]

#: Priority of a task without PRIORITY. By the standard it is the lowest priority, so the task runs
#: last.
_LOWEST = 65535
#: Longest period [us] of a program that has no task in a project with tasks. A shorter tick of the
#: tasks is the period.
_SCAN_US = 10_000


@dataclass(frozen=True)
class Schedule:
    """The instances, tasks, base tick and running order of a project."""

    instances: dict[str, BlockType]
    tasks: tuple[Task, ...]
    tick_us: int | None
    runs: tuple[ScheduledInstance, ...]


def configure(registry: Registry, declarations: Declarations) -> Schedule:
    """Return the instances, tasks and running order of a project.

    Without a CONFIGURATION, one PROGRAM runs in every scan as `Main` (`_uncalled`).

    Raises:
        InputError: There is no CONFIGURATION and more than one program to run, or the CONFIGURATION
            has a mistake.
    """
    declared = registry.configuration
    if declared is None:
        programs = _uncalled(registry, declarations)
        blocks = [pou.block for pou in programs if pou.block is not None]
        instances = dict(zip(("Main",), blocks, strict=False))
        return Schedule(
            instances, (), None, tuple(ScheduledInstance(name, 1) for name in instances)
        )
    return _configured(declared, registry, declarations)


def _uncalled(registry: Registry, declarations: Declarations) -> list[Pou]:
    """Return the program that runs without a CONFIGURATION; none if all are called.

    The result is the only program that no other program calls. If there are several, the program
    PLC_PRG or MAIN runs; new projects of CODESYS and TwinCAT have these names.
    """
    programs = [pou for pou in declarations.pous.values() if pou.kind == "PROGRAM"]
    if len(programs) > 1:
        first = registry.pous[programs[0].name.upper()]
        first.note("several PROGRAMs without a CONFIGURATION", first.node.name.at)
    free = [pou for pou in programs if pou.name.upper() not in declarations.called]
    usual = [pou for pou in free if pou.name.upper() in ("MAIN", "PLC_PRG")]
    if len(free) > 1 and len(usual) != 1:
        second = registry.pous[free[1].name.upper()]
        raise second.error(
            f"several programs and no CONFIGURATION: {', '.join(pou.name for pou in free)}",
            second.node.name.at,
            "add one; or call the others from one of them, or call that MAIN or PLC_PRG",
        )
    return usual if len(free) > 1 else free


def _configured(declared: Declared, registry: Registry, declarations: Declarations) -> Schedule:
    node = declared.node
    assert isinstance(node, s.Configuration)
    if node.resources > 1:
        raise declared.error("more than one RESOURCE is not supported", node.at)
    intervals: dict[str, tuple[s.Name, int, int]] = {}
    for task in node.tasks:
        if task.name.key in intervals:
            raise declared.error(f"the task {task.name.text} is declared twice", task.at)
        intervals[task.name.key] = (task.name, *_settings(task, declared, declarations))
    instances: dict[str, BlockType] = {}
    members: dict[str, list[str]] = {key: [] for key in intervals}
    free: list[str] = []
    for program in node.programs:
        instances[program.name.text] = _instance(
            program, instances, declared, registry, declarations
        )
        if program.task is None:
            free.append(program.name.text)
        elif program.task.key not in members:
            raise declared.error(f"there is no task {program.task.text}", program.task.at)
        else:
            members[program.task.key].append(program.name.text)
    if not instances:
        raise declared.error("the CONFIGURATION has no PROGRAM", node.at)
    tasks = tuple(
        Task(name.text, interval, priority, tuple(members[key]))
        for key, (name, interval, priority) in intervals.items()
    )
    # A program without a task does not depend on the tasks: it runs in every scan.
    own_us = [_SCAN_US] if free else []
    tick = math.gcd(*(task.interval_us for task in tasks), *own_us) if tasks else None
    runs = [
        ScheduledInstance(instance, task.interval_us // (tick or 1))
        for task in sorted(tasks, key=lambda task: task.priority)
        for instance in task.instances
    ]
    return Schedule(instances, tasks, tick, (*runs, *(ScheduledInstance(name, 1) for name in free)))


def _settings(
    task: s.TaskDeclaration, declared: Declared, declarations: Declarations
) -> tuple[int, int]:
    interval, priority = 0, _LOWEST
    for name, value in task.settings:
        if name.key == "INTERVAL":
            nanoseconds = declarations.constant(value, TIME, declared).value
            interval, rest = divmod(int(nanoseconds), 1000)
            if interval <= 0 or rest:
                raise declared.error("an interval must be whole microseconds above 0", value.at)
        elif name.key == "PRIORITY":
            if not isinstance(value, s.Literal) or not value.text.isdigit():
                raise declared.error("a priority must be a whole number", value.at)
            priority = int(value.text)
        else:
            raise declared.error(f"{name.text} of a task is not supported", name.at)
    if not interval:
        raise declared.error(
            f"the task {task.name.text} has no INTERVAL", task.at, "write (INTERVAL := T#10ms)"
        )
    return interval, priority


def _instance(
    program: s.ProgramInstance,
    instances: dict[str, BlockType],
    declared: Declared,
    registry: Registry,
    declarations: Declarations,
) -> BlockType:
    name, kind = program.name, program.program
    if program.connected:
        raise declared.error(
            "connections of a PROGRAM are not supported", program.at, "use VAR_GLOBAL"
        )
    if name.key in (known.upper() for known in instances):
        raise declared.error(f"the program instance {name.text} is declared twice", name.at)
    clash = registry.variable_clash(name.key)
    if clash and name.key != kind.key:  # PLC tools give a single instance the name of its program
        raise declared.error(f"{name.text} {clash}", name.at, "choose another instance name")
    if name.key in declarations.globals and name.key not in declarations.programs:
        raise declared.error(f"{name.text} is also a global variable", name.at)
    pou = declarations.pous.get(kind.key)
    if pou is None or pou.kind != "PROGRAM" or pou.block is None:
        raise declared.error(f"there is no program {kind.text}", kind.at)
    others = [one for one, block in instances.items() if block is pou.block]
    if others and kind.key in declarations.programs:
        raise declared.error(
            f"{kind.text} is used by its name, and has the instances {others[0]} and {name.text}",
            name.at,
            "use a program with a single instance",
        )
    return pou.block
