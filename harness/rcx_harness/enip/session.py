"""One TCP connection of a scanner: encapsulation commands in, answers out, no sockets.

Which command is answered how is chapter 2 of the EtherNet/IP adaptation of CIP (volume 2). A
command that cannot be served gets a status; only UnRegisterSession ends the connection.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from rcx_harness.enip.encapsulation import (
    PROTOCOL_VERSION,
    Command,
    EncapsulationStatus,
    Frame,
    Item,
    encode_items,
    next_frame,
    unconnected,
    unconnected_message,
)
from rcx_harness.enip.router import Router

__all__ = ["Session"]

_CIP_OVER_TCP = 0x0020  # of the capability flags; class 0 and 1 over UDP would be 0x0100


class Session:
    """The encapsulation layer of one connection.

    Args:
        router: Answers the CIP requests.
        new_handle: Gives a session handle that no other connection has.
        address: The adapter's own socket address, as ListIdentity shows it.

    Attributes:
        ended: The scanner has taken its leave; the connection is to be closed.
    """

    def __init__(self, router: Router, new_handle: Callable[[], int], address: bytes) -> None:
        self.ended = False
        self._router = router
        self._new_handle = new_handle
        self._address = address
        self._handle = 0
        self._received = bytearray()
        self._commands: dict[int, Callable[[Frame], Frame | None]] = {
            Command.NOP: lambda _: None,
            Command.LIST_SERVICES: self._list_services,
            Command.LIST_IDENTITY: self._list_identity,
            Command.LIST_INTERFACES: lambda frame: frame.answer(encode_items()),
            Command.REGISTER_SESSION: self._register,
            Command.UNREGISTER_SESSION: self._unregister,
            Command.SEND_RR_DATA: self._send_rr_data,
        }

    def receive(self, data: bytes) -> bytes:
        """Take bytes as they come off the wire, whole frames or not; return all answers."""
        self._received += data
        answers = []
        while not self.ended and (frame := next_frame(self._received)):
            # The protocol has requests with a status or with options discarded without a word.
            if frame.status or frame.options:
                continue
            command = self._commands.get(frame.command)
            if command is None:
                answers.append(frame.answer(status=EncapsulationStatus.INVALID_COMMAND))
            elif (answer := command(frame)) is not None:
                answers.append(answer)
        return b"".join(answer.encode() for answer in answers)

    def _list_services(self, frame: Frame) -> Frame:
        service = struct.pack("<HH16s", PROTOCOL_VERSION, _CIP_OVER_TCP, b"Communications")
        return frame.answer(encode_items((Item.SERVICES, service)))

    def _list_identity(self, frame: Frame) -> Frame:
        version = struct.pack("<H", PROTOCOL_VERSION)
        identity = version + self._address + self._router.identity()
        return frame.answer(encode_items((Item.IDENTITY, identity)))

    def _register(self, frame: Frame) -> Frame:
        if len(frame.data) != 4:
            return frame.answer(status=EncapsulationStatus.INVALID_LENGTH)
        ours = struct.pack("<HH", PROTOCOL_VERSION, 0)
        if frame.data != ours:
            return frame.answer(ours, EncapsulationStatus.UNSUPPORTED_VERSION)
        if self._handle:
            return frame.answer(status=EncapsulationStatus.INVALID_COMMAND)
        self._handle = self._new_handle()
        return frame.answer(ours, session=self._handle)

    def _unregister(self, frame: Frame) -> Frame | None:
        if not self._is_ours(frame):
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        self.ended = True
        return None

    def _send_rr_data(self, frame: Frame) -> Frame:
        if not self._is_ours(frame):
            return frame.answer(status=EncapsulationStatus.INVALID_SESSION)
        message = unconnected_message(frame.data)
        if message is None or len(message) < 2:
            return frame.answer(status=EncapsulationStatus.INCORRECT_DATA)
        return frame.answer(unconnected(self._router.answer(message)))

    def _is_ours(self, frame: Frame) -> bool:
        return self._handle != 0 and frame.session == self._handle
