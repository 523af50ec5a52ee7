"""What goes wrong on the network, as the caller sees it."""

from __future__ import annotations

from rcx_harness.enip.cip import status_text
from rcx_harness.errors import InputError

__all__ = ["CipError", "EnipError"]


class EnipError(InputError):
    """The EtherNet/IP exchange failed: no connection, no answer in time, or not an answer."""


class CipError(EnipError):
    """The device answered, and refused.

    Args:
        request: What was asked, in words.
        status: General status of the reply, 1 to 255.
    """

    def __init__(self, request: str, status: int) -> None:
        self.status = status
        super().__init__(f"{request} was refused: 0x{status:02X}, {status_text(status)}")
