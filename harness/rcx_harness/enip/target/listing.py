"""Discovery: the commands that need no session, over TCP and UDP, without sockets.

A broadcast ListIdentity is answered after a random delay, because all devices on the network
answer it (volume 2, chapter 2-4.2). The first two bytes of the sender context are the longest delay
in milliseconds: 0 means 2 s, and less than 500 means 500.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from rcx_harness.enip.codec.encapsulation import (
    HEADER_SIZE,
    PROTOCOL_VERSION,
    Command,
    EncapsulationStatus,
    Frame,
    Item,
    decode_header,
    encode_items,
    socket_address,
)
from rcx_harness.enip.target.router import Router

__all__ = ["Datagrams", "Delayed", "Listing"]

_CIP_OVER_TCP, _CYCLIC_OVER_UDP = 0x0020, 0x0100  # capability flags


class Listing:
    """Answers the discovery commands ListServices, ListIdentity and ListInterfaces."""

    def __init__(self, router: Router, cyclic: bool) -> None:
        self._router = router
        self._flags = _CIP_OVER_TCP | (_CYCLIC_OVER_UDP if cyclic else 0)

    def answer(self, frame: Frame, local: tuple[str, int]) -> Frame | None:
        """Answer a discovery command.

        A command with data is refused with status 0x65. `local` is our own host and port, as shown
        by ListIdentity.

        Returns:
            The answer; None if the command is not a discovery command.
        """
        if frame.command == Command.LIST_SERVICES:
            item = struct.pack("<HH16s", PROTOCOL_VERSION, self._flags, b"Communications")
            items = encode_items((Item.SERVICES, item))
        elif frame.command == Command.LIST_IDENTITY:
            version = struct.pack("<H", PROTOCOL_VERSION)
            item = version + socket_address(*local) + self._router.identity()
            items = encode_items((Item.IDENTITY, item))
        elif frame.command == Command.LIST_INTERFACES:
            items = encode_items()
        else:
            return None
        if frame.data:
            return frame.answer(status=EncapsulationStatus.INVALID_LENGTH)
        return frame.answer(items)


_DEFAULT_DELAY_MS, _LEAST_DELAY_MS = 2000, 500


@dataclass(frozen=True)
class Delayed:
    """An answer, and the delay in seconds before it is sent."""

    data: bytes
    delay_s: float


class Datagrams:
    """Answers the datagrams on the UDP port of explicit messages.

    Args:
        random: Function that returns a uniform random number from 0 to 1.
    """

    def __init__(self, listing: Listing, random: Callable[[], float]) -> None:
        self._listing = listing
        self._random = random

    def answer(self, data: bytes, local: tuple[str, int], broadcast: bool) -> Delayed | None:
        """Answer one datagram.

        A datagram that is not exactly one frame is discarded. A broadcast gets no error answer.
        """
        found = decode_header(data)
        if found is None or len(data) != HEADER_SIZE + found[1]:
            return None
        frame, length = found
        if frame.status or frame.options or frame.command == Command.NOP:
            return None
        listed = None
        if length == 0 or not broadcast:
            listed = self._listing.answer(frame._replace(data=data[HEADER_SIZE:]), local)
        if listed is None:
            # RegisterSession, SendRRData and all commands that need a session are not allowed over
            # UDP.
            refused = frame.answer(status=EncapsulationStatus.INVALID_COMMAND)
            return None if broadcast else Delayed(refused.encode(), 0.0)
        delayed = broadcast and frame.command == Command.LIST_IDENTITY
        return Delayed(listed.encode(), self._delay_s(frame.context) if delayed else 0.0)

    def _delay_s(self, context: bytes) -> float:
        longest = int.from_bytes(context[:2], "little") or _DEFAULT_DELAY_MS
        return self._random() * max(longest, _LEAST_DELAY_MS) / 1000
