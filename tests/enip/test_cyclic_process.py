"""The process of the cyclic I/O sends and receives the right packets over real sockets.

The tests do not check times. They simulate the master with a UDP socket. To wait for an effect, a
test counts the robot's packets, which arrive every 4 ms. The limit is so high that even a slow
computer does not reach it.
"""

from __future__ import annotations

import os
import queue
import signal
import socket
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass, field, replace

import pytest

import exchange_bench
from exchange_bench import IMAGE
from rcx_harness.enip.cyclic.connections import (
    ConnectionKind,
    ConnectionParameters,
    EndReason,
    OwnerState,
)
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.cyclic.shared import LinkState, SharedImages
from rcx_harness.enip.errors import EnipError

ROBOT, MASTER, STRANGER = "127.5.0.1", "127.5.0.2", "127.5.0.3"
GENEROUS_S = 60.0
_IP_RECVTTL = 12  # the number of IP_RECVTTL on Linux; Python does not define the name

OWNER = replace(
    exchange_bench.OWNER,
    o_to_t_api_us=4_000,
    t_to_o_api_us=4_000,
    multiplier=7,
    peer=MASTER,
    destination=MASTER,
)


def packet(number: int, identifier: str = "11111111") -> bytes:
    """Return a packet of a master in RUN. Both sequence numbers of the packet are `number`."""
    return exchange_bench.packet(number, number, identifier)


def udp(host: str) -> socket.socket:
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    one.bind((host, 0))
    one.settimeout(GENEROUS_S)
    one.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 20)
    return one


@dataclass
class Target:
    """The process under test, and the UDP socket of the simulated master."""

    images: SharedImages
    socket: socket.socket
    ended: queue.Queue[tuple[int, EndReason]] = field(default_factory=queue.Queue)

    def __post_init__(self) -> None:
        self.control = CyclicControl(self.images.name, ROBOT, 0, lambda *end: self.ended.put(end))
        self.port = self.socket.getsockname()[1]

    def open(self, parameters: ConnectionParameters = OWNER) -> None:
        """Open a connection that sends its packets to the master's socket."""
        self.control.add(replace(parameters, destination_port=self.port))

    def send(self, datagram: bytes) -> None:
        """Send a datagram from the master's socket to the process."""
        self.socket.sendto(datagram, (ROBOT, self.control.port))

    def receive(self) -> bytes:
        """Wait for the robot's next packet, and return it."""
        datagram, (host, port) = self.socket.recvfrom(2048)
        assert (host, port) == (ROBOT, self.control.port)
        return datagram

    def receive_until(self, condition: Callable[[], bool]) -> None:
        """Receive packets of the robot until the condition is true."""
        for _ in range(10_000):
            if condition():
                return
            self.receive()
        raise AssertionError("the condition did not become true within 10,000 packets")


@pytest.fixture
def target() -> Iterator[Target]:
    with SharedImages.create(48) as images, udp(MASTER) as master:
        target = Target(images, master)
        images.unlink()
        with target.control:
            yield target


def test_packets_are_sent_in_sequence_with_the_robots_outputs(target: Target) -> None:
    target.images.to_master.write(IMAGE)
    target.open()
    received = [target.receive() for _ in range(30)]
    assert received == [
        bytes.fromhex(
            f"0200 0280 0800 22222222 {number.to_bytes(4, 'little').hex()}"
            f"B100 3200 0100 {IMAGE.hex()}"
        )
        for number in range(1, 31)
    ]


def test_a_packet_right_after_the_order_to_open_is_accepted(target: Target) -> None:
    """A packet is accepted even if it arrives before the process has read the order to open."""
    target.open(replace(OWNER, number=1_000))
    with udp(STRANGER) as stranger:
        for number in range(1, 101):
            for _ in range(60):
                stranger.sendto(b"\xff" * 60, (ROBOT, target.control.port))
            rare = replace(OWNER, number=number, o_to_t_id=number, t_to_o_api_us=3_200_000)
            target.open(rare)
            target.send(packet(1, identifier=number.to_bytes(4, "little").hex()))
            target.receive_until(lambda: target.images.status().received == number)  # noqa: B023


