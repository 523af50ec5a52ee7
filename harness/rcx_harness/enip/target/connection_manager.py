"""The Connection Manager, which opens and closes connections (CIP volume 1, chapter 3, 5).

`admission` checks a Forward Open. The cyclic exchange handles the packets of class 1; this module
adds and removes its connections. Messages of class 3 are answered here.
"""

from __future__ import annotations

import secrets
from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field

from rcx_harness.enip.codec import forward_open as bytes_of
from rcx_harness.enip.codec.cip import (
    ConnectionService,
    ExtendedStatus,
    Refusal,
    Request,
    Status,
    encode_reply,
)
from rcx_harness.enip.codec.encapsulation import Item, decode_socket_address, socket_address
from rcx_harness.enip.codec.forward_open import (
    ConnectionPath,
    ConnectionType,
    ForwardOpen,
    PathRefusal,
    Triad,
    decode_connection_path,
)
from rcx_harness.enip.cyclic.connections import (
    IO_PORT,
    RUN_IDLE_SIZE,
    SEQUENCE_SIZE,
    ConnectionKind,
    ConnectionParameters,
)
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.target.admission import (
    EXPLICIT_CLASS,
    check_cyclic,
    check_explicit,
    check_transport,
    has_room,
    key_mismatch,
    refused,
)
from rcx_harness.enip.target.refusal_text import Facts, refusal_text

__all__ = [
    "MAX_CYCLIC",
    "MAX_EXPLICIT",
    "MAX_EXPLICIT_OF_PEER",
    "ConnectionManager",
    "ExplicitConnection",
    "Origin",
    "random_id",
]


@dataclass
class Origin:
    """The sender of a request, with the addresses of request and reply.

    Attributes:
        local: Our IPv4 address that the originator has used.
        session: Handle of the session. An explicit connection ends with its session.
        addresses: Socket address items of the request, by their type.
        items: Socket address items for the reply.
    """

    peer: str = "127.0.0.1"
    local: str = "127.0.0.1"
    session: int = 0
    addresses: Mapping[int, bytes] = field(default_factory=dict)
    items: list[tuple[int, bytes]] = field(default_factory=list)


_FIRST_S = 10.0
_OPENING = (ConnectionService.FORWARD_OPEN, ConnectionService.LARGE_FORWARD_OPEN)


class ExplicitConnection:
    """A class 3 connection, which carries explicit messages and answers them.

    A repeated message, which has the same sequence count, gets the same reply and is not executed
    again.

    The connection ends with its session. Times are seconds of one monotonic clock.
    """

    def __init__(
        self, request: ForwardOpen, connection_id: int, session: int, peer: str, now: float
    ) -> None:
        self.triad = request.triad
        self.connection_id = connection_id
        self.session = session
        self.peer = peer
        self.reply_id = request.t_to_o_id
        self._sizes = request.o_to_t.size, request.t_to_o.size
        self._timeout_s = request.o_to_t_rpi * (4 << request.multiplier) / 1e6
        self._deadline = now + max(self._timeout_s, _FIRST_S)
        self._last = b""
        self._reply = b""

    def has_timed_out(self, now: float) -> bool:
        """Return whether the time-out has passed without a message (first: at least 10 s)."""
        return now >= self._deadline

    def answer(self, message: bytes, now: float, perform: Callable[[bytes], bytes]) -> bytes | None:
        """Return the reply to a message. Message and reply begin with the same sequence count.

        A message that is longer than the connection's size is answered with status 0x15. `perform`
        executes the CIP request and returns its reply.

        Returns:
            The reply; None if the message is too short to be answered.
        """
        if len(message) < SEQUENCE_SIZE + 2:
            return None
        self._deadline = now + self._timeout_s
        sequence, service = message[:SEQUENCE_SIZE], message[SEQUENCE_SIZE]
        if sequence == self._last:
            return self._reply
        if len(message) > self._sizes[0]:
            reply = encode_reply(service, Status.TOO_MUCH_DATA)
        else:
            reply = perform(message[SEQUENCE_SIZE:])
        if SEQUENCE_SIZE + len(reply) > self._sizes[1]:
            reply = encode_reply(service, Status.REPLY_DATA_TOO_LARGE)
        self._last, self._reply = sequence, sequence + reply
        return self._reply


