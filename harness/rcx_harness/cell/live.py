"""Real-time runs of a cell: an agenda that waits for the clock, and a real cyclic connection.

The cell still counts its own time in whole microseconds and calls PLC and controller in the usual
order. It waits for the clock of this computer before each event, because other processes send the
packets at their own times.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rcx_harness.cell.clock import Timing
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import LinkState, now_us
from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.enip.links import AdapterLink
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.opening import Opener, multiplier_of
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from structured_text.bench.agenda import Action, Agenda
from structured_text.errors import InputError
from structured_text.output.system import fine_timers
from structured_text.output.units import format_us

__all__ = ["LiveNetwork", "RealTimeAgenda", "RealTimeLink"]

#: The longest delay of this computer after which the cell catches up [us]. After a longer delay the
#: cell's time is stopped.
_LATE_US = 5_000
_LOOK_S = 0.01
_REOPEN_S = 0.1
_FIRST_PACKET_S = 2.0


class RealTimeAgenda(Agenda):
    """An agenda that returns an event only when the event is due in real time.

    Attributes:
        stalls: How often the agenda was so late that the cell's time was stopped.
    """

    def __init__(
        self,
        clock_us: Callable[[], int] = now_us,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        super().__init__()
        fine_timers()
        self._clock_us, self._sleep = clock_us, sleep
        self._start_us: int | None = None
        self.stalls = self.stalled_us = 0

    @property
    def notice(self) -> str:
        """Return a line about the delays of this computer; empty if the computer was never late."""
        if not self.stalls:
            return ""
        times = "once" if self.stalls == 1 else f"{self.stalls} times"
        late = format_us(self.stalled_us)
        return f"this computer was late {times}, by {late} in all; the run waited meanwhile"

    def pop(self) -> tuple[int, Action]:
        """Wait until the next event is due, and return it."""
        due_us = self.first()[0]
        if self._start_us is None:
            self._start_us = self._clock_us() - due_us
        while (wait_us := self._start_us + due_us - self._clock_us()) > 0:
            self._sleep(wait_us / 1e6)
        if -wait_us > _LATE_US:
            # Catching up would run many scans at once between two real packets. The start of the
            # run is shifted instead, so the cell's time stands still during the delay.
            self._start_us -= wait_us
            self.stalls += 1
            self.stalled_us -= wait_us
        return super().pop()


class RealTimeLink(AdapterLink):
    """An exclusive-owner connection on the loopback interface; a thread opens it after each loss.

    Calls never wait: they return the data that arrived last, or set the data to send next.

    Attributes:
        shared: Both areas at the robot's end, and the state of the connection.
    """

    name = "enip-realtime"

    def __init__(self, size: int, timing: Timing) -> None:
        multiplier = multiplier_of(timing.timeout_us, timing.rpi_us)
        options = AdapterOptions(rpi_min_us=1_000)
        super().__init__(size, Adapter(size, cyclic=0, options=options))
        self.shared = self.adapter.shared
        host, port = self.adapter.address
        try:
            self.scanner = Scanner(
                *(host, size, timing.rpi_us),
                multiplier=multiplier,
                address=host,
                io_port=0,
                port=port,
            )
        except BaseException:
            self.adapter.close()
            raise
        self._opener = Opener(self._opened, _FIRST_PACKET_S)
        self._opener.wanted = False
        self._opener.start(_LOOK_S, _REOPEN_S)

    def network(self, agenda: Agenda, *, matched: bool) -> LiveNetwork:
        """Return the network of this link. The packets are real, so they do not use the agenda."""
        del agenda
        return LiveNetwork(self, matched=matched)

    def want(self, connection: bool) -> None:
        """Request that the connection is opened and kept open (True), or closed (False)."""
        self._opener.wanted = connection

    @property
    def failure(self) -> str:
        """Describe the process that has ended unexpectedly; empty while all processes run."""
        return self.adapter.failure or self.scanner.failure

    def scanner_write(self, image: bytes) -> None:
        """Set the data of the master's next packets, with the run state."""
        self.scanner.write(image)

    def scanner_read(self) -> bytes:
        """Return the data that the master received last."""
        return self.scanner.read().image

    def close(self) -> None:
        """End thread, connection and processes; a second call has no effect."""
        self._opener.end()
        self.scanner.close()
        self.adapter.close()

    def _opened(self) -> Scanner:
        self.scanner.open()
        return self.scanner


class LiveNetwork:
    """The implementation of `rcx_harness.cell.link.Network` with real packets in real time.

    Args:
        matched: Whether master and robot have areas of the same size; otherwise no connection is
            opened.
    """

    def __init__(self, link: RealTimeLink, *, matched: bool) -> None:
        self._link, self._matched = link, matched
        self._cable, self._adapter = True, False
        self._state = LinkState.UP
        self._switch()

    @property
    def input(self) -> bytes:
        """Return the last image that the PLC has received."""
        return self._link.scanner_read()

    def start(self, content: Callable[[], bytes]) -> None:
        """Do nothing, because the processes of scanner and adapter send packets by themselves."""

    def set_cable(self, up: bool) -> None:
        """Plug or unplug the cable."""
        self._cable = up
        self._switch()

    def set_adapter(self, up: bool) -> None:
        """Switch the robot's adapter on or off, as its controller boots or loses power."""
        if up != self._adapter:
            self._adapter = up
            self._switch()

    def robot_connected(self, now_us: int) -> bool:
        """Return whether the robot still receives packets from a master in RUN."""
        return self._matched and self._link.shared.owner is OwnerState.RUN

    def plc_connected(self, now_us: int) -> bool:
        """Return whether the PLC still receives packets, which its scanner shows as its status."""
        return self._link.scanner.read().connected

    def scanned(self, image: bytes) -> None:
        """Send the outputs of the finished scan from now on.

        Raises:
            ProcessDiedError: a process of the connection has ended by itself.
        """
        if failure := self._link.failure:
            raise ProcessDiedError(failure)
        self._link.scanner_write(image)

    def snapshot(self) -> object:
        """Raise InputError, because packets on a real network cannot be saved."""
        raise InputError("a run in real time has no snapshot", hint="use the link direct or enip")

    def restore(self, snapshot: Any) -> None:
        """Raise InputError, because there is no snapshot of a run in real time."""
        self.snapshot()

    def _switch(self) -> None:
        state = LinkState.OFF
        if self._adapter:
            state = LinkState.UP if self._cable else LinkState.CUT
        if state is not self._state:
            self._state = self._link.shared.link = state
        self._link.want(self._matched and state is LinkState.UP)
