"""Category 6: task status and task execution line (guide, 4.7.5 and 4.7.6)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.tasks import Task

__all__ = ["read_lines", "read_states"]

_HALF = 8  # tasks in an answer
_STOPPED, _RUNNING, _SUSPENDED, _STANDBY, _NO_TASK = 0, 1, 2, 3, 9


@act(0x507)
def read_states(machine: Machine, call: Call) -> Response:
    """The states of eight tasks (4.7.5)."""
    return {"task_states": tuple(_state(machine, task) for task in _tasks(machine, call))}


@act(0x508)
def read_lines(machine: Machine, call: Call) -> Response:
    """The lines that eight tasks execute (4.7.6); 0 without a task."""
    return {"lines": tuple(task.line if task else 0 for task in _tasks(machine, call))}


def _tasks(machine: Machine, call: Call) -> list[Task | None]:
    first = 1 + _HALF * call.values["task_range"]
    return [machine.program.in_task(number) for number in range(first, first + _HALF)]


def _state(machine: Machine, task: Task | None) -> int:
    if task is None:
        return _NO_TASK
    if task.state == "running":
        return _STANDBY if task.waits and machine.config.waiting_is_standby else _RUNNING
    return _SUSPENDED if task.state == "suspended" else _STOPPED
