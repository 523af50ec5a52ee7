"""CIP messages as bytes: request, path and reply, for both ends of the wire; codes in words.

Numbers are those of the Common Industrial Protocol, volume 1: general status codes in appendix B,
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
    "older",
    "status_text",
]


class ExtendedStatus(IntEnum):
    """The extended status codes that belong to general status 0x01, connection failure."""

    DUPLICATE_FORWARD_OPEN = 0x100
    CLASS_AND_TRIGGER = 0x103
    OWNERSHIP_CONFLICT = 0x106
    CONNECTION_NOT_FOUND = 0x107
    INVALID_CONNECTION_TYPE = 0x108
    INVALID_CONNECTION_SIZE = 0x109
    RPI_NOT_SUPPORTED = 0x111
    RPI_NOT_ACCEPTABLE = 0x112
    OUT_OF_CONNECTIONS = 0x113
    KEY_VENDOR_OR_PRODUCT = 0x114
    KEY_DEVICE_TYPE = 0x115
    KEY_REVISION = 0x116
    INVALID_APPLICATION_PATH = 0x117
    INVALID_CONFIGURATION_PATH = 0x118
    ONLY_LISTENERS = 0x119
    INHIBIT_TIME_ABOVE_RPI = 0x11B
    TRANSPORT_CLASS = 0x11C
    PRODUCTION_TRIGGER = 0x11D
    DIRECTION = 0x11E
    O_TO_T_TYPE = 0x123
    T_TO_O_TYPE = 0x124
    REDUNDANT_OWNER = 0x125
    CONFIGURATION_SIZE = 0x126
    O_TO_T_SIZE = 0x127
    T_TO_O_SIZE = 0x128
    CONFIGURATION_PATH = 0x129
    CONSUMING_PATH = 0x12A
    PRODUCING_PATH = 0x12B
    INCONSISTENT_PATHS = 0x12F
    NULL_FORWARD_OPEN = 0x132
    TIMEOUT_MULTIPLIER = 0x133
    PARAMETER_ERROR = 0x205
    PORT_NOT_AVAILABLE = 0x311
    LINK_ADDRESS_NOT_VALID = 0x312
    SEGMENT_IN_PATH = 0x315
    CLOSE_PATH_MISMATCH = 0x316


_TEXTS = {
    ExtendedStatus.DUPLICATE_FORWARD_OPEN: "this connection is already open",
    ExtendedStatus.CLASS_AND_TRIGGER: "transport class and trigger are not supported together",
    ExtendedStatus.OWNERSHIP_CONFLICT: "another master owns the outputs",
    ExtendedStatus.CONNECTION_NOT_FOUND: "there is no such connection",
    ExtendedStatus.INVALID_CONNECTION_TYPE: "the connection type or priority is not valid",
    ExtendedStatus.INVALID_CONNECTION_SIZE: "the connection size does not fit the assembly",
    ExtendedStatus.RPI_NOT_SUPPORTED: "the packet interval is not supported",
    ExtendedStatus.RPI_NOT_ACCEPTABLE: "the packet interval is not acceptable",
    ExtendedStatus.OUT_OF_CONNECTIONS: "no more connections are available",
    ExtendedStatus.KEY_VENDOR_OR_PRODUCT: "vendor or product code do not match the device",
    ExtendedStatus.KEY_DEVICE_TYPE: "the device type does not match the device",
    ExtendedStatus.KEY_REVISION: "the revision does not match the device",
    ExtendedStatus.INVALID_APPLICATION_PATH: "the produced or consumed path is not valid",
    ExtendedStatus.INVALID_CONFIGURATION_PATH: "the configuration path is not valid",
    ExtendedStatus.ONLY_LISTENERS: "listen only needs a connection that is more than that",
    ExtendedStatus.INHIBIT_TIME_ABOVE_RPI: "the production inhibit time exceeds the interval",
    ExtendedStatus.TRANSPORT_CLASS: "the transport class is not supported",
    ExtendedStatus.PRODUCTION_TRIGGER: "the production trigger is not supported",
    ExtendedStatus.DIRECTION: "the transport direction is not supported",
    ExtendedStatus.O_TO_T_TYPE: "the connection type to the device is not supported",
    ExtendedStatus.T_TO_O_TYPE: "the connection type from the device is not supported",
    ExtendedStatus.REDUNDANT_OWNER: "redundant owners are not supported",
    ExtendedStatus.CONFIGURATION_SIZE: "the configuration data has a wrong size",
    ExtendedStatus.O_TO_T_SIZE: "the size to the device does not fit the assembly",
    ExtendedStatus.T_TO_O_SIZE: "the size from the device does not fit the assembly",
    ExtendedStatus.CONFIGURATION_PATH: "there is no such configuration instance",
    ExtendedStatus.CONSUMING_PATH: "there is no such consuming connection point",
    ExtendedStatus.PRODUCING_PATH: "there is no such producing connection point",
    ExtendedStatus.INCONSISTENT_PATHS: "the application paths do not belong together",
    ExtendedStatus.NULL_FORWARD_OPEN: "a null Forward Open is not supported",
    ExtendedStatus.TIMEOUT_MULTIPLIER: "the time-out multiplier is not acceptable",
    ExtendedStatus.PARAMETER_ERROR: "a parameter of the request is wrong",
    ExtendedStatus.PORT_NOT_AVAILABLE: "the route names a port that there is not",
    ExtendedStatus.LINK_ADDRESS_NOT_VALID: "the route names a link address that there is not",
    ExtendedStatus.SEGMENT_IN_PATH: "a segment of the connection path is not valid",
    ExtendedStatus.CLOSE_PATH_MISMATCH: "the path to close is not the one that was opened",
}

# What a device of an earlier edition answers, which knew fewer codes.
_OLDER = {
    ExtendedStatus.TRANSPORT_CLASS: ExtendedStatus.CLASS_AND_TRIGGER,
    ExtendedStatus.PRODUCTION_TRIGGER: ExtendedStatus.CLASS_AND_TRIGGER,
    ExtendedStatus.DIRECTION: ExtendedStatus.CLASS_AND_TRIGGER,
    ExtendedStatus.O_TO_T_TYPE: ExtendedStatus.INVALID_CONNECTION_TYPE,
    ExtendedStatus.T_TO_O_TYPE: ExtendedStatus.INVALID_CONNECTION_TYPE,
    ExtendedStatus.REDUNDANT_OWNER: ExtendedStatus.INVALID_CONNECTION_TYPE,
    ExtendedStatus.RPI_NOT_ACCEPTABLE: ExtendedStatus.RPI_NOT_SUPPORTED,
    ExtendedStatus.O_TO_T_SIZE: ExtendedStatus.INVALID_CONNECTION_SIZE,
    ExtendedStatus.T_TO_O_SIZE: ExtendedStatus.INVALID_CONNECTION_SIZE,
    ExtendedStatus.CONFIGURATION_SIZE: ExtendedStatus.INVALID_CONFIGURATION_PATH,
    ExtendedStatus.CONFIGURATION_PATH: ExtendedStatus.INVALID_CONFIGURATION_PATH,
    ExtendedStatus.CONSUMING_PATH: ExtendedStatus.INVALID_APPLICATION_PATH,
    ExtendedStatus.PRODUCING_PATH: ExtendedStatus.INVALID_APPLICATION_PATH,
    ExtendedStatus.INCONSISTENT_PATHS: ExtendedStatus.INVALID_APPLICATION_PATH,
}


def extended_text(code: int) -> str:
    """An extended status code of the Connection Manager in words."""
    try:
        return _TEXTS[ExtendedStatus(code)]
    except ValueError:
        return "an extended status this harness does not know"


def older(code: ExtendedStatus) -> ExtendedStatus:
    """The code that an earlier edition had for the same refusal; the code itself if it had it."""
    return _OLDER.get(code, code)


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
    """Path of logical segments."""
    path = encode_segment(0x20, class_id) + encode_segment(0x24, instance)
    return path if attribute is None else path + encode_segment(0x30, attribute)


def encode_segment(kind: int, number: int) -> bytes:
    """A logical segment, 8 bit wide where the number allows it, else 16 bit (padded)."""
    if number <= 0xFF:
        return struct.pack("<BB", kind, number)
    return struct.pack("<BxH", kind | _SIXTEEN_BIT, number)


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
