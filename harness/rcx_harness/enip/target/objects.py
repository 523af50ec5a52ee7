"""The device's CIP objects and their attributes, held by cpppo; nothing else imports cpppo.

cpppo has one object directory per process, so a process has one device, and a new `ObjectModel`
replaces the model before it. CIP volume 2, chapter 5 defines the objects that describe the network:
TCP/IP Interface (0xF5, revision 4), Ethernet Link (0xF6, revision 4) and QoS (0x48, revision 1). A
virtual controller uses the addresses of its host, so only attributes without an effect on the host
can be set.
"""

from __future__ import annotations

import ipaddress
import logging
import struct
from collections.abc import Callable, Mapping
from typing import Any

from cpppo.dotdict import dotdict
from cpppo.server.enip import device, parser

from rcx_harness.enip.codec.cip import REVISIONS, ClassId, Path, Refusal, Status
from rcx_harness.enip.cyclic.shared import Image
from rcx_harness.enip.options import INACTIVITY_S, Identity
from rcx_harness.enip.target.network_interface import NetworkInterface
from rcx_harness.spec.wire import TO_MASTER, TO_ROBOT

__all__ = ["ObjectModel"]

DSCP = {4: 55, 5: 47, 6: 43, 7: 31, 8: 27}
"""Initial code points of the QoS object by attribute: urgent to low priority, explicit messages."""

_CONFIGURED = 1  # interface status: the configuration is valid
_FULL_DUPLEX_UP = 0x0F  # link up, full duplex, negotiated (3 in bits 2 to 4)
_MBIT = 100
_NEGOTIATE = 1
_TWISTED_PAIR = 2
_ENABLED, _DISABLED = 1, 2
_CAN_NEGOTIATE = 0x02
_SPEEDS = ((10, 0), (10, 1), (100, 0), (100, 1))  # Mbit/s, full duplex


def tcp_ip_values(interface: NetworkInterface, group: str) -> dict[int, bytes]:
    """Return attributes 1 to 12 of the TCP/IP Interface object."""
    address = _number(interface.address) + _number(interface.netmask) + bytes(12)
    return {
        1: struct.pack("<I", _CONFIGURED),
        2: bytes(4),  # configuration capability: none, all settings are fixed
        3: bytes(4),  # configuration control: a fixed address
        # physical link object: no path, because the module's switch has two of these objects
        4: bytes(2),
        5: address + bytes(2),  # gateway, name servers and domain name: none set
        6: bytes(2),  # host name: none
        7: bytes(6),  # safety network number
        8: bytes([1]),  # time to live of multicast packets
        9: struct.pack("<BxH", 0, 1) + _number(group),  # multicast: allocated by address, one group
        10: bytes(1),  # address conflict detection: off
        11: bytes(35),  # last address conflict: none
        12: bytes(1),  # quick connect: off
    }


def ethernet_link_values(port: int, hardware_address: bytes) -> dict[int, bytes]:
    """Return attributes 1 to 11 of an Ethernet Link instance.

    The module has two connectors, 10Base-T or 100Base-TX (manual chapter 1, 3.1). The cable is in
    the first connector.
    """
    plugged = port == 1
    label = f"Port {port}".encode()
    speeds = b"".join(struct.pack("<HB", *speed) for speed in _SPEEDS)
    return {
        1: struct.pack("<I", _MBIT if plugged else 0),
        2: struct.pack("<I", _FULL_DUPLEX_UP if plugged else 0),
        3: hardware_address,
        4: bytes(11 * 4),  # interface counters
        5: bytes(12 * 4),  # media counters
        6: struct.pack("<HH", _NEGOTIATE, 0),
        7: bytes([_TWISTED_PAIR]),
        8: bytes([_ENABLED if plugged else _DISABLED]),
        9: bytes([_ENABLED]),
        10: bytes([len(label)]) + label,
        11: struct.pack("<IB", _CAN_NEGOTIATE, len(_SPEEDS)) + speeds,
    }


def _number(address: str) -> bytes:
    return int(ipaddress.IPv4Address(address)).to_bytes(4, "little")


_OPERATIONAL = 3
_CONTROL, _INACTIVITY = 3, 13  # attributes of the TCP/IP Interface object
_MAX_INACTIVITY_S = 3600
_EXPLICIT_DSCP = 8
_MAX_DSCP = 63
_CLASS_ATTRIBUTES = 7

