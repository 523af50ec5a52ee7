"""What can befall the network and the PLC of a cell, beside what befalls a controller."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

from rcx_harness.cell.clock import LONGEST_RPI_US, SHORTEST_RPI_US
from rcx_harness.cell.link import BOTH, Network, PacketNetwork
from rcx_harness.robot import EVENTS as ROBOT_EVENTS
from structured_text.errors import InputError
from structured_text.units import parse_us

__all__ = ["EVENTS", "OPPOSITES", "STARTS", "Surrounded", "befall", "check", "opposite"]

#: How a PLC can go into RUN.
STARTS = ("warm", "cold", "continue")
_WAYS = {"both": BOTH, "robot": BOTH[:1], "plc": BOTH[1:]}
_LONGEST_US = 60_000_000


class Surrounded(Protocol):
    """What a cell can do to itself."""

    def set_cable(self, up: bool, controller: int) -> None: ...  # noqa: D102

    def network_of(self, controller: int) -> Network: ...  # noqa: D102

    def stop_plc(self, *, power: bool) -> None: ...  # noqa: D102

    def start_plc(self, start: str) -> None: ...  # noqa: D102

    def overrun(self, late_us: int) -> None: ...  # noqa: D102

    def change_interval(self, rpi_us: int) -> None: ...  # noqa: D102


@dataclass(frozen=True)
class _Event:
    """An event: its help, and what makes the call of it from its arguments, which it checks."""

    text: str
    made: Callable[..., Callable[[Surrounded, int], None]]


def _cable(up: bool) -> Callable[..., Callable[[Surrounded, int], None]]:
    return lambda: lambda cell, controller: cell.set_cable(up, controller)


def _packets(kind: str) -> Callable[..., Callable[[Surrounded, int], None]]:
    def made(share: float = 1.0, by: str = "50ms", to: str = "both") -> Any:
        if not isinstance(share, (int, float)) or isinstance(share, bool) or not 0 <= share <= 1:
            raise InputError(f"share = {share!r} is no part of the packets", hint="it is 0 to 1")
        if not isinstance(to, str) or to not in _WAYS:
            raise InputError(f"to = {to!r} is no direction", hint=f"use {', '.join(_WAYS)}")
        by_us = _time("by", by, 0, _LONGEST_US)

        def disturb(cell: Surrounded, controller: int) -> None:
            network = cell.network_of(controller)
            if not isinstance(network, PacketNetwork):
                hint = "run it without --realtime and --connect"
                raise InputError("packets are disturbed in virtual time only", hint=hint)
            for direction in _WAYS[to]:
                network.disturb(kind, direction, share, by_us)

        return disturb

    def lost(share: float = 1.0, to: str = "both") -> Any:
        return made(share, "0ms", to)

    return lost if kind == "lost" else made


def _interval(rpi: str) -> Callable[[Surrounded, int], None]:
    rpi_us = _time("rpi", rpi, SHORTEST_RPI_US, LONGEST_RPI_US)
    return lambda cell, _: cell.change_interval(rpi_us)


def _overrun(by: str = "50ms") -> Callable[[Surrounded, int], None]:
    late_us = _time("by", by, 0, _LONGEST_US)
    return lambda cell, _: cell.overrun(late_us)


def _stop(start: str = "warm") -> Callable[[Surrounded, int], None]:
    _run(start)
    return lambda cell, _: cell.stop_plc(power=False)


def _power_off(start: str = "warm") -> Callable[[Surrounded, int], None]:
    _power_on(start)
    return lambda cell, _: cell.stop_plc(power=True)


def _run(start: str = "warm") -> Callable[[Surrounded, int], None]:
    if start not in STARTS:
        raise InputError(f"start = {start!r} is no start", hint=f"use {', '.join(STARTS)}")
    return lambda cell, _: cell.start_plc(start)


def _power_on(start: str = "warm") -> Callable[[Surrounded, int], None]:
    if start == "continue":
        hint = "use warm or cold"
        raise InputError("a PLC does not continue after a loss of its power", hint=hint)
    return _run(start)


_EVENTS: dict[str, _Event] = {
    "link_down": _Event("the network cable is unplugged: packets are lost", _cable(False)),
    "link_up": _Event("the network cable is plugged in again", _cable(True)),
    "packets_lost": _Event(
        "from now on this share of the packets is lost: share = 0.3 (1), to = robot or plc (both)",
        _packets("lost"),
    ),
    "packets_late": _Event(
        "from now on this share of the packets is late, by at most this: share, by = 30ms (50ms), "
        "to; the order is kept",
        _packets("late"),
    ),
    "packets_doubled": _Event(
        "from now on this share of the packets comes twice: share, by, to", _packets("doubled")
    ),
    "packet_interval": _Event("all packets go in another interval: rpi = 20ms", _interval),
    "plc_stop": _Event(
        "the PLC goes into STOP: no scan runs, and its scanner's connections end; with 'for', "
        "start = says how it begins again",
        _stop,
    ),
    "plc_run": _Event(
        "the PLC goes into RUN: start = warm (RETAIN is kept), cold, or continue (as it stands)",
        _run,
    ),
    "plc_power_off": _Event("the PLC loses its power; start as at stop", _power_off),
    "plc_power_on": _Event("the PLC has power again: start = warm, or cold", _power_on),
    "plc_overrun": _Event("the PLC's next scan comes late: by = 30ms (50ms)", _overrun),
}

#: Events of network and PLC by name, each with a line of help.
EVENTS: dict[str, str] = {name: one.text for name, one in _EVENTS.items()}

#: Which event takes which back.
OPPOSITES: dict[str, str] = {
    "link_down": "link_up",
    "plc_stop": "plc_run",
    "plc_power_off": "plc_power_on",
    "emergency_stop": "emergency_stop_release",
    "power_off": "power_on",
    "warning": "warning_clear",
    "pendant_on": "pendant_off",
    "manual_mode": "auto_mode",
    "auto_input_off": "auto_input_on",
    "manual_lock_on": "manual_lock_off",
    "main_power_off": "main_power_on",
    "safety_on": "safety_off",
    "parallel_stop": "parallel_stop_release",
}
assert all(one in EVENTS or one in ROBOT_EVENTS for pair in OPPOSITES.items() for one in pair)


def opposite(event: str, args: Mapping[str, Any]) -> tuple[str, dict[str, Any]]:
    """The event that takes another back, with its arguments.

    A start says how the PLC begins anew: it is an argument of what it takes back.

    Raises:
        InputError: it is over as soon as it has happened.
    """
    if event.startswith("packets_"):
        return event, {**args, "share": 0}
    if event in ("plc_stop", "plc_power_off"):
        return OPPOSITES[event], dict(args)
    if event not in OPPOSITES:
        lasting = ", ".join([*OPPOSITES, "packets_lost", "packets_late", "packets_doubled"])
        raise InputError(f"event {event!r} does not last", hint=f"'for' goes with {lasting}")
    return OPPOSITES[event], {}


def check(event: str, args: Mapping[str, Any]) -> Callable[[Surrounded, int], None]:
    """What an event of network or PLC does to a cell, for one of its controllers.

    Raises:
        InputError: arguments that it does not take, or values that cannot be.
    """
    made = _EVENTS[event].made
    takes = list(inspect.signature(made).parameters)
    needs = [
        name
        for name, one in inspect.signature(made).parameters.items()
        if one.default is inspect.Parameter.empty
    ]
    wrong = [name for name in args if name not in takes]
    missing = [name for name in needs if name not in args]
    if wrong or missing:
        if not takes:
            hint = f'write robot = "{event}"'
            raise InputError(f"event {event!r} takes no arguments", hint=hint)
        what = f"has no argument {wrong[0]!r}" if wrong else f"needs {missing[0]}"
        named = ", ".join(f"{name} = ..." for name in takes)
        hint = f'write robot = {{ event = "{event}", {named} }}'
        raise InputError(f"event {event!r} {what}", hint=hint)
    return made(**args)


def befall(cell: Surrounded, event: str, controller: int, args: Mapping[str, Any]) -> None:
    """Let an event of network or PLC happen now.

    Raises:
        InputError: as `check`, or where it cannot happen.
    """
    check(event, args)(cell, controller)


def _time(name: str, value: object, low: int, high: int) -> int:
    if not isinstance(value, str):
        raise InputError(f"{name} is not a text", hint=f'write {name} = "30ms"')
    given_us = parse_us(value)
    if not low <= given_us <= high:
        raise InputError(f"{name} = {value!r} is out of its range")
    return given_us
