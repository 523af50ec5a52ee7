"""The settings of the adapter: identity, limits and connection points."""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.enip.cyclic.connections import (
    FIRST_PACKET_US,
    LONGEST_TIMEOUT_US,
    ConnectionKind,
)
from rcx_harness.spec.wire import TO_ROBOT
from structured_text.errors import InputError
from structured_text.output.units import format_us

__all__ = ["CONFIGURATIONS", "INACTIVITY_S", "KINDS", "RPI_MAX_US", "AdapterOptions", "Identity"]

# The manual does not give the following values; they are assumed.

#: The kind of connection that each consuming connection point selects. The points 3 and 4 are usual
#: for communication modules with the assemblies 100 and 150.
KINDS = {
    TO_ROBOT: ConnectionKind.EXCLUSIVE_OWNER,
    3: ConnectionKind.INPUT_ONLY,
    4: ConnectionKind.LISTEN_ONLY,
}
#: Configuration instances that a connection path may name. A path without an instance is also
#: accepted.
CONFIGURATIONS = (1, 5, 151)
#: Largest accepted packet interval [us]. The value is that of the RCX3's predecessor.
RPI_MAX_US = 3_200_000
#: Time without a message after which a TCP connection is closed [s]. A scanner may set another
#: time.
INACTIVITY_S = 120


@dataclass(frozen=True)
class Identity:
    """The Identity object's attributes 1 to 7.

    The manual gives the device type (chapter 5, section 4). Vendor, product code and revision of
    the RCX3 are not known; the values of its predecessor are assumed. A scanner that checks the
    electronic key may need other values.
    """

    vendor: int = 636
    device_type: int = 43
    product_code: int = 5
    major_revision: int = 1
    minor_revision: int = 1
    serial_number: int = 1
    product_name: str = "RCX3 virtual controller"

    def __post_init__(self) -> None:
        """Raise InputError for values that do not fit into the attributes."""
        limits = {
            "vendor": 0xFFFF,
            "device_type": 0xFFFF,
            "product_code": 0xFFFF,
            # In an electronic key, the highest bit of the major revision is the "compatible" flag.
            # So the revision has only 7 bits.
            "major_revision": 0x7F,
            "minor_revision": 0xFF,
            "serial_number": 0xFFFFFFFF,
        }
        for name, limit in limits.items():
            if not 0 <= getattr(self, name) <= limit:
                raise InputError(f"identity: {name} must be 0 to {limit}")
        if len(self.product_name) > 32 or not self.product_name.isascii():
            raise InputError("identity: product_name must be at most 32 ASCII letters")


@dataclass(frozen=True)
class AdapterOptions:
    """Settings of the adapter; values that the manual does not give are assumed.

    Args:
        rpi_min_us: Smallest accepted packet interval in microseconds, at least 1 ms. Assumed: 2 ms,
            the value of the RCX3's predecessor.
        first_packet_us: Upper limit of the wait for the first packet of a cyclic connection, in
            microseconds. Assumed: 10 s, the minimum of CIP. Without this limit, a master that never
            sends can hold its connection for up to 512 intervals.
    """

    rpi_min_us: int = 2_000
    first_packet_us: int = FIRST_PACKET_US

    def __post_init__(self) -> None:
        """Raise InputError for settings that the adapter cannot serve."""
        if not 1_000 <= self.rpi_min_us <= RPI_MAX_US:
            least, greatest = format_us(self.rpi_min_us), format_us(RPI_MAX_US)
            raise InputError(
                f"packet intervals of {least} to {greatest} cannot be served",
                hint="choose a smallest interval of at least 1 ms, not above the greatest",
            )
        if not FIRST_PACKET_US <= self.first_packet_us <= LONGEST_TIMEOUT_US:
            shown = format_us(self.first_packet_us)
            raise InputError(
                f"the time to wait for the first packet cannot be {shown}", hint="use 10s to 610h"
            )
