"""The EtherNet/IP encapsulation as bytes: header and common packet format, for both ends.

Numbers are those of the EtherNet/IP adaptation of CIP (volume 2), chapter 2; the manual names
edition 1.15 (chapter 5, section 4). Everything is little endian but the socket address.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, replace
from enum import IntEnum

__all__ = [
    "HEADER_SIZE",
    "PROTOCOL_VERSION",
    "Command",
    "EncapsulationStatus",
    "Frame",
    "Item",
    "decode_items",
    "encode_items",
    "next_frame",
    "socket_address",
    "unconnected",
    "unconnected_message",
]

HEADER_SIZE = 24
PROTOCOL_VERSION = 1

_HEADER = struct.Struct("<HHII8sI")
_NULL_ADDRESS, _UNCONNECTED_DATA = 0x0000, 0x00B2
# SendRRData starts with the interface handle (0: CIP) and a time-out that TCP does not use.
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


class EncapsulationStatus(IntEnum):
    """Status codes of the encapsulation header."""

    SUCCESS = 0x00
    INVALID_COMMAND = 0x01
    INCORRECT_DATA = 0x03
    INVALID_SESSION = 0x64
    INVALID_LENGTH = 0x65
    UNSUPPORTED_VERSION = 0x69


class Item(IntEnum):
    """Items of the common packet format in the answers of ListIdentity and ListServices."""

    IDENTITY = 0x000C
    SERVICES = 0x0100


@dataclass(frozen=True)
class Frame:
    """One encapsulated message; `context` comes back unchanged in the answer."""

    command: int
    session: int = 0
    status: int = 0
    context: bytes = bytes(8)
    options: int = 0
    data: bytes = b""

    def encode(self) -> bytes:
        """Header and data."""
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
        """The frame that answers this one; a new session handle only if given."""
        session = self.session if session is None else session
        return replace(self, session=session, status=int(status), data=data)


def next_frame(buffer: bytearray) -> Frame | None:
    """Take the first whole frame out of what has been received; None while it is not complete."""
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
    """Common packet format: the number of items, then type, length and data of each."""
    parts = [struct.pack("<H", len(items))]
    parts += [struct.pack("<HH", kind, len(data)) + data for kind, data in items]
    return b"".join(parts)


def decode_items(data: bytes) -> list[tuple[int, bytes]] | None:
    """Take a common packet apart; None if its lengths do not fit together."""
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


def unconnected(message: bytes) -> bytes:
    """Data of a SendRRData that carries an unconnected CIP message."""
    items = encode_items((_NULL_ADDRESS, b""), (_UNCONNECTED_DATA, message))
    return _INTERFACE.pack(_CIP_INTERFACE, 0) + items


def unconnected_message(data: bytes) -> bytes | None:
    """The CIP message in the data of a SendRRData; None if there is none in it.

    Further items, the socket addresses that some scanners add, are allowed and passed over.
    """
    if len(data) < _INTERFACE.size or _INTERFACE.unpack_from(data)[0] != _CIP_INTERFACE:
        return None
    items = decode_items(data[_INTERFACE.size :])
    if items is None or len(items) < 2:
        return None
    (address, no_address), (kind, message) = items[:2]
    if address != _NULL_ADDRESS or no_address or kind != _UNCONNECTED_DATA:
        return None
    return message


def socket_address(host: str, port: int) -> bytes:
    """An IPv4 address as the protocol carries it: 16 bytes, big endian."""
    return struct.pack(">HH4s8x", 2, port, bytes(int(part) for part in host.split(".")))
