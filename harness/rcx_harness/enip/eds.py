"""The virtual controller's electronic data sheet (EDS).

A PLC's configuration tool reads an EDS file to learn the device's identity and connections. The
format is defined in the Common Industrial Protocol, volume 1, chapter 7. A section consists of
entries, and an entry of fields; a comment begins with `$` and ends with the line. `eds.txt` is the
sheet with placeholders. Its date is fixed, so that the text does not depend on the day. The sheet
is not derived from the vendor's file for the real controller.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from rcx_harness.enip.options import RPI_MAX_US, AdapterOptions, Identity
from rcx_harness.enip.target.connection_manager import MAX_CYCLIC, MAX_EXPLICIT
from rcx_harness.spec.wire import EXTENDED_SIZE, SIZE, check_size

__all__ = ["eds_text"]

_SHEET = Path(__file__).with_name("eds.txt")
_USUAL_RPI_US = 10_000


def eds_text(
    size: int = SIZE, identity: Identity | None = None, options: AdapterOptions | None = None
) -> str:
    """Return the complete sheet.

    `size` is the size of each area that a configuration tool proposes by default. Its user can
    choose either size of the controller.

    Returns:
        ASCII text with LF line ends.
    """
    check_size(size)
    least_us = (options or AdapterOptions()).rpi_min_us
    values = asdict(identity or Identity())
    # Pad the value together with its semicolon, so that the comments of the sheet are aligned.
    values["device_type"] = f"{values['device_type']};"
    return _SHEET.read_text(encoding="ascii").format(
        **values,
        intervals=f"{least_us},{RPI_MAX_US},{max(_USUAL_RPI_US, least_us)},",
        sizes=f"{SIZE},{EXTENDED_SIZE},{size},",
        cyclic=sum(MAX_CYCLIC.values()),
        explicit=MAX_EXPLICIT,
    )
