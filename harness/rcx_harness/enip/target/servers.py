"""The TCP and UDP ports of a device, with the limits for connections.

On UDP there is one socket for our address and one for each broadcast address. The socket that
receives a datagram shows whether it was a broadcast. Several adapters on one machine must all
receive a broadcast, so these sockets share their address; the socket of our address is not shared.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable
from typing import cast

from rcx_harness.enip.target.admission import has_room
from rcx_harness.enip.target.device import Device, Session
from rcx_harness.enip.target.listing import Datagrams
from rcx_harness.enip.target.network_interface import ANY, address_toward

__all__ = [
    "MAX_CONNECTIONS",
    "MAX_CONNECTIONS_OF_PEER",
    "MAX_DELAYED",
    "MAX_DELAYED_OF_PEER",
    "TcpServer",
    "UdpServer",
]

MAX_CONNECTIONS, MAX_CONNECTIONS_OF_PEER = 64, 32
_NEWCOMERS = 1

#: Number of bytes that one connection may process before other connections are served. The bytes
#: are received in a permanent buffer, because asyncio's `Protocol` allocates and frees 256 KiB each
#: time.
_TURN = 1024


class TcpServer:
    """All TCP connections of one device."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.accepts = True
        self.connections: set[_Connection] = set()
        """The open TCP connections of the device."""

    def protocol(self) -> asyncio.BufferedProtocol:
        """Return the protocol object that asyncio needs for each new connection."""
        return _Connection(self)

    def has_room(self, peer: str) -> bool:
        """Return whether another connection from this address is allowed."""
        taken = (each.peer for each in self.connections)
        return self.accepts and has_room(taken, peer, MAX_CONNECTIONS, MAX_CONNECTIONS_OF_PEER)

    def make_room(self, peer: str) -> bool:
        """Close an idle connection if necessary; return whether the address may connect.

        A connection is closed only for an address with at most one connection. A master that has
        lost its connection without notice connects again from the same address.
        """
        if self.has_room(peer):
            return True
        own = sum(each.peer == peer for each in self.connections)
        if not self.accepts or own > _NEWCOMERS:
            return False
        ways = [(way, each) for each in self.connections if (way := each.session.gives_way())]
        if not ways:
            return False
        _, oldest = min(ways, key=lambda one: one[0])
        oldest.give_way()
        return True

    def close_overdue(self) -> None:
        """Close TCP connections that have been silent or slow for too long."""
        for connection in list(self.connections):
            if connection.session.is_overdue():
                connection.transport.abort()

    def close_all(self) -> None:
        """Close all connections once their answers have been sent."""
        for connection in list(self.connections):
            connection.transport.close()

    def abort_all(self) -> None:
        """Close all connections at once."""
        for connection in list(self.connections):
            connection.transport.abort()


