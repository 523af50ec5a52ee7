"""The parameters of a class 1 connection after its Forward Open was accepted.

The adapter decodes and checks the Forward Open. It then sends the `ConnectionParameters` to the
process that produces and consumes (`cyclic.process`). A scanner describes its end in the same way.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, IntEnum
from typing import Any, NamedTuple

__all__ = [
    "FIRST_PACKET_US",
    "IO_PORT",
    "LONGEST_TIMEOUT_US",
    "RUN_IDLE_SIZE",
    "SEQUENCE_SIZE",
    "ConnectionKind",
    "ConnectionParameters",
    "EndReason",
    "OwnerState",
    "Way",
    "multicast_address",
]

IO_PORT = 2222
"""UDP port of class 0 and class 1 packets."""

FIRST_PACKET_US = 10_000_000
"""Shortest time limit of the first packet of a connection: 10 s (CIP volume 1, chapter 3)."""

LONGEST_TIMEOUT_US = 0xFFFFFFFF * 512
"""The longest possible time-out: the greatest interval times the greatest multiplier."""

RUN_IDLE_SIZE, SEQUENCE_SIZE = 4, 2
"""Bytes of the run/idle header and of the sequence count before the data of a packet."""

_MULTICAST_BASE = int(ipaddress.IPv4Address("239.192.1.0"))
_MULTICAST_HOSTS, _MULTICAST_BLOCK = 0x3FF, 5


class ConnectionKind(str, Enum):
    """Application types of a connection to the adapter's assemblies."""

    EXCLUSIVE_OWNER = "exclusive owner"
    INPUT_ONLY = "input only"
    LISTEN_ONLY = "listen only"


class OwnerState(IntEnum):
    """The state of the owner, which is the connection that owns the outputs (assembly 150)."""

    NONE = 0
    """No connection has owned the outputs yet."""
    WAITING = 1
    """The connection is open, but no packet of the master has come yet."""
    RUN = 2
    """Packets of the master come, and the master's program runs."""
    IDLE = 3
    """Packets of the master come, but its program is stopped, so the data is ignored."""
    TIMED_OUT = 4
    """The master has stopped sending, so the connection has timed out."""
    CLOSED = 5
    """The master has closed the connection (Forward Close)."""


class EndReason(str, Enum):
    """The reasons for which the cyclic process itself ends a connection."""

    TIMED_OUT = "timed out"
    """No packet came for the connection's time-out."""
    NO_OWNER = "no owner"
    """The last connection that is not listen-only has ended, which ends this listen-only
    connection."""
    OFF = "off"
    """The adapter has been switched off (`LinkState.OFF`)."""


class Way(NamedTuple):
    """The packets in one direction of a connection: their id, interval and size."""

    identifier: int
    api_us: int
    size: int
    run_idle: bool


@dataclass(frozen=True)
class ConnectionParameters:
    """The agreed parameters of a class 1 connection; target and originator use the same values.

    Args:
        number: Number that both processes use for the connection; it is never reused.
        o_to_t_id: Connection id in the packets from the originator to the target.
        t_to_o_id: Connection id in the packets from the target to the originator. Multicast
            connections with the same id share one production.
        o_to_t_api_us: Actual packet interval from the originator, in microseconds.
        t_to_o_api_us: Actual packet interval from the target, in microseconds.
        o_to_t_size: Bytes of application data from the originator (without sequence count and
            run/idle header); 0 for a heartbeat.
        t_to_o_size: Bytes of application data from the target (without sequence count).
        multiplier: Connection time-out multiplier as coded, 0 to 7 (4 to 512 intervals).
        peer: IPv4 address of the other end; packets from other addresses are dropped. The UDP port
            of the peer is not checked.
        destination: IPv4 address to send our packets to: the peer's or, at the target of a
            multicast connection, the group.
        destination_port: UDP port to send our packets to.
        run_idle: Whether the originator's packets carry the 32-bit run/idle header.
        multicast: Whether the target's packets go to a multicast group.
        dscp: Differentiated services code point of our packets, 0 to 63.
        first_packet_us: Upper limit of the wait for the first packet, at least `FIRST_PACKET_US`,
            for connections with a longer time-out.
    """

    number: int
    kind: ConnectionKind
    o_to_t_id: int
    t_to_o_id: int
    o_to_t_api_us: int
    t_to_o_api_us: int
    o_to_t_size: int
    t_to_o_size: int
    multiplier: int
    peer: str
    destination: str
    destination_port: int = IO_PORT
    run_idle: bool = True
    multicast: bool = False
    dscp: int = 0
    first_packet_us: int = LONGEST_TIMEOUT_US

    @property
    def is_owner(self) -> bool:
        """Return whether the connection owns the outputs."""
        return self.kind is ConnectionKind.EXCLUSIVE_OWNER

    @property
    def o_to_t(self) -> Way:
        """Return the direction from the originator to the target."""
        return Way(self.o_to_t_id, self.o_to_t_api_us, self.o_to_t_size, self.run_idle)

    @property
    def t_to_o(self) -> Way:
        """Return the direction from the target to the originator."""
        return Way(self.t_to_o_id, self.t_to_o_api_us, self.t_to_o_size, False)

    def timeout_us(self, way: Way) -> int:
        """Return the time without a packet after which the connection times out [us]."""
        return way.api_us * (4 << self.multiplier)

    @classmethod
    def from_message(cls, message: Mapping[str, Any]) -> ConnectionParameters:
        """Create the parameters from the JSON form of their `asdict`."""
        return cls(**{**message, "kind": ConnectionKind(message["kind"])})


def multicast_address(host: str, netmask: str = "255.255.255.0") -> str:
    """Return the multicast address of an adapter: the first address of its block of 32 addresses.

    Source: EtherNet/IP adaptation of CIP (volume 2), chapter 3, 5.3, allocation by host number.
    """
    number = int(ipaddress.IPv4Address(host)) & ~int(ipaddress.IPv4Address(netmask)) & 0xFFFFFFFF
    index = (number - 1) & _MULTICAST_HOSTS
    return str(ipaddress.IPv4Address(_MULTICAST_BASE + (index << _MULTICAST_BLOCK)))
