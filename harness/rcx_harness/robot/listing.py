"""The robot programs for the trace: their lines, and the line that each task executes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rcx_harness.robot.controller import Controller

__all__ = ["listings", "task_places"]


def listings(controller: Controller) -> list[dict[str, Any]]:
    """Return the programs of a controller, in the order of their numbers.

    Each has its `name`, the name of its `file` if it has one, and its `lines` as written; a program
    that is only a duration has no lines. The list is empty if no program is a text.
    """
    programs = controller.config.programs
    if not any(program.text for program in programs):
        return []
    found = []
    for program in programs:
        entry: dict[str, Any] = {"name": program.name}
        if program.file:
            entry["file"] = Path(program.file).name
        found.append(entry | {"lines": program.text.splitlines() or list(program.steps)})
    return found


def task_places(controller: Controller) -> tuple[dict[str, Any], ...]:
    """Return where each task is, in the order of the numbers of the tasks.

    Each has the number of the `task`, the name of its `program`, the `line` from 1, and its `state`
    (see RobotTask). A controller that is off has no tasks.
    """
    if not controller.machine.powered:
        return ()
    tasks = sorted(
        (task for task in controller.program.tasks if task.number), key=lambda task: task.number
    )
    return tuple(
        {"task": one.number, "program": one.program.name, "line": one.line, "state": one.state}
        for one in tasks
    )
