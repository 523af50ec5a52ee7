"""What the device answers to a CIP request."""

from __future__ import annotations

import struct

from rcx_harness.enip.cip import (
    ElectronicKey,
    Path,
    Refusal,
    Request,
    Service,
    Status,
    decode_request,
    encode_reply,
)
from rcx_harness.enip.identity import Identity
from rcx_harness.enip.objects import IDENTITY, ObjectModel

__all__ = ["Router"]


class Router:
    """Turns requests into replies; every request gets one.

    Args:
        objects: The device's objects.
        identity: What an electronic key in a path is compared with.
    """

    def __init__(self, objects: ObjectModel, identity: Identity) -> None:
        self._objects = objects
        self._identity = identity

    def answer(self, message: bytes) -> bytes:
        """Reply to an unconnected CIP request of at least two bytes."""
        try:
            request = decode_request(message)
            self._check_key(request.path.key)
            self._objects.require(request.path)
            return self._perform(request)
        except Refusal as refusal:
            return encode_reply(message[0], refusal.status)

    def identity(self) -> bytes:
        """Attributes 1 to 8 of the Identity object, as ListIdentity shows them."""
        return b"".join(self._objects.get(IDENTITY, 1, number) for number in range(1, 9))

    def _perform(self, request: Request) -> bytes:
        path = request.path
        if request.service == Service.GET_ATTRIBUTE_SINGLE:
            value = self._objects.get(path.class_id, path.instance, path.attribute)
            _refuse_data(request)
            return encode_reply(request.service, Status.SUCCESS, value)
        if request.service == Service.SET_ATTRIBUTE_SINGLE:
            self._objects.set(path, request.data)
            return encode_reply(request.service, Status.SUCCESS)
        if request.service == Service.GET_ATTRIBUTE_LIST:
            return self._get_list(path, request.data)
        reply = self._objects.perform(request.service, path)
        if request.service == Service.GET_ATTRIBUTES_ALL and reply[2] == Status.SUCCESS:
            _refuse_data(request)
        return reply

    def _get_list(self, path: Path, data: bytes) -> bytes:
        # Here and not in cpppo, whose reply lacks the number of attributes.
        wanted = 2 + 2 * int.from_bytes(data[:2], "little")
        if len(data) < max(wanted, 2):
            raise Refusal(Status.NOT_ENOUGH_DATA)
        if len(data) > wanted:
            raise Refusal(Status.TOO_MUCH_DATA)
        status = Status.SUCCESS
        values = [data[:2]]
        for (number,) in struct.iter_unpack("<H", data[2:]):
            try:
                value = self._objects.get(path.class_id, path.instance, number)
                values.append(struct.pack("<HH", number, Status.SUCCESS) + value)
            except Refusal as refusal:
                status = Status.ATTRIBUTE_LIST_ERROR
                values.append(struct.pack("<HH", number, refusal.status))
        return encode_reply(Service.GET_ATTRIBUTE_LIST, status, b"".join(values))

    def _check_key(self, key: ElectronicKey | None) -> None:
        if key is None:
            return
        ours = self._identity
        pairs = [
            (key.vendor, ours.vendor),
            (key.device_type, ours.device_type),
            (key.product_code, ours.product_code),
            (key.major, ours.major_revision),
        ]
        if any(wanted and wanted != have for wanted, have in pairs):
            raise Refusal(Status.KEY_FAILURE_IN_PATH)
        # A compatible device may be newer; otherwise the minor revision must be the same.
        newer = key.compatible and ours.minor_revision > key.minor
        if key.minor and key.minor != ours.minor_revision and not newer:
            raise Refusal(Status.KEY_FAILURE_IN_PATH)


def _refuse_data(request: Request) -> None:
    if request.data:
        raise Refusal(Status.TOO_MUCH_DATA)
