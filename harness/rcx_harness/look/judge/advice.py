"""The advice for a capture in which no connection of a controller was found."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rcx_harness.enip.cyclic.connections import RUN_IDLE_SIZE, SEQUENCE_SIZE
from rcx_harness.look.judge.capture import host_text
from rcx_harness.look.judge.network import Network
from rcx_harness.spec.wire import AREA_SIZES

__all__ = ["advice"]

_MOST_HOSTS = 6
_TO_ROBOT = SEQUENCE_SIZE + RUN_IDLE_SIZE
_AREAS = " or ".join(map(str, AREA_SIZES))


def advice(network: Network, hosts: Collection[bytes], sizes: Collection[int]) -> str:
    """Return the advice for a recording without a connection.

    `hosts` has the addresses from --controller. `sizes` has the sizes of areas that were tried.
    """
    if not network.cyclic:
        return "capture TCP port 44818 and UDP port 2222 at a mirror port, or with rcx record"
    if hosts:
        return _of_named(network, hosts, sizes)
    for one in network.strangers.values():
        if one.length - _TO_ROBOT in sizes:
            return f"perhaps --controller {host_text(one.destination)}"
    for host, _, size in _pairs(network):
        return _other_size(host, size, sizes)
    return "name the controller with --controller, or begin before the PLC connects"


def _of_named(network: Network, hosts: Collection[bytes], sizes: Collection[int]) -> str:
    """Return the reason why the named controllers were not found."""
    for host, master, size in _pairs(network):
        if host in hosts:
            return _other_size(host, size, sizes)
        if master in hosts:
            return f"{host_text(master)} is the master: perhaps --controller {host_text(host)}"
    for one in network.strangers.values():
        for host, header in ((one.destination, _TO_ROBOT), (one.source, SEQUENCE_SIZE)):
            if host in hosts and one.length > header:
                return _other_size(host, one.length - header, sizes)
    strangers = network.strangers.values()
    ends = {one.source for one in strangers} | {one.destination for one in strangers}
    if ends.intersection(hosts):
        return "its packets contain no areas: record the connection of its master, too"
    named = ", ".join(map(host_text, hosts))
    shown = sorted(ends)[:_MOST_HOSTS]
    others = ", ".join(map(host_text, shown)) + (", ..." if len(ends) > len(shown) else "")
    return f"the capture has no class 1 packet to or from {named}, only packets of {others}"


def _pairs(network: Network) -> Iterator[tuple[bytes, bytes, int]]:
    """Yield device, master and size for each pair of hosts that exchange areas of the same size."""
    strangers = list(network.strangers.values())
    for one in strangers:
        size = one.length - _TO_ROBOT
        for other in strangers:
            answers = (other.source, other.destination) == (one.destination, one.source)
            if size > 0 and answers and other.length - SEQUENCE_SIZE == size:
                yield one.destination, one.source, size


def _other_size(host: bytes, size: int, sizes: Collection[int]) -> str:
    if size in AREA_SIZES and size not in sizes:
        return f"the areas of {host_text(host)} have {size} bytes: --size {size}"
    return (
        f"the areas of {host_text(host)} have {size} bytes, those of a controller {_AREAS}: set "
        "one of these in controller and PLC, unless it is another device"
    )
