"""A run in real time: the packets of a real cyclic connection, and a clock that keeps step.

The cell's time is still its own, in whole microseconds, and PLC and controller are called in its
order. It is only held back to the time of this computer, because packets now travel by themselves.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

from rcx_harness.cell.clock import Action, Agenda, Timing
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import LinkState, now_us
from rcx_harness.enip.errors import ProcessDiedError
from rcx_harness.enip.links import Class1Link
from rcx_harness.enip.originator.opening import Opener, multiplier_of
from rcx_harness.enip.originator.scanner import Scanner
from structured_text.errors import InputError
from structured_text.output.system import fine_timers
from structured_text.output.units import format_us

__all__ = ["LiveNetwork", "RealTimeAgenda", "RealTimeLink"]

#: Being late by less is made up for; by more, the cell's time stands still [us].
_LATE_US = 5_000
_LOOK_S = 0.01
_REOPEN_S = 0.1
_FIRST_PACKET_S = 2.0


class RealTimeAgenda(Agenda):
    """An agenda that lets nothing happen before its time has come.

    Args:
        clock_us: This computer's monotonic time in microseconds.
        sleep: Waits for so many seconds, perhaps longer.

    Attributes:
        stalls: How often something came so late that the cell's time stood still meanwhile.
        stalled_us: How long, in all.
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
        """One line if this computer was late; else empty."""
        if not self.stalls:
            return ""
        times = "once" if self.stalls == 1 else f"{self.stalls} times"
        late = format_us(self.stalled_us)
        return f"this computer was late {times}, by {late} in all; the run waited meanwhile"

    def pop(self) -> tuple[int, Action]:
        """Take the next event when it is due."""
        due_us = self.first()[0]
        if self._start_us is None:
            self._start_us = self._clock_us() - due_us
        while (wait_us := self._start_us + due_us - self._clock_us()) > 0:
            self._sleep(wait_us / 1e6)
        if -wait_us > _LATE_US:
            # A burst of scans would meet packets that go on at their own pace.
            self._start_us -= wait_us
            self.stalls += 1
            self.stalled_us -= wait_us
        return super().pop()


class RealTimeLink(Class1Link):
    """A cyclic connection that is opened, and after a loss opened anew, by a thread.

    Args:
        size: Bytes of each area, 48 or 256.
        timing: RPI and time-out.

    Raises:
        InputError: a time-out that cannot be asked for, or a process did not start.
    """

    name = "enip-realtime"

    def __init__(self, size: int, timing: Timing) -> None:
        super().__init__(size, timing.rpi_us, multiplier_of(timing.timeout_us, timing.rpi_us))
        self._opener = Opener(self._opened, _FIRST_PACKET_S)
        self._opener.wanted = False
        self._opener.start(_LOOK_S, _REOPEN_S)

    def network(self, agenda: Agenda, *, matched: bool) -> LiveNetwork:
        """Its network; the packets keep no agenda."""
        del agenda
        return LiveNetwork(self, matched=matched)

    def want(self, connection: bool) -> None:
        """Is there to be a connection?"""
        self._opener.wanted = connection

    def close(self) -> None:
        """End thread, connection and processes; more than once does no harm."""
        self._opener.end()
        super().close()

    def _opened(self) -> Scanner:
        self.scanner.open()
        return self.scanner


class LiveNetwork:
    """A `rcx_harness.cell.link.Network` over packets that travel by themselves.

    Args:
        link: The connection.
        matched: False when master and robot differ in the area's size: nothing is opened then.
    """

    def __init__(self, link: RealTimeLink, *, matched: bool) -> None:
        self._link, self._matched = link, matched
        self._cable, self._adapter = True, False
        self._state = LinkState.UP
        self._switch()

    @property
    def input(self) -> bytes:
        """What the PLC has received so far."""
        return self._link.scanner_read()

    def start(self, content: Callable[[], bytes]) -> None:
        """Nothing: the processes of scanner and adapter send at their own interval."""

    def set_cable(self, up: bool) -> None:
        """Plug or unplug the cable."""
        self._cable = up
        self._switch()

    def set_adapter(self, up: bool) -> None:
        """The robot's adapter starts, or goes off with its controller's power."""
        if up != self._adapter:
            self._adapter = up
            self._switch()

    def robot_connected(self, now_us: int) -> bool:
        """Does the robot still receive packets, of a master that runs?"""
        return self._matched and self._link.shared.owner is OwnerState.RUN

    def plc_connected(self, now_us: int) -> bool:
        """Does the PLC still receive packets: the status its scanner shows."""
        return self._link.scanner.read().connected

    def scanned(self, image: bytes) -> None:
        """The scan has ended: from now on its outputs are sent.

        Raises:
            ProcessDiedError: a process of the connection has ended by itself.
        """
        if failure := self._link.failure:
            raise ProcessDiedError(failure)
        self._link.scanner_write(image)

    def snapshot(self) -> object:
        """Not possible: what is under way on a real network cannot be kept.

        Raises:
            InputError: always.
        """
        raise InputError("a run in real time has no snapshot", hint="use the link direct or enip")

    def restore(self, snapshot: Any) -> None:
        """Not possible either.

        Raises:
            InputError: always.
        """
        self.snapshot()

    def _switch(self) -> None:
        state = LinkState.OFF
        if self._adapter:
            state = LinkState.UP if self._cable else LinkState.CUT
        if state is not self._state:
            self._state = self._link.shared.link = state
        self._link.want(self._matched and state is LinkState.UP)
