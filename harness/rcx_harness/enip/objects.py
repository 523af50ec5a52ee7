"""The device's CIP objects and their attributes, held by cpppo; nothing else imports cpppo.

cpppo keeps its object directory for the whole process: one device per process, and a new
`ObjectModel` replaces the one before it.
"""

from __future__ import annotations

import logging
from typing import Any

from cpppo.dotdict import dotdict
from cpppo.server.enip import device, parser

from rcx_harness.enip.cip import Path, Refusal, Status
from rcx_harness.enip.identity import Identity

__all__ = ["ASSEMBLY", "IDENTITY", "TO_MASTER", "TO_ROBOT", "ObjectModel"]

IDENTITY, MESSAGE_ROUTER, ASSEMBLY = 0x01, 0x02, 0x04
TO_MASTER, TO_ROBOT = 100, 150

_NO_IO_CONNECTION = 0x0030  # status word, bits 4 to 7 = 3: no I/O connection established
_OPERATIONAL = 3

# cpppo reports every refused request as a warning with a stack trace; the refusal is in the reply.
for _name in ("cpppo", "enip"):
    logging.getLogger(_name).setLevel(logging.CRITICAL)


class _Identity(device.Object):  # type: ignore[misc]  # cpppo has no types
    class_id = IDENTITY


class _MessageRouter(device.Object):  # type: ignore[misc]
    class_id = MESSAGE_ROUTER


class _Assembly(device.Object):  # type: ignore[misc]
    class_id = ASSEMBLY


class _Settable(device.Attribute):  # type: ignore[misc]
    """An attribute that Set_Attribute_Single may write."""


class ObjectModel:
    """Identity, Message Router and the Assemblies 100 and 150 of one adapter.

    Args:
        to_master: Image of assembly 100, written by the robot.
        to_robot: Image of assembly 150, as long as the other one, written by the master.
        identity: Attributes of the Identity object.
    """

    def __init__(self, to_master: memoryview, to_robot: memoryview, identity: Identity) -> None:
        device.lookup_reset()
        _add(_Identity, 1, 1, _identity_attributes(identity))
        _add(_MessageRouter, 1, 1, {})
        for instance, kind, image in (
            (TO_MASTER, device.Attribute, to_master),
            (TO_ROBOT, _Settable, to_robot),
        ):
            data = kind("Data", parser.USINT, default=image)
            size = device.Attribute("Size", parser.UINT, default=len(image))
            _add(_Assembly, 2, instance, {3: data, 4: size})

    def require(self, path: Path) -> None:
        """Check that the object of `path` exists.

        Raises:
            Refusal: 0x05, no such class or instance.
        """
        if device.lookup(path.class_id, path.instance) is None:
            raise Refusal(Status.PATH_DESTINATION_UNKNOWN)

    def get(self, class_id: int, instance: int, attribute: int | None) -> bytes:
        """Value of an attribute of an existing object.

        Raises:
            Refusal: 0x14, no such attribute.
        """
        value: bytes = _attribute(class_id, instance, attribute).produce()
        return value

    def set(self, path: Path, data: bytes) -> None:
        """Set an attribute of an existing object, whole.

        Raises:
            Refusal: 0x14 no such attribute, 0x0E read only, 0x13 too short, 0x15 too long.
        """
        attribute = _attribute(path.class_id, path.instance, path.attribute)
        if not isinstance(attribute, _Settable):
            raise Refusal(Status.ATTRIBUTE_NOT_SETTABLE)
        if len(data) < len(attribute):
            raise Refusal(Status.NOT_ENOUGH_DATA)
        if len(data) > len(attribute):
            raise Refusal(Status.TOO_MUCH_DATA)
        attribute[:] = data

    def perform(self, service: int, path: Path) -> bytes:
        """Hand a service without data to the object itself.

        Returns:
            The whole CIP reply.

        Raises:
            Refusal: 0x08, the object does not know the service.
        """
        data = dotdict(
            service=service,
            path={"segment": [{"class": path.class_id}, {"instance": path.instance}]},
        )
        try:
            device.lookup(path.class_id, path.instance).request(data)
        except device.RequestUnrecognized:
            raise Refusal(Status.SERVICE_NOT_SUPPORTED) from None
        return bytes(data.input)


def _attribute(class_id: int, instance: int, attribute: int | None) -> Any:
    # cpppo keeps the object itself as attribute 0.
    found = device.lookup(class_id, instance, attribute) if attribute else None
    if found is None:
        raise Refusal(Status.ATTRIBUTE_NOT_SUPPORTED)
    return found


def _add(kind: Any, revision: int, instance: int, attributes: dict[int, Any]) -> None:
    """Create an instance, and with the first one its class."""
    kind(instance_id=instance).attribute.update({str(k): v for k, v in attributes.items()})
    device.lookup(kind.class_id, 0, 1).value = revision


def _identity_attributes(identity: Identity) -> dict[int, Any]:
    revision = identity.major_revision | identity.minor_revision << 8
    values = (
        ("Vendor ID", parser.UINT, identity.vendor),
        ("Device Type", parser.UINT, identity.device_type),
        ("Product Code", parser.UINT, identity.product_code),
        ("Revision", parser.UINT, revision),
        ("Status", parser.WORD, _NO_IO_CONNECTION),
        ("Serial Number", parser.UDINT, identity.serial_number),
        ("Product Name", parser.SSTRING, identity.product_name),
    )
    attributes = {
        number: device.Attribute(name, kind, default=value)
        for number, (name, kind, value) in enumerate(values, start=1)
    }
    # Get_Attributes_All ends with the product name; ListIdentity and Get_Attribute_Single need it.
    mask = device.Attribute.MASK_GA_ALL
    attributes[8] = device.Attribute("State", parser.USINT, default=_OPERATIONAL, mask=mask)
    return attributes
