"""The UDP port of the encapsulation: one socket for our address, one for each broadcast address.

The socket that a datagram comes to tells whether it was a broadcast. Several adapters on one
machine must all hear a broadcast, so those sockets share their address; our own is ours alone.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Iterable
from typing import cast

from rcx_harness.enip.target.network_interface import ANY, address_toward
from rcx_harness.enip.target.shares import has_room
from rcx_harness.enip.target.udp import Datagrams

__all__ = ["MAX_DELAYED", "MAX_DELAYED_OF_PEER", "UdpServer"]

MAX_DELAYED, MAX_DELAYED_OF_PEER = 64, 8


class UdpServer:
    """The UDP sockets of one device.

    Args:
        datagrams: Answers them.
        local: Host and port; the socket is bound to it. With `ANY` a broadcast cannot be told from
            a question to us alone, and is answered at once.
        broadcasts: Broadcast addresses to listen at; those the machine does not allow are left.
        dscp: Code point of the answers.

    Attributes:
        answers: Does the device answer at all?
        delayed: Who waits for an answer that comes after a delay.

    Raises:
        OSError: the port is taken.
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
        # A socket of all addresses hears broadcasts, too.
        for address in () if local[0] == ANY else broadcasts:
            try:
                self._broadcast.append(_bound((address, local[1]), shared=True))
            except OSError:
                continue  # not every system has addresses of that kind to bind to

    async def start(self) -> None:
        """Begin to answer."""
        loop = asyncio.get_running_loop()
        transport, _ = await loop.create_datagram_endpoint(
            lambda: _Endpoint(self, broadcast=False), sock=self._unicast
        )
        for each in self._broadcast:
            # Answers come from our own address, whichever the question came to.
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
            # Whoever has asked too often waits no more; nobody's question is dropped for it.
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
