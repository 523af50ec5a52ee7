"""Who the adapter says it is."""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.errors import InputError

__all__ = ["Identity"]


@dataclass(frozen=True)
class Identity:
    """The Identity object's attributes 1 to 7.

    The device type is the manual's (chapter 5, section 4). Vendor, product code and revision are
    assumed: they are those of the RCX3's predecessor, because the RCX3's own are not known. A
    scanner that checks its electronic key may need others.
    """

    vendor: int = 636
    device_type: int = 43
    product_code: int = 5
    major_revision: int = 1
    minor_revision: int = 1
    serial_number: int = 1
    product_name: str = "RCX3 virtual controller"

    def __post_init__(self) -> None:
        """Refuse what the attributes cannot carry.

        Raises:
            InputError: a number out of its attribute's range, or a name of more than 32 letters.
        """
        limits = {
            "vendor": 0xFFFF,
            "device_type": 0xFFFF,
            "product_code": 0xFFFF,
            # The highest bit of the major revision means "compatible" in an electronic key.
            "major_revision": 0x7F,
            "minor_revision": 0xFF,
            "serial_number": 0xFFFFFFFF,
        }
        for name, limit in limits.items():
            if not 0 <= getattr(self, name) <= limit:
                raise InputError(f"identity: {name} must be 0 to {limit}")
        if len(self.product_name) > 32 or not self.product_name.isascii():
            raise InputError("identity: product_name must be at most 32 ASCII letters")
