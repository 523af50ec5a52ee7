"""The events of a served controller, each reported once and with its own time."""

from __future__ import annotations

from collections import deque

from rcx_harness.enip.cyclic.connections import ConnectionKind, EndReason
from rcx_harness.enip.cyclic.journal import ConnectionEvent
from rcx_harness.serve.status import Event
from structured_text.output.units import format_us

__all__ = ["News", "event_text", "intervals_text"]

_MOST = 500
_OWNER = {
    "waiting": "a master has opened the connection",
    "run": "connected",
    "idle": "connected, but the master's program is stopped (idle)",
    "closed": "the master has closed the connection",
    EndReason.TIMED_OUT.value: "the master fell silent: the connection has timed out",
}
_READER = {
    "closed": "it has closed its connection",
    EndReason.TIMED_OUT.value: "its connection has timed out",
    EndReason.NO_OWNER.value: "the last connection to which it listened has ended",
}


class News:
    """A buffer for events until they are reported; if it is full, the oldest are dropped."""

    def __init__(self) -> None:
        self._events: deque[Event] = deque(maxlen=_MOST)
        self._lost = 0

    def note(self, t_us: int, kind: str, text: str) -> None:
        """Add an event."""
        self._lost += len(self._events) == _MOST
        self._events.append(Event(t_us, kind, text))

    def take(self, now_us: int) -> tuple[Event, ...]:
        """Return the events since the last call, in the order of time."""
        events = sorted(self._events, key=lambda event: event.t_us)
        if self._lost:
            text = f"{self._lost} earlier events are not shown: there were too many at once"
            events.append(Event(now_us, "lost", text))
        self._events.clear()
        self._lost = 0
        return tuple(events)


def event_text(event: ConnectionEvent) -> tuple[str, str]:
    """Return kind and sentence of a change of a connection; both are empty if it needs no report.

    A controller that is switched off has no connections, so their end is not reported. For a
    reader, which only listens, the opening and the end of its connection are reported.
    """
    if event.kind is ConnectionKind.EXCLUSIVE_OWNER:
        text = _OWNER.get(event.state, "")
        if not text:
            return "", ""
        if event.state in ("waiting", "run", "idle"):
            text += f": {event.peer}, {intervals_text(event.o_to_t_api_us, event.t_to_o_api_us)}"
        else:
            text += f": {event.peer}"
        return "connection", text
    readers = "1 reader" if event.readers == 1 else f"{event.readers} readers"
    if event.state == "waiting":
        every = format_us(event.t_to_o_api_us)
        return "readers", f"{event.peer} reads along ({event.kind.value}), every {every}; {readers}"
    if how := _READER.get(event.state):
        return "readers", f"{event.peer} no longer reads along: {how}; {readers}"
    return "", ""


def intervals_text(to_robot_us: int, to_master_us: int) -> str:
    """Return the packet intervals of a connection in words."""
    if to_robot_us == to_master_us:
        return f"every {format_us(to_robot_us)}"
    return f"every {format_us(to_robot_us)} to the robot, {format_us(to_master_us)} back"
