"""A scanner sends and accepts packets of class 1 connections at the right times.

The tests use literal packets and virtual time, without sockets. Times are in microseconds. The
connections and their packets are in `exchange_bench`.
"""

from __future__ import annotations

import json
from dataclasses import asdict, replace

import pytest

from exchange_bench import (
    DATA,
    IMAGE,
    INPUT_ONLY,
    LISTEN_ONLY,
    OWNER,
    ROBOT,
    Device,
    multicast,
)
from rcx_harness.enip.cyclic.connections import ConnectionParameters, EndReason, OwnerState
from rcx_harness.enip.cyclic.exchange import Role
from rcx_harness.enip.cyclic.shared import SharedImages


@pytest.fixture
def scanner(images: SharedImages) -> Device:
    """Return a scanner with an exclusive owner connection to the robot, opened at time 0."""
    device = Device(images, Role.ORIGINATOR)
    device.exchange.add(replace(OWNER, peer=ROBOT, destination=ROBOT), 0)
    return device


def from_robot(number: int) -> bytes:
    count = number.to_bytes(4, "little").hex()
    return bytes.fromhex(f"0200 0280 0800 22222222 {count} B100 3200 0100 {DATA}")


@pytest.mark.parametrize(("run", "header"), [(True, "01000000"), (False, "00000000")])
def test_a_scanner_sends_assembly_150_with_its_run_or_idle_state(
    scanner: Device, run: bool, header: str
) -> None:
    scanner.images.to_robot.write(IMAGE)
    scanner.images.run = run
    scanner.poll(0)
    expected = f"0200 0280 0800 11111111 01000000 B100 3600 0100 {header} {DATA}"
    assert scanner.sent == [(bytes.fromhex(expected), (ROBOT, 2222), 0)]


def test_a_scanner_receives_assembly_100_and_is_then_connected(scanner: Device) -> None:
    assert scanner.owner() is OwnerState.WAITING
    assert scanner.exchange.receive(from_robot(1), ROBOT, 0)
    assert scanner.images.to_master.read() == IMAGE
    assert scanner.owner() is OwnerState.RUN


def test_a_scanner_that_is_connected_has_the_data_and_their_time(
    scanner: Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """When a reader sees RUN, the image and its arrival time are already written.

    Another process may read between any two of the writes.
    """
    seen: list[tuple[OwnerState, int, bytes]] = []

    def set_owner(images: SharedImages, state: OwnerState, _: ConnectionParameters | None) -> None:
        seen.append((state, images.arrived_us, images.to_master.read()))

    monkeypatch.setattr(SharedImages, "set_owner", set_owner)
    scanner.exchange.receive(from_robot(1), ROBOT, 7_000)
    assert seen == [(OwnerState.RUN, 7_000, IMAGE)]


def test_the_time_out_of_a_scanner_uses_the_robots_interval(images: SharedImages) -> None:
    """The time-out is 16 times the robot's interval of 2 ms, not the scanner's 100 ms."""
    scanner = Device(images, Role.ORIGINATOR)
    one = replace(OWNER, o_to_t_api_us=100_000, t_to_o_api_us=2_000)
    scanner.exchange.add(replace(one, peer=ROBOT, destination=ROBOT), 0)
    scanner.exchange.receive(from_robot(1), ROBOT, 0)
    assert scanner.poll(0) == 32_000
    scanner.poll(31_999)
    assert scanner.owner() is OwnerState.RUN
    scanner.poll(32_000)
    assert scanner.owner() is OwnerState.TIMED_OUT
    assert scanner.ended == [(1, EndReason.TIMED_OUT)]


def test_a_scanner_that_owns_nothing_sends_a_heartbeat(images: SharedImages) -> None:
    scanner = Device(images, Role.ORIGINATOR)
    scanner.exchange.add(replace(INPUT_ONLY, peer=ROBOT, destination=ROBOT), 0)
    scanner.poll(0)
    expected = "0200 0280 0800 33333333 01000000 B100 0200 0100"
    assert [one[0] for one in scanner.sent] == [bytes.fromhex(expected)]
    beat = bytes.fromhex(f"0200 0280 0800 44444444 01000000 B100 3200 0100 {DATA}")
    assert scanner.exchange.receive(beat, ROBOT, 0)
    assert scanner.owner() is OwnerState.RUN


def test_a_scanner_alone_may_listen_only(images: SharedImages) -> None:
    """A scanner's listen-only connection continues alone; the adapter decides when it must end."""
    scanner = Device(images, Role.ORIGINATOR)
    for one in (INPUT_ONLY, LISTEN_ONLY):
        scanner.exchange.add(replace(one, peer=ROBOT, destination=ROBOT), 0)
    scanner.exchange.remove(INPUT_ONLY.number, 0)
    scanner.poll(0)
    assert scanner.ended == []
    assert [one[0][6:10].hex() for one in scanner.sent] == ["55555555"]


def test_parameters_go_through_the_pipe_unchanged() -> None:
    one = replace(multicast(LISTEN_ONLY), dscp=47)
    message = json.loads(json.dumps(asdict(one)))
    assert ConnectionParameters.from_message(message) == one
