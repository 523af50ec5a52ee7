"""CIP requests, paths and replies as bytes, for both ends of the wire, and texts for their codes.

The numbers come from the Common Industrial Protocol, volume 1: general status codes in appendix B,
path segments in appendix C, the Connection Manager's extended status codes in chapter 3, 5.6. The
manual names edition 3.14 (chapter 5, section 4).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

__all__ = [
    "REVISIONS",
    "ClassId",
    "ConnectionService",
    "ElectronicKey",
    "ExtendedStatus",
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
    "encode_segment",
    "extended_text",
    "status_text",
]


class ExtendedStatus(IntEnum):
    """The extended status codes of general status 0x01, connection failure, with meanings."""

    meaning: str

    def __new__(cls, code: int, meaning: str = "") -> ExtendedStatus:
        """Create a member of the enumeration: `code` is its value, `meaning` its text."""
        member = int.__new__(cls, code)
        member._value_ = code
        member.meaning = meaning
        return member

    DUPLICATE_FORWARD_OPEN = 0x100, "this connection is already open"
    CLASS_AND_TRIGGER = 0x103, "transport class and trigger are not supported together"
    OWNERSHIP_CONFLICT = 0x106, "another master owns the outputs"
    CONNECTION_NOT_FOUND = 0x107, "there is no such connection"
    INVALID_CONNECTION_TYPE = 0x108, "the connection type or priority is not valid"
    INVALID_CONNECTION_SIZE = 0x109, "the connection size does not fit the assembly"
    RPI_NOT_SUPPORTED = 0x111, "the packet interval is not supported"
    RPI_NOT_ACCEPTABLE = 0x112, "the packet interval is not acceptable"
    OUT_OF_CONNECTIONS = 0x113, "no more connections are available"
    KEY_VENDOR_OR_PRODUCT = 0x114, "vendor or product code does not match the device"
    KEY_DEVICE_TYPE = 0x115, "the device type does not match the device"
    KEY_REVISION = 0x116, "the revision does not match the device"
    INVALID_APPLICATION_PATH = 0x117, "the produced or consumed path is not valid"
    INVALID_CONFIGURATION_PATH = 0x118, "the configuration path is not valid"
    ONLY_LISTENERS = 0x119, "a listen only connection needs another connection"
    INHIBIT_TIME_ABOVE_RPI = 0x11B, "the production inhibit time exceeds the interval"
    TRANSPORT_CLASS = 0x11C, "the transport class is not supported"
    PRODUCTION_TRIGGER = 0x11D, "the production trigger is not supported"
    DIRECTION = 0x11E, "the transport direction is not supported"
    O_TO_T_TYPE = 0x123, "the connection type to the device is not supported"
    T_TO_O_TYPE = 0x124, "the connection type from the device is not supported"
    REDUNDANT_OWNER = 0x125, "redundant owners are not supported"
    CONFIGURATION_SIZE = 0x126, "the configuration data has a wrong size"
    O_TO_T_SIZE = 0x127, "the size to the device does not fit the assembly"
    T_TO_O_SIZE = 0x128, "the size from the device does not fit the assembly"
    CONFIGURATION_PATH = 0x129, "there is no such configuration instance"
    CONSUMING_PATH = 0x12A, "there is no such consuming connection point"
    PRODUCING_PATH = 0x12B, "there is no such producing connection point"
    INCONSISTENT_PATHS = 0x12F, "the application paths do not belong together"
    NULL_FORWARD_OPEN = 0x132, "a null Forward Open is not supported"
    TIMEOUT_MULTIPLIER = 0x133, "the time-out multiplier is not acceptable"
    PARAMETER_ERROR = 0x205, "a parameter of the request is wrong"
    PORT_NOT_AVAILABLE = 0x311, "the route names a port that does not exist"
    LINK_ADDRESS_NOT_VALID = 0x312, "the route names a link address that does not exist"
    SEGMENT_IN_PATH = 0x315, "a segment of the connection path is not valid"
    CLOSE_PATH_MISMATCH = 0x316, "the path to close is not the one that was opened"


def extended_text(code: int) -> str:
    """Return the text that describes an extended status code of the Connection Manager."""
    try:
        return ExtendedStatus(code).meaning
    except ValueError:
        return "an extended status that this harness does not know"


class ClassId(IntEnum):
    """The classes of objects that this device has (CIP volumes 1 and 2, chapter 5)."""

    IDENTITY = 0x01
    MESSAGE_ROUTER = 0x02
    ASSEMBLY = 0x04
    CONNECTION_MANAGER = 0x06
    QOS = 0x48
    TCP_IP = 0xF5
    ETHERNET_LINK = 0xF6


REVISIONS = {
    ClassId.IDENTITY: 1,
    ClassId.MESSAGE_ROUTER: 1,
    ClassId.ASSEMBLY: 2,
    ClassId.CONNECTION_MANAGER: 1,
    ClassId.QOS: 1,
    ClassId.TCP_IP: 4,
    ClassId.ETHERNET_LINK: 4,
}
"""Maps each class of CIP objects to its revision in this device."""


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
    """The general status codes with which this device answers."""

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
    """The error for a rejected request; the reply carries the status codes of the error.

    Args:
        data: Data that follows the status in the reply, for services that report details.
    """

    def __init__(self, status: Status, extended: tuple[int, ...] = (), data: bytes = b"") -> None:
        self.status = status
        self.extended = extended
        self.data = data
        super().__init__(status_text(status))


@dataclass(frozen=True)
class ElectronicKey:
    """The identity of the device that the sender expects; a value of 0 matches any device.

    If `compatible` is set, a device that can replace a device of this revision also matches.
    """

    vendor: int
    device_type: int
    product_code: int
    major: int
    minor: int
    compatible: bool


@dataclass(frozen=True)
class Path:
    """The path of a request to an object; instance number 0 addresses the class itself."""

    class_id: int
    instance: int
    attribute: int | None
    key: ElectronicKey | None = None


class Request(NamedTuple):
    """A CIP request: the service, the path of the object, and the data."""

    service: int
    path: Path
    data: bytes


class Reply(NamedTuple):
    """The reply to a CIP request; `service` is the service code without the reply bit."""

    service: int
    status: int
    data: bytes
    extended: tuple[int, ...] = ()


_REPLY_BIT = 0x80
# For the Assembly object, the number of a connection point is the number of an instance.
_LOGICAL_SEGMENTS = {0x20: "class", 0x24: "instance", 0x2C: "instance", 0x30: "attribute"}
_SIXTEEN_BIT = 0x01
_KEY_SEGMENT, _KEY_FORMAT = 0x34, 0x04
_KEY = struct.Struct("<HHHBB")


def status_text(status: int) -> str:
    """Return the text that describes a general status code of CIP."""
    try:
        return Status(status).name.lower().replace("_", " ")
    except ValueError:
        return "a status that this harness does not know"


def encode_path(class_id: int, instance: int, attribute: int | None = None) -> bytes:
    """Encode a path as logical segments."""
    path = encode_segment(0x20, class_id) + encode_segment(0x24, instance)
    return path if attribute is None else path + encode_segment(0x30, attribute)


def encode_segment(kind: int, number: int) -> bytes:
    """Encode a logical segment, with 8 bits for a number up to 255, otherwise 16 bits (padded)."""
    if number <= 0xFF:
        return struct.pack("<BB", kind, number)
    return struct.pack("<BxH", kind | _SIXTEEN_BIT, number)


def encode_request(service: int, path: bytes, data: bytes = b"") -> bytes:
    """Encode a request: the service, the size of the path in words, the path, and the data."""
    return struct.pack("<BB", service, len(path) // 2) + path + data


def decode_request(message: bytes) -> Request:
    """Decode a request.

    The message has at least two bytes.

    Raises:
        Refusal: The path exceeds the message, or contains an unknown segment.
    """
    end = 2 + 2 * message[1]
    if len(message) < end:
        raise Refusal(Status.PATH_SEGMENT_ERROR)
    return Request(message[0], _decode_path(message[2:end]), message[end:])


def encode_reply(
    service: int, status: int, data: bytes = b"", extended: tuple[int, ...] = ()
) -> bytes:
    """Encode a reply: service with reply bit, general status, additional status words, and data."""
    head = struct.pack("<BBBB", service | _REPLY_BIT, 0, status, len(extended))
    return head + struct.pack(f"<{len(extended)}H", *extended) + data


def decode_reply(message: bytes) -> Reply | None:
    """Decode a CIP reply; return None if the message is not a CIP reply."""
    if len(message) < 4 or not message[0] & _REPLY_BIT or len(message) < 4 + 2 * message[3]:
        return None
    end = 4 + 2 * message[3]
    extended = struct.unpack(f"<{message[3]}H", message[4:end])
    return Reply(message[0] & ~_REPLY_BIT, message[2], message[end:], extended)


@lru_cache(maxsize=256)  # cached because a scanner sends the same few paths again and again
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
    """Decode an electronic key of format 4 from its eight bytes."""
    vendor, device_type, product_code, major, minor = _KEY.unpack(data)
    return ElectronicKey(vendor, device_type, product_code, major & 0x7F, minor, bool(major & 0x80))