class _Connection(asyncio.BufferedProtocol):
    """One scanner on the TCP port."""

    transport: asyncio.Transport
    session: Session
    peer: str

    def __init__(self, server: TcpServer) -> None:
        self._server = server
        self._admitted = False
        self._received = memoryview(bytearray(_TURN))

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start a session; asyncio has set TCP_NODELAY."""
        assert isinstance(transport, asyncio.Transport)
        self.transport = transport
        self.peer = transport.get_extra_info("peername")[0]
        if not self._server.make_room(self.peer):
            transport.abort()
            return
        device = self._server.device
        local_host, local_port = transport.get_extra_info("sockname")
        self.session = device.connect((local_host, local_port), self.peer)
        # The code point is in the upper six bits of the type of service.
        wire: socket.socket = transport.get_extra_info("socket")
        wire.setsockopt(socket.IPPROTO_IP, socket.IP_TOS, device.objects.explicit_dscp << 2)
        self._admitted = True
        self._server.connections.add(self)

    def get_buffer(self, sizehint: int) -> memoryview:
        """Return the buffer for the bytes of one read; asyncio reads further bytes later."""
        return self._received

    def buffer_updated(self, nbytes: int) -> None:
        """Answer all complete messages in the buffer."""
        if not self._admitted:
            return
        if answers := self.session.receive(self._received[:nbytes]):
            self.transport.write(answers)
        if self.session.ended:
            self.transport.close()

    def pause_writing(self) -> None:
        """Stop reading requests, because the client does not read our answers."""
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        """Resume reading, because the client has read our answers."""
        self.transport.resume_reading()

    def give_way(self) -> None:
        """Close this connection at once, to make room for a new connection and its session."""
        self.transport.abort()
        self._leave()

    def connection_lost(self, error: Exception | None) -> None:
        """End the session of a lost connection."""
        self._leave()

    def _leave(self) -> None:
        if self._admitted:
            self._admitted = False
            self._server.connections.discard(self)
            self.session.close()


MAX_DELAYED, MAX_DELAYED_OF_PEER = 64, 8


class UdpServer:
    """The UDP sockets of one device.

    Args:
        local: Host and port to bind to. With `ANY`, a broadcast looks like a request to this device
            alone, so each request is answered at once.
        broadcasts: Broadcast addresses to listen at; addresses that the system refuses are skipped.

    Attributes:
        answers: Whether the device answers at all.
        delayed: Addresses that wait for a delayed answer.
    """

    def __init__(
        self,
        datagrams: Datagrams,
        local: tuple[str, int],
        broadcasts: Iterable[str],
        dscp: int = 0,
    ) -> None:
        self.answers = True
        self.datagrams = datagrams
        self.local = local
        self.delayed: list[str] = []
        self._unicast = _bound(local, shared=False)
        self._unicast.setsockopt(socket.IPPROTO_IP, socket.IP_TOS, dscp << 2)
        self._broadcast = []
        # A socket that is bound to all addresses also receives broadcasts.
        for address in () if local[0] == ANY else broadcasts:
            try:
                self._broadcast.append(_bound((address, local[1]), shared=True))
            except OSError:
                continue  # some systems cannot bind to a broadcast address

    async def start(self) -> None:
        """Open the sockets and begin to answer datagrams."""
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _Endpoint(self, broadcast=False), sock=self._unicast
        )
        for each in self._broadcast:
            # Answers are sent from our own address, even if the request was sent to a broadcast
            # address.
            await loop.create_datagram_endpoint(
                lambda: _Endpoint(self, broadcast=True, reply=transport), sock=each
            )


class _Endpoint(asyncio.DatagramProtocol):
    def __init__(
        self,
        server: UdpServer,
        broadcast: bool,
        reply: asyncio.DatagramTransport | None = None,
    ) -> None:
        self._server = server
        self._broadcast = broadcast
        self._reply = reply

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._reply = self._reply or cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        server = self._server
        if not server.answers:
            return
        host, port = server.local
        local = address_toward(host, addr[0]), port
        answer = server.datagrams.answer(data, local, self._broadcast)
        if answer is None:
            return
        room = has_room(server.delayed, addr[0], MAX_DELAYED, MAX_DELAYED_OF_PEER)
        if answer.delay_s == 0 or not room:
            # If too many delayed answers are waiting, send this answer at once instead of dropping
            # it.
            self._send(answer.data, addr)
        else:
            server.delayed.append(addr[0])
            loop = asyncio.get_running_loop()
            loop.call_later(answer.delay_s, self._send_delayed, answer.data, addr)

    def _send_delayed(self, data: bytes, addr: tuple[str, int]) -> None:
        self._server.delayed.remove(addr[0])
        if self._server.answers:
            self._send(data, addr)

    def _send(self, data: bytes, addr: tuple[str, int]) -> None:
        assert self._reply is not None
        self._reply.sendto(data, addr)


def _bound(address: tuple[str, int], shared: bool) -> socket.socket:
    wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        if shared:
            wire.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        wire.setblocking(False)
        wire.bind(address)
    except BaseException:
        wire.close()
        raise
    return wire
