"""Events of the network and the PLC of a cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from rcx_harness.cell.clock import LONGEST_RPI_US, SHORTEST_RPI_US
from rcx_harness.cell.link import BOTH, Network, PacketNetwork
from rcx_harness.robot import EVENTS as ROBOT_EVENTS
from structured_text.bench import events
from structured_text.bench.events import EVENTS as PLC_EVENTS
from structured_text.bench.events import Event, checked, time_us
from structured_text.errors import InputError

__all__ = ["EVENTS", "OPPOSITES", "Surrounded", "befall", "check", "opposite"]

_WAYS = {"both": BOTH, "robot": BOTH[:1], "plc": BOTH[1:]}
_LONGEST_US = 60_000_000


class Surrounded(events.Stopped, Protocol):
    """The methods of a cell that the events of network and PLC call."""

    def set_cable(self, up: bool, controller: int) -> None: ...  # noqa: D102

    def network_of(self, controller: int) -> Network: ...  # noqa: D102

    def change_interval(self, rpi_us: int) -> None: ...  # noqa: D102


def _cable(up: bool) -> Callable[..., Callable[[Surrounded, int], None]]:
    return lambda: lambda cell, controller: cell.set_cable(up, controller)


def _packets(kind: str) -> Callable[..., Callable[[Surrounded, int], None]]:
    def made(share: float = 1.0, by: str = "50ms", to: str = "both") -> Any:
        if not isinstance(share, (int, float)) or isinstance(share, bool) or not 0 <= share <= 1:
            raise InputError(f"share = {share!r} is not a share of the packets", hint="use 0 to 1")
        if not isinstance(to, str) or to not in _WAYS:
            raise InputError(f"to = {to!r} is not a direction", hint=f"use {', '.join(_WAYS)}")
        by_us = time_us("by", by, 0, _LONGEST_US)

        def disturb(cell: Surrounded, controller: int) -> None:
            network = cell.network_of(controller)
            if not isinstance(network, PacketNetwork):
                hint = "run it without --realtime and --connect"
                raise InputError("packets can be disturbed in virtual time only", hint=hint)
            for direction in _WAYS[to]:
                network.disturb(kind, direction, share, by_us)

        return disturb

    def lost(share: float = 1.0, to: str = "both") -> Any:
        return made(share, "0ms", to)

    return lost if kind == "lost" else made


def _interval(rpi: str) -> Callable[[Surrounded, int], None]:
    rpi_us = time_us("rpi", rpi, SHORTEST_RPI_US, LONGEST_RPI_US)
    return lambda cell, _: cell.change_interval(rpi_us)


_EVENTS: dict[str, Event[Surrounded]] = {
    "link_down": Event("the network cable is unplugged: packets are lost", _cable(False)),
    "link_up": Event("the network cable is plugged in again", _cable(True)),
    "packets_lost": Event(
        "from now on this share of the packets is lost: share = 0.3 (1), to = robot or plc (both)",
        _packets("lost"),
    ),
    "packets_late": Event(
        "from now on this share of the packets is late, by at most this: share, by = 30ms (50ms), "
        "to; the order is kept",
        _packets("late"),
    ),
    "packets_doubled": Event(
        "from now on this share of the packets arrives twice: share, by, to", _packets("doubled")
    ),
    "packet_interval": Event("the packet interval changes: rpi = 20ms", _interval),
    **PLC_EVENTS,
}

#: Maps the name of each event of network and PLC to a line of help.
EVENTS: dict[str, str] = {name: one.text for name, one in _EVENTS.items()}

#: Maps an event to the event that undoes it.
OPPOSITES: dict[str, str] = {
    "link_down": "link_up",
    **events.OPPOSITES,
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
    """Return the event that undoes `event`, with the arguments of the returned event.

    The start mode of the PLC is an argument of the stop event. It becomes an argument of the start
    event.
    """
    if event.startswith("packets_"):
        return event, {**args, "share": 0}
    if event in events.OPPOSITES:
        return OPPOSITES[event], dict(args)
    if event not in OPPOSITES:
        lasting = ", ".join([*OPPOSITES, "packets_lost", "packets_late", "packets_doubled"])
        raise InputError(
            f"event {event!r} cannot have a duration ('for')", hint=f"use 'for' with {lasting}"
        )
    return OPPOSITES[event], {}


def check(event: str, args: Mapping[str, Any]) -> Callable[[Surrounded, int], None]:
    """Check an event of network or PLC and return the function that applies it to a cell.

    The arguments of the returned function are the cell and the number of the controller.
    """
    return checked(_EVENTS, event, args, "plc" if event in PLC_EVENTS else "robot")


def befall(cell: Surrounded, event: str, controller: int, args: Mapping[str, Any]) -> None:
    """Apply an event of network or PLC to the cell at the current time."""
    check(event, args)(cell, controller)
