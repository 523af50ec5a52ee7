"""The connection between PLC and robot: two images, and the packets that carry them.

A link holds the images. A network determines when a packet is produced, when it arrives, and when
the connection is lost.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from hashlib import blake2b
from random import Random
from typing import Any, Protocol, runtime_checkable

from rcx_harness.cell.clock import Kind, Timing
from rcx_harness.spec.wire import SIZE
from structured_text.bench.agenda import Agenda

__all__ = ["BOTH", "DirectLink", "Link", "Network", "OwnNetwork", "PacketNetwork", "make_network"]

_TO_ROBOT, _TO_PLC = 0, 1
#: The two directions of packets: to the robot, to the PLC.
BOTH = (_TO_ROBOT, _TO_PLC)

#: Shortest time in which a scanner reopens a connection.
_REOPEN_US = 100_000


@runtime_checkable
class Link(Protocol):
    """The two assemblies of the adapter, as seen from the scanner and from the robot.

    Images are exactly `size` bytes. A link has no clock. The cell decides when a packet is produced
    and when it arrives.
    """

    name: str
    size: int

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150 to `image`, because a packet from the master has arrived."""

    def scanner_read(self) -> bytes:
        """Return assembly 100, for a packet that the master receives now."""

    def robot_read(self) -> bytes:
        """Return assembly 150, which the controller reads."""

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100 to the controller's outputs."""

    def close(self) -> None:
        """Close the connection and free its resources."""


class Network(Protocol):
    """The interface of a network to its cell; `PacketNetwork` documents the methods."""

    @property
    def input(self) -> bytes: ...  # noqa: D102

    def start(self, content: Callable[[], bytes]) -> None: ...  # noqa: D102

    def set_cable(self, up: bool) -> None: ...  # noqa: D102

    def set_adapter(self, up: bool) -> None: ...  # noqa: D102

    def robot_connected(self, now_us: int) -> bool: ...  # noqa: D102

    def plc_connected(self, now_us: int) -> bool: ...  # noqa: D102

    def scanned(self, image: bytes) -> None: ...  # noqa: D102

    def snapshot(self) -> object: ...  # noqa: D102

    def restore(self, snapshot: Any) -> None: ...  # noqa: D102


@runtime_checkable
class OwnNetwork(Protocol):
    """A link with its own implementation of `Network`, which replaces `PacketNetwork`."""

    def network(self, agenda: Agenda, *, matched: bool) -> Network:
        """Return the network of the link; `PacketNetwork` documents the argument `matched`."""


def make_network(
    link: Link, timing: Timing, agenda: Agenda, *, matched: bool, seed: int, controller: int
) -> Network:
    """Return the network of a link: its own network, or packets in virtual time."""
    if isinstance(link, OwnNetwork):
        return link.network(agenda, matched=matched)
    return PacketNetwork(link, timing, agenda, matched=matched, seed=seed, controller=controller)


class DirectLink:
    """A link with both images in one process, without a network."""

    name = "direct"

    def __init__(self, size: int = SIZE) -> None:
        self.size = size
        self._to_robot = bytes(size)
        self._to_master = bytes(size)

    def scanner_write(self, image: bytes) -> None:
        """Set assembly 150, which goes to the robot."""
        self._to_robot = bytes(image)

    def scanner_read(self) -> bytes:
        """Return assembly 100, which comes from the robot."""
        return self._to_master

    def robot_read(self) -> bytes:
        """Return assembly 150, which comes from the PLC."""
        return self._to_robot

    def robot_write(self, image: bytes) -> None:
        """Set assembly 100, which goes to the PLC."""
        self._to_master = bytes(image)

    def close(self) -> None:
        """Do nothing: there are no resources to free."""


