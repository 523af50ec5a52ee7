"""The bridge opens, keeps and replaces its connection to the robot."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator

import pytest

from fake_scanner import FakeScanner
from rcx_harness.bridge.core import Lost
from rcx_harness.bridge.loop import RobotLink
from rcx_harness.enip.cyclic.connections import EndReason, OwnerState
from rcx_harness.enip.errors import CipError, EnipError
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from structured_text.errors import InputError

_MOST_POLLS = 60_000


class Network:
    """A simulated network in which each new connection uses the next of the given scanners."""

    def __init__(self, *scanners: FakeScanner) -> None:
        self.scanners = list(scanners)
        self.link = RobotLink("robot", 48, self.connect)

    def connect(self) -> FakeScanner:
        """Return the next scanner, or raise EnipError if no scanner is left."""
        if not self.scanners:
            raise EnipError("nobody there")
        return self.scanners.pop(0)


def test_the_first_packet_of_a_connection_is_zero() -> None:
    scanner = FakeScanner()
    Network(scanner).link.opener.open()
    assert scanner.done == ["write", "open"]
    assert scanner.written == [(bytes(48), None)]


def test_the_robot_is_lost_until_its_first_packet() -> None:
    scanner = FakeScanner()
    link = Network(scanner).link
    assert link.read() == Lost("robot: not connected yet")
    link.opener.open()
    assert link.read() == Lost("robot: no packets have arrived yet")
    scanner.dropped = "of a wrong length (20 bytes instead of 50)"
    assert link.read() == Lost(
        "robot: packets arrive, but cannot be used: they are "
        "of a wrong length (20 bytes instead of 50)"
    )
    scanner.connected = True
    assert link.read() == bytes([7] * 48)


@pytest.mark.parametrize("end", ["timed out", "process"])
def test_a_connection_that_has_ended_is_replaced(end: str) -> None:
    first, second = FakeScanner(), FakeScanner()
    link = Network(first, second).link
    link.opener.open()
    if end == "process":
        first.failure = "the process of the cyclic I/O has ended by itself (killed by SIGKILL)"
        assert link.read() == Lost(f"robot: {first.failure}; it is started again")
    else:
        first.ended = EndReason.TIMED_OUT
        assert link.read() == Lost("robot: the connection has ended: timed out")
    link.opener.keep()
    assert first.done[-1] == "close"
    assert second.done == ["write", "open"]


def test_without_a_robot_the_reason_is_reported_after_each_retry() -> None:
    link = Network().link
    link.opener.keep()
    link.opener.keep()
    assert link.read() == Lost("nobody there")
    assert link.look() is None
    link.write(bytes(48), None)
    link.close()


def test_a_refusal_closes_the_scanner_and_says_what_to_do() -> None:
    scanner = FakeScanner(CipError("the connection (Forward Open)", 1, (0x106,)))
    link = Network(scanner).link
    with pytest.raises(InputError) as refused:
        link.opener.open()
    assert scanner.done[-1] == "close"
    assert "0x0106, another master owns the outputs" in str(refused.value)
    assert str(refused.value).endswith(
        "; another master owns the robot: disconnect that master first"
    )


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    with Adapter(48, cyclic=0, options=AdapterOptions(rpi_min_us=1_000)) as made:
        yield made


@pytest.fixture
def link(adapter: Adapter) -> Iterator[RobotLink]:
    def connect() -> Scanner:
        host, port = adapter.address
        return Scanner(host, 48, 2_000, port=port, io_port=0, multiplier=7)

    made = RobotLink("robot", 48, connect)
    yield made
    made.close()


def until(what: Callable[[], bool]) -> None:
    """Poll every millisecond until the condition is true."""
    pause = threading.Event()
    for _ in range(_MOST_POLLS):
        if what():
            return
        pause.wait(0.001)
    raise AssertionError("the condition did not become true")


def received(link: RobotLink) -> int:
    """Return the number of packets that the bridge has received from the adapter."""
    look = link.look()
    return look[0].received if look else 0


def test_words_pass_in_both_directions(adapter: Adapter, link: RobotLink) -> None:
    adapter.write_to_master(bytes(range(48)))
    link.opener.open()
    link.write(bytes(range(100, 148)), 60_000_000)
    until(lambda: adapter.read_to_robot() == bytes(range(100, 148)))
    until(lambda: link.read() == bytes(range(48)))


@pytest.mark.exhaustive
def test_expired_words_are_not_sent_until_new_words_come(adapter: Adapter, link: RobotLink) -> None:
    """If the PLC stops writing, its words expire and the robot receives no more packets.

    The test waits for twenty packets from the robot, so twenty could have been sent.
    """
    link.opener.open()
    until(lambda: adapter.shared.owner is OwnerState.RUN)
    link.write(bytes([1] * 48), 0)
    before = received(link)
    until(lambda: received(link) >= before + 2)  # wait for packets that were already sent
    arrived = adapter.shared.status().received
    until(lambda: received(link) >= before + 22)
    assert adapter.shared.status().received == arrived
    link.write(bytes([2] * 48), None)
    until(lambda: adapter.read_to_robot() == bytes([2] * 48))