# cpppo logs every refused request with a stack trace, although the reply contains the refusal.
for _name in ("cpppo", "enip"):
    logging.getLogger(_name).setLevel(logging.CRITICAL)


#: Maps each class of CIP objects to a subclass of cpppo's Object.
_KINDS: dict[ClassId, Any] = {
    class_id: type(f"Class{class_id}", (device.Object,), {"class_id": int(class_id)})
    for class_id in ClassId
}


class _Value(device.Attribute):  # type: ignore[misc]  # cpppo has no types
    """An attribute whose bytes come from a function.

    It can be set if there is a `write` function.
    """

    def __init__(
        self,
        name: str,
        read: Callable[[], bytes],
        write: Callable[[bytes], None] | None = None,
    ) -> None:
        super().__init__(name, parser.USINT, default=b"")
        self.read = read
        self.write = write

    def produce(self, start: int = 0, stop: int | None = None) -> bytes:
        """Return the current bytes of the attribute's value."""
        return self.read()[start:stop]


class ObjectModel:
    """The objects of one adapter.

    Identity, Message Router, the Assemblies 100 and 150, Connection Manager (without attributes),
    QoS, TCP/IP Interface and two Ethernet Links.

    Args:
        status: Function that returns the status word of the Identity object.
        is_owned: Function that returns whether a connection owns assembly 150.
        group: First multicast address of the adapter.

    Attributes:
        inactivity_s: Silence after which a TCP connection is closed [s]; 0: never.
    """

    def __init__(
        self,
        to_master: Image,
        to_robot: Image,
        identity: Identity,
        status: Callable[[], int],
        is_owned: Callable[[], bool],
        interface: NetworkInterface,
        group: str,
    ) -> None:
        self._found: dict[tuple[int, ...], Any] = {}
        self.inactivity_s = INACTIVITY_S
        self._dscp = dict(DSCP)
        self._is_owned = is_owned
        device.lookup_reset()
        _add(ClassId.IDENTITY, 1, _identity_attributes(identity, status))
        _add(ClassId.MESSAGE_ROUTER, 1, {})
        for instance, image, write in (
            (TO_MASTER, to_master, None),
            (TO_ROBOT, to_robot, to_robot.write),
        ):
            size = struct.pack("<H", len(image.read()))
            data = _Value("Data", image.read, write)
            _add(ClassId.ASSEMBLY, instance, {3: data, 4: _fixed("Size", size)})
        _add(ClassId.CONNECTION_MANAGER, 1, {})
        _add(ClassId.QOS, 1, {number: self._dscp_attribute(number) for number in DSCP})
        values = _fixed_values(tcp_ip_values(interface, group))
        values[_CONTROL].write = self._keep_control
        values[_INACTIVITY] = _Value(
            "Inactivity", lambda: struct.pack("<H", self.inactivity_s), self._set_inactivity
        )
        _add(ClassId.TCP_IP, 1, values)
        for port in (1, 2):
            link = ethernet_link_values(port, interface.hardware_address)
            _add(ClassId.ETHERNET_LINK, port, _fixed_values(link))

    @property
    def explicit_dscp(self) -> int:
        """Return the code point for explicit messages."""
        return self._dscp[_EXPLICIT_DSCP]

    def dscp(self, priority: int) -> int:
        """Return the code point for packets of a connection with priority 0 (low) to 3 (urgent)."""
        return self._dscp[7 - priority]

    def require(self, path: Path) -> None:
        """Check that the object of `path` exists.

        Raises:
            Refusal: 0x05 if there is no such class or instance.
        """
        if self._find(path.class_id, path.instance) is None:
            raise Refusal(Status.PATH_DESTINATION_UNKNOWN)

    def get(self, class_id: int, instance: int, attribute: int | None) -> bytes:
        """Return the value of an attribute of an existing object.

        Raises:
            Refusal: 0x14 if there is no such attribute.
        """
        value: bytes = self._attribute(class_id, instance, attribute).produce()
        return value

    def set(self, path: Path, data: bytes) -> None:
        """Set the complete value of an attribute of an existing object.

        Raises:
            Refusal: 0x14 if there is no such attribute, 0x0E if it is read only, 0x13 if the value
                is too short, 0x15 if it is too long, 0x09 if it is invalid, 0x0C while a connection
                owns assembly 150, because it locks all attributes.
        """
        attribute = self._attribute(path.class_id, path.instance, path.attribute)
        if getattr(attribute, "write", None) is None:
            raise Refusal(Status.ATTRIBUTE_NOT_SETTABLE)
        length = len(attribute.read())
        if len(data) < length:
            raise Refusal(Status.NOT_ENOUGH_DATA)
        if len(data) > length:
            raise Refusal(Status.TOO_MUCH_DATA)
        if self._is_owned():
            raise Refusal(Status.OBJECT_STATE_CONFLICT)
        attribute.write(data)

    def perform(self, service: int, path: Path) -> bytes:
        """Let cpppo's object perform a service without data.

        Returns:
            The complete CIP reply.

        Raises:
            Refusal: 0x08 if the object does not support the service.
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

    def _attribute(self, class_id: int, instance: int, attribute: int | None) -> Any:
        # cpppo keeps the object itself as attribute 0.
        found = self._find(class_id, instance, attribute) if attribute else None
        if found is None:
            raise Refusal(Status.ATTRIBUTE_NOT_SUPPORTED)
        return found

    def _find(self, *path: int) -> Any:
        """Return an object or attribute, or None if it does not exist.

        An object that exists is cached.
        """
        found = self._found.get(path)
        if found is None:
            found = device.lookup(*map(int, path))
            if found is not None:
                self._found[path] = found
        return found

    def _keep_control(self, data: bytes) -> None:
        if any(data):
            raise Refusal(Status.INVALID_ATTRIBUTE_VALUE)

    def _set_inactivity(self, data: bytes) -> None:
        seconds = int.from_bytes(data, "little")
        if seconds > _MAX_INACTIVITY_S:
            raise Refusal(Status.INVALID_ATTRIBUTE_VALUE)
        self.inactivity_s = seconds

    def _dscp_attribute(self, number: int) -> _Value:
        def write(data: bytes) -> None:
            if data[0] > _MAX_DSCP:
                raise Refusal(Status.INVALID_ATTRIBUTE_VALUE)
            self._dscp[number] = data[0]

        return _Value(f"DSCP {number}", lambda: bytes([self._dscp[number]]), write)


def _add(class_id: ClassId, instance: int, attributes: Mapping[int, Any]) -> None:
    """Create an instance of a class; with its first instance, create the class itself."""
    _KINDS[class_id](instance_id=instance).attribute.update(
        {str(k): v for k, v in attributes.items()}
    )
    of_class = device.lookup(int(class_id), 0).attribute
    of_class["1"].value = REVISIONS[class_id]
    for number, value in ((6, _CLASS_ATTRIBUTES), (7, max(attributes, default=0))):
        of_class[str(number)] = device.Attribute("Maximum", parser.UINT, default=value)


def _fixed(name: str, value: bytes) -> _Value:
    return _Value(name, lambda: value)


def _fixed_values(values: Mapping[int, bytes]) -> dict[int, _Value]:
    return {number: _fixed(f"Attribute {number}", value) for number, value in values.items()}


def _identity_attributes(identity: Identity, status: Callable[[], int]) -> dict[int, Any]:
    revision = identity.major_revision | identity.minor_revision << 8
    values = (
        ("Vendor ID", parser.UINT, identity.vendor),
        ("Device Type", parser.UINT, identity.device_type),
        ("Product Code", parser.UINT, identity.product_code),
        ("Revision", parser.UINT, revision),
        ("Status", parser.WORD, 0),
        ("Serial Number", parser.UDINT, identity.serial_number),
        ("Product Name", parser.SSTRING, identity.product_name),
    )
    attributes = {
        number: device.Attribute(name, kind, default=value)
        for number, (name, kind, value) in enumerate(values, start=1)
    }
    attributes[5] = _Value("Status", lambda: struct.pack("<H", status()))
    # Get_Attributes_All leaves out the state, which ListIdentity and Get_Attribute_Single show.
    mask = device.Attribute.MASK_GA_ALL
    attributes[8] = device.Attribute("State", parser.USINT, default=_OPERATIONAL, mask=mask)
    return attributes
