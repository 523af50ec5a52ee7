"""A served controller in words, for the terminal and the web page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rcx_harness.serve.host import Host
from rcx_harness.serve.news import intervals_text
from rcx_harness.serve.status import Note, Status
from rcx_harness.spec import Signal, signals
from rcx_harness.spec.wire import DEDICATED_AT

__all__ = ["LED_MEANINGS", "connection_text", "view"]

#: The manual's words for the LEDs (chapter 1, 3): Module Status, then Network Status.
LED_MEANINGS = {
    "module": {
        "off": "power is OFF",
        "green": "normal connection with the master module",
        "green, flashing": "no connection with the master module",
        "red": "unrecoverable error",
        "red, flashing": "recoverable minor error",
        "green and red, flashing": "self-test",
    },
    "network": {
        "off": "power is OFF, or no IP address",
        "green": "online, connected to the master",
        "green, flashing": "online, but not connected",
        "red": "serious error, such as a duplicate IP address",
        "red, flashing": "the connection has timed out",
        "green and red, flashing": "self-test",
    },
}

_STATES = {
    "none": "no master has connected yet",
    "waiting": "a master has opened the connection, but sends nothing yet",
    "untaken": "a master has opened the connection, but none of its packets is accepted",
    "run": "connected",
    "idle": "connected, but the master's program is stopped (idle)",
    "timed out": "the master fell silent: the connection has timed out",
    "closed": "the master has closed the connection",
}

_STILL = "the controller's process does not respond: it was stopped, or this computer is too busy"

_PLACES = ("X [mm]", "Y [mm]", "Z [mm]", "R [deg]", "axis 5 [mm, deg]", "axis 6 [mm, deg]")
_PORTS = (*range(8), *range(10, 16))  # SI0() to SI7(), SI10() to SI15(): bytes 32 to 45
_WORDS, _EXTENDED = range(16), range(24, 128)


def view(number: int, host: Host) -> dict[str, Any]:
    """Return the complete display of a controller in words, as values for JSON."""
    status = host.status
    si, so = bytes.fromhex(status.si) or bytes(host.size), bytes.fromhex(status.so)
    so = so or bytes(host.size)
    table = signals()
    return {
        "id": number,
        "name": host.name,
        "size": host.size,
        "running": not host.ended.is_set(),
        "t_us": status.t_us,
        "cycles": status.cycles,
        "skipped": status.skipped,
        "connected": bool(status.si),
        "connection": _STILL if host.silent else connection_text(status),
        "packets": asdict(status.connection),
        "leds": [
            _led("module", "Module Status", status.module_led),
            _led("network", "Network Status", status.network_led),
        ],
        "switches": {
            "power": status.powered,
            "cable": not status.link_cut,
            "emergency_stop": status.emergency_stop,
            "pendant": status.pendant,
            "auto": status.auto_switch,
            "warning": status.warning,
            "main_power": status.main_power,
            "safety": status.safety,
            "parallel_stop": status.parallel_stop,
        },
        "held": list(status.held),
        "workpieces": [{"axis": axis, "pulses": pulses} for axis, pulses in status.workpieces],
        "recording": {"on": status.recording, "cycles": status.recorded},
        "inputs": [_bit(one, si) for one in table.input],
        "outputs": [_bit(one, so) for one in table.output],
        "monitor": {
            "SI": _ports(si),
            "SO": _ports(so),
            "SIW": _words(si),
            "SOW": _words(so),
        },
        "positions": list(status.positions),
        "mm": list(status.mm),
        "way": [list(sample) for sample in host.way],
        "poses": list(status.poses),
        "drawn": host.drawn,
        "titles": axis_titles(host.shapes),
        "programs": len(host.listings),
        "tasks": list(status.tasks),
        "alarms": list(status.alarms),
        "executed": status.executed,
        "commands": [
            {"time": _clock(one.t_us), "request": one.request, "result": one.result}
            for one in reversed(status.commands)
        ],
        "violation_count": status.violation_count,
        "violations": [_note(one) for one in reversed(status.violations)],
    }


def axis_titles(shapes: Sequence[Mapping[str, Any]]) -> list[dict[str, str]]:
    """Return the titles of each axis, robot by robot: its name, and its position with the unit."""
    several = len(shapes) > 1
    return [
        {
            "axis": f"Robot {shape['robot']} axis {place + 1}" if several else f"Axis {place + 1}",
            "place": _PLACES[place],
        }
        for shape in shapes
        for place, _ in enumerate(shape["axes"])
    ]


def connection_text(status: Status) -> str:
    """Return one line about the connection with the master."""
    if not status.powered:
        return "the controller is off"
    if not status.online:
        return "the controller starts, or has no IP address of its own"
    connection = status.connection
    state = "untaken" if connection.untaken else connection.state
    text = _STATES.get(state, state)
    if connection.peer:
        every = intervals_text(connection.to_robot_us, connection.to_master_us)
        text += f": {connection.peer}, {every}"
    if connection.untaken:
        text += f"; dropped: {connection.untaken}"
    if connection.refused:
        text += f"; {connection.refused}"
    if connection.others:
        text += f"; {connection.others} more that only listen"
    return f"the network cable is unplugged ({text})" if status.link_cut else text


def _led(kind: str, title: str, state: str) -> dict[str, str]:
    return {"title": title, "state": state, "meaning": LED_MEANINGS[kind].get(state, "")}


def _bit(signal: Signal, area: bytes) -> dict[str, Any]:
    on = bool(area[signal.byte] >> signal.bit & 1)
    return {"signal": signal.signal, "title": signal.title, "meaning": signal.meaning, "on": on}


def _ports(area: bytes) -> list[dict[str, int]]:
    return [
        {"port": port, "value": area[DEDICATED_AT + place]} for place, port in enumerate(_PORTS)
    ]


def _words(area: bytes) -> list[dict[str, int]]:
    numbers = [*_WORDS, *(_EXTENDED if len(area) > 2 * _EXTENDED[0] else ())]
    return [{"port": one, "value": area[2 * one] | area[2 * one + 1] << 8} for one in numbers]


def _note(note: Note) -> dict[str, str]:
    return {"time": _clock(note.t_us), "text": note.text}


def _clock(t_us: int) -> str:
    """Return the seconds since the start, to the millisecond."""
    return f"{t_us / 1e6:.3f} s"
