"""The encapsulation over UDP, port 44818: who is there. No sessions, no sockets.

A broadcast ListIdentity is answered after a random delay, because everybody on the network
answers it (volume 2, chapter 2-4.2); the longest delay is the request's, in milliseconds, in the
first two bytes of its sender context: 0 stands for 2 s, and less than 500 for 500.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from rcx_harness.enip.codec.encapsulation import (
    HEADER_SIZE,
    Command,
    EncapsulationStatus,
    decode_header,
)
from rcx_harness.enip.target.listing import Listing

__all__ = ["Datagrams", "Delayed"]

_DEFAULT_DELAY_MS, _LEAST_DELAY_MS = 2000, 500


@dataclass(frozen=True)
class Delayed:
    """An answer and the seconds to wait before it is sent."""

    data: bytes
    delay_s: float


class Datagrams:
    """Answers datagrams.

    Args:
        listing: Answers the three commands that go over UDP.
        random: Uniform from 0 to 1.
    """

    def __init__(self, listing: Listing, random: Callable[[], float]) -> None:
        self._listing = listing
        self._random = random

    def answer(self, data: bytes, local: tuple[str, int], broadcast: bool) -> Delayed | None:
        """Answer one datagram.

        Args:
            data: One frame; anything else is discarded.
            local: Our own host and port.
            broadcast: It was sent to everybody; then there is no answer but to what was asked.
        """
        found = decode_header(data)
        if found is None or len(data) != HEADER_SIZE + found[1]:
            return None
        frame, length = found
        if frame.status or frame.options or frame.command == Command.NOP:
            return None
        listed = None
        if length == 0 or not broadcast:
            listed = self._listing.answer(frame.with_data(data[HEADER_SIZE:]), local)
        if listed is None:
            # RegisterSession, SendRRData and all that need a session are not for UDP.
            refused = frame.answer(status=EncapsulationStatus.INVALID_COMMAND)
            return None if broadcast else Delayed(refused.encode(), 0.0)
        delayed = broadcast and frame.command == Command.LIST_IDENTITY
        return Delayed(listed.encode(), self._delay_s(frame.context) if delayed else 0.0)

    def _delay_s(self, context: bytes) -> float:
        longest = int.from_bytes(context[:2], "little") or _DEFAULT_DELAY_MS
        return self._random() * max(longest, _LEAST_DELAY_MS) / 1000
