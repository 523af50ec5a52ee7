"""The robot programs for the trace: their lines, and the line that each task executes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rcx_harness.robot.controller import Controller

__all__ = ["Tasks", "listings", "task_places"]


def listings(controller: Controller) -> list[dict[str, Any]]:
    """Return the programs of a controller, in the order of their numbers.

    Each entry has the `name`, the `lines` as written, and the name of the `file` if there is one. A
    program that is only a duration has no lines. If no program has a text, the list is empty.
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
    """Return the current line and state of each task, in the order of their numbers.

    Each entry has the number of the `task`, the name of its `program`, the `line` from 1, and its
    `state` (see RobotTask). A controller that is off has no tasks.
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


class Tasks:
    """The tasks of a controller for a trace. A trace stores the tasks only when they have changed.

    If no program has a text, the tasks never change.
    """

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._has_text = any(program.text for program in controller.config.programs)
        self.forget()

    def forget(self) -> None:
        """Forget the last tasks, so that the next call of `changed` returns the tasks."""
        self._seen: list[Any] = []
        self._places: tuple[dict[str, Any], ...] | None = None

    def changed(self) -> tuple[dict[str, Any], ...] | None:
        """Return `task_places` if they have changed since the last call; else None."""
        if not self._has_text:
            return None
        # A cheap comparison comes first, because this method runs in every cycle and the tasks
        # rarely change.
        programs = self._controller.program
        seen = [programs, *((one.number, one.at, one.state) for one in programs.tasks)]
        seen.append(self._controller.machine.powered)
        if seen == self._seen:
            return None
        self._seen = seen
        before, self._places = self._places, task_places(self._controller)
        return None if self._places == before else self._places
