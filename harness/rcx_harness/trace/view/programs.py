"""The robot programs of a recording for the page: listings, and a lane for each task."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rcx_harness.trace.tasks import statement_of, task_text
from rcx_harness.trace.view.lanes import Group, Lane, Lanes
from rcx_harness.trace.view.pack import Texts

__all__ = ["Programs"]

_MOST_TASKS = 64


class Programs:
    """The listings of the robot programs, and the lanes of their tasks.

    Args:
        given: The programs of each controller, as in the header of a trace.

    Raises:
        KeyError, TypeError or ValueError: the header has no programs that can be shown.
    """

    def __init__(self, lanes: Lanes, given: Sequence[Sequence[Mapping[str, Any]]]) -> None:
        self._lanes = lanes
        self._given = [[_checked(program) for program in every] for every in given]
        self._tasks: dict[tuple[int, int], Lane] = {}
        self._places: dict[int, dict[int, tuple[str, int, str]]] = {}
        """For each controller: maps the number of a text to program, line and state."""

    def take(self, t_us: int, controller: int, tasks: Sequence[Mapping[str, Any]]) -> None:
        """Record the tasks of a controller from `t_us` on."""
        places, none = self._places.setdefault(controller, {}), self._none
        programs = self._given[controller - 1] if controller <= len(self._given) else []
        shown: dict[int, int] = {}
        for task in tasks:
            text = task_text(task, statement_of(programs, task))
            shown[task["task"]] = number = self._lanes.text(text)
            places[number] = (task["program"], task["line"], task["state"])
        is_first = all(who != controller for who, _ in self._tasks)
        for task_number in shown:
            if (controller, task_number) not in self._tasks:
                lane = self._tasks[controller, task_number] = self._new(controller, task_number)
                if not is_first:
                    self._lanes.note(lane, t_us, none)
        for (who, task_number), lane in self._tasks.items():
            if who == controller:
                self._lanes.note(lane, t_us, shown.get(task_number, none))

    @property
    def _none(self) -> int:
        return self._lanes.text("no program")

    def _new(self, controller: int, number: int) -> Lane:
        if len(self._tasks) >= _MOST_TASKS:
            raise ValueError("too many tasks")
        name = f"{controller}: Task {number}" if controller > 1 else f"Task {number}"
        return self._lanes.new(name, Texts(), "task", short=f"{name}:", idle=self._none)

    def groups(self) -> Iterator[Group]:
        """Yield a group with the tasks of each controller."""
        several = len({controller for controller, _ in self._tasks}) > 1
        for who in sorted({controller for controller, _ in self._tasks}):
            lanes = [lane for (other, _), lane in sorted(self._tasks.items()) if other == who]
            yield Group(f"Controller {who}: Robot programs" if several else "Robot programs", lanes)

    def table(self, places: Mapping[int, int]) -> list[dict[str, Any]]:
        """Return the programs of each controller for the page.

        `places` has the number of each lane that the page shows. Each entry has the `programs` of
        the controller, its `tasks` (maps the number of a task to its lane), and program, line and
        state for each text in these lanes. The list is empty if no task was recorded.
        """
        return [
            {
                "title": f"Controller {who}" if len(self._given) > 1 else "",
                "programs": programs,
                "tasks": [
                    [number, places[id(lane)]]
                    for (other, number), lane in sorted(self._tasks.items())
                    if other == who
                ],
                "texts": self._places[who],
            }
            for who, programs in enumerate(self._given, 1)
            if programs and who in self._places
        ]


def _checked(program: Mapping[str, Any]) -> dict[str, Any]:
    """Return a program for the page; raise KeyError, TypeError or ValueError if it is invalid."""
    name, lines, file = program["name"], program["lines"], program.get("file", "")
    if not isinstance(name, str) or not isinstance(file, str) or not isinstance(lines, list):
        raise TypeError("no program")
    if not all(isinstance(line, str) for line in lines):
        raise TypeError("no lines")
    return {"name": name, "title": file or name, "lines": lines}
