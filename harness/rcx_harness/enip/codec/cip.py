"""CIP messages as bytes: request, path and reply, for both ends of the wire.

Numbers are those of the Common Industrial Protocol, volume 1: general status codes in appendix B,
path segments in appendix C. The manual names edition 3.14 (chapter 5, section 4).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

from rcx_harness.enip.codec.connection_status import extended_text

__all__ = [
    "ConnectionService",
    "ElectronicKey",
    "Path",
    "Refusal",
    "Reply",
    "Request",
    "Service",
    "Status",
    "decode_key",
    "decode_reply",
    "decode_request",
    "encode_path",
    "encode_reply",
    "encode_request",
    "extended_text",
    "status_text",
]


class Service(IntEnum):
    """The services that every object shares."""

    GET_ATTRIBUTES_ALL = 0x01
    GET_ATTRIBUTE_LIST = 0x03
    RESET = 0x05
    GET_ATTRIBUTE_SINGLE = 0x0E
    SET_ATTRIBUTE_SINGLE = 0x10


class ConnectionService(IntEnum):
    """The services of the Connection Manager (CIP volume 1, chapter 3, 5.5)."""

    FORWARD_CLOSE = 0x4E
    UNCONNECTED_SEND = 0x52
    FORWARD_OPEN = 0x54
    LARGE_FORWARD_OPEN = 0x5B


class Status(IntEnum):
    """The general status codes this device answers."""

    SUCCESS = 0x00
    CONNECTION_FAILURE = 0x01
    PATH_SEGMENT_ERROR = 0x04
    PATH_DESTINATION_UNKNOWN = 0x05
    SERVICE_NOT_SUPPORTED = 0x08
    INVALID_ATTRIBUTE_VALUE = 0x09
    ATTRIBUTE_LIST_ERROR = 0x0A
    OBJECT_STATE_CONFLICT = 0x0C
    ATTRIBUTE_NOT_SETTABLE = 0x0E
    PRIVILEGE_VIOLATION = 0x0F
    DEVICE_STATE_CONFLICT = 0x10
    REPLY_DATA_TOO_LARGE = 0x11
    NOT_ENOUGH_DATA = 0x13
    ATTRIBUTE_NOT_SUPPORTED = 0x14
    TOO_MUCH_DATA = 0x15
    INVALID_PARAMETER = 0x20
    KEY_FAILURE_IN_PATH = 0x25


class Refusal(Exception):  # noqa: N818 (a refusal is an answer, not a failure)
    """A request that ends in an error reply.

    Args:
        status: General status.
        extended: Additional status, 16-bit words.
        data: What follows the status, for the services that say more.
    """

    def __init__(self, status: Status, extended: tuple[int, ...] = (), data: bytes = b"") -> None:
        self.status = status
        self.extended = extended
        self.data = data
        super().__init__(status_text(status))


@dataclass(frozen=True)
class ElectronicKey:
    """Which device the sender means; 0 stands for any.

    `compatible` asks for a device that can take the place of this revision.
    """

    vendor: int
    device_type: int
    product_code: int
    major: int
    minor: int
    compatible: bool


@dataclass(frozen=True)
class Path:
    """Where a request goes; instance 0 is the class itself."""

    class_id: int
    instance: int
    attribute: int | None
    key: ElectronicKey | None = None


class Request(NamedTuple):
    """A service for one object, with its data."""

    service: int
    path: Path
    data: bytes


class Reply(NamedTuple):
    """The answer to `service` (without the reply bit), with its additional status words."""

    service: int
    status: int
    data: bytes
    extended: tuple[int, ...] = ()


_REPLY_BIT = 0x80
# A connection point of the Assembly object is the same as its instance.
_LOGICAL_SEGMENTS = {0x20: "class", 0x24: "instance", 0x2C: "instance", 0x30: "attribute"}
_SIXTEEN_BIT = 0x01
_KEY_SEGMENT, _KEY_FORMAT = 0x34, 0x04
_KEY = struct.Struct("<HHHBB")


def status_text(status: int) -> str:
    """A general status code in words."""
    try:
        return Status(status).name.lower().replace("_", " ")
    except ValueError:
        return "a status this harness does not know"


def encode_path(class_id: int, instance: int, attribute: int | None = None) -> bytes:
    """Path of logical segments, 8 bit wide where the number allows it, else 16 bit (padded)."""
    numbers = [(0x20, class_id), (0x24, instance)]
    if attribute is not None:
        numbers.append((0x30, attribute))
    return b"".join(
        struct.pack("<BB", segment, number)
        if number <= 0xFF
        else struct.pack("<BxH", segment | _SIXTEEN_BIT, number)
        for segment, number in numbers
    )


def encode_request(service: int, path: bytes, data: bytes = b"") -> bytes:
    """Service, path with its size in words, data."""
    return struct.pack("<BB", service, len(path) // 2) + path + data


def decode_request(message: bytes) -> Request:
    """Take a request apart.

    Args:
        message: At least two bytes.

    Raises:
        Refusal: the path runs over the end, or holds a segment not understood here.
    """
    end = 2 + 2 * message[1]
    if len(message) < end:
        raise Refusal(Status.PATH_SEGMENT_ERROR)
    return Request(message[0], _decode_path(message[2:end]), message[end:])


def encode_reply(
    service: int, status: int, data: bytes = b"", extended: tuple[int, ...] = ()
) -> bytes:
    """Reply: service with the reply bit, general status, additional status words, data."""
    head = struct.pack("<BBBB", service | _REPLY_BIT, 0, status, len(extended))
    return head + struct.pack(f"<{len(extended)}H", *extended) + data


def decode_reply(message: bytes) -> Reply | None:
    """Take a reply apart; None if it is none."""
    if len(message) < 4 or not message[0] & _REPLY_BIT or len(message) < 4 + 2 * message[3]:
        return None
    end = 4 + 2 * message[3]
    extended = struct.unpack(f"<{message[3]}H", message[4:end])
    return Reply(message[0] & ~_REPLY_BIT, message[2], message[end:], extended)


@lru_cache(maxsize=256)  # a scanner sends the same few paths in every scan
def _decode_path(path: bytes) -> Path:
    numbers: dict[str, int] = {}
    key = None
    at = 0
    while at < len(path):
        segment, narrow = path[at], path[at + 1]
        if segment == _KEY_SEGMENT and narrow == _KEY_FORMAT and at == 0 and len(path) >= 10:
            key = decode_key(path[2:10])
            at += 10
            continue
        kind = _LOGICAL_SEGMENTS.get(segment & ~_SIXTEEN_BIT)
        if kind is None or kind in numbers:
            raise Refusal(Status.PATH_SEGMENT_ERROR)
        if segment & _SIXTEEN_BIT:
            if len(path) < at + 4:
                raise Refusal(Status.PATH_SEGMENT_ERROR)
            numbers[kind] = int.from_bytes(path[at + 2 : at + 4], "little")
            at += 4
        else:
            numbers[kind] = narrow
            at += 2
    if "class" not in numbers:
        raise Refusal(Status.PATH_DESTINATION_UNKNOWN)
    return Path(numbers["class"], numbers.get("instance", 0), numbers.get("attribute"), key)


def decode_key(data: bytes) -> ElectronicKey:
    """The eight bytes of an electronic key of format 4."""
    vendor, device_type, product_code, major, minor = _KEY.unpack(data)
    return ElectronicKey(vendor, device_type, product_code, major & 0x7F, minor, bool(major & 0x80))