MAX_CYCLIC = {
    ConnectionKind.EXCLUSIVE_OWNER: 1,
    ConnectionKind.INPUT_ONLY: 8,
    ConnectionKind.LISTEN_ONLY: 8,
}
MAX_EXPLICIT, MAX_EXPLICIT_OF_PEER = 32, 16
MAX_CYCLIC_OF_PEER = 8

_ID_BITS = 32


def random_id() -> int:
    """Return 32 random bits that cannot be guessed."""
    return secrets.randbits(_ID_BITS)


class ConnectionManager:
    """The connections of one adapter.

    Args:
        identity: Compared with the electronic keys of requests.
        cyclic: The cyclic exchange; None for an adapter with explicit connections only.
        draw_id: Function that returns 32 random bits for a connection id. It must be impossible to
            guess an id from other ids, even from ids before the last start.
        on_refused: Function that is called with a sentence for each refused Forward Open.
        group: Multicast address to produce to.
    """

    def __init__(
        self,
        size: int,
        identity: Identity,
        options: AdapterOptions,
        cyclic: CyclicControl | None,
        clock: Callable[[], float],
        draw_id: Callable[[], int] = random_id,
        on_refused: Callable[[str], None] = lambda text: None,
        group: str = "239.192.1.0",
        dscp: Callable[[int], int] = lambda _: 0,
    ) -> None:
        self._size = size
        self._identity = identity
        self._options = options
        self._cyclic = cyclic
        self._clock = clock
        self._draw_id = draw_id
        self._on_refused = on_refused
        self._last_number = 0
        self._group = group
        self._dscp = dscp
        self._explicit: dict[int, ExplicitConnection] = {}
        self._peers: dict[Triad, str] = {}
        self._class1: dict[Triad, ConnectionParameters] = {}
        self._openers: dict[Triad, int] = {}
        """The session that has opened a class 1 connection. This session may have ended since."""

    @property
    def is_owned(self) -> bool:
        """Return whether assembly 150 has an Exclusive Owner."""
        return self._count(ConnectionKind.EXCLUSIVE_OWNER) > 0

    @property
    def cyclic_connections(self) -> tuple[ConnectionParameters, ...]:
        """Return the open class 1 connections."""
        return tuple(self._class1.values())

    def perform(self, request: Request, origin: Origin) -> bytes:
        """Reply to (Large) Forward Open and Forward Close; other services get error 0x08."""
        asked = None
        opens = request.service in _OPENING
        try:
            if request.service == ConnectionService.FORWARD_CLOSE:
                data = self._close(bytes_of.decode_forward_close(request), origin)
            elif opens:
                asked = bytes_of.decode_forward_open(request)
                data = self._open(asked, origin)
            else:
                return encode_reply(request.service, Status.SERVICE_NOT_SUPPORTED)
        except Refusal as refusal:
            remaining = refusal.remaining if isinstance(refusal, PathRefusal) else 0
            data = bytes_of.refusal_data(request, remaining)
            if opens:
                self._on_refused(refusal_text(origin.peer, asked, refusal, self._facts()))
            return encode_reply(request.service, refusal.status, data, refusal.extended)
        return encode_reply(request.service, Status.SUCCESS, data)

    def explicit(self, connection_id: int, session: int) -> ExplicitConnection | None:
        """Return the open class 3 connection of a session with this id; None if there is none."""
        self.expire()
        found = self._explicit.get(connection_id)
        return found if found is not None and found.session == session else None

    def is_used_by(self, session: int) -> bool:
        """Return whether the session has opened a connection (class 1 or 3) that is still open."""
        self.expire()
        explicit = {connection.session for connection in self._explicit.values()}
        return session in explicit | set(self._openers.values())

    def session_ended(self, session: int) -> None:
        """Close the session's class 3 connections; its class 1 connections continue."""
        self._drop(lambda connection: connection.session == session)

    def expire(self) -> None:
        """Close the class 3 connections that have timed out."""
        now = self._clock()
        self._drop(lambda connection: connection.has_timed_out(now))

    def ended(self, number: int) -> None:
        """Remove a class 1 connection that the cyclic process has ended by itself."""
        for triad, parameters in list(self._class1.items()):
            if parameters.number == number:
                self._forget(triad)

    def forget_cyclic(self) -> None:
        """Remove all class 1 connections, because the cyclic process has ended."""
        for triad in self._class1:
            del self._peers[triad]
        self._class1.clear()
        self._openers.clear()

    def close_all(self) -> None:
        """Close all connections of class 1 and 3, because the device is reset."""
        while self._class1:
            self._remove(next(iter(self._class1)))
        self._drop(lambda _: True)

    def _open(self, request: ForwardOpen, origin: Origin) -> bytes:
        self.expire()
        if request.triad in self._peers:
            kinds = (request.o_to_t.kind, request.t_to_o.kind)
            null = kinds == (ConnectionType.NULL, ConnectionType.NULL)
            raise refused(
                ExtendedStatus.NULL_FORWARD_OPEN if null else ExtendedStatus.DUPLICATE_FORWARD_OPEN
            )
        check_transport(request)
        path = decode_connection_path(request.path)
        if (mismatch := key_mismatch(path.key, self._identity)) is not None:
            raise refused(mismatch)
        if request.transport_class == EXPLICIT_CLASS:
            return self._open_explicit(request, path, origin)
        return self._open_cyclic(request, path, origin)

    def _open_explicit(self, request: ForwardOpen, path: ConnectionPath, origin: Origin) -> bytes:
        check_explicit(request, path)
        taken = (other.peer for other in self._explicit.values())
        if not has_room(taken, origin.peer, MAX_EXPLICIT, MAX_EXPLICIT_OF_PEER):
            raise refused(ExtendedStatus.OUT_OF_CONNECTIONS)
        connection = ExplicitConnection(
            request, self._new_id(), origin.session, origin.peer, self._clock()
        )
        self._explicit[connection.connection_id] = connection
        self._peers[request.triad] = origin.peer
        return bytes_of.open_reply(
            connection.connection_id,
            request.t_to_o_id,
            request.triad,
            request.o_to_t_rpi,
            request.t_to_o_rpi,
        )

    def _open_cyclic(self, request: ForwardOpen, path: ConnectionPath, origin: Origin) -> bytes:
        multicast = request.t_to_o.kind is ConnectionType.MULTICAST
        shared = [other for other in self._class1.values() if other.multicast] if multicast else []
        produced = [other.t_to_o_api_us for other in shared[:1]]
        kind = check_cyclic(request, path, self._size, self._options.rpi_min_us, produced)
        if self._cyclic is None:
            raise refused(ExtendedStatus.OUT_OF_CONNECTIONS)
        self._check_room(kind, origin.peer)
        t_to_o_id = request.t_to_o_id
        if multicast:
            t_to_o_id = shared[0].t_to_o_id if shared else self._new_id()
        heartbeat = kind is not ConnectionKind.EXCLUSIVE_OWNER
        self._last_number += 1
        parameters = ConnectionParameters(
            number=self._last_number,
            kind=kind,
            o_to_t_id=self._new_id(),
            t_to_o_id=t_to_o_id,
            o_to_t_api_us=request.o_to_t_rpi,
            t_to_o_api_us=request.t_to_o_rpi,
            o_to_t_size=0 if heartbeat else self._size,
            t_to_o_size=self._size,
            multiplier=request.multiplier,
            peer=origin.peer,
            destination=self._group if multicast else origin.peer,
            destination_port=self._destination_port(multicast, origin),
            run_idle=not heartbeat or request.o_to_t.size == SEQUENCE_SIZE + RUN_IDLE_SIZE,
            multicast=multicast,
            dscp=self._dscp(request.t_to_o.priority),
            first_packet_us=self._options.first_packet_us,
        )
        try:
            self._cyclic.add(parameters)
        except EnipError:  # the cyclic process has ended, so it cannot add a connection
            raise refused(ExtendedStatus.OUT_OF_CONNECTIONS) from None
        self._class1[request.triad] = parameters
        self._openers[request.triad] = origin.session
        self._peers[request.triad] = origin.peer
        ours = socket_address(origin.local, self._cyclic.port)
        origin.items.append((Item.O_TO_T_ADDRESS, ours))
        if multicast:
            group = socket_address(self._group, parameters.destination_port)
            origin.items.append((Item.T_TO_O_ADDRESS, group))
        return bytes_of.open_reply(
            parameters.o_to_t_id,
            parameters.t_to_o_id,
            request.triad,
            parameters.o_to_t_api_us,
            parameters.t_to_o_api_us,
        )

    def _check_room(self, kind: ConnectionKind, peer: str) -> None:
        if kind is ConnectionKind.EXCLUSIVE_OWNER and self.is_owned:
            raise refused(ExtendedStatus.OWNERSHIP_CONFLICT)
        listeners = self._count(ConnectionKind.LISTEN_ONLY)
        if kind is ConnectionKind.LISTEN_ONLY and len(self._class1) == listeners:
            raise refused(ExtendedStatus.ONLY_LISTENERS)
        taken = (other.peer for other in self._class1.values() if other.kind is kind)
        if not has_room(taken, peer, MAX_CYCLIC[kind], MAX_CYCLIC_OF_PEER):
            raise refused(ExtendedStatus.OUT_OF_CONNECTIONS)

    @staticmethod
    def _destination_port(multicast: bool, origin: Origin) -> int:
        """Return the UDP port for our packets.

        The originator may name a port for its own address.
        """
        item = origin.addresses.get(Item.T_TO_O_ADDRESS)
        if multicast or item is None:
            return IO_PORT
        address = decode_socket_address(item)
        if address is None or address[0] not in ("0.0.0.0", origin.peer):
            raise refused(ExtendedStatus.PARAMETER_ERROR)
        return address[1] or IO_PORT

    def _close(self, request: bytes_of.ForwardClose, origin: Origin) -> bytes:
        self.expire()
        if request.triad not in self._peers:
            raise refused(ExtendedStatus.CONNECTION_NOT_FOUND)
        # The triad alone identifies the connection. The path is ignored, because scanners send the
        # path of the connection, a route, the path of the Connection Manager or no path (CIP volume
        # 1, chapter 3, 5.5.3).
        if self._peers[request.triad] != origin.peer:
            raise Refusal(Status.PRIVILEGE_VIOLATION)
        if request.triad in self._class1:
            self._remove(request.triad)
        else:
            self._drop(lambda connection: connection.triad == request.triad)
        return bytes_of.close_reply(request.triad)

    def _remove(self, triad: Triad) -> None:
        number = self._class1[triad].number
        self._forget(triad)
        if self._cyclic is not None:
            with suppress(EnipError):  # the cyclic process has ended, so there is no connection
                self._cyclic.remove(number)

    def _forget(self, triad: Triad) -> None:
        """Remove a connection; if only listen-only connections remain, remove them as well."""
        del self._class1[triad], self._peers[triad], self._openers[triad]
        if len(self._class1) == self._count(ConnectionKind.LISTEN_ONLY):
            for alone in list(self._class1):
                del self._class1[alone], self._peers[alone], self._openers[alone]

    def _drop(self, which: Callable[[ExplicitConnection], bool]) -> None:
        for connection in [each for each in self._explicit.values() if which(each)]:
            del self._explicit[connection.connection_id], self._peers[connection.triad]

    def _count(self, kind: ConnectionKind) -> int:
        return Counter(each.kind for each in self._class1.values())[kind]

    def _facts(self) -> Facts:
        owners = [one.peer for one in self._class1.values() if one.is_owner]
        cyclic = self._cyclic is not None
        owner = owners[0] if owners else ""
        return Facts(self._size, self._identity, self._options.rpi_min_us, owner, cyclic)

    def _new_id(self) -> int:
        """Return an unused connection id other than 0."""
        taken = {0, *self._explicit}
        for each in self._class1.values():
            taken |= {each.o_to_t_id, each.t_to_o_id}
        while True:
            if (number := self._draw_id()) not in taken:
                return number
