"""Forward Open and Forward Close as bytes, for both ends: requests, connection path and replies.

Layout: CIP volume 1, chapter 3, 5.5.2 (Forward Open, Large Forward Open) and 5.5.3 (Forward Close).
Sizes are the connection sizes on the wire; intervals are in microseconds. Appendix C defines the
segments of a path: logical (0x20, 0x24, 0x2C, 8 or 16 bits wide), electronic key (0x34), network
(0x43, 0x50: production inhibit time) and simple data (0x80).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

from rcx_harness.enip.codec.cip import (
    ClassId,
    ConnectionService,
    ElectronicKey,
    ExtendedStatus,
    Refusal,
    Request,
    Status,
    decode_key,
    encode_path,
    encode_request,
    encode_segment,
)
from structured_text.output.units import format_us

__all__ = [
    "ConnectionPath",
    "ConnectionType",
    "ForwardClose",
    "ForwardOpen",
    "NetworkParameters",
    "OpenReply",
    "OpenRequest",
    "PathRefusal",
    "Triad",
    "close_reply",
    "decode_connection_path",
    "decode_forward_close",
    "decode_forward_open",
    "decode_open_reply",
    "open_reply",
    "refusal_data",
]

_CLASS, _INSTANCE, _CONNECTION_POINT = 0x20, 0x24, 0x2C
_SIXTEEN_BIT = 0x01
_KEY, _KEY_FORMAT, _KEY_END = 0x34, 0x04, 10
_INHIBIT_MS, _INHIBIT_US, _INHIBIT_US_WORDS = 0x43, 0x50, 2
_DATA = 0x80


class PathRefusal(Refusal):
    """The error for a connection path with an invalid segment (extended status 0x315).

    Args:
        remaining: Number of words of the path from the invalid segment to the end.
    """

    def __init__(self, remaining: int) -> None:
        super().__init__(Status.CONNECTION_FAILURE, (ExtendedStatus.SEGMENT_IN_PATH,))
        self.remaining = remaining


@dataclass(frozen=True)
class ConnectionPath:
    """A decoded connection path: electronic key, class, numbers and production inhibit time.

    Attributes:
        key: The device that the originator expects.
        class_id: Class of all application paths.
        numbers: Instances and connection points. Two numbers are consuming and producing; three are
            configuration, consuming and producing. An explicit connection has one instance.
        inhibit_us: Production inhibit time in microseconds; 0 if the path has none.
    """

    key: ElectronicKey | None
    class_id: int
    numbers: tuple[int, ...]
    configuration: bytes = b""
    inhibit_us: int = 0

    def application(self) -> tuple[int, tuple[int, ...]]:
        """Return the class and the numbers, which together identify the application."""
        return self.class_id, self.numbers


def decode_connection_path(path: bytes) -> ConnectionPath:
    """Decode a connection path.

    The path is padded: it has an even number of bytes.

    Raises:
        PathRefusal: a segment is unknown, misplaced or incomplete, or the path has no class.
        Refusal: the application paths name several classes.
    """
    key: ElectronicKey | None = None
    class_id: int | None = None
    numbers: list[int] = []
    configuration = b""
    inhibit_us = 0
    at = 0
    while at < len(path):
        kind, length = path[at] & ~_SIXTEEN_BIT, _length(path, at)
        body = path[at + 2 : at + length]
        if path[at] == _KEY and at == 0:
            key = decode_key(body)
        elif kind == _CLASS:
            number = _number(path, at)
            if class_id not in (None, number):
                raise Refusal(Status.CONNECTION_FAILURE, (ExtendedStatus.INCONSISTENT_PATHS,))
            class_id = number
        elif kind in (_INSTANCE, _CONNECTION_POINT) and class_id is not None:
            numbers.append(_number(path, at))
        elif path[at] == _INHIBIT_MS:
            inhibit_us = 1000 * path[at + 1]
        elif path[at] == _INHIBIT_US:
            inhibit_us = int.from_bytes(body, "little")
        elif path[at] == _DATA:
            configuration = body
        else:
            raise _refused(path, at)
        at += length
    if class_id is None:
        raise _refused(path, len(path))
    return ConnectionPath(key, class_id, tuple(numbers), configuration, inhibit_us)


def _length(path: bytes, at: int) -> int:
    """Return the length of the segment at byte `at`; raise PathRefusal if it is cut off."""
    segment, second = path[at], path[at + 1]
    if segment & ~_SIXTEEN_BIT in (_CLASS, _INSTANCE, _CONNECTION_POINT):
        length = 4 if segment & _SIXTEEN_BIT else 2
    elif segment == _KEY and second == _KEY_FORMAT:
        length = _KEY_END
    elif segment == _INHIBIT_MS:
        length = 2
    elif segment == _DATA or (segment == _INHIBIT_US and second == _INHIBIT_US_WORDS):
        length = 2 + 2 * second
    else:
        raise _refused(path, at)
    if at + length > len(path):
        raise _refused(path, at)
    return length


def _number(path: bytes, at: int) -> int:
    if path[at] & _SIXTEEN_BIT:
        return int.from_bytes(path[at + 2 : at + 4], "little")
    return path[at + 1]


def _refused(path: bytes, at: int) -> PathRefusal:
    return PathRefusal((len(path) - at) // 2)


# Fields of a Forward Open: priority and ticks, O->T id (not used), T->O id, triad, multiplier,
# interval and parameters of each direction, transport, path size.
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
    """The connection type, two bits of the network connection parameters."""

    NULL = 0
    MULTICAST = 1
    POINT_TO_POINT = 2
    RESERVED = 3


@dataclass(frozen=True)
class Triad:
    """The identity of a connection: its serial number, and vendor and number of the originator."""

    serial: int
    vendor: int
    originator: int

    def encode(self) -> bytes:
        """Return the triad as eight bytes."""
        return _TRIAD.pack(self.serial, self.vendor, self.originator)


@dataclass(frozen=True)
class NetworkParameters:
    """The network connection parameters for one direction of a connection."""

    kind: ConnectionType
    size: int
    priority: int
    variable: bool
    redundant: bool


@dataclass(frozen=True)
class ForwardOpen:
    """A request to open a connection, without its O->T connection id, which the target chooses."""

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
    """Decode a Forward Open or a Large Forward Open.

    Raises:
        Refusal: 0x13 if the request is too short, 0x15 if it is too long.
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
    """Decode a Forward Close.

    Raises:
        Refusal: 0x13 if the request is too short, 0x15 if it is too long.
    """
    if len(request.data) < _CLOSE.size:
        raise Refusal(Status.NOT_ENOUGH_DATA)
    *triad, words = _CLOSE.unpack_from(request.data)
    return ForwardClose(Triad(*triad), _path(request.data, _CLOSE.size, words))


