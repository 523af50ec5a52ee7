"""The process of the adapter works with real sockets: UDP, cyclic I/O, and a cut link."""

from __future__ import annotations

import os
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from forward_open_bytes import forward_close, forward_open
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.cyclic.shared import LinkState
from rcx_harness.enip.errors import CipError, EnipError
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter

LONG_S = 30.0
LIST_IDENTITY = bytes.fromhex("6300 0000 00000000 00000000 0100 A3A4A5A6A7A8 00000000")
FORWARD_OPEN, FORWARD_CLOSE, CONNECTION_MANAGER = 0x54, 0x4E, bytes.fromhex("2006 2401")


@pytest.fixture
def wire() -> Iterator[socket.socket]:
    """Return a UDP socket that may send broadcasts."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
        udp.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        udp.settimeout(LONG_S)
        yield udp


@pytest.fixture
def adapter() -> Iterator[Adapter]:
    """Return an adapter whose cyclic I/O uses any free port."""
    with Adapter(48, cyclic=0) as device:
        yield device


def open_owner(master: Client, **fields: str) -> bytes:
    """Open an Exclusive Owner connection with a long time-out, and return the data of the reply."""
    slow = {"o_to_t_rpi": "A0860100", "multiplier": "07", **fields}  # a time-out of 100 ms x 512
    return master.request(FORWARD_OPEN, CONNECTION_MANAGER, bytes.fromhex(forward_open(**slow))[6:])


def ask_for_ever(master: Client) -> None:
    """Send requests until one of them fails."""
    while True:
        master.get_assembly(100)


def wait_for_owner(adapter: Adapter, master: Client, state: OwnerState) -> None:
    """Send requests until the adapter's owner has the given state."""
    while adapter.shared.owner is not state:
        master.get_assembly(100)


def close_owner(master: Client) -> bytes:
    return master.request(FORWARD_CLOSE, CONNECTION_MANAGER, bytes.fromhex(forward_close())[6:])


def test_an_adapter_on_all_addresses_answers_with_the_requested_address(
    wire: socket.socket,
) -> None:
    """UDP and TCP answers, and attribute 5, contain the address to which the request was sent.

    The address 0.0.0.0 would be useless, because a client cannot connect to it.
    """
    told = struct.pack(">HH4s8x", 2, 0, bytes([127, 0, 0, 1]))
    with Adapter(host="0.0.0.0") as adapter:
        port = adapter.address[1]
        wire.sendto(LIST_IDENTITY, ("127.0.0.1", port))
        answers = [wire.recvfrom(1500)[0]]
        with socket.create_connection(("127.0.0.1", port), LONG_S) as tcp:
            tcp.sendall(LIST_IDENTITY)
            answers.append(tcp.recv(1500))
        with Client("127.0.0.1", port) as client:
            configured = client.get_attribute(0xF5, 1, 5)[:4]
    for answer in answers:
        assert answer[32:34] + bytes(2) + answer[36:48] == told
    assert configured != bytes(4)


@pytest.mark.exhaustive
@pytest.mark.skipif(sys.platform != "linux", reason="broadcasts on the loopback are Linux's")
def test_a_broadcast_reaches_every_adapter_of_the_machine(wire: socket.socket) -> None:
    with Adapter(host="127.0.0.31") as one:
        port = one.address[1]
        with Adapter(host="127.0.0.32", port=port):
            wire.sendto(LIST_IDENTITY, ("127.255.255.255", port))
            senders = {wire.recvfrom(1500)[1] for _ in range(2)}
    assert senders == {("127.0.0.31", port), ("127.0.0.32", port)}


def test_a_udp_port_in_use_is_reported(wire: socket.socket) -> None:
    wire.bind(("127.0.0.1", 0))
    port = wire.getsockname()[1]
    with pytest.raises(EnipError, match=rf"cannot listen on 127\.0\.0\.1:{port}.*free port"):
        Adapter(port=port)


def test_a_port_of_cyclic_io_in_use_is_reported(wire: socket.socket) -> None:
    wire.bind(("127.0.0.1", 0))
    port = wire.getsockname()[1]
    with pytest.raises(EnipError, match=f"cannot use UDP port {port} of 127.0.0.1"):
        Adapter(cyclic=port)


