"""Class 1 connections of a device without sockets: connections, packets, and results.

Times are in microseconds. Connections have 48 bytes in each direction, 10 ms, and the multiplier 2
(16 intervals: 160 ms).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from rcx_harness.enip.cyclic.connections import (
    ConnectionKind,
    ConnectionParameters,
    EndReason,
    OwnerState,
)
from rcx_harness.enip.cyclic.exchange import Exchange, Role
from rcx_harness.enip.cyclic.shared import SharedImages

MASTER, ROBOT, OTHER = "192.168.0.7", "192.168.0.2", "192.168.0.8"
GROUP = "239.192.1.32"

OWNER = ConnectionParameters(
    number=1,
    kind=ConnectionKind.EXCLUSIVE_OWNER,
    o_to_t_id=0x11111111,
    t_to_o_id=0x22222222,
    o_to_t_api_us=10_000,
    t_to_o_api_us=10_000,
    o_to_t_size=48,
    t_to_o_size=48,
    multiplier=2,
    peer=MASTER,
    destination=MASTER,
)
INPUT_ONLY = replace(
    OWNER,
    number=2,
    kind=ConnectionKind.INPUT_ONLY,
    o_to_t_id=0x33333333,
    t_to_o_id=0x44444444,
    o_to_t_size=0,
    run_idle=False,
    peer=OTHER,
    destination=OTHER,
)
LISTEN_ONLY = replace(
    INPUT_ONLY,
    number=3,
    kind=ConnectionKind.LISTEN_ONLY,
    o_to_t_id=0x55555555,
    t_to_o_id=0x66666666,
)

IMAGE = bytes(range(1, 49))
DATA = IMAGE.hex()


def packet(number: int, count: int, identifier: str = "11111111", run: int = 1) -> bytes:
    """Return a packet of the master with IMAGE: 54 (0x36) bytes of connected data."""
    return bytes.fromhex(
        f"0200 0280 0800 {identifier} {number.to_bytes(4, 'little').hex()}"
        f"B100 3600 {count.to_bytes(2, 'little').hex()} {run:02X}000000 {DATA}"
    )


def heartbeat(number: int, identifier: str) -> bytes:
    """Return a packet that contains only a sequence count."""
    return bytes.fromhex(
        f"0200 0280 0800 {identifier} {number.to_bytes(4, 'little').hex()} B100 0200 0000"
    )


def multicast(one: ConnectionParameters, api_us: int = 10_000) -> ConnectionParameters:
    """Return the same connection with a multicast production."""
    return replace(
        one, t_to_o_id=0x0A0A0A0A, t_to_o_api_us=api_us, multicast=True, destination=GROUP
    )


@dataclass
class Device:
    """An exchange with its packets (packet, address, code point) and connection ends."""

    images: SharedImages
    role: Role = Role.TARGET
    sent: list[tuple[bytes, tuple[str, int], int]] = field(default_factory=list)
    ended: list[tuple[int, EndReason]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.exchange = Exchange(self.images, lambda *end: self.ended.append(end), self.role)

    def poll(self, now_us: int) -> int | None:
        """Send packets that are due, and end connections that have timed out."""
        return self.exchange.poll(now_us, lambda *one: self.sent.append(one))

    def destinations(self) -> list[str]:
        """Return the hosts to which packets were sent since the last call."""
        hosts = [address[0] for _, address, _ in self.sent]
        self.sent.clear()
        return hosts

    def owner(self) -> OwnerState:
        """Return the state of the owner's connection."""
        return self.images.status().owner