def open_reply(
    o_to_t_id: int, t_to_o_id: int, triad: Triad, o_to_t_api: int, t_to_o_api: int
) -> bytes:
    """Return the data of a successful Forward Open reply, without an application reply."""
    ids = struct.pack("<II", o_to_t_id, t_to_o_id)
    return ids + triad.encode() + struct.pack("<IIBx", o_to_t_api, t_to_o_api, 0)


def close_reply(triad: Triad) -> bytes:
    """Return the data of a successful Forward Close reply, without an application reply."""
    return triad.encode() + bytes(2)


def refusal_data(request: Request, remaining: int = 0) -> bytes:
    """Return the data of the reply that refuses a request: its triad, and the `remaining` words.

    `request` is a Forward Open or Forward Close of any length. `remaining` counts the words of the
    connection path from the invalid segment to the end.

    Returns:
        Ten bytes; no bytes if the request is too short to contain its triad.
    """
    at = _TRIAD_AT[ConnectionService(request.service)]
    triad = request.data[at : at + _TRIAD.size]
    return triad + struct.pack("<Bx", remaining) if len(triad) == _TRIAD.size else b""


def _network_parameters(value: int, large: bool) -> NetworkParameters:
    """Decode connection parameters: redundant owner, type, priority, variable flag and size."""
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


_CONNECTION_MANAGER = encode_path(ClassId.CONNECTION_MANAGER, 1)
# Time limit of the request on its route: a byte with priority and tick (1.024 s), then 14 ticks.
_PATIENCE = struct.pack("<BB", 0x0A, 0x0E)
_CLASS_1_CYCLIC = 0x01
_SCHEDULED = 2
_REPLY = struct.Struct("<IIHHIII")
_SHORTEST_API_US, _LONGEST_API_US = 500, 10_000_000


