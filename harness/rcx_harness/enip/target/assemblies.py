"""Which assemblies of an adapter a scanner asks for, and how long they are."""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.errors import InputError

__all__ = ["AREA_SIZES", "LARGEST", "Assemblies", "areas_of"]

AREA_SIZES = (48, 256)
"""Bytes that the controller's areas can have."""

LARGEST = 1400
"""Bytes of data that fit into one datagram of the Ethernet."""


@dataclass(frozen=True)
class Assemblies:
    """The assemblies of one connection; as they stand, those of the controller with 48 bytes.

    Args:
        input_size: Bytes from the adapter.
        output_size: Bytes to the adapter; an exclusive owner alone sends them.
        input_instance: The adapter's instance, or connection point, to receive from.
        output_instance: The one to send to.
        heartbeat: The one that readers name instead; None for the usual one.
        configuration: Configuration instance to name, None for none.
        configuration_data: Data for it, an even number of bytes.

    Raises:
        InputError: a size that no datagram holds, a number that is no instance, or data without
            their instance.
    """

    input_size: int = 48
    output_size: int = 48
    input_instance: int = 100
    output_instance: int = 150
    heartbeat: int | None = None
    configuration: int | None = None
    configuration_data: bytes = b""

    def __post_init__(self) -> None:
        """Refuse what cannot be asked for."""
        for size in (self.input_size, self.output_size):
            if not 1 <= size <= LARGEST:
                hint = f"an assembly has 1 to {LARGEST}"
                raise InputError(f"an assembly of {size} bytes cannot be exchanged", hint=hint)
        numbers = (self.input_instance, self.output_instance, self.heartbeat, self.configuration)
        for number in numbers:
            if number is not None and not 1 <= number <= 0xFFFF:
                raise InputError(f"{number} is no instance of an assembly; they are 1 to 65535")
        if self.configuration_data and self.configuration is None:
            raise InputError("configuration data need the instance that they are for")
        if len(self.configuration_data) % 2 or len(self.configuration_data) > 2 * 0xFF:
            raise InputError("configuration data are an even number of bytes, at most 510")


def areas_of(size: int) -> Assemblies:
    """The controller's areas, 48 or 256 bytes.

    Raises:
        InputError: another size.
    """
    if size not in AREA_SIZES:
        raise InputError(
            f"the areas cannot be {size} bytes long",
            hint="the controller has 48 bytes, or 256 with its word extension",
        )
    return Assemblies(size, size)
