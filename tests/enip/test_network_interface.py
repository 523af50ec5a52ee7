from __future__ import annotations

import sys

import pytest

from rcx_harness.enip.target.network_interface import (
    ANY,
    NetworkInterface,
    address_toward,
    find_interface,
)


@pytest.mark.parametrize(
    ("address", "netmask", "broadcasts"),
    [
        ("127.0.0.5", "255.0.0.0", ("127.255.255.255",)),
        ("192.168.0.2", "255.255.255.0", ("192.168.0.255", "255.255.255.255")),
        ("10.1.2.3", "255.255.240.0", ("10.1.15.255", "255.255.255.255")),
    ],
)
def test_an_interface_has_its_broadcast_addresses(
    address: str, netmask: str, broadcasts: tuple[str, ...]
) -> None:
    assert NetworkInterface(address, netmask).broadcast_addresses() == broadcasts


@pytest.mark.parametrize("address", ["127.0.0.1", "127.1.2.3"])
def test_the_loopback_has_all_its_addresses(address: str) -> None:
    assert find_interface(address) == NetworkInterface(address, "255.0.0.0", bytes(6))


def test_an_adapter_on_all_addresses_has_the_address_that_reaches_the_peer() -> None:
    assert address_toward(ANY, "127.0.0.9") == "127.0.0.1"
    assert address_toward("127.0.0.2", "127.0.0.9") == "127.0.0.2"
    assert address_toward(ANY) != ANY


def test_without_a_route_the_address_is_the_loopback() -> None:
    """If the system refuses a route, here to a broadcast address, the loopback address is used."""
    assert address_toward(ANY, "255.255.255.255") == "127.0.0.1"


def test_an_address_of_no_interface_gets_a_guessed_netmask() -> None:
    """An address that no interface has gets the netmask 255.255.255.0.

    The addresses 203.0.113.0/24 are reserved for documentation.
    """
    assert find_interface("203.0.113.77") == NetworkInterface("203.0.113.77", "255.255.255.0")


@pytest.mark.skipif(sys.platform != "linux", reason="what Linux tells is left out")
def test_on_other_systems_the_netmask_is_guessed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "platform", "other")
    assert find_interface("127.0.0.1").netmask == "255.0.0.0"