def test_packets_from_another_port_of_the_master_arrive_in_assembly_150(target: Target) -> None:
    """Packets of the master are accepted from any source port."""
    target.open()
    with udp(MASTER) as other:
        other.sendto(packet(1), (ROBOT, target.control.port))
    target.receive_until(lambda: target.images.owner is OwnerState.RUN)
    assert target.images.to_robot.read() == IMAGE


def test_packets_of_strangers_and_garbage_are_counted_and_change_nothing(target: Target) -> None:
    target.open()
    with udp(STRANGER) as stranger:
        stranger.sendto(packet(1), (ROBOT, target.control.port))
        for number in range(9):
            stranger.sendto(b"\xff" * 200 * number, (ROBOT, target.control.port))
        stranger.sendto(packet(1, identifier="99999999"), (ROBOT, target.control.port))
    target.receive_until(lambda: target.images.status().dropped == 11)
    assert target.images.to_robot.version == 0
    assert target.images.owner is OwnerState.WAITING


def test_a_flood_of_garbage_does_not_stop_the_robots_packets(target: Target) -> None:
    target.open()
    numbers = []
    with udp(STRANGER) as stranger:
        for _ in range(30):
            for _ in range(100):
                stranger.sendto(b"\xff" * 1400, (ROBOT, target.control.port))
            numbers.append(int.from_bytes(target.receive()[10:14], "little"))
    assert numbers == list(range(1, 31))


def test_silence_is_reported_with_the_connections_number(target: Target) -> None:
    target.open(replace(OWNER, number=77, o_to_t_api_us=1_000, multiplier=5))
    target.send(packet(1))
    assert target.ended.get(timeout=GENEROUS_S) == (77, EndReason.TIMED_OUT)
    assert target.images.owner is OwnerState.TIMED_OUT


def test_a_closed_connection_is_not_served_any_more(target: Target) -> None:
    target.open()
    target.open(replace(OWNER, number=2, t_to_o_id=0x33333333, kind=ConnectionKind.INPUT_ONLY))
    target.control.remove(1)
    target.receive_until(lambda: target.images.owner is OwnerState.CLOSED)
    # The first of these packets may have been sent before the connection was closed.
    identifiers: list[str] = []
    while identifiers.count("33333333") < 20:
        identifiers.append(target.receive()[6:10].hex())
    assert set(identifiers[-10:]) == {"33333333"}
    assert target.ended.empty()


def test_a_cut_cable_leads_to_a_time_out(target: Target) -> None:
    target.open(replace(OWNER, o_to_t_api_us=1_000))
    target.send(packet(1))
    target.receive_until(lambda: target.images.status().received == 1)
    target.images.link = LinkState.CUT
    # The master continues to send, but the link is cut, so the connection times out.
    for number in range(2, 20_000):
        target.send(packet(number))
        with suppress(queue.Empty):
            assert target.ended.get(timeout=0.001) == (1, EndReason.TIMED_OUT)
            break
    else:
        raise AssertionError("the connection did not time out within 20,000 packets")
    target.socket.setblocking(False)
    last = b""
    with suppress(BlockingIOError):
        while True:
            last = target.socket.recv(2048)
    produced = target.images.status().sent
    assert int.from_bytes(last[10:14], "little") < produced, "packets arrived through the cut"


def test_an_adapter_switched_off_has_lost_its_connections(target: Target) -> None:
    target.open()
    target.receive()
    target.images.link = LinkState.OFF
    assert target.ended.get(timeout=GENEROUS_S) == (1, EndReason.OFF)
    target.images.link = LinkState.UP
    target.open(replace(OWNER, number=2, t_to_o_id=0x33333333))
    while target.receive()[6:14].hex() != "3333333305000000":
        pass  # packets of the first connection may still arrive