@dataclass(frozen=True)
class OpenRequest:
    """The class 1 connection that a scanner requests.

    Attributes:
        triad: Serial number, vendor and originator, which together name the connection.
        t_to_o_id: Connection id of the packets from the adapter, which the scanner chooses.
        o_to_t_length: Connection size to the adapter, as on the wire.
        t_to_o_length: Connection size from the adapter, as on the wire.
        consuming: Connection point of the adapter that receives our data, or our heartbeat.
        producing: Connection point of the adapter that sends data to us.
        configuration: Configuration instance in the path; None: the path names no instance.
        configuration_data: Data for the configuration instance, an even number of bytes.
        large: Whether to send a Large Forward Open instead of a Forward Open.
    """

    triad: Triad
    t_to_o_id: int
    rpi_us: int
    o_to_t_length: int
    t_to_o_length: int
    multiplier: int
    consuming: int
    producing: int
    configuration: int | None = None
    configuration_data: bytes = b""
    large: bool = False

    def path(self) -> bytes:
        """Return the connection path: configuration, consuming and producing point, and data."""
        path = encode_segment(_CLASS, ClassId.ASSEMBLY)
        if self.configuration is not None:
            path += encode_segment(_INSTANCE, self.configuration)
        path += encode_segment(_CONNECTION_POINT, self.consuming)
        path += encode_segment(_CONNECTION_POINT, self.producing)
        if data := self.configuration_data:
            path += struct.pack("<BB", _DATA, len(data) // 2) + data
        return path

    def forward_open(self) -> bytes:
        """Return the complete CIP request to open the connection."""
        data = _PATIENCE + struct.pack("<II", 0, self.t_to_o_id)
        data += self.triad.encode() + struct.pack("<B3x", self.multiplier)
        rpi = struct.pack("<I", self.rpi_us)
        data += rpi + self._parameters(self.o_to_t_length)
        data += rpi + self._parameters(self.t_to_o_length)
        path = self.path()
        data += struct.pack("<BB", _CLASS_1_CYCLIC, len(path) // 2) + path
        service = (
            ConnectionService.LARGE_FORWARD_OPEN if self.large else ConnectionService.FORWARD_OPEN
        )
        return encode_request(service, _CONNECTION_MANAGER, data)

    def forward_close(self) -> bytes:
        """Return the complete CIP request to close the connection."""
        path = self.path()
        data = _PATIENCE + self.triad.encode() + struct.pack("<Bx", len(path) // 2) + path
        return encode_request(ConnectionService.FORWARD_CLOSE, _CONNECTION_MANAGER, data)

    def problem(self, agreed: OpenReply) -> str:
        """Describe the invalid value in a successful reply; empty if all values are valid.

        A device may set another interval than requested, but not 0 us or an hour.
        """
        if agreed.triad != self.triad:
            return "names another connection than requested"
        longest_us = max(_LONGEST_API_US, self.rpi_us)
        for api_us, way in ((agreed.o_to_t_api_us, "to"), (agreed.t_to_o_api_us, "from")):
            if not _SHORTEST_API_US <= api_us <= longest_us:
                every, asked = format_us(api_us), format_us(self.rpi_us)
                return f"sets a packet {way} it every {every} instead of every {asked}"
        return ""

    def _parameters(self, length: int) -> bytes:
        """Encode a connection size with its flags: point to point, fixed length, not redundant."""
        flags = ConnectionType.POINT_TO_POINT << 13 | _SCHEDULED << 10
        return (
            struct.pack("<I", flags << 16 | length)
            if self.large
            else struct.pack("<H", flags | length)
        )


@dataclass(frozen=True)
class OpenReply:
    """The reply of the adapter: connection ids, triad, and the actual packet intervals."""

    o_to_t_id: int
    t_to_o_id: int
    o_to_t_api_us: int
    t_to_o_api_us: int
    triad: Triad


def decode_open_reply(data: bytes) -> OpenReply | None:
    """Decode the data of a successful Forward Open reply; return None if the data is too short."""
    if len(data) < _REPLY.size:
        return None
    o_to_t_id, t_to_o_id, *triad, o_to_t_api_us, t_to_o_api_us = _REPLY.unpack_from(data)
    return OpenReply(o_to_t_id, t_to_o_id, o_to_t_api_us, t_to_o_api_us, Triad(*triad))
