"""What the machine tells of the network interface that has an address.

Linux tells all; elsewhere the netmask is guessed and the rest is unknown (zero), which costs only
the answers about it.
"""

from __future__ import annotations

import ipaddress
import socket
import struct
import sys
from dataclasses import dataclass

__all__ = ["ANY", "NetworkInterface", "address_toward", "find_interface"]

_GET_ADDRESS, _GET_NETMASK, _GET_HARDWARE_ADDRESS = 0x8915, 0x891B, 0x8927
_NO_HARDWARE_ADDRESS = bytes(6)
# Of the addresses for documentation (RFC 5737): somewhere beyond the own network.
_ELSEWHERE = "192.0.2.1"

ANY = "0.0.0.0"
"""Listens on all addresses of this machine, and is none of them."""


@dataclass(frozen=True)
class NetworkInterface:
    """An IPv4 address and what belongs to it.

    Attributes:
        address: Of the adapter.
        netmask: Of its network.
        hardware_address: Six bytes.
    """

    address: str = "127.0.0.1"
    netmask: str = "255.0.0.0"
    hardware_address: bytes = _NO_HARDWARE_ADDRESS

    def broadcast_addresses(self) -> tuple[str, ...]:
        """Where a broadcast to its network may be sent to; on the loopback only its own."""
        network = ipaddress.IPv4Network((self.address, self.netmask), strict=False)
        directed = str(network.broadcast_address)
        if network.is_loopback or directed == "255.255.255.255":
            return (directed,)
        return directed, "255.255.255.255"


def address_toward(local: str, peer: str = _ELSEWHERE) -> str:
    """Our address as this peer knows it: `local`, or the one that leads there if it is `ANY`."""
    if local != ANY:
        return local
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect((peer, 9))  # finds the way, and sends nothing
        except OSError:  # no way there
            return "127.0.0.1"
        return str(probe.getsockname()[0])


def find_interface(address: str) -> NetworkInterface:
    """The interface of an IPv4 address of this machine."""
    if sys.platform == "linux":
        wanted = ipaddress.IPv4Address(address)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
            for _, name in socket.if_nameindex():
                try:
                    own = _ask(any_socket, name, _GET_ADDRESS)[4:8]
                    mask = _ask(any_socket, name, _GET_NETMASK)[4:8]
                    hardware = _ask(any_socket, name, _GET_HARDWARE_ADDRESS)[2:8]
                except OSError:
                    continue  # without an IPv4 address, or gone
                netmask = str(ipaddress.IPv4Address(mask))
                # Only the first address is told; further ones are of the same network, as a rule.
                if wanted in ipaddress.IPv4Network((own, netmask), strict=False):
                    return NetworkInterface(address, netmask, hardware)
    loopback = ipaddress.IPv4Address(address).is_loopback
    return NetworkInterface(address, "255.0.0.0" if loopback else "255.255.255.0")


def _ask(any_socket: socket.socket, name: str, question: int) -> bytes:
    """A `struct sockaddr` about an interface by ioctl: family, then port or hardware address."""
    if sys.platform != "linux":  # pragma: no cover
        raise OSError("only Linux is asked")
    import fcntl

    request = struct.pack("256s", name.encode()[:15])
    return fcntl.ioctl(any_socket.fileno(), question, request)[16:32]
