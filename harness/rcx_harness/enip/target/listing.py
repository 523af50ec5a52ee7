"""The commands that need no session and go over TCP and UDP alike: what is there, and who."""

from __future__ import annotations

import struct

from rcx_harness.enip.codec.encapsulation import (
    PROTOCOL_VERSION,
    Command,
    EncapsulationStatus,
    Frame,
    Item,
    encode_items,
    socket_address,
)
from rcx_harness.enip.target.router import Router

__all__ = ["Listing"]

_CIP_OVER_TCP, _CYCLIC_OVER_UDP = 0x0020, 0x0100  # capability flags


class Listing:
    """Answers ListServices, ListIdentity and ListInterfaces.

    Args:
        router: Knows the identity.
        cyclic: Class 1 connections can be opened.
    """

    def __init__(self, router: Router, cyclic: bool) -> None:
        self._router = router
        self._flags = _CIP_OVER_TCP | (_CYCLIC_OVER_UDP if cyclic else 0)

    def answer(self, frame: Frame, local: tuple[str, int]) -> Frame | None:
        """Answer a command.

        Args:
            frame: The request; it has no data, else it is refused with 0x65.
            local: Our own host and port, as ListIdentity shows them.

        Returns:
            None if it is another command.
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
