"""Several class 1 connections work at the same time: input only, listen only, multicast.

Times are in microseconds. The connections and their packets are in `exchange_bench`.
"""

from __future__ import annotations

import pytest

from exchange_bench import (
    DATA,
    GROUP,
    IMAGE,
    INPUT_ONLY,
    LISTEN_ONLY,
    MASTER,
    OTHER,
    OWNER,
    Device,
    heartbeat,
    multicast,
    packet,
)
from rcx_harness.enip.cyclic.connections import (
    ConnectionParameters,
    EndReason,
    OwnerState,
    multicast_address,
)

# Tests of input-only and listen-only connections


def test_input_only_receives_the_outputs_and_owns_nothing(device: Device) -> None:
    device.exchange.add(INPUT_ONLY, 0)
    device.images.to_master.write(IMAGE)
    device.poll(10_000)
    assert device.sent[0][0] == bytes.fromhex(
        f"0200 0280 0800 44444444 01000000 B100 3200 0100 {DATA}"
    )
    assert device.exchange.receive(heartbeat(1, "33333333"), OTHER, 0)
    status = device.images.status()
    assert status.owner is OwnerState.NONE
    assert (status.owners, status.input_only, status.received) == (0, 1, 1)
    assert device.images.to_robot.version == 0, "a heartbeat writes nothing"


@pytest.mark.parametrize("content", ["0000", "0200 0000"])
def test_a_heartbeat_of_no_or_two_bytes_keeps_the_connection(device: Device, content: str) -> None:
    device.exchange.add(INPUT_ONLY, 0)
    beat = bytes.fromhex(f"0200 0280 0800 33333333 01000000 B100 {content}")
    assert device.exchange.receive(beat, OTHER, 9_990_000)
    device.poll(10_149_999)
    assert device.ended == []
    device.poll(10_150_000)
    assert device.ended == [(2, EndReason.TIMED_OUT)]


def test_the_end_of_an_owner_leaves_an_input_only_connection_alone(owned: Device) -> None:
    owned.exchange.add(INPUT_ONLY, 0)
    owned.exchange.remove(1, 0)
    owned.poll(20_000)
    assert owned.destinations() == [OTHER]
    assert owned.ended == []


@pytest.mark.parametrize("companion", [OWNER, INPUT_ONLY])
def test_listen_only_ends_with_the_last_connection_of_another_kind(
    device: Device, companion: ConnectionParameters
) -> None:
    device.exchange.add(companion, 0)
    device.exchange.add(LISTEN_ONLY, 0)
    device.exchange.remove(companion.number, 0)
    assert device.ended == [(3, EndReason.NO_OWNER)]
    assert device.images.status().connections == 0


def test_listen_only_continues_while_another_connection_is_open(owned: Device) -> None:
    owned.exchange.add(INPUT_ONLY, 0)
    owned.exchange.add(LISTEN_ONLY, 0)
    owned.exchange.remove(1, 0)
    assert owned.ended == []
    assert owned.images.status().listen_only == 1
    owned.exchange.remove(2, 0)
    assert owned.ended == [(3, EndReason.NO_OWNER)]


def test_a_listener_that_times_out_ends_no_other_connection(owned: Device) -> None:
    owned.exchange.add(LISTEN_ONLY, 0)
    owned.exchange.receive(packet(1, 1), MASTER, 9_900_000)
    owned.poll(10_000_000)
    assert owned.ended == [(3, EndReason.TIMED_OUT)]
    assert owned.owner() is OwnerState.RUN


# Multicast


def test_one_packet_serves_all_multicast_connections(device: Device) -> None:
    for one in (OWNER, INPUT_ONLY, LISTEN_ONLY):
        device.exchange.add(multicast(one), 0)
    device.poll(10_000)
    assert [one[0][6:14].hex() for one in device.sent] == ["0a0a0a0a01000000"]
    assert device.destinations() == [GROUP]


def test_a_connection_that_joins_later_gets_the_next_numbers(device: Device) -> None:
    device.exchange.add(multicast(OWNER), 0)
    device.poll(10_000)
    device.exchange.add(multicast(INPUT_ONLY), 15_000)
    device.poll(15_000)
    device.poll(20_000)
    assert [one[0][10:14].hex() for one in device.sent] == ["01000000", "02000000"]


def test_multicast_continues_while_one_connection_is_open(device: Device) -> None:
    for one in (OWNER, INPUT_ONLY):
        device.exchange.add(multicast(one), 0)
    device.exchange.remove(1, 0)
    device.poll(10_000)
    assert device.destinations() == [GROUP]
    device.exchange.remove(2, 0)
    assert device.poll(20_000) is None
    assert device.destinations() == []


def test_multicast_has_the_shortest_interval_of_all_connections(device: Device) -> None:
    device.exchange.add(multicast(OWNER, 20_000), 0)
    device.exchange.add(multicast(INPUT_ONLY, 5_000), 0)
    device.exchange.add(multicast(LISTEN_ONLY, 40_000), 0)
    assert device.poll(10_000) == 15_000
    device.exchange.remove(2, 0)
    device.poll(15_000)
    device.destinations()
    device.poll(34_999)
    assert device.destinations() == []
    device.poll(35_000)
    assert device.destinations() == [GROUP]


def test_point_to_point_packets_are_sent_in_addition_to_multicast(device: Device) -> None:
    device.exchange.add(multicast(OWNER), 0)
    device.exchange.add(INPUT_ONLY, 0)
    device.poll(10_000)
    assert device.destinations() == [GROUP, OTHER]


@pytest.mark.parametrize(
    ("host", "netmask", "group"),
    [
        ("192.168.0.1", "255.255.255.0", "239.192.1.0"),
        ("192.168.0.2", "255.255.255.0", "239.192.1.32"),
        ("192.168.0.9", "255.255.255.0", "239.192.2.0"),
        ("192.168.0.254", "255.255.255.0", "239.192.32.160"),
        ("10.0.4.0", "255.0.0.0", "239.192.128.224"),
        ("10.0.4.1", "255.0.0.0", "239.192.1.0"),  # host number 1025 has the group of host number 1
        ("127.0.0.1", "255.0.0.0", "239.192.1.0"),
    ],
)
def test_the_multicast_group_follows_from_the_host_number(
    host: str, netmask: str, group: str
) -> None:
    """Each host has a block of 32 groups, starting with host number 1 at 239.192.1.0.

    Source: EtherNet/IP adaptation of CIP (volume 2), chapter 3.
    """
    assert multicast_address(host, netmask) == group
