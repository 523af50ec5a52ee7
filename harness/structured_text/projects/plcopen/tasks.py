"""The tasks in PLCopen TC6 XML, started by an interval, a variable, or an event of a tool.

The element `task` has the interval or, as `single`, a variable. CODESYS adds `TaskSettings`, with
the kind of task.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path

from structured_text.errors import InputError
from structured_text.projects.numbers import (
    interval_text,
    interval_us,
    milliseconds_us,
    priority_of,
)
from structured_text.projects.tasks import EDGE, FREE, LEVEL, UNKNOWN, ToolTask
from structured_text.projects.xml import Element

__all__ = ["read_tasks", "written_interval"]

_PERIOD = re.compile(r"P(?:T(?:(\d+)H)?(?:(\d+)M)?(?:(\d*\.?\d+)S)?)", re.IGNORECASE | re.ASCII)
_TIME = re.compile(
    r"(?:T|TIME)#(?:(\d+)h)?(?:(\d+)m(?!s))?(?:(\d+(?:\.\d+)?)s)?(?:(\d+(?:\.\d+)?)ms)?",
    re.IGNORECASE | re.ASCII,
)
#: Largest number of characters in an interval.
_LONGEST = 60
#: Matches a variable, also with the name of its list of globals or program before it.
_VARIABLE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*", re.ASCII)
#: The kind of start (`tasks`) for each kind of task in CODESYS that is not cyclic.
_STARTS = {"event": EDGE, "status": LEVEL, "freewheeling": FREE, "externalevent": UNKNOWN}
#: Names of the CODESYS settings that contain the variable or event of a task.
_EVENTS = ("Event", "EventVariable", "Variable", "Status", "StatusVariable", "ExternalEvent")


def read_tasks(elements: Iterable[Element], file: Path) -> list[ToolTask]:
    """Return the tasks, or raise InputError."""
    return [_task(element, file) for element in elements]


def written_interval(element: Element, task: ToolTask) -> str:
    """Return the interval of a task as a literal; a valid literal is returned unchanged."""
    text = element.get("interval").strip()
    return text if "#" in text else interval_text(task.interval_us)


def _task(element: Element, file: Path) -> ToolTask:
    name = element.get("name")
    if not name:
        raise InputError("<task> has no name", file=file, line=element.at)
    programs = []
    for one in element.all("pouInstance"):
        instance = one.get("name")
        if not instance:
            raise InputError("<pouInstance> has no name", file=file, line=one.at)
        programs.append((instance, one.get("typeName") or one.get("type") or instance))
    priority = priority_of(element.get("priority"), name, file, element.at)
    start, event = _start(element)
    interval = 0 if start else _microseconds(element, file)
    return ToolTask(name, interval, priority, tuple(programs), file, element.at, start, event)


def _settings(element: Element) -> Element:
    """Return the element with the task settings of CODESYS; an empty element if there is none."""
    return next(element.below("TaskSettings"), Element("TaskSettings", {}, element.at))


def _start(element: Element) -> tuple[str, str]:
    """Return how a task is started, and the variable or event.

    Both texts are empty if an interval starts the task.
    """
    settings = _settings(element)
    kind = settings.get("KindOfTask").lower().replace(" ", "")
    texts = (element.get("single"), *(settings.get(name) for name in _EVENTS))
    event = next((text.strip() for text in texts if text.strip()), "")
    start = _STARTS.get(kind, "")
    if not kind and event:
        start = EDGE
    if not kind and not event and not element.get("interval").strip():
        start = UNKNOWN
    if start in (EDGE, LEVEL) and not _VARIABLE.fullmatch(event):
        start = UNKNOWN
    return start, event


def _microseconds(task: Element, file: Path) -> int:
    """Return the interval of a task [µs]: `T#10ms`, `PT0.01S` or milliseconds.

    If the element has no interval, or the interval 0, the setting that CODESYS adds is read.
    """
    text, name = task.get("interval").strip(), task.get("name")
    settings = _settings(task)
    if settings.get("Interval") and text in ("", "PT0S"):
        text = settings.get("Interval").strip()
        if settings.get("IntervalUnit") in ("us", "µs") and re.fullmatch(r"[0-9]{1,18}", text):
            return interval_us(Fraction(text), text, name, file, task.at)
    found = None
    if len(text) <= _LONGEST:
        found = _PERIOD.fullmatch(text) or _TIME.fullmatch(text)
    if found is None:
        return milliseconds_us(text, name, file, task.at)
    hours, minutes, seconds, *rest = (Fraction(part or 0) for part in found.groups())
    exact = (hours * 3600 + minutes * 60 + seconds) * 1_000_000 + sum(rest) * 1_000
    return interval_us(exact, text, name, file, task.at)
