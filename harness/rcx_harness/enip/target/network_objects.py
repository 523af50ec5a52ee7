"""Values of the objects that describe the network: TCP/IP Interface, Ethernet Link, QoS.

CIP volume 2, chapter 5: TCP/IP Interface (0xF5, revision 4), Ethernet Link (0xF6, revision 4) and
QoS (0x48, revision 1). A virtual controller has nothing to configure: the addresses are its
host's, and only what touches nobody else can be set.
"""

from __future__ import annotations

import ipaddress
import struct

from rcx_harness.enip.target.network_interface import NetworkInterface

__all__ = [
    "DSCP",
    "ETHERNET_LINK",
    "QOS",
    "TCP_IP",
    "ethernet_link_values",
    "tcp_ip_values",
]

QOS, TCP_IP, ETHERNET_LINK = 0x48, 0xF5, 0xF6

DSCP = {4: 55, 5: 47, 6: 43, 7: 31, 8: 27}
"""Attributes of the QoS object with their initial code points: urgent, scheduled, high and low
priority, explicit messages."""

_CONFIGURED = 1  # status: the interface configuration is valid
_FULL_DUPLEX_UP = 0x0F  # link up, full duplex, negotiated (3 in bits 2 to 4)
_MBIT = 100
_NEGOTIATE = 1
_TWISTED_PAIR = 2
_ENABLED, _DISABLED = 1, 2
_CAN_NEGOTIATE = 0x02
_SPEEDS = ((10, 0), (10, 1), (100, 0), (100, 1))  # Mbit/s, full duplex


def tcp_ip_values(interface: NetworkInterface, group: str) -> dict[int, bytes]:
    """Attributes 1 to 12 of the TCP/IP Interface object.

    Args:
        interface: The adapter's own.
        group: First multicast address.
    """
    address = _number(interface.address) + _number(interface.netmask) + bytes(12)
    return {
        1: struct.pack("<I", _CONFIGURED),
        2: bytes(4),  # configuration capability: none
        3: bytes(4),  # configuration control: a fixed address
        4: bytes(2),  # physical link object: two of them, behind the module's switch
        5: address + bytes(2),  # gateway, name servers and domain name: none
        6: bytes(2),  # host name: none
        7: bytes(6),  # safety network number
        8: bytes([1]),  # time to live of multicast packets
        9: struct.pack("<BxH", 0, 1) + _number(group),  # allocated by address, one
        10: bytes(1),  # address conflict detection: off
        11: bytes(35),  # last conflict: none
        12: bytes(1),  # quick connect: off
    }


def ethernet_link_values(port: int, hardware_address: bytes) -> dict[int, bytes]:
    """Attributes 1 to 11 of an Ethernet Link instance.

    The module has two connectors, 10Base-T or 100Base-TX (manual chapter 1, 3.1); the first is
    the one that is plugged in.

    Args:
        port: Number of the connector, 1 or 2.
        hardware_address: Six bytes.
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
