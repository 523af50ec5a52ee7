"""The tasks of robot programs in words, for charts and pages."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ["task_text"]


def task_text(task: Mapping[str, Any]) -> str:
    """Return where a task of a record is: `PLACE:4`, `PLACE:4 stopped`, `PLACE ready`.

    A task that is ready or has ended is not in any line.
    """
    program, state = task["program"], task["state"]
    if state == "running":
        return f"{program}:{task['line']}"
    if state in ("ready", "ended"):
        return f"{program} {state}"
    return f"{program}:{task['line']} {state}"
