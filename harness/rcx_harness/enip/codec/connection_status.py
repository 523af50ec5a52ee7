"""Why a connection was refused: the extended status codes of the Connection Manager, in words.

Numbers are those of CIP volume 1, chapter 3, 5.6 (connection manager service request error codes).
"""

from __future__ import annotations

from enum import IntEnum

__all__ = ["ExtendedStatus", "extended_text", "older"]


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
