"""One TCP connection of a scanner: encapsulation commands in, answers out, no sockets.

Which command is answered how is chapter 2 of the EtherNet/IP adaptation of CIP (volume 2). A
command that cannot be served gets a status; UnRegisterSession ends the connection, and so does a
sender that says too much at once, too slowly, or nothing for too long.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Protocol

from rcx_harness.enip.codec.encapsulation import (
    HEADER_SIZE,
    MAX_DATA,
    PROTOCOL_VERSION,
    Command,
    EncapsulationStatus,
    Frame,
    connected,
    connected_items,
    decode_header,
    next_frame,
    unconnected,
    unconnected_items,
)
from rcx_harness.enip.target.connection_manager import ConnectionManager
from rcx_harness.enip.target.listing import Listing
from rcx_harness.enip.target.origin import Origin
from rcx_harness.enip.target.router import Router

__all__ = ["SLOW_S", "Session", "SessionHost"]

SLOW_S = 10.0
"""Longest time for one frame to arrive whole, in seconds."""


#: Where a header says how much data follow.
_LENGTH = slice(2, 4)


class SessionHost(Protocol):
    """What the sessions of one device share."""

    router: Router
    connections: ConnectionManager
    listing: Listing
    clock: Callable[[], float]

    @property
    def inactivity_s(self) -> int:
        """Seconds of silence before a connection is closed; 0 for never."""
        ...

    def register(self) -> int:
        """A session handle that no other connection has; 0 if there is no room for one more."""
        ...

    def unregister(self, handle: int) -> None:
        """Its session has ended."""
        ...


class Session:
    """The encapsulation layer of one connection.

    Args:
        host: The device.
        local: Host and port of our end, as ListIdentity shows them.
        peer: IPv4 address of the other end.

    Attributes:
        ended: The connection is to be closed, once all answers have gone.
    """

    def __init__(self, host: SessionHost, local: tuple[str, int], peer: str) -> None:
        self.ended = False
        self._host = host
        self._local = local
        self._peer = peer
        self._handle = 0
        self._received = bytearray()
        self._last_frame = self._started = host.clock()
        self._commands: dict[int, Callable[[Frame], Frame | None]] = {
            Command.NOP: lambda _: None,
            Command.REGISTER_SESSION: self._register,
            Command.UNREGISTER_SESSION: self._unregister,
            Command.SEND_RR_DATA: self._send_rr_data,
            Command.SEND_UNIT_DATA: self._send_unit_data,
        }

    def receive(self, data: bytes | memoryview) -> bytes:
        """Take bytes as they come off the wire, whole frames or not; return all answers."""
        now = self._host.clock()
        if not self._received:
            self._started = now
        self._received += data
        answers = []
        while not self.ended and (frame := self._next()):
            self._started = self._last_frame = now
            # The protocol has requests with a status or with options discarded without a word.
            if not frame.status and not frame.options and (answer := self._answer(frame)):
                answers.append(answer)
        return b"".join(answer.encode() for answer in answers)

    def is_overdue(self) -> bool:
        """Nothing has come for too long, or a frame is too long on its way."""
        now = self._host.clock()
        if self._received and now - self._started >= SLOW_S:
            return True
        limit = self._host.inactivity_s
        return limit > 0 and now - self._last_frame >= limit

    def close(self) -> None:
        """The connection is gone, whoever closed it; its class 3 connections go with it."""
        self.ended = True
        if self._handle:
            self._host.unregister(self._handle)
            self._handle = 0

    def _next(self) -> Frame | None:
        """The next whole frame; an oversized one ends the connection before its data has come."""
        if len(self._received) < HEADER_SIZE:
            return None
        if int.from_bytes(self._received[_LENGTH], "little") > MAX_DATA:
            header = decode_header(self._received)
            self.ended = True
            self._received.clear()
            return header[0] if header else None
        return next_frame(self._received)

    def _answer(self, frame: Frame) -> Frame | None:
        if self.ended:
            return frame.answer(status=EncapsulationStatus.INVALID_LENGTH)
        if command := self._commands.get(frame.command):
            return command(frame)
        listed = self._host.listing.answer(frame, self._local)
        return listed or frame.answer(status=EncapsulationStatus.INVALID_COMMAND)

    def _register(self, frame: Frame) -> Frame:
        if len(frame.data) != 4:
            return frame.answer(status=EncapsulationStatus.INVALID_LENGTH)
        ours = struct.pack("<HH", PROTOCOL_VERSION, 0)
        if frame.data != ours:
            return frame.answer(ours, EncapsulationStatus.UNSUPPORTED_VERSION)
        if self._handle:
            return frame.answer(status=EncapsulationStatus.INVALID_COMMAND)
        self._handle = self._host.register()
        if not self._handle:
            return frame.answer(ours, EncapsulationStatus.INSUFFICIENT_MEMORY)
        return frame.answer(ours, session=self._handle)

    def _unregister(self, frame: Frame) -> Frame | None:
        if not self._is_ours(frame):
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        self.ended = True
        return None

    def _send_rr_data(self, frame: Frame) -> Frame:
        if not self._is_ours(frame):
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        found = unconnected_items(frame.data)
        if found is None or len(found[0]) < 2:
            return frame.answer(status=EncapsulationStatus.INCORRECT_DATA)
        origin = self._origin(dict(found[1]))
        return frame.answer(unconnected(self._host.router.answer(found[0], origin), *origin.items))

    def _send_unit_data(self, frame: Frame) -> Frame | None:
        if not self._is_ours(frame):
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        found = connected_items(frame.data)
        if found is None:
            return frame.answer(status=EncapsulationStatus.INCORRECT_DATA)
        connection = self._host.connections.explicit(found[0], self._handle)
        if connection is None:
            return None  # a connection that has ended meanwhile; its originator will notice
        reply = connection.answer(
            found[1],
            self._host.clock(),
            lambda message: self._host.router.answer(message, self._origin({})),
        )
        return None if reply is None else frame.answer(connected(connection.reply_id, reply))

    def _origin(self, addresses: dict[int, bytes]) -> Origin:
        return Origin(self._peer, self._local[0], self._handle, addresses)

    def _is_ours(self, frame: Frame) -> bool:
        return self._handle != 0 and frame.session == self._handle
