"""The cyclic exchange: all class 1 connections of a device, without sockets and without a clock.

The caller passes received packets and the time. The exchange returns packets to send and reports
connections that have ended. For each connection a producer makes the packets in one direction at
the packet interval, and a consumer judges the packets of the other direction.

A packet has two items of the common packet format. The first is the sequenced address: the
connection id and a sequence number of 32 bits, which grows with every packet. The second is the
connected data: a sequence count of 16 bits, which grows only with new data, then (from the
originator) the run/idle header of 32 bits, then the data. A receiver thus recognises lost packets
by the number, and unchanged data by the count. Rules: CIP volume 1, chapter 3, transport class 1
and connection timing; EtherNet/IP adaptation (volume 2), chapter 3.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import asdict, dataclass
from enum import Enum
from operator import attrgetter
from typing import NamedTuple

from rcx_harness.enip.cyclic.connections import (
    FIRST_PACKET_US,
    LONGEST_TIMEOUT_US,
    ConnectionKind,
    ConnectionParameters,
    EndReason,
    OwnerState,
    Way,
)
from rcx_harness.enip.cyclic.journal import ConnectionEvent
from rcx_harness.enip.cyclic.shared import Drop, SharedImages, Word

__all__ = [
    "WINDOW",
    "Arrival",
    "Consumer",
    "Exchange",
    "Packet",
    "Producer",
    "Role",
    "Send",
    "decode_packet",
]

WINDOW = 1024
"""The largest accepted step of the sequence number.

