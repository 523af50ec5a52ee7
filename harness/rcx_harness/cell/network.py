"""The network between PLC and robot: packets both ways, their delay, and the loss of the link."""

from __future__ import annotations

from collections.abc import Callable
from random import Random
from typing import Any, Protocol

from rcx_harness.cell.clock import Agenda, Kind, Timing
from rcx_harness.cell.link import Link, RealLink

__all__ = ["AnyNetwork", "Network", "make_network"]

_TO_ROBOT, _TO_PLC = 0, 1

#: How long a scanner takes at least to open a connection anew.
_REOPEN_US = 100_000


class AnyNetwork(Protocol):
    """What a cell asks of its network; `Network` says what each of it means."""

    @property
    def input(self) -> bytes: ...  # noqa: D102

    @property
    def notice(self) -> str: ...  # noqa: D102

    def set_cable(self, up: bool) -> None: ...  # noqa: D102

    def set_adapter(self, up: bool) -> None: ...  # noqa: D102

    def robot_connected(self, now_us: int) -> bool: ...  # noqa: D102

    def plc_connected(self, now_us: int) -> bool: ...  # noqa: D102

    def scanned(self, image: bytes) -> None: ...  # noqa: D102

    def produce_to_robot(self, now_us: int, content: Callable[[], bytes]) -> None: ...  # noqa: D102

    def produce_to_plc(self, now_us: int) -> None: ...  # noqa: D102

    def deliver(self, now_us: int, packet: tuple[int, int, bytes]) -> None: ...  # noqa: D102

    def snapshot(self) -> object: ...  # noqa: D102

    def restore(self, snapshot: Any) -> None: ...  # noqa: D102


def make_network(
    link: Link, timing: Timing, *, matched: bool, seed: int
) -> tuple[Agenda, AnyNetwork]:
    """The clock and the network of a cell: the link's own if it is a real one."""
    if isinstance(link, RealLink):
        return link.make_network(matched=matched)
    agenda = Agenda()
    return agenda, Network(link, timing, agenda, matched=matched, seed=seed)


class Network:
    """Cyclic packets in both directions over one connection.

    Packets flow while the cable is plugged in and the robot's adapter is on; an interruption
    also takes those under way. A side takes the connection as lost when no packet has arrived
    for `Timing.timeout_us`; the adapter also loses it with its power. Once one side has lost it,
    no packet flows until the other has lost it too and the scanner has opened a new one, which
    takes at least 100 ms and a scan: neither side misses the restart of the other. Before the
    first packet both images are zero.

    Args:
        link: The two images.
        timing: RPI, jitter, time-out.
        agenda: Where packets under way are queued.
        matched: False when master and robot differ in the area's size: there is no connection
            then (manual chapter 3, 1).
        seed: Seed of the jitter.
    """

    def __init__(
        self, link: Link, timing: Timing, agenda: Agenda, *, matched: bool, seed: int
    ) -> None:
        self._link, self._timing, self._agenda = link, timing, agenda
        self._matched = matched
        self._random = Random(f"jitter {seed}")
        self._cable, self._adapter = True, False
        self._open = False
        self._epoch = 0
        self._lost_us: int | None = None
        self._last: list[int | None] = [None, None]
        self._due = [0, 0]
        self.input = bytes(link.size)
        """What the PLC has received so far."""
        self.notice = ""
        """Something to tell at the end of a run; here there is nothing."""

    def set_cable(self, up: bool) -> None:
        """Plug or unplug the cable."""
        self._cable = up
        if not up:
            self._epoch += 1

    def set_adapter(self, up: bool) -> None:
        """The robot's adapter starts, or goes off with its controller's power."""
        if up != self._adapter:
            self._adapter = up
            if not up:
                self._lose(_TO_ROBOT)

    def robot_connected(self, now_us: int) -> bool:
        """Does the robot still receive packets?"""
        return self._alive(_TO_ROBOT, now_us)

    def plc_connected(self, now_us: int) -> bool:
        """Does the PLC still receive packets: the status its scanner shows."""
        return self._alive(_TO_PLC, now_us)

    def scanned(self, image: bytes) -> None:
        """A scan has ended; what it put out goes with the next packet produced."""

    def produce_to_robot(self, now_us: int, content: Callable[[], bytes]) -> None:
        """The PLC's scanner sends its output image as it is now."""
        if self._flows(now_us):
            self._send(_TO_ROBOT, now_us, content())

    def produce_to_plc(self, now_us: int) -> None:
        """The robot's adapter sends its output image as it is now."""
        if self._flows(now_us):
            self._send(_TO_PLC, now_us, self._link.scanner_read())

    def deliver(self, now_us: int, packet: tuple[int, int, bytes]) -> None:
        """A packet arrives; a packet from before an interruption does not."""
        direction, epoch, content = packet
        if epoch == self._epoch:
            self._arrive(direction, now_us, content)

    def snapshot(self) -> object:
        """The whole state, images included."""
        state = (self._cable, self._adapter, self._open, self._epoch, self._lost_us)
        packets = (tuple(self._last), tuple(self._due))
        images = (self._link.robot_read(), self._link.scanner_read(), self.input)
        return state, packets, images, self._random.getstate()

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        state, packets, images, random = snapshot
        self._cable, self._adapter, self._open, self._epoch, self._lost_us = state
        self._last, self._due = list(packets[0]), list(packets[1])
        self._link.scanner_write(images[0])
        self._link.robot_write(images[1])
        self.input = images[2]
        self._random.setstate(random)

    def _flows(self, now_us: int) -> bool:
        """Is there a connection, or can a new one be opened?"""
        if not (self._matched and self._cable and self._adapter):
            return False
        if not self._open:
            lost = [not self._alive(direction, now_us) for direction in (_TO_ROBOT, _TO_PLC)]
            pause_us = max(_REOPEN_US, self._timing.scan_us + 1)
            early = self._lost_us is not None and now_us - self._lost_us < pause_us
            self._open = all(lost) and not early
        return self._open

    def _lose(self, direction: int) -> None:
        self._last[direction] = None
        self._open = False
        self._epoch += 1

    def _alive(self, direction: int, now_us: int) -> bool:
        last = self._last[direction]
        if last is None:
            return False
        if now_us - last < self._timing.timeout_us:
            return True
        self._lose(direction)
        self._lost_us = now_us
        return False

    def _send(self, direction: int, now_us: int, content: bytes) -> None:
        jitter_us = self._timing.jitter_us
        if not jitter_us and now_us > self._due[direction]:
            # Nothing else is under way, and nothing happens between sending and arriving.
            self._due[direction] = now_us
            self._arrive(direction, now_us, content)
            return
        delay = self._random.randint(0, jitter_us) if jitter_us else 0
        due = self._due[direction] = max(now_us + delay, self._due[direction])
        self._agenda.add(due, Kind.DELIVER, (direction, self._epoch, content))

    def _arrive(self, direction: int, now_us: int, content: bytes) -> None:
        self._last[direction] = now_us
        if direction == _TO_ROBOT:
            self._link.scanner_write(content)
        else:
            self.input = content