def test_a_cyclic_connection_owns_the_outputs_until_it_is_closed(adapter: Adapter) -> None:
    """A cyclic connection stays open when its TCP connection is closed.

    Another TCP connection from the same machine can close the cyclic connection.
    """
    with Client(*adapter.address) as master:
        assert len(open_owner(master)) == 26
        assert master.get_attribute(1, 1, 5) == bytes.fromhex("7100")
        with pytest.raises(CipError) as refusal:
            open_owner(master, triad="0200 4D00 EFBEADDE")
        assert (refusal.value.status, refusal.value.extended) == (0x01, (0x106,))
    with Client(*adapter.address) as master:
        assert master.get_attribute(1, 1, 5) == bytes.fromhex("7100")
        with pytest.raises(CipError, match="object state conflict"):
            master.set_assembly(150, bytes(48))
        assert close_owner(master) == bytes.fromhex("0100 4D00 EFBEADDE 0000")
        assert master.get_attribute(1, 1, 5) == bytes.fromhex("3000")
        master.set_assembly(150, b"\x01" * 48)
    assert adapter.read_to_robot() == b"\x01" * 48


def test_an_adapter_without_cyclic_io_refuses_cyclic_connections() -> None:
    with Adapter() as adapter, Client(*adapter.address) as master:
        assert adapter.io_port is None
        with pytest.raises(CipError) as refusal:
            open_owner(master)
        assert refusal.value.extended == (0x113,)


def test_the_options_reach_the_device() -> None:
    options = AdapterOptions(rpi_min_us=200_000)
    with Adapter(cyclic=0, options=options) as adapter, Client(*adapter.address) as master:
        with pytest.raises(CipError) as refusal:
            open_owner(master)
        assert refusal.value.extended[0] == 0x112


def test_a_reset_closes_the_tcp_connections_after_its_reply() -> None:
    with Adapter() as adapter, Client(*adapter.address) as master:
        assert master.request(0x05, bytes.fromhex("2001 2401")) == b""
        with pytest.raises(EnipError, match="failed to answer"):
            ask_for_ever(master)
        with Client(*adapter.address) as again:
            assert again.get_assembly(100) == bytes(48)


@pytest.mark.exhaustive(but=["1"])
@pytest.mark.parametrize("state", [LinkState.CUT, LinkState.OFF])
def test_an_adapter_that_is_cut_off_does_not_answer(adapter: Adapter, state: LinkState) -> None:
    master = Client(*adapter.address, timeout_s=LONG_S)
    open_owner(master)
    adapter.shared.link = state
    with pytest.raises(EnipError, match="failed to answer"):
        ask_for_ever(master)
    with pytest.raises(EnipError):
        Client(*adapter.address, timeout_s=LONG_S)

    adapter.shared.link = LinkState.UP
    while True:
        try:
            with Client(*adapter.address, timeout_s=LONG_S) as again:
                owned = again.get_attribute(1, 1, 5)
                break
        except EnipError:
            continue
    # A cut link does not close a cyclic connection at once; the connection ends by its time-out.
    assert (owned[0] & 1) == (state is LinkState.CUT)


@pytest.mark.skipif(sys.platform != "linux", reason="finds the process by /proc")
def test_if_the_cyclic_process_dies_the_adapter_ends_without_an_owner(
    processes: list[subprocess.Popen[str]],
) -> None:
    with Adapter(48, cyclic=0) as adapter, Client(*adapter.address, timeout_s=LONG_S) as master:
        open_owner(master)
        wait_for_owner(adapter, master, OwnerState.WAITING)
        pid = processes[0].pid
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        (cyclic,) = [int(pid) for pid in children]
        os.kill(cyclic, signal.SIGKILL)
        assert adapter.wait_for_failure() == (
            "the EtherNet/IP adapter has ended: the process of the cyclic I/O has ended by itself "
            "(killed by SIGKILL)"
        )
        assert adapter.shared.owner is OwnerState.TIMED_OUT
        assert not adapter.alive
