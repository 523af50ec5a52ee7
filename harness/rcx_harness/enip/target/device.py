"""One device, composed of objects, connections and sessions, without sockets.

A session is one TCP connection of a scanner, with encapsulation commands and their answers. Source:
EtherNet/IP adaptation of CIP (volume 2), chapter 2. A command that cannot be served is answered
with an error status. The TCP connection ends after UnRegisterSession, after a frame that is too
long or too slow, and after a long time without a frame.
"""

from __future__ import annotations

import struct
import time
from collections.abc import Callable

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
from rcx_harness.enip.cyclic.connections import OwnerState, multicast_address
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.cyclic.shared import Image
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.target.connection_manager import (
    ConnectionManager,
    Origin,
    random_id,
)
from rcx_harness.enip.target.listing import Listing
from rcx_harness.enip.target.network_interface import NetworkInterface
from rcx_harness.enip.target.objects import ObjectModel
from rcx_harness.enip.target.router import Router

__all__ = ["IDLE_S", "MAX_SESSIONS", "SLOW_S", "Device", "Session"]

SLOW_S = 10.0
"""Longest time between the first and the last byte of a frame, in seconds."""

IDLE_S = 10.0
"""Time without a request after which a session may be closed to make room for a new session [s]."""


#: Commands that need a registered session.
_OF_SESSION = (Command.UNREGISTER_SESSION, Command.SEND_RR_DATA, Command.SEND_UNIT_DATA)
#: Position of the length of the data within the bytes of a header.
_LENGTH = slice(2, 4)


class Session:
    """The encapsulation layer of one connection.

    Attributes:
        ended: The TCP connection must be closed as soon as all answers have been sent.
    """

    def __init__(self, device: Device, local: tuple[str, int], peer: str) -> None:
        self.ended = False
        self._device = device
        self._local = local
        self._peer = peer
        self._handle = 0
        self._has_asked = False
        self._received = bytearray()
        self._last_frame = self._started = device.clock()
        self._commands: dict[int, Callable[[Frame], Frame | None]] = {
            Command.NOP: lambda _: None,
            Command.REGISTER_SESSION: self._register,
            Command.UNREGISTER_SESSION: self._unregister,
            Command.SEND_RR_DATA: self._send_rr_data,
            Command.SEND_UNIT_DATA: self._send_unit_data,
        }

    def receive(self, data: bytes | memoryview) -> bytes:
        """Process received bytes and return all answers. The last frame may still be incomplete."""
        now = self._device.clock()
        if not self._received:
            self._started = now
        self._received += data
        answers = []
        while not self.ended and (frame := self._next()):
            self._started = self._last_frame = now
            # The protocol demands that requests with a status or with options are discarded
            # silently.
            if not frame.status and not frame.options and (answer := self._answer(frame)):
                answers.append(answer)
        return b"".join(answer.encode() for answer in answers)

    def is_overdue(self) -> bool:
        """Return whether the client has been silent for too long, or sends a frame too slowly."""
        now = self._device.clock()
        if self._received and now - self._started >= SLOW_S:
            return True
        limit = self._device.objects.inactivity_s
        return limit > 0 and now - self._last_frame >= limit

    def gives_way(self) -> tuple[bool, float] | None:
        """Return the rank of the session; a new session replaces the session with the lowest rank.

        A TCP connection without a session has a lower rank than a TCP connection with a session.
        Otherwise the longest silence has the lowest rank. None: the session must stay, because it
        has an open connection or its last request is recent.
        """
        if not self._handle:
            return False, self._last_frame
        if self._device.connections.is_used_by(self._handle):
            return None
        if self._has_asked and self._device.clock() - self._last_frame < IDLE_S:
            return None
        return True, self._last_frame

    def close(self) -> None:
        """End the session and its class 3 connections, whether we or the client closed it."""
        self.ended = True
        if self._handle:
            self._device.unregister(self._handle)
            self._handle = 0

    def _next(self) -> Frame | None:
        """Return the next complete frame, or None. An oversized frame ends the TCP connection."""
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
        ours = self._handle != 0 and frame.session == self._handle
        if frame.command in _OF_SESSION and not ours:
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        if command := self._commands.get(frame.command):
            return command(frame)
        listed = self._device.listing.answer(frame, self._local)
        return listed or frame.answer(status=EncapsulationStatus.INVALID_COMMAND)

    def _register(self, frame: Frame) -> Frame:
        if len(frame.data) != 4:
            return frame.answer(status=EncapsulationStatus.INVALID_LENGTH)
        ours = struct.pack("<HH", PROTOCOL_VERSION, 0)
        if frame.data != ours:
            return frame.answer(ours, EncapsulationStatus.UNSUPPORTED_VERSION)
        if self._handle:
            return frame.answer(status=EncapsulationStatus.INVALID_COMMAND)
        self._handle = self._device.register()
        if not self._handle:
            return frame.answer(ours, EncapsulationStatus.INSUFFICIENT_MEMORY)
        return frame.answer(ours, session=self._handle)

    def _unregister(self, _: Frame) -> None:
        self.ended = True

    def _send_rr_data(self, frame: Frame) -> Frame:
        self._has_asked = True
        found = unconnected_items(frame.data)
        if found is None or len(found[0]) < 2:
            return frame.answer(status=EncapsulationStatus.INCORRECT_DATA)
        origin = self._origin(dict(found[1]))
        return frame.answer(
            unconnected(self._device.router.answer(found[0], origin), *origin.items)
        )

    def _send_unit_data(self, frame: Frame) -> Frame | None:
        found = connected_items(frame.data)
        if found is None:
            return frame.answer(status=EncapsulationStatus.INCORRECT_DATA)
        connection = self._device.connections.explicit(found[0], self._handle)
        if connection is None:
            return None  # the connection has ended; its originator will notice
        reply = connection.answer(
            found[1],
            self._device.clock(),
            lambda message: self._device.router.answer(message, self._origin({})),
        )
        return None if reply is None else frame.answer(connected(connection.reply_id, reply))

    def _origin(self, addresses: dict[int, bytes]) -> Origin:
        return Origin(self._peer, self._local[0], self._handle, addresses)