def test_multicast_packets_reach_the_group_and_leave_no_network(target: Target) -> None:
    """Multicast packets reach the group. Their time to live is 1, so no router forwards them."""
    group = "239.192.5.32"
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    listener.bind((group, 0))
    membership = socket.inet_aton(group) + socket.inet_aton(MASTER)
    listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
    listener.setsockopt(socket.IPPROTO_IP, _IP_RECVTTL, 1)
    listener.settimeout(GENEROUS_S)
    with listener:
        port = listener.getsockname()[1]
        parameters = replace(OWNER, multicast=True, destination=group, destination_port=port)
        target.control.add(parameters)
        datagram, ancillary, _, (host, _) = listener.recvmsg(2048, 64)
    assert host == ROBOT
    assert datagram[6:14].hex() == "2222222201000000"
    assert [(kind, data[0]) for _, kind, data in ancillary] == [(socket.IP_TTL, 1)]


def test_packets_carry_the_code_point_that_was_agreed(target: Target) -> None:
    """Packets have the agreed code point 47 in the upper six bits of their TOS byte (0xBC)."""
    target.socket.setsockopt(socket.IPPROTO_IP, socket.IP_RECVTOS, 1)
    target.open(replace(OWNER, dscp=47))
    _, ancillary, _, _ = target.socket.recvmsg(2048, 64)
    assert [(kind, data[0]) for _, kind, data in ancillary] == [(socket.IP_TOS, 0xBC)]


def test_a_port_that_is_taken_is_refused_in_one_sentence() -> None:
    """If another process uses the UDP port, the port is refused with one sentence.

    Otherwise each process would receive a part of the packets without notice.
    """
    with SharedImages.create(48) as images, udp(ROBOT) as first:
        port = first.getsockname()[1]
        first.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        with pytest.raises(EnipError) as refused:
            CyclicControl(images.name, ROBOT, port)
        images.unlink()
    assert str(refused.value) == (
        f"cyclic I/O cannot use UDP port {port} of {ROBOT}: [Errno 98] Address already in use; "
        "end the program that uses the port (a program on 0.0.0.0 uses it on every address), or "
        "choose another address or port"
    )


def test_an_address_of_another_machine_is_refused_in_one_sentence() -> None:
    with SharedImages.create(48) as images:
        with pytest.raises(EnipError, match=r"cannot use UDP port 2222 of 192\.0\.2\.1"):
            CyclicControl(images.name, "192.0.2.1", 2222)
        images.unlink()


def test_orders_to_a_process_that_has_ended_are_an_error(target: Target) -> None:
    target.control.close()
    target.control.close()
    assert not target.control.alive
    with pytest.raises(EnipError, match="has ended"):
        target.open()


def test_without_its_parent_the_process_leaves_no_owner_behind(target: Target) -> None:
    """If the pipe of its parent is closed, the process ends, and no owner remains."""
    target.open()
    target.send(packet(1))
    target.receive_until(lambda: target.images.owner is OwnerState.RUN)
    target.control.close()
    assert target.images.owner is OwnerState.NONE
    assert target.images.status().connections == 0


def test_the_process_ends_with_its_parent() -> None:
    """The process ends with its parent, in whatever way the parent ends.

    The test waits until standard error is closed, which both processes hold open.
    """
    parent = textwrap.dedent(
        f"""
        import sys
        from rcx_harness.enip.cyclic.control import CyclicControl
        from rcx_harness.enip.cyclic.shared import SharedImages
        images = SharedImages.create(48)
        control = CyclicControl(images.name, "{ROBOT}", 0)
        images.unlink()
        print("ready", flush=True)
        sys.stdin.read()
        """
    )
    process = subprocess.Popen(
        [sys.executable, "-c", parent],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    os.kill(process.pid, signal.SIGKILL)
    process.communicate(timeout=GENEROUS_S)
    assert process.returncode == -signal.SIGKILL
