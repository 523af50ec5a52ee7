"""Events of the PLC itself: STOP and RUN, its power, a late scan."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from structured_text.errors import InputError
from structured_text.output.units import parse_us

__all__ = ["EVENTS", "OPPOSITES", "Event", "Stopped", "checked", "opposite", "time_us"]

#: Kinds of a transition to RUN.
_STARTS = ("warm", "cold", "continue")
_LONGEST_US = 60_000_000


class Stopped(Protocol):
    """A bench or cell with a PLC that events can stop, start and delay."""

    def stop_plc(self, *, power: bool) -> None: ...  # noqa: D102

    def start_plc(self, start: str) -> None: ...  # noqa: D102

    def overrun(self, late_us: int) -> None: ...  # noqa: D102


_On = TypeVar("_On", contravariant=True)


@dataclass(frozen=True)
class Event(Generic[_On]):
    """An event of the PLC.

    It has a help text, and a function that checks the arguments and returns the action.
    """

    text: str
    made: Callable[..., Callable[[_On, int], None]]


def _overrun(by: str = "50ms") -> Callable[[Stopped, int], None]:
    late_us = time_us("by", by, 0, _LONGEST_US)
    return lambda cell, _: cell.overrun(late_us)


def _stop(start: str = "warm") -> Callable[[Stopped, int], None]:
    _run(start)
    return lambda cell, _: cell.stop_plc(power=False)


def _power_off(start: str = "warm") -> Callable[[Stopped, int], None]:
    _power_on(start)
    return lambda cell, _: cell.stop_plc(power=True)


def _run(start: str = "warm") -> Callable[[Stopped, int], None]:
    if start not in _STARTS:
        raise InputError(
            f"start = {start!r} is not a kind of start", hint=f"use {', '.join(_STARTS)}"
        )
    return lambda cell, _: cell.start_plc(start)


def _power_on(start: str = "warm") -> Callable[[Stopped, int], None]:
    if start == "continue":
        hint = "use warm or cold"
        raise InputError("start = continue is not possible after a power loss", hint=hint)
    return _run(start)


#: Events of a PLC by name.
EVENTS: dict[str, Event[Stopped]] = {
    "plc_stop": Event(
        "the PLC goes into STOP: no scan runs, and its scanner's connections end; with 'for', "
        "start = says how it begins again",
        _stop,
    ),
    "plc_run": Event(
        "the PLC goes into RUN: start = warm (keeps RETAIN), cold, or continue (keeps all values)",
        _run,
    ),
    "plc_power_off": Event("the PLC loses its power; start as at stop", _power_off),
    "plc_power_on": Event("the PLC has power again: start = warm, or cold", _power_on),
    "plc_overrun": Event("the PLC's next scan comes late: by = 30ms (50ms)", _overrun),
}

#: The events that have a duration, each with the event that ends it.
OPPOSITES: dict[str, str] = {"plc_stop": "plc_run", "plc_power_off": "plc_power_on"}


def opposite(event: str, args: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """Return the event that ends an event with a duration, and the same arguments.

    Raise InputError if the event cannot have a duration.
    """
    if event not in OPPOSITES:
        hint = "use 'for' with stop or power_off only"
        raise InputError(f"event {event!r} cannot have a duration ('for')", hint=hint)
    return OPPOSITES[event], dict(args)


def checked(
    events: Mapping[str, Event[_On]], event: str, args: Mapping[str, Any], key: str = "plc"
) -> Callable[[_On, int], None]:
    """Check the arguments of an event; return a function that triggers it on a bench or device.

    Raises:
        InputError: The event does not take these arguments, or a value is impossible.
    """
    made = events[event].made
    takes = list(inspect.signature(made).parameters)
    needs = [
        name
        for name, one in inspect.signature(made).parameters.items()
        if one.default is inspect.Parameter.empty
    ]
    wrong = [name for name in args if name not in takes]
    missing = [name for name in needs if name not in args]
    if wrong or missing:
        shown = event.removeprefix(f"{key}_")
        if not takes:
            hint = f'write {key} = "{shown}"'
            raise InputError(f"event {event!r} takes no arguments", hint=hint)
        what = f"has no argument {wrong[0]!r}" if wrong else f"needs {missing[0]}"
        named = ", ".join(f"{name} = ..." for name in takes)
        hint = f'write {key} = {{ event = "{shown}", {named} }}'
        raise InputError(f"event {event!r} {what}", hint=hint)
    return made(**args)


def time_us(name: str, value: object, low: int, high: int) -> int:
    """Return a time of an event in microseconds; raise InputError if it is out of its range."""
    if not isinstance(value, str):
        raise InputError(f"{name} is not a text", hint=f'write {name} = "30ms"')
    given_us = parse_us(value)
    if not low <= given_us <= high:
        raise InputError(f"{name} = {value!r} is out of its range")
    return given_us
