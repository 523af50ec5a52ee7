"""The EtherNet/IP encapsulation as bytes: header and common packet format, for both ends.

The numbers come from the EtherNet/IP adaptation of CIP (volume 2), chapter 2; the manual names
edition 1.15 (chapter 5, section 4). All numbers are little endian, except in socket addresses.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import NamedTuple

__all__ = [
    "HEADER_SIZE",
    "MAX_DATA",
    "PROTOCOL_VERSION",
    "Command",
    "EncapsulationStatus",
    "Frame",
    "Item",
    "connected",
    "connected_items",
    "decode_header",
    "decode_items",
    "decode_socket_address",
    "encode_items",
    "next_frame",
    "socket_address",
    "unconnected",
    "unconnected_items",
]

HEADER_SIZE = 24
PROTOCOL_VERSION = 1
MAX_DATA = 4096 + 64
"""Longest data of a frame that the adapter accepts: the longest message of a large connection."""

_HEADER = struct.Struct("<HHII8sI")
# The data starts with the interface handle (0: CIP) and a time-out that is not used on TCP.
_CIP_INTERFACE = 0
_INTERFACE = struct.Struct("<IH")


class Command(IntEnum):
    """Encapsulation commands."""

    NOP = 0x0000
    LIST_SERVICES = 0x0004
    LIST_IDENTITY = 0x0063
    LIST_INTERFACES = 0x0064
    REGISTER_SESSION = 0x0065
    UNREGISTER_SESSION = 0x0066
    SEND_RR_DATA = 0x006F
    SEND_UNIT_DATA = 0x0070


class EncapsulationStatus(IntEnum):
    """The status codes in the header of an encapsulated message."""

    SUCCESS = 0x00
    INVALID_COMMAND = 0x01
    INSUFFICIENT_MEMORY = 0x02
    INCORRECT_DATA = 0x03
    INVALID_SESSION = 0x64
    INVALID_LENGTH = 0x65
    UNSUPPORTED_VERSION = 0x69


class Item(IntEnum):
    """The type codes of the items in the common packet format."""

    NULL_ADDRESS = 0x0000
    IDENTITY = 0x000C
    CONNECTED_ADDRESS = 0x00A1
    CONNECTED_DATA = 0x00B1
    UNCONNECTED_DATA = 0x00B2
    SERVICES = 0x0100
    O_TO_T_ADDRESS = 0x8000
    T_TO_O_ADDRESS = 0x8001


class Frame(NamedTuple):
    """One encapsulated message. The answer to a message has the `context` of the message."""

    command: int
    session: int = 0
    status: int = 0
    context: bytes = bytes(8)
    options: int = 0
    data: bytes = b""

    def encode(self) -> bytes:
        """Encode the frame: its header and its data."""
        header = _HEADER.pack(
            self.command, len(self.data), self.session, self.status, self.context, self.options
        )
        return header + self.data

    def answer(
        self,
        data: bytes = b"",
        status: EncapsulationStatus = EncapsulationStatus.SUCCESS,
        session: int | None = None,
    ) -> Frame:
        """Return the answer to this frame; `session` replaces its session handle if given."""
        session = self.session if session is None else session
        return self._replace(session=session, status=int(status), data=data)


def decode_header(data: bytes | bytearray) -> tuple[Frame, int] | None:
    """Return the first frame without data, and the length of its data; None without a header."""
    if len(data) < HEADER_SIZE:
        return None
    command, length, session, status, context, options = _HEADER.unpack_from(data)
    return Frame(command, session, status, context, options), length


def next_frame(buffer: bytearray) -> Frame | None:
    """Remove the first frame from the buffer and return it; None if the frame is incomplete."""
    if len(buffer) < HEADER_SIZE:
        return None
    command, length, session, status, context, options = _HEADER.unpack_from(buffer)
    end = HEADER_SIZE + length
    if len(buffer) < end:
        return None
    frame = Frame(command, session, status, context, options, bytes(buffer[HEADER_SIZE:end]))
    del buffer[:end]
    return frame


def encode_items(*items: tuple[int, bytes]) -> bytes:
    """Encode a common packet: the number of items, then type, length and data of each item."""
    parts = [struct.pack("<H", len(items))]
    parts += [struct.pack("<HH", kind, len(data)) + data for kind, data in items]
    return b"".join(parts)


def decode_items(data: bytes) -> list[tuple[int, bytes]] | None:
    """Decode a common packet; return None if its lengths are inconsistent."""
    if len(data) < 2:
        return None
    items = []
    at = 2
    for _ in range(int.from_bytes(data[:2], "little")):
        if len(data) < at + 4:
            return None
        kind, length = struct.unpack_from("<HH", data, at)
        at += 4 + length
        if len(data) < at:
            return None
        items.append((kind, data[at - length : at]))
    return items if at == len(data) else None


def unconnected(message: bytes, *further: tuple[int, bytes]) -> bytes:
    """Return the data for a SendRRData command: an unconnected CIP message and further items."""
    items = encode_items((Item.NULL_ADDRESS, b""), (Item.UNCONNECTED_DATA, message), *further)
    return _INTERFACE.pack(_CIP_INTERFACE, 0) + items


def unconnected_items(data: bytes) -> tuple[bytes, list[tuple[int, bytes]]] | None:
    """Return the CIP message and further items in the data of SendRRData; None if it is invalid."""
    items = _cip_items(data)
    if items is None or len(items) < 2:
        return None
    (address, no_address), (kind, message) = items[:2]
    if address != Item.NULL_ADDRESS or no_address or kind != Item.UNCONNECTED_DATA:
        return None
    return message, items[2:]


def connected(connection_id: int, message: bytes) -> bytes:
    """Return the data for SendUnitData: a class 3 message that starts with its sequence count."""
    address = struct.pack("<I", connection_id)
    items = encode_items((Item.CONNECTED_ADDRESS, address), (Item.CONNECTED_DATA, message))
    return _INTERFACE.pack(_CIP_INTERFACE, 0) + items


def connected_items(data: bytes) -> tuple[int, bytes] | None:
    """Return connection id and message from the data of SendUnitData; None if it is invalid."""
    items = _cip_items(data)
    if items is None or len(items) < 2:
        return None
    (address, connection_id), (kind, message) = items[:2]
    if address != Item.CONNECTED_ADDRESS or len(connection_id) != 4 or kind != Item.CONNECTED_DATA:
        return None
    return int.from_bytes(connection_id, "little"), message


def socket_address(host: str, port: int) -> bytes:
    """Encode an IPv4 address and a port as the 16 bytes of a socket address item (big endian)."""
    return struct.pack(">HH4s8x", 2, port, bytes(int(part) for part in host.split(".")))


def decode_socket_address(data: bytes) -> tuple[str, int] | None:
    """Return host and port from a socket address item; None if it has no IPv4 address."""
    if len(data) != 16:
        return None
    family, port, host = struct.unpack(">HH4s8x", data)
    return (".".join(str(byte) for byte in host), port) if family == 2 else None


def _cip_items(data: bytes) -> list[tuple[int, bytes]] | None:
    if len(data) < _INTERFACE.size or _INTERFACE.unpack_from(data)[0] != _CIP_INTERFACE:
        return None
    return decode_items(data[_INTERFACE.size :])
