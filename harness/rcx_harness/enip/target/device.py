"""All that makes up one device, put together: objects, connections, sessions. No sockets."""

from __future__ import annotations

import time
from collections.abc import Callable

from rcx_harness.enip.cyclic.connections import OwnerState, multicast_address
from rcx_harness.enip.identity import Identity
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.target.connection_manager import ConnectionManager, CyclicPart
from rcx_harness.enip.target.listing import Listing
from rcx_harness.enip.target.network_interface import NetworkInterface
from rcx_harness.enip.target.objects import Image, ObjectModel
from rcx_harness.enip.target.router import Router
from rcx_harness.enip.target.session import Session

__all__ = ["MAX_SESSIONS", "Device"]

MAX_SESSIONS = 64
"""One for each connection there can be (`tcp_server`): who has a connection gets a session."""

# Identity object, status word: bit 0, and bits 4 to 7 (volume 1, chapter 5, 2.2.1.5)
_OWNED = 0x0001
_FAULTED, _NONE, _RUN, _IDLE = 0x0020, 0x0030, 0x0060, 0x0070


class Device:
    """One adapter: what it is, what is connected, and who speaks to it.

    Args:
        to_master: Assembly 100.
        to_robot: Assembly 150.
        identity: What the Identity object shows.
        options: Limits and manners.
        cyclic: The cyclic part, None for explicit messages only.
        owner_state: What the cyclic part says of the owner.
        interface: The network interface.
        clock: Seconds, monotonic.
        incarnation: Differs from start to start, 16 bits.

    Attributes:
        router: Answers CIP requests.
        connections: The Connection Manager.
        listing: Answers what needs no session.
        clock: As given.
        on_reset: Called after a reset of the device, to close all TCP connections.
    """

    def __init__(
        self,
        to_master: Image,
        to_robot: Image,
        identity: Identity | None = None,
        options: AdapterOptions | None = None,
        cyclic: CyclicPart | None = None,
        owner_state: Callable[[], OwnerState] = lambda: OwnerState.NONE,
        interface: NetworkInterface | None = None,
        clock: Callable[[], float] = time.monotonic,
        incarnation: int = 1,
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
            incarnation=incarnation,
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
            inactivity_s=options.inactivity_s,
        )
        self.router = Router(self.objects, identity, self.connections, self._reset)
        self.listing = Listing(self.router, cyclic is not None)

    @property
    def inactivity_s(self) -> int:
        """Seconds of silence before a TCP connection is closed; 0 for never."""
        return self.objects.inactivity_s

    def connect(self, local: tuple[str, int], peer: str) -> Session:
        """The session layer of a new TCP connection."""
        return Session(self, local, peer)

    def register(self) -> int:
        """A new session handle; 0 if there are `MAX_SESSIONS`."""
        if len(self._handles) >= MAX_SESSIONS:
            return 0
        self._last_handle += 1
        self._handles.add(self._last_handle)
        return self._last_handle

    def unregister(self, handle: int) -> None:
        """A session has ended; its class 3 connections end with it."""
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
