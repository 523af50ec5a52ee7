"""Forward Open and Forward Close as bytes: requests in, replies out.

Layout: CIP volume 1, chapter 3, 5.5.2 (Forward Open, Large Forward Open) and 5.5.3 (Forward
Close). Sizes are the connection sizes on the wire, intervals microseconds.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

from rcx_harness.enip.codec.cip import ConnectionService, Refusal, Request, Status

__all__ = [
    "ConnectionType",
    "ForwardClose",
    "ForwardOpen",
    "NetworkParameters",
    "Triad",
    "close_reply",
    "decode_forward_close",
    "decode_forward_open",
    "open_reply",
    "refusal_data",
]

# Priority and ticks, O->T id (not used), T->O id, triad, multiplier, interval and parameters each
# way, transport, path size
_OPEN = struct.Struct("<6xIHHIB3xIHIHBB")
_LARGE_OPEN = struct.Struct("<6xIHHIB3xIIIIBB")
_CLOSE = struct.Struct("<2xHHIBx")
_TRIAD = struct.Struct("<HHI")
_TRIAD_AT = {
    ConnectionService.FORWARD_OPEN: 10,
    ConnectionService.LARGE_FORWARD_OPEN: 10,
    ConnectionService.FORWARD_CLOSE: 2,
}


class ConnectionType(IntEnum):
    """Two bits of the network connection parameters."""

    NULL = 0
    MULTICAST = 1
    POINT_TO_POINT = 2
    RESERVED = 3


@dataclass(frozen=True)
class Triad:
    """What names a connection everywhere: its serial number, and its originator."""

    serial: int
    vendor: int
    originator: int

    def encode(self) -> bytes:
        """Eight bytes."""
        return _TRIAD.pack(self.serial, self.vendor, self.originator)


@dataclass(frozen=True)
class NetworkParameters:
    """One direction of a connection."""

    kind: ConnectionType
    size: int
    priority: int
    variable: bool
    redundant: bool


@dataclass(frozen=True)
class ForwardOpen:
    """A request to open a connection. Its O->T connection id is left out: the target chooses it."""

    t_to_o_id: int
    triad: Triad
    multiplier: int
    o_to_t_rpi: int
    o_to_t: NetworkParameters
    t_to_o_rpi: int
    t_to_o: NetworkParameters
    transport_class: int
    trigger: int
    server: bool
    path: bytes


@dataclass(frozen=True)
class ForwardClose:
    """A request to close a connection."""

    triad: Triad
    path: bytes


def decode_forward_open(request: Request) -> ForwardOpen:
    """Take a Forward Open or a Large Forward Open apart.

    Raises:
        Refusal: 0x13 too short, 0x15 too long.
    """
    large = request.service == ConnectionService.LARGE_FORWARD_OPEN
    layout = _LARGE_OPEN if large else _OPEN
    if len(request.data) < layout.size:
        raise Refusal(Status.NOT_ENOUGH_DATA)
    values = layout.unpack_from(request.data)
    transport = values[9]
    return ForwardOpen(
        t_to_o_id=values[0],
        triad=Triad(*values[1:4]),
        multiplier=values[4],
        o_to_t_rpi=values[5],
        o_to_t=_network_parameters(values[6], large),
        t_to_o_rpi=values[7],
        t_to_o=_network_parameters(values[8], large),
        transport_class=transport & 0x0F,
        trigger=transport >> 4 & 0x07,
        server=bool(transport & 0x80),
        path=_path(request.data, layout.size, values[10]),
    )


def decode_forward_close(request: Request) -> ForwardClose:
    """Take a Forward Close apart.

    Raises:
        Refusal: 0x13 too short, 0x15 too long.
    """
    if len(request.data) < _CLOSE.size:
        raise Refusal(Status.NOT_ENOUGH_DATA)
    *triad, words = _CLOSE.unpack_from(request.data)
    return ForwardClose(Triad(*triad), _path(request.data, _CLOSE.size, words))


def open_reply(
    o_to_t_id: int, t_to_o_id: int, triad: Triad, o_to_t_api: int, t_to_o_api: int
) -> bytes:
    """Data of the reply to a Forward Open that succeeded; without an application reply."""
    ids = struct.pack("<II", o_to_t_id, t_to_o_id)
    return ids + triad.encode() + struct.pack("<IIBx", o_to_t_api, t_to_o_api, 0)


def close_reply(triad: Triad) -> bytes:
    """Data of the reply to a Forward Close that succeeded; without an application reply."""
    return triad.encode() + bytes(2)


def refusal_data(request: Request, remaining: int = 0) -> bytes:
    """Data of a refusal: the triad as it was sent, and words of the path that were left.

    Args:
        request: A Forward Open or Forward Close, of any length.
        remaining: Words of the connection path from the offending segment to the end.

    Returns:
        Ten bytes; none if the request ends before its triad does.
    """
    at = _TRIAD_AT[ConnectionService(request.service)]
    triad = request.data[at : at + _TRIAD.size]
    return triad + struct.pack("<Bx", remaining) if len(triad) == _TRIAD.size else b""


def _network_parameters(value: int, large: bool) -> NetworkParameters:
    """Redundant owner, type (2 bits), reserved, priority (2 bits), variable, size."""
    flags = value >> 16 if large else value
    return NetworkParameters(
        kind=ConnectionType(flags >> 13 & 3),
        size=value & (0xFFFF if large else 0x01FF),
        priority=flags >> 10 & 3,
        variable=bool(flags & 0x0200),
        redundant=bool(flags & 0x8000),
    )


def _path(data: bytes, start: int, words: int) -> bytes:
    path = data[start:]
    if len(path) < 2 * words:
        raise Refusal(Status.NOT_ENOUGH_DATA)
    if len(path) > 2 * words:
        raise Refusal(Status.TOO_MUCH_DATA)
    return path