class PacketNetwork:
    """Cyclic packets in both directions over one connection.

    Packets flow while the cable is plugged in and the robot's adapter is on. An interruption also
    drops packets that were sent but have not arrived. A side considers the connection lost when no
    packet has arrived for `Timing.timeout_us`. The adapter also loses the connection when the
    adapter is switched off. After one side has lost the connection, no packet flows until the
    second side has also lost it and the scanner has opened a new connection. The new connection is
    opened after at least 100 ms and a scan, so each side notices the loss. Before the first packet
    both images are zero.

    Args:
        matched: Whether master and robot have areas of the same size; otherwise there is no
            connection (manual chapter 3, 1).
    """

    def __init__(
        self,
        link: Link,
        timing: Timing,
        agenda: Agenda,
        *,
        matched: bool,
        seed: int,
        controller: int = 1,
    ) -> None:
        self._link, self._timing, self._agenda = link, timing, agenda
        self._matched, self._controller = matched, controller
        self._random = Random(f"jitter {seed}")
        self._cable, self._adapter, self._plc = True, False, True
        self._seed = seed
        self._faults: dict[tuple[str, int], tuple[float, int]] = {}
        self._hits = {"lost": 0, "late": 0, "doubled": 0}
        self._open = False
        self._epoch = 0
        self._lost_us: int | None = None
        self._last: list[int | None] = [None, None]
        self._due = [0, 0]
        self.input = bytes(link.size)
        """The last image that the PLC has received."""

    def start(self, content: Callable[[], bytes]) -> None:
        """Start to produce packets; packets to the robot carry the result of `content`."""

        def to_robot(now_us: int) -> None:
            self.produce_to_robot(now_us, content)

        _, first_to_robot, first_to_plc, _ = self._timing.phases
        for first_us, kind, produce in (
            (first_to_robot, Kind.PRODUCE_TO_ROBOT, to_robot),
            (first_to_plc, Kind.PRODUCE_TO_PLC, self.produce_to_plc),
        ):
            self._agenda.repeat(first_us, kind, self._timing.rpi_us, produce, self._controller)

    @property
    def has_cable(self) -> bool:
        """Return whether the cable is plugged in."""
        return self._cable

    def set_cable(self, up: bool) -> None:
        """Plug or unplug the cable."""
        self._cable = up
        if not up:
            self._epoch += 1

    def set_adapter(self, up: bool) -> None:
        """Switch the robot's adapter on or off, because the controller has booted or lost power."""
        if up != self._adapter:
            self._adapter = up
            if not up:
                self._lose(_TO_ROBOT)

    def set_plc(self, up: bool) -> None:
        """Start the PLC's scanner, or end its connection."""
        self._plc = up
        if not up:
            self._lose(_TO_PLC)

    def disturb(self, kind: str, direction: int, share: float, by_us: int = 0) -> None:
        """Disturb a `share` of a direction's packets from now on: `lost`, `late` or `doubled`.

        A late packet arrives up to `by_us` later, as does the copy of a doubled packet. The order
        of the packets does not change. The disturbance of a packet depends only on the seed and on
        its time. If a disturbance is removed from a run, the run before the disturbance therefore
        does not change.
        """
        if share:
            self._faults[kind, direction] = (share, by_us)
        else:
            self._faults.pop((kind, direction), None)

    @property
    def disturbed(self) -> dict[str, int]:
        """Return the number of packets that were `lost`, `late` and `doubled` by `disturb`."""
        return dict(self._hits)

    def change_interval(self, timing: Timing) -> None:
        """Change the packet interval; the agenda uses it from the next packet on."""
        self._timing = timing

    def robot_connected(self, now_us: int) -> bool:
        """Return whether the robot still receives packets."""
        return self._alive(_TO_ROBOT, now_us)

    def plc_connected(self, now_us: int) -> bool:
        """Return whether the PLC still receives packets, which its scanner shows as its status."""
        return self._alive(_TO_PLC, now_us)

    def scanned(self, image: bytes) -> None:
        """Do nothing, because the next packet carries the outputs of the scan."""

    def produce_to_robot(self, now_us: int, content: Callable[[], bytes]) -> None:
        """Send the current output image of the PLC's scanner."""
        if self._flows(now_us):
            self._send(_TO_ROBOT, now_us, content())

    def produce_to_plc(self, now_us: int) -> None:
        """Send the current output image of the robot's adapter."""
        if self._flows(now_us):
            self._send(_TO_PLC, now_us, self._link.scanner_read())

    def snapshot(self) -> object:
        """Return the complete state, including the images."""
        state = (self._cable, self._adapter, self._plc, self._open, self._epoch, self._lost_us)
        packets = (tuple(self._last), tuple(self._due))
        images = (self._link.robot_read(), self._link.scanner_read(), self.input)
        faults = (dict(self._faults), dict(self._hits), self._timing)
        return state, packets, images, self._random.getstate(), faults

    def restore(self, snapshot: Any) -> None:
        """Restore the state of a snapshot."""
        state, packets, images, random, faults = snapshot
        self._cable, self._adapter, self._plc, self._open, self._epoch, self._lost_us = state
        self._faults, self._hits, self._timing = dict(faults[0]), dict(faults[1]), faults[2]
        self._last, self._due = list(packets[0]), list(packets[1])
        self._link.scanner_write(images[0])
        self._link.robot_write(images[1])
        self.input = images[2]
        self._random.setstate(random)

    def _flows(self, now_us: int) -> bool:
        """Return whether PLC and robot are connected; first open a new connection if possible."""
        if not (self._matched and self._cable and self._adapter and self._plc):
            return False
        # A lost connection is reopened only after both sides have noticed the loss. Otherwise one
        # side would continue without noticing that the other has restarted. The pause is also
        # longer than a scan, so that the program sees the connection status OFF at least once.
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
        if not self._faults:
            self._send_on(direction, now_us, content)
            return
        if self._hit("lost", direction, now_us):
            return
        if (late_us := self._hit("late", direction, now_us)) is not None:
            self._due[direction] = max(now_us + late_us, self._due[direction])
        self._send_on(direction, now_us, content)
        if (twice_us := self._hit("doubled", direction, now_us)) is not None:
            self._due[direction] = max(now_us + twice_us, self._due[direction])
            self._queue(self._due[direction], direction, content)

    def _hit(self, kind: str, direction: int, now_us: int) -> int | None:
        """Draw whether to disturb a packet; return its delay [us] (at least 1), or None if not."""
        share, by_us = self._faults.get((kind, direction), (0.0, 0))
        key = f"{kind} {direction} {now_us} {self._seed}".encode()
        draw = (int.from_bytes(blake2b(key, digest_size=4).digest(), "big") + 1) / 2**32
        if draw > share:
            return None
        self._hits[kind] += 1
        return max(1, round(draw / share * by_us))

    def _send_on(self, direction: int, now_us: int, content: bytes) -> None:
        jitter_us = self._timing.jitter_us
        if not jitter_us and now_us > self._due[direction]:
            # No other packet waits for its delivery, and without jitter no event can come between
            # sending and arrival. So deliver the packet at once, which saves an entry in the
            # agenda.
            self._due[direction] = now_us
            self._arrive(direction, now_us, content)
            return
        delay = self._random.randint(0, jitter_us) if jitter_us else 0
        due = self._due[direction] = max(now_us + delay, self._due[direction])
        self._queue(due, direction, content)

    def _queue(self, due_us: int, direction: int, content: bytes) -> None:
        """Deliver a packet at `due_us`, unless an interruption comes first."""
        packet = partial(self._deliver, direction, self._epoch, content)
        self._agenda.add(due_us, Kind.DELIVER, packet, self._controller)

    def _deliver(self, direction: int, epoch: int, content: bytes, now_us: int) -> None:
        if epoch == self._epoch:
            self._arrive(direction, now_us, content)

    def _arrive(self, direction: int, now_us: int, content: bytes) -> None:
        self._last[direction] = now_us
        if direction == _TO_ROBOT:
            self._link.scanner_write(content)
        else:
            self.input = content
