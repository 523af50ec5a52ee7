"""The properties of the network interface with a given address.

Linux reports all properties. On other systems the netmask is guessed and the rest is unknown
(zero). The unknown properties affect only the CIP attributes that show them.
"""

from __future__ import annotations

import ipaddress
import socket
from dataclasses import dataclass

from structured_text.output.system import addresses

__all__ = ["ANY", "NetworkInterface", "address_toward", "find_interface"]

_NO_HARDWARE_ADDRESS = bytes(6)
# An address for documentation (RFC 5737), which is outside any local network.
_ELSEWHERE = "192.0.2.1"

ANY = "0.0.0.0"
"""The address that stands for all addresses of this machine."""


@dataclass(frozen=True)
class NetworkInterface:
    """An IPv4 address with its netmask and hardware address."""

    address: str = "127.0.0.1"
    netmask: str = "255.0.0.0"
    hardware_address: bytes = _NO_HARDWARE_ADDRESS

    def broadcast_addresses(self) -> tuple[str, ...]:
        """Return the broadcast addresses of the network; on loopback only the directed address."""
        network = ipaddress.IPv4Network((self.address, self.netmask), strict=False)
        directed = str(network.broadcast_address)
        if network.is_loopback or directed == "255.255.255.255":
            return (directed,)
        return directed, "255.255.255.255"


def address_toward(local: str, peer: str = _ELSEWHERE) -> str:
    """Return our address for a peer: `local`, or for `ANY` the address of the route to the peer."""
    if local != ANY:
        return local
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            # `connect` on a UDP socket only selects the route; it sends nothing
            probe.connect((peer, 9))
        except OSError:  # no route to the peer
            return "127.0.0.1"
        return str(probe.getsockname()[0])


def find_interface(address: str) -> NetworkInterface:
    """Return the interface of an IPv4 address of this machine."""
    wanted = ipaddress.IPv4Address(address)
    for own, netmask, hardware in addresses():
        # Use only the first address; further addresses usually belong to the same network.
        if wanted in ipaddress.IPv4Network((own, netmask), strict=False):
            return NetworkInterface(address, netmask, hardware)
    return NetworkInterface(address, "255.0.0.0" if wanted.is_loopback else "255.255.255.0")
