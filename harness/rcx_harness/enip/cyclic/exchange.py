"""All class 1 connections of a device, without sockets and without a clock.

Packets and times go in, packets and the end of connections come out. Rules: CIP volume 1, chapter
3, transport class 1 and connection timing; EtherNet/IP adaptation (volume 2), chapter 3.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from rcx_harness.enip.cyclic.connections import (
    ConnectionKind,
    ConnectionParameters,
    EndReason,
    OwnerState,
)
from rcx_harness.enip.cyclic.packets import Arrival, Consumer, Producer, decode_packet
from rcx_harness.enip.cyclic.shared import Counter, SharedImages

__all__ = ["Exchange", "Role", "Send"]

Send = Callable[[bytes, tuple[str, int], int], None]
"""Sends a packet to an address and port with a differentiated services code point."""

_REPLY_FIRST_US = 10_000


class Role(str, Enum):
    """The end of the connection that this is."""

    TARGET = "target"
    ORIGINATOR = "originator"


@dataclass
class _Connection:
    parameters: ConnectionParameters
    consumer: Consumer
    arrived_us: int | None = None


@dataclass
class _Production:
    """What several multicast connections share."""

    producer: Producer
    destination: tuple[str, int]
    dscp: int
    users: dict[int, int]
    """Number and interval of each."""


class Exchange:
    """All class 1 connections of one device.

    The target takes data into assembly 150 and sends assembly 100; the originator, a scanner, the
    other way round. Times are microseconds of one clock that never goes back.

    Args:
        images: The assemblies and the status that is kept there.
        on_ended: Told the number of each connection that ends by itself, and why.
        role: Which end this is.
    """

    def __init__(
        self,
        images: SharedImages,
        on_ended: Callable[[int, EndReason], None],
        role: Role = Role.TARGET,
    ) -> None:
        self._images = images
        self._on_ended = on_ended
        self._role = role
        is_target = role is Role.TARGET
        self._source = images.to_master if is_target else images.to_robot
        self._sink = images.to_robot if is_target else images.to_master
        self._connections: dict[int, _Connection] = {}
        self._by_id: dict[int, _Connection] = {}
        self._productions: dict[tuple[bool, int], _Production] = {}

    def add(self, parameters: ConnectionParameters, now_us: int) -> None:
        """Open a connection.

        A scanner's first packet is due at once. The target's must not arrive before the reply to
        the Forward Open, in which the scanner learns of the connection: it comes a little later.
        """
        connection = _Connection(parameters, self._consumer(parameters, now_us))
        self._connections[parameters.number] = connection
        self._by_id[self._consumed_id(parameters)] = connection
        key = self._production_key(parameters)
        production = self._productions.get(key)
        if production is None:
            production = self._productions[key] = _Production(
                self._producer(parameters, now_us),
                (parameters.destination, parameters.destination_port),
                parameters.dscp,
                {},
            )
        production.users[parameters.number] = self._produced_api_us(parameters)
        production.producer.api_us = min(production.users.values())
        self._images.count(_COUNTERS[parameters.kind], 1)
        if self._is_watched(parameters):
            self._images.set_owner(OwnerState.WAITING, parameters)

    def remove(self, number: int) -> None:
        """The originator has closed a connection; an unknown number does no harm."""
        if (connection := self._connections.get(number)) is not None:
            self._end(connection, OwnerState.CLOSED)
            self._end_listeners()

    def clear(self) -> None:
        """The adapter goes off: all connections are gone."""
        for number, connection in list(self._connections.items()):
            self._end(connection, OwnerState.NONE)
            self._on_ended(number, EndReason.OFF)

    def receive(self, datagram: bytes, host: str, now_us: int) -> bool:
        """A packet has arrived.

        Returns:
            False if no connection has its id, or it has none; nothing has been counted then.
        """
        packet = decode_packet(datagram)
        connection = self._by_id.get(packet.connection_id) if packet else None
        if packet is None or connection is None:
            return False
        arrival = None
        if connection.parameters.peer == host and packet.content is not None:
            arrival = connection.consumer.take(packet.number, packet.content, now_us)
        if arrival is None:
            self._images.count(Counter.DROPPED)
            return True
        if arrival.missing:
            self._images.count(Counter.MISSING, arrival.missing)
        if self._is_watched(connection.parameters):
            self._publish(connection.parameters, arrival)
        # Last, too: a scanner's reader believes the data once something has arrived.
        last_us, connection.arrived_us = connection.arrived_us, now_us
        self._images.arrive(now_us, None if last_us is None else now_us - last_us)
        return True

    def poll(self, now_us: int, send: Send) -> int | None:
        """Send what is due and end what has timed out.

        Returns:
            When to poll again; None without a connection.
        """
        for production in self._productions.values():
            if production.producer.due_us <= now_us:
                self._produce(production, now_us, send)
        for number, connection in list(self._connections.items()):
            if connection.consumer.deadline_us <= now_us and number in self._connections:
                self._end(connection, OwnerState.TIMED_OUT)
                self._on_ended(number, EndReason.TIMED_OUT)
                self._end_listeners()
        times = [production.producer.due_us for production in self._productions.values()]
        times += [connection.consumer.deadline_us for connection in self._connections.values()]
        return min(times, default=None)

    def _produce(self, production: _Production, now_us: int, send: Send) -> None:
        producer = production.producer
        run = self._images.run
        # The version first: what is written in between is then new once more, never overlooked.
        version = self._source.version
        if producer.is_new(version, run):
            producer.renew(self._source.read(), version, run)
        send(producer.packet(), production.destination, production.dscp)
        self._images.count(Counter.SENT)
        if skipped := producer.advance(now_us):
            self._images.count(Counter.SKIPPED, skipped)

    def _publish(self, parameters: ConnectionParameters, arrival: Arrival) -> None:
        # The data first: who sees the state RUN also sees the data.
        if arrival.data is not None:
            self._sink.write(arrival.data)
        state = OwnerState.RUN if arrival.run else OwnerState.IDLE
        if self._images.owner is not state:
            self._images.set_owner(state, parameters)

    def _end(self, connection: _Connection, state: OwnerState) -> None:
        parameters = connection.parameters
        del self._connections[parameters.number]
        del self._by_id[self._consumed_id(parameters)]
        key = self._production_key(parameters)
        users = self._productions[key].users
        del users[parameters.number]
        if users:
            self._productions[key].producer.api_us = min(users.values())
        else:
            del self._productions[key]
        self._images.count(_COUNTERS[parameters.kind], -1)
        if self._is_watched(parameters):
            self._images.set_owner(state, None)

    def _end_listeners(self) -> None:
        """A listen-only connection lives as long as one of another kind does."""
        if self._role is not Role.TARGET:
            return
        connections = list(self._connections.items())
        kinds = {connection.parameters.kind for _, connection in connections}
        if kinds == {ConnectionKind.LISTEN_ONLY}:
            for number, connection in connections:
                self._end(connection, OwnerState.CLOSED)
                self._on_ended(number, EndReason.NO_OWNER)

    def _is_watched(self, parameters: ConnectionParameters) -> bool:
        """Does its state count: the target's owner, and whatever a scanner has opened."""
        return parameters.is_owner or self._role is Role.ORIGINATOR

    def _consumer(self, parameters: ConnectionParameters, now_us: int) -> Consumer:
        if self._role is Role.TARGET:
            timeout_us = parameters.timeout_us(parameters.o_to_t_api_us)
            size, run_idle = parameters.o_to_t_size, parameters.run_idle
            return Consumer(size, run_idle, timeout_us, now_us, parameters.first_packet_us)
        timeout_us = parameters.timeout_us(parameters.t_to_o_api_us)
        return Consumer(parameters.t_to_o_size, False, timeout_us, now_us)

    def _producer(self, parameters: ConnectionParameters, now_us: int) -> Producer:
        api_us = self._produced_api_us(parameters)
        if self._role is Role.TARGET:
            first_us = now_us + min(api_us, _REPLY_FIRST_US)
            return Producer(parameters.t_to_o_id, parameters.t_to_o_size, False, api_us, first_us)
        size, run_idle = parameters.o_to_t_size, parameters.run_idle
        return Producer(parameters.o_to_t_id, size, run_idle, api_us, now_us)

    def _produced_api_us(self, parameters: ConnectionParameters) -> int:
        is_target = self._role is Role.TARGET
        return parameters.t_to_o_api_us if is_target else parameters.o_to_t_api_us

    def _consumed_id(self, parameters: ConnectionParameters) -> int:
        return parameters.o_to_t_id if self._role is Role.TARGET else parameters.t_to_o_id

    def _production_key(self, parameters: ConnectionParameters) -> tuple[bool, int]:
        if self._role is Role.TARGET and parameters.multicast:
            return True, parameters.t_to_o_id
        return False, parameters.number


_COUNTERS = {
    ConnectionKind.EXCLUSIVE_OWNER: Counter.OWNERS,
    ConnectionKind.INPUT_ONLY: Counter.INPUT_ONLY,
    ConnectionKind.LISTEN_ONLY: Counter.LISTEN_ONLY,
}
