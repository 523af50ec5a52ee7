"""The errors of the network that callers catch."""

from __future__ import annotations

from rcx_harness.enip.codec.cip import Status, extended_text, status_text
from structured_text.errors import InputError

__all__ = ["CipError", "EnipError", "ProcessDiedError"]


class EnipError(InputError):
    """The EtherNet/IP exchange failed: no connection, no answer in time, or an invalid answer."""


class ProcessDiedError(EnipError):
    """A process of the harness has ended by itself; the user's input is not the cause."""

    exit_code = 1


class CipError(EnipError):
    """The device has refused a request.

    Args:
        request: The request in words.
    """

    def __init__(self, request: str, status: int, extended: tuple[int, ...] = ()) -> None:
        self.status = status
        self.extended = extended
        reasons = [f"0x{status:02X}, {status_text(status)}"]
        # Extended status words have names only for the Connection Manager, with status "connection
        # failure".
        if status == Status.CONNECTION_FAILURE:
            reasons += [f"0x{code:04X}, {extended_text(code)}" for code in extended[:1]]
        super().__init__(f"{request} was refused: {'; '.join(reasons)}")