The limit is twice the 512 intervals of the longest time-out. A connection that loses more packets
in a row has already timed out. A larger step therefore does not come from the originator.
"""

_SEQUENCED_ADDRESS, _CONNECTED_DATA = 0x8002, 0x00B1
# The beginning of a packet: number of items; type, length, connection id and sequence number of the
# first item; type and length of the second item.
_HEADER = struct.Struct("<HHHIIHH")
_NUMBER = struct.Struct("<I")
_NUMBER_AT = 10
_COUNT = struct.Struct("<H")
_RUN_IDLE = struct.Struct("<I")
_RUN = 1


class Packet(NamedTuple):
    """One decoded packet.

    Attributes:
        connection_id: Identifier of the connection to which the packet belongs.
        content: The connected data; None if the length of the item does not fit the length of the
            datagram.
    """

    connection_id: int
    number: int
    content: bytes | None


def decode_packet(datagram: bytes) -> Packet | None:
    """Decode a datagram; return None if it is not a packet of class 1."""
    if len(datagram) < _HEADER.size:
        return None
    items, address, size, identifier, number, kind, length = _HEADER.unpack_from(datagram)
    if (items, address, size, kind) != (2, _SEQUENCED_ADDRESS, 8, _CONNECTED_DATA):
        return None
    content = datagram[_HEADER.size :]
    return Packet(identifier, number, content if len(content) == length else None)


class Producer:
    """Produces the packets of one connection id, one per interval.

    Args:
        size: Number of data bytes in each packet, without sequence count and run/idle header.

    Attributes:
        number: Sequence number of the last packet; the next packet has the number after it.
    """

    def __init__(
        self, connection_id: int, size: int, run_idle: bool, api_us: int, first_us: int
    ) -> None:
        self.api_us = api_us
        self.due_us = first_us
        self._size = size
        self._run_idle = run_idle
        length = _COUNT.size + (_RUN_IDLE.size if run_idle else 0) + size
        self._packet = bytearray(_HEADER.size + length)
        _HEADER.pack_into(
            self._packet, 0, 2, _SEQUENCED_ADDRESS, 8, connection_id, 0, _CONNECTED_DATA, length
        )
        self.number = self._count = 0
        self._last: tuple[int, bool] | None = None

    def is_new(self, version: int, run: bool) -> bool:
        """Return whether the data or the run state has changed since the last packet."""
        return self._last != (version, run)

    def renew(self, image: bytes, version: int, run: bool) -> None:
        """Replace the data of the next packets with the first `size` bytes of the image."""
        self._last = (version, run)
        self._count = (self._count + 1) & 0xFFFF
        _COUNT.pack_into(self._packet, _HEADER.size, self._count)
        at = _HEADER.size + _COUNT.size
        if self._run_idle:
            _RUN_IDLE.pack_into(self._packet, at, _RUN if run else 0)
            at += _RUN_IDLE.size
        self._packet[at:] = image[: self._size]

    def packet(self) -> bytes:
        """Return the next packet with the current data and the next sequence number."""
        self.number = (self.number + 1) & 0xFFFFFFFF
        _NUMBER.pack_into(self._packet, _NUMBER_AT, self.number)
        return bytes(self._packet)

    def advance(self, now_us: int) -> int:
        """Set the time of the next packet on the grid of the interval; skip times that have passed.

        Returns:
            How many packets were skipped because their time had passed.
        """
        skipped = max(0, now_us - self.due_us) // self.api_us
        self.due_us += (skipped + 1) * self.api_us
        return skipped


class Arrival(NamedTuple):
    """The data and state of a packet that the consumer has accepted.

    Attributes:
        data: The application's data; None if the packet repeats old data or is idle.
        run: Whether the program at the other end runs.
        missing: The number of lost packets directly before this packet.
    """

    data: bytes | None
    run: bool
    missing: int


class Consumer:
    """Checks the received packets of one connection id, and accepts or drops each packet.

    Args:
        size: Expected number of data bytes; 0 for a heartbeat, with or without a sequence count.
        timeout_us: Longest silence between two packets; the first packet may take at least 10 s.
        first_us: Upper limit of the wait for the first packet, for connections with a long
            time-out.
    """

    def __init__(
        self,
        size: int,
        run_idle: bool,
        timeout_us: int,
        now_us: int,
        first_us: int = LONGEST_TIMEOUT_US,
    ) -> None:
        self.deadline_us = now_us + min(max(timeout_us, FIRST_PACKET_US), first_us)
        self._size = size
        self._run_idle = run_idle
        self._timeout_us = timeout_us
        self._data_at = _COUNT.size + (_RUN_IDLE.size if run_idle else 0)
        lengths = {self._data_at + size}
        self._lengths = lengths if size else lengths | {0, _COUNT.size}
        self._number: int | None = None
        self._count: int | None = None

    @property
    def length(self) -> int:
        """Return the expected number of bytes of connected data."""
        return max(self._lengths)

    def take(self, number: int, content: bytes, now_us: int) -> Arrival | Drop:
        """Process a packet of this connection.

        The first packet may have any number. After it, a number is valid if it is at most `WINDOW`
        ahead of the last number, also across the end of the 32 bits.

        Returns:
            The arrival, or the reason why the packet is dropped. A dropped packet does not restart
            the time-out.
        """
        if len(content) not in self._lengths:
            return Drop.LENGTH
        missing = 0
        if self._number is not None:
            ahead = (number - self._number) & 0xFFFFFFFF
            if not 0 < ahead < 0x80000000:
                return Drop.OLD
            if ahead > WINDOW:
                return Drop.JUMP
            missing = ahead - 1
        self._number = number
        self.deadline_us = now_us + self._timeout_us
        if not self._size:
            return Arrival(None, True, missing)
        run = not self._run_idle or bool(content[_COUNT.size] & _RUN)
        if not run:
            # The first packet after a loss counts as new data, even with an unchanged count.
            self._count = None
            return Arrival(None, False, missing)
        (count,) = _COUNT.unpack_from(content)
        data = content[self._data_at :] if count != self._count else None
        self._count = count
        return Arrival(data, True, missing)


Send = Callable[[bytes, tuple[str, int], int], None]
"""Sends a packet to an address and port with a differentiated services code point."""

_REPLY_FIRST_US = 10_000


class Role(str, Enum):
    """The ends of a connection."""

    TARGET = "target"
    ORIGINATOR = "originator"


@dataclass
class _Connection:
    parameters: ConnectionParameters
    consumer: Consumer
    arrived_us: int | None = None


@dataclass
class _Production:
    """The packets of one connection id, which several multicast connections can share."""

    producer: Producer
    destination: tuple[str, int]
    dscp: int
    users: dict[int, int]
    """Maps the number of each connection to its packet interval."""


class Exchange:
    """All class 1 connections of one device.

    The target receives assembly 150 and sends assembly 100; the originator, a scanner, does the
    opposite. Times are microseconds of one clock that never goes back.

    Args:
        images: The assemblies and the status of the connections.
        on_ended: Called with the number of each connection that ends by itself, and the reason.
    """

    def __init__(
        self,
        images: SharedImages,
        on_ended: Callable[[int, EndReason], None],
        role: Role = Role.TARGET,
    ) -> None:
        self._images = images
        self._on_ended = on_ended
        ends = (images.to_master, images.to_robot)
        ways = (attrgetter("o_to_t"), attrgetter("t_to_o"))
        self._is_target = role is Role.TARGET
        self._source, self._sink = ends if self._is_target else ends[::-1]
        consumed, produced = ways if self._is_target else ways[::-1]
        self._consumed: Callable[[ConnectionParameters], Way] = consumed
        self._produced: Callable[[ConnectionParameters], Way] = produced
        self._connections: dict[int, _Connection] = {}
        self._by_id: dict[int, _Connection] = {}
        self._productions: dict[tuple[bool, int], _Production] = {}
        self._due_us: int | None = None
        """The time of the next deadline [us]; None if there is no connection."""

    def add(self, parameters: ConnectionParameters, now_us: int) -> None:
        """Open a connection.

        A scanner sends its first packet at once. A target sends its first packet a little later,
        because it must not arrive before the reply to the Forward Open.
        """
        connection = _Connection(parameters, self._consumer(parameters, now_us))
        self._connections[parameters.number] = connection
        self._by_id[self._consumed(parameters).identifier] = connection
        key = self._production_key(parameters)
        production = self._productions.get(key)
        if production is None:
            production = self._productions[key] = _Production(
                self._producer(parameters, now_us),
                (parameters.destination, parameters.destination_port),
                parameters.dscp,
                {},
            )
        production.users[parameters.number] = self._produced(parameters).api_us
        production.producer.api_us = min(production.users.values())
        self._due_us = self._first_due_us()
        self._images.count(_OPEN[parameters.kind], 1)
        if self._is_watched(parameters):
            self._images.set_owner(OwnerState.WAITING, parameters)
        self._note(parameters, _STATES[OwnerState.WAITING], now_us)

    def remove(self, number: int, now_us: int) -> None:
        """Remove the connection with this number, because the originator has closed it.

        An unknown number has no effect.
        """
        if (connection := self._connections.get(number)) is not None:
            self._end(connection, OwnerState.CLOSED, _STATES[OwnerState.CLOSED], now_us)
            self._end_listeners(now_us)

    def clear(self, now_us: int) -> None:
        """End all connections, because the adapter is switched off."""
        for number, connection in list(self._connections.items()):
            self._end(connection, OwnerState.NONE, EndReason.OFF.value, now_us)
            self._on_ended(number, EndReason.OFF)

    def receive(self, datagram: bytes, host: str, now_us: int) -> bool:
        """Process a received packet.

        Returns:
            False if the datagram is not a packet, or if no connection has the packet's id. The
            statistics do not count such a datagram.
        """
        packet = decode_packet(datagram)
        connection = self._by_id.get(packet.connection_id) if packet else None
        if packet is None or connection is None:
            return False
        arrival: Arrival | Drop = Drop.PEER
        if connection.parameters.peer == host:
            arrival = Drop.LENGTH
            if packet.content is not None:
                arrival = connection.consumer.take(packet.number, packet.content, now_us)
            # The first packet may take longer than later packets. From now on the normal time-out
            # applies.
            end_us = connection.consumer.deadline_us
            if self._due_us is None or end_us < self._due_us:
                self._due_us = end_us
        if isinstance(arrival, Drop):
            self._images.drop(arrival)
            if arrival is Drop.LENGTH:
                length = len(datagram) - _HEADER.size
                self._images.note_length(length, connection.consumer.length)
            return True
        if arrival.missing:
            self._images.count(Word.MISSING, arrival.missing)
        # Write the data first, then the time, then the state. A reader in another process reads in
        # the reverse order. If it finds the state RUN, time and data of the packet are therefore
        # already valid.
        watched = self._is_watched(connection.parameters)
        if watched and arrival.data is not None:
            self._sink.write(arrival.data)
        last_us, connection.arrived_us = connection.arrived_us, now_us
        self._images.arrive(now_us, None if last_us is None else now_us - last_us)
        if watched:
            self._publish(connection.parameters, arrival, now_us)
        return True

    def poll(self, now_us: int, send: Send) -> int | None:
        """Send the packets that are due, and end connections that have timed out.

        Returns:
            The time of the next poll [us]; None without a connection.
        """
        if self._due_us is None or now_us < self._due_us:
            return self._due_us
        for production in self._productions.values():
            if production.producer.due_us <= now_us:
                self._produce(production, now_us, send)
        for number, connection in list(self._connections.items()):
            if connection.consumer.deadline_us <= now_us and number in self._connections:
                reason = EndReason.TIMED_OUT
                self._end(connection, OwnerState.TIMED_OUT, reason.value, now_us)
                self._on_ended(number, reason)
                self._end_listeners(now_us)
        self._due_us = self._first_due_us()
        return self._due_us

    def _first_due_us(self) -> int | None:
        times = [production.producer.due_us for production in self._productions.values()]
        times += [connection.consumer.deadline_us for connection in self._connections.values()]
        return min(times, default=None)

    def _produce(self, production: _Production, now_us: int, send: Send) -> None:
        producer = production.producer
        run = self._images.run
        # Read the version before the data. If new data is written between both reads, the next poll
        # sees a new version. In the reverse order it would miss the new data.
        version = self._source.version
        if producer.is_new(version, run):
            producer.renew(self._source.read(), version, run)
        send(producer.packet(), production.destination, production.dscp)
        self._images.count(Word.SENT)
        if skipped := producer.advance(now_us):
            self._images.count(Word.SKIPPED, skipped)

    def _publish(self, parameters: ConnectionParameters, arrival: Arrival, now_us: int) -> None:
        state = OwnerState.RUN if arrival.run else OwnerState.IDLE
        if self._images.owner is not state:
            self._images.set_owner(state, parameters)
            self._note(parameters, _STATES[state], now_us)

    def _end(self, connection: _Connection, state: OwnerState, how: str, now_us: int) -> None:
        parameters = connection.parameters
        del self._connections[parameters.number]
        del self._by_id[self._consumed(parameters).identifier]
        key = self._production_key(parameters)
        users = self._productions[key].users
        del users[parameters.number]
        if users:
            self._productions[key].producer.api_us = min(users.values())
        else:
            del self._productions[key]
        self._due_us = self._first_due_us()
        self._images.count(_OPEN[parameters.kind], -1)
        if self._is_watched(parameters):
            self._images.set_owner(state, None)
        self._note(parameters, how, now_us)

    def _note(self, parameters: ConnectionParameters, state: str, now_us: int) -> None:
        """Write an event to the journal: the new state of a connection."""
        event = ConnectionEvent(
            at_us=now_us,
            kind=parameters.kind,
            state=state,
            peer=parameters.peer,
            o_to_t_api_us=parameters.o_to_t_api_us,
            t_to_o_api_us=parameters.t_to_o_api_us,
            readers=sum(not one.parameters.is_owner for one in self._connections.values()),
        )
        self._images.events.write(asdict(event))

    def _end_listeners(self, now_us: int) -> None:
        """End all listen-only connections if no connection of another kind remains."""
        if not self._is_target:
            return
        connections = list(self._connections.items())
        kinds = {connection.parameters.kind for _, connection in connections}
        if kinds == {ConnectionKind.LISTEN_ONLY}:
            for number, connection in connections:
                reason = EndReason.NO_OWNER
                self._end(connection, OwnerState.CLOSED, reason.value, now_us)
                self._on_ended(number, reason)

    def _is_watched(self, parameters: ConnectionParameters) -> bool:
        """Return whether the state of this connection is published.

        A target publishes the state of its owner; a scanner publishes the state of its connection.
        """
        return parameters.is_owner or not self._is_target

    def _consumer(self, parameters: ConnectionParameters, now_us: int) -> Consumer:
        way = self._consumed(parameters)
        timeout_us = parameters.timeout_us(way)
        return Consumer(way.size, way.run_idle, timeout_us, now_us, parameters.first_packet_us)

    def _producer(self, parameters: ConnectionParameters, now_us: int) -> Producer:
        way = self._produced(parameters)
        first_us = now_us + (min(way.api_us, _REPLY_FIRST_US) if self._is_target else 0)
        return Producer(way.identifier, way.size, way.run_idle, way.api_us, first_us)

    def _production_key(self, parameters: ConnectionParameters) -> tuple[bool, int]:
        if self._is_target and parameters.multicast:
            return True, parameters.t_to_o_id
        return False, parameters.number


_STATES = {
    OwnerState.WAITING: "waiting",
    OwnerState.RUN: "run",
    OwnerState.IDLE: "idle",
    OwnerState.CLOSED: "closed",
}
_OPEN = {
    ConnectionKind.EXCLUSIVE_OWNER: Word.OWNERS,
    ConnectionKind.INPUT_ONLY: Word.INPUT_ONLY,
    ConnectionKind.LISTEN_ONLY: Word.LISTEN_ONLY,
}
