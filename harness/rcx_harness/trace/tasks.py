"""The tasks of robot programs in words, for charts, pages and reports."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

__all__ = ["statement_of", "task_text"]

#: States in which a task has a current line.
_IN_LINE = ("running", "stopped", "suspended")


def task_text(task: Mapping[str, Any], statement: str = "") -> str:
    """Return a text about a task of a record: program, line, state, and the statement if given.

    Examples: `PLACE:4`, `PLACE:4 stopped`, `PLACE:4 WAIT SI(20)=1`, `PLACE ready`. For a task that
    is ready or has ended there is no line.
    """
    program, state = task["program"], task["state"]
    if state not in _IN_LINE:
        return f"{program} {state}"
    words = [f"{program}:{task['line']}", "" if state == "running" else state, statement]
    return " ".join(word for word in words if word)


def statement_of(programs: Iterable[Mapping[str, Any]], task: Mapping[str, Any]) -> str:
    """Return the statement in the line of a task, without a comment. Empty if the line is unknown.

    Args:
        programs: The programs of the controller (`rcx_harness.robot.listing.listings`).
        task: A task of a record.
    """
    number = task["line"] - 1
    for program in programs:
        if program["name"] == task["program"]:
            lines = program["lines"]
            return _without_comment(lines[number]) if 0 <= number < len(lines) else ""
    return ""


def _without_comment(text: str) -> str:
    """Return a statement without its comment; several spaces become one."""
    quoted = False
    for k, letter in enumerate(text):
        if letter == '"':
            quoted = not quoted
        elif letter == "'" and not quoted:
            text = text[:k]
            break
    return " ".join(text.split())
