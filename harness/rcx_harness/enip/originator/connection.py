"""Forward Open and Forward Close as a scanner sends them, and the reply as it reads it.

Layout: CIP volume 1, chapter 3, 5.5.2 and 5.5.3.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from rcx_harness.enip.codec.cip import ConnectionService, encode_request

__all__ = ["OpenReply", "OpenRequest", "decode_open_reply"]

_CONNECTION_MANAGER = bytes.fromhex("2006 2401")
# Priority and time of a tick, ticks: how long a bridge may take, 14 x 1.024 s.
_PATIENCE = struct.pack("<BB", 0x0A, 0x0E)
_CLASS_1_CYCLIC = 0x01
_POINT_TO_POINT, _MULTICAST = 2, 1
_SCHEDULED = 2
_DATA = 0x80  # simple data segment
_REPLY = struct.Struct("<IIHHIII")


@dataclass(frozen=True)
class OpenRequest:
    """A class 1 connection as a scanner asks for it.

    Attributes:
        serial: Connection serial number; with the next two it names the connection.
        vendor: The scanner's vendor.
        originator: The scanner's serial number.
        t_to_o_id: The id we choose; unused with multicast.
        rpi_us: Requested packet interval of both directions, in microseconds.
        o_to_t_length: Connection size to the adapter, on the wire.
        t_to_o_length: Connection size from the adapter, on the wire.
        multiplier: Connection time-out multiplier as coded, 0 to 7.
        multicast: The adapter is to send to a multicast group.
        consuming: The adapter's connection point to send to, or the one of the heartbeat.
        producing: The adapter's connection point to receive from.
        configuration: Configuration instance, if one is to be named.
        configuration_data: Data for it, an even number of bytes.
        large: Ask by Large Forward Open.
    """

    serial: int
    vendor: int
    originator: int
    t_to_o_id: int
    rpi_us: int
    o_to_t_length: int
    t_to_o_length: int
    multiplier: int
    multicast: bool
    consuming: int
    producing: int
    configuration: int | None = None
    configuration_data: bytes = b""
    large: bool = False

    def path(self) -> bytes:
        """The application path: configuration, consuming and producing connection point, data."""
        path = bytes.fromhex("2004")
        if self.configuration is not None:
            path += _segment(0x24, self.configuration)
        path += _segment(0x2C, self.consuming) + _segment(0x2C, self.producing)
        if data := self.configuration_data:
            path += struct.pack("<BB", _DATA, len(data) // 2) + data
        return path

    def forward_open(self) -> bytes:
        """The whole CIP request."""
        t_to_o_kind = _MULTICAST if self.multicast else _POINT_TO_POINT
        data = _PATIENCE + struct.pack("<II", 0, 0 if self.multicast else self.t_to_o_id)
        data += self._triad() + struct.pack("<B3x", self.multiplier)
        data += struct.pack("<I", self.rpi_us) + self._parameters(
            _POINT_TO_POINT, self.o_to_t_length
        )
        data += struct.pack("<I", self.rpi_us) + self._parameters(t_to_o_kind, self.t_to_o_length)
        path = self.path()
        data += struct.pack("<BB", _CLASS_1_CYCLIC, len(path) // 2) + path
        service = (
            ConnectionService.LARGE_FORWARD_OPEN if self.large else ConnectionService.FORWARD_OPEN
        )
        return encode_request(service, _CONNECTION_MANAGER, data)

    def forward_close(self) -> bytes:
        """The whole CIP request."""
        path = self.path()
        data = _PATIENCE + self._triad() + struct.pack("<Bx", len(path) // 2) + path
        return encode_request(ConnectionService.FORWARD_CLOSE, _CONNECTION_MANAGER, data)

    def _triad(self) -> bytes:
        return struct.pack("<HHI", self.serial, self.vendor, self.originator)

    def _parameters(self, kind: int, length: int) -> bytes:
        """Type, priority and size; of fixed length, not redundant."""
        flags = kind << 13 | _SCHEDULED << 10
        return (
            struct.pack("<I", flags << 16 | length)
            if self.large
            else struct.pack("<H", flags | length)
        )


@dataclass(frozen=True)
class OpenReply:
    """What the adapter has agreed to: the ids, and the actual packet intervals."""

    o_to_t_id: int
    t_to_o_id: int
    o_to_t_api_us: int
    t_to_o_api_us: int


def decode_open_reply(data: bytes) -> OpenReply | None:
    """The data of a reply that says success; None if it is too short."""
    if len(data) < _REPLY.size:
        return None
    o_to_t_id, t_to_o_id, _, _, _, o_to_t_api_us, t_to_o_api_us = _REPLY.unpack_from(data)
    return OpenReply(o_to_t_id, t_to_o_id, o_to_t_api_us, t_to_o_api_us)


def _segment(kind: int, number: int) -> bytes:
    """A logical segment, 8 bit wide where the number allows it, else 16 bit (padded)."""
    if number <= 0xFF:
        return struct.pack("<BB", kind, number)
    return struct.pack("<BxH", kind | 1, number)
