"""The router, which answers CIP requests to the device."""

from __future__ import annotations

import struct
from collections.abc import Callable

from rcx_harness.enip.codec.cip import (
    ClassId,
    ConnectionService,
    ExtendedStatus,
    Path,
    Refusal,
    Request,
    Service,
    Status,
    decode_request,
    encode_reply,
)
from rcx_harness.enip.options import Identity
from rcx_harness.enip.target.admission import key_mismatch
from rcx_harness.enip.target.connection_manager import ConnectionManager, Origin
from rcx_harness.enip.target.objects import ObjectModel

__all__ = ["Router"]

_MAX_REPLY = 4000
_CONNECTION_SERVICES = frozenset(ConnectionService)
# two bytes with priority and ticks (ignored), then the length of the message
_UNCONNECTED_SEND = struct.Struct("<2xH")
_BACKPLANE = b"\x01\x00"  # port 1, link address 0: scanners expect a processor at this address


class Router:
    """The router of requests: it returns a reply to every request.

    `identity` is compared with the electronic key of a path. `reset` resets the device after the
    reply has been sent.
    """

    def __init__(
        self,
        objects: ObjectModel,
        identity: Identity,
        connections: ConnectionManager,
        reset: Callable[[], None],
    ) -> None:
        self._objects = objects
        self._identity = identity
        self._connections = connections
        self._reset = reset

    def answer(self, message: bytes, origin: Origin | None = None) -> bytes:
        """Return the reply to a CIP request of at least two bytes, connected or unconnected."""
        return self._answer(message, origin or Origin(), routed=False)

    def identity(self) -> bytes:
        """Return attributes 1 to 8 of the Identity object, as ListIdentity shows them."""
        return b"".join(self._objects.get(ClassId.IDENTITY, 1, number) for number in range(1, 9))

    def _answer(self, message: bytes, origin: Origin, routed: bool) -> bytes:
        try:
            request = decode_request(message)
            path = request.path
            if key_mismatch(path.key, self._identity) is not None:
                raise Refusal(Status.KEY_FAILURE_IN_PATH)
            self._objects.require(path)
            if (path.class_id, path.instance) == (ClassId.CONNECTION_MANAGER, 1):
                if request.service == ConnectionService.UNCONNECTED_SEND:
                    return self._unconnected_send(request, origin, routed)
                if request.service in _CONNECTION_SERVICES:
                    return self._connections.perform(request, origin)
            return self._perform(request)
        except Refusal as refusal:
            return encode_reply(message[0], refusal.status, refusal.data, refusal.extended)

    def _perform(self, request: Request) -> bytes:
        path = request.path
        if request.service == Service.GET_ATTRIBUTE_SINGLE:
            # Data after a read request is ignored, because some clients append an empty route.
            value = self._objects.get(path.class_id, path.instance, path.attribute)
            return encode_reply(request.service, Status.SUCCESS, value)
        if request.service == Service.SET_ATTRIBUTE_SINGLE:
            self._objects.set(path, request.data)
            return encode_reply(request.service, Status.SUCCESS)
        if request.service == Service.GET_ATTRIBUTE_LIST:
            return self._get_list(path, request.data)
        if request.service == Service.RESET and (path.class_id, path.instance) == (
            ClassId.IDENTITY,
            1,
        ):
            return self._reset_device(request)
        return self._objects.perform(request.service, path)

    def _get_list(self, path: Path, data: bytes) -> bytes:
        # Answer this service here, because the reply of cpppo lacks the number of attributes.
        wanted = 2 + 2 * int.from_bytes(data[:2], "little")
        if len(data) < max(wanted, 2):
            raise Refusal(Status.NOT_ENOUGH_DATA)
        status = Status.SUCCESS
        values = data[:2]
        for (number,) in struct.iter_unpack("<H", data[2:wanted]):
            try:
                value = self._objects.get(path.class_id, path.instance, number)
                values += struct.pack("<HH", number, Status.SUCCESS) + value
            except Refusal as refusal:
                status = Status.ATTRIBUTE_LIST_ERROR
                values += struct.pack("<HH", number, refusal.status)
            if len(values) > _MAX_REPLY:
                raise Refusal(Status.REPLY_DATA_TOO_LARGE)
        return encode_reply(Service.GET_ATTRIBUTE_LIST, status, values)

    def _reset_device(self, request: Request) -> bytes:
        """Reset the network side for type 0 (the default), and refuse all other types.

        While a master owns the outputs, the reset is refused, because an unintended reset would
        separate the robot from its master.
        """
        if len(request.data) > 1:
            raise Refusal(Status.TOO_MUCH_DATA)
        if any(request.data):
            raise Refusal(Status.INVALID_PARAMETER)
        if self._connections.is_owned:
            raise Refusal(Status.DEVICE_STATE_CONFLICT)
        self._reset()
        return encode_reply(request.service, Status.SUCCESS)

    def _unconnected_send(self, request: Request, origin: Origin, routed: bool) -> bytes:
        """Execute the request inside an Unconnected Send, which must be for this device."""
        data = request.data
        if len(data) < _UNCONNECTED_SEND.size:
            raise Refusal(Status.NOT_ENOUGH_DATA)
        (length,) = _UNCONNECTED_SEND.unpack_from(data)
        end = _UNCONNECTED_SEND.size + length
        route_at = end + length % 2  # a message of odd length is followed by a pad
        if len(data) < route_at + 2:
            raise Refusal(Status.NOT_ENOUGH_DATA)
        words, route = data[route_at], data[route_at + 2 :]
        if len(route) != 2 * words:
            wrong = len(route) < 2 * words
            raise Refusal(Status.NOT_ENOUGH_DATA if wrong else Status.TOO_MUCH_DATA)
        if route not in (b"", _BACKPLANE):
            known = route[:1] == _BACKPLANE[:1]
            code = (
                ExtendedStatus.LINK_ADDRESS_NOT_VALID
                if known
                else ExtendedStatus.PORT_NOT_AVAILABLE
            )
            # data: number of remaining words of the route, and a reserved byte
            raise Refusal(Status.CONNECTION_FAILURE, (code,), bytes([words, 0]))
        message = data[_UNCONNECTED_SEND.size : end]
        if length < 2 or routed:
            raise Refusal(Status.CONNECTION_FAILURE, (ExtendedStatus.PARAMETER_ERROR,))
        return self._answer(message, origin, routed=True)
