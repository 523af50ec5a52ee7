"""The TCP port: who may connect, and each connection's bytes to and from its session."""

from __future__ import annotations

import asyncio
import socket

from rcx_harness.enip.target.device import Device
from rcx_harness.enip.target.session import Session
from rcx_harness.enip.target.shares import has_room

__all__ = ["MAX_CONNECTIONS", "MAX_CONNECTIONS_OF_PEER", "TcpServer"]

MAX_CONNECTIONS, MAX_CONNECTIONS_OF_PEER = 64, 32

#: So many bytes of one connection are answered before the others have their turn. They are
#: received into memory that stays: asyncio's `Protocol` takes and gives back 256 KiB each time.
_TURN = 1024


class TcpServer:
    """All TCP connections of one device.

    Args:
        device: Answers them.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self.accepts = True
        self._connections: set[_Connection] = set()

    def protocol(self) -> asyncio.BufferedProtocol:
        """What asyncio asks for with each new connection."""
        return _Connection(self)

    def has_room(self, peer: str) -> bool:
        """May one more connection come from this address?"""
        taken = (each.peer for each in self._connections)
        return self.accepts and has_room(taken, peer, MAX_CONNECTIONS, MAX_CONNECTIONS_OF_PEER)

    def add(self, connection: _Connection) -> None:
        """A connection has come."""
        self._connections.add(connection)

    def discard(self, connection: _Connection) -> None:
        """It has gone."""
        self._connections.discard(connection)

    def close_overdue(self) -> None:
        """Close what has been silent, or slow, for too long."""
        for connection in list(self._connections):
            if connection.session.is_overdue():
                connection.transport.abort()

    def close_all(self) -> None:
        """Close all connections once their answers have gone."""
        for connection in list(self._connections):
            connection.transport.close()

    def abort_all(self) -> None:
        """Close all connections at once."""
        for connection in list(self._connections):
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
        if not self._server.has_room(self.peer):
            transport.abort()
            return
        device = self._server.device
        local_host, local_port = transport.get_extra_info("sockname")
        self.session = device.connect((local_host, local_port), self.peer)
        # The code point is in the upper six bits of the type of service.
        wire: socket.socket = transport.get_extra_info("socket")
        wire.setsockopt(socket.IPPROTO_IP, socket.IP_TOS, device.objects.explicit_dscp << 2)
        self._admitted = True
        self._server.add(self)

    def get_buffer(self, sizehint: int) -> memoryview:
        """Where the next bytes are received: a turn's, what is more waits for the next turn."""
        return self._received

    def buffer_updated(self, nbytes: int) -> None:
        """Answer what is complete."""
        if not self._admitted:
            return
        if answers := self.session.receive(self._received[:nbytes]):
            self.transport.write(answers)
        if self.session.ended:
            self.transport.close()

    def pause_writing(self) -> None:
        """It does not take our answers: take no more of its requests."""
        self.transport.pause_reading()

    def resume_writing(self) -> None:
        """It has taken them."""
        self.transport.resume_reading()

    def connection_lost(self, error: Exception | None) -> None:
        """The connection is gone; its session with it."""
        if self._admitted:
            self._server.discard(self)
            self.session.close()