MAX_SESSIONS = 64
"""The limit of sessions equals the limit of TCP connections (see `servers`), so each TCP connection
can have a session."""

# Identity object, status word: bit 0, and bits 4 to 7 (volume 1, chapter 5, 2.2.1.5)
_OWNED = 0x0001
_FAULTED, _NONE, _RUN, _IDLE = 0x0020, 0x0030, 0x0060, 0x0070


class Device:
    """One adapter with its objects, its connections and its sessions.

    Args:
        cyclic: The cyclic exchange; None for explicit messages only.
        owner_state: Function that returns the state of the owner's cyclic connection.
        draw_id: Returns 32 random bits for each connection id.
        on_refused: Called with a sentence for each refused Forward Open.

    Attributes:
        listing: The object that answers the commands that need no session.
        on_reset: Function that is called after a reset of the device, to close all TCP connections.
    """

    def __init__(
        self,
        to_master: Image,
        to_robot: Image,
        identity: Identity | None = None,
        options: AdapterOptions | None = None,
        cyclic: CyclicControl | None = None,
        owner_state: Callable[[], OwnerState] = lambda: OwnerState.NONE,
        interface: NetworkInterface | None = None,
        clock: Callable[[], float] = time.monotonic,
        draw_id: Callable[[], int] = random_id,
        on_refused: Callable[[str], None] = lambda text: None,
    ) -> None:
        identity = identity or Identity()
        options = options or AdapterOptions()
        interface = interface or NetworkInterface()
        group = multicast_address(interface.address, interface.netmask)
        self.clock = clock
        self.on_reset: Callable[[], None] = lambda: None
        self._owner_state = owner_state
        self._handles: set[int] = set()
        self._last_handle = 0
        self.connections = ConnectionManager(
            size=len(to_master.read()),
            identity=identity,
            options=options,
            cyclic=cyclic,
            clock=clock,
            draw_id=draw_id,
            on_refused=on_refused,
            group=group,
            dscp=lambda priority: self.objects.dscp(priority),
        )
        self.objects = ObjectModel(
            to_master,
            to_robot,
            identity,
            status=self._status_word,
            is_owned=lambda: self.connections.is_owned,
            interface=interface,
            group=group,
        )
        self.router = Router(self.objects, identity, self.connections, self._reset)
        self.listing = Listing(self.router, cyclic is not None)

    def connect(self, local: tuple[str, int], peer: str) -> Session:
        """Return the session layer of a new TCP connection."""
        return Session(self, local, peer)

    def register(self) -> int:
        """Return a new session handle; 0 if there are `MAX_SESSIONS`."""
        if len(self._handles) >= MAX_SESSIONS:
            return 0
        self._last_handle += 1
        self._handles.add(self._last_handle)
        return self._last_handle

    def unregister(self, handle: int) -> None:
        """End a session, and its class 3 connections."""
        self._handles.discard(handle)
        self.connections.session_ended(handle)

    def _reset(self) -> None:
        self.connections.close_all()
        self.on_reset()

    def _status_word(self) -> int:
        state = self._owner_state()
        if self.connections.is_owned:
            return _OWNED | (_RUN if state is OwnerState.RUN else _IDLE)
        if self.connections.cyclic_connections:
            return _IDLE
        return _FAULTED if state is OwnerState.TIMED_OUT else _NONE
