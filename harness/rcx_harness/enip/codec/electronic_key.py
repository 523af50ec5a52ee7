"""Does an electronic key fit the device it has reached?"""

from __future__ import annotations

from rcx_harness.enip.codec.cip import ElectronicKey
from rcx_harness.enip.codec.connection_status import ExtendedStatus
from rcx_harness.enip.identity import Identity

__all__ = ["key_mismatch"]


def key_mismatch(key: ElectronicKey | None, identity: Identity) -> ExtendedStatus | None:
    """What of the key does not fit, as a Forward Open is refused for it; None if it fits.

    A value of 0 fits every device. A compatible device may have a newer minor revision.
    """
    if key is None:
        return None
    if _differs(key.vendor, identity.vendor) or _differs(key.product_code, identity.product_code):
        return ExtendedStatus.KEY_VENDOR_OR_PRODUCT
    if _differs(key.device_type, identity.device_type):
        return ExtendedStatus.KEY_DEVICE_TYPE
    newer = key.compatible and identity.minor_revision > key.minor
    if _differs(key.major, identity.major_revision) or (
        _differs(key.minor, identity.minor_revision) and not newer
    ):
        return ExtendedStatus.KEY_REVISION
    return None


def _differs(wanted: int, have: int) -> bool:
    return wanted not in (0, have)
