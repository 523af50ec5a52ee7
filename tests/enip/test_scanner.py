"""A scanner and an adapter on the loopback interface exchange data over class 1 connections.

No test measures time. To wait for an effect, a test sends explicit requests to the adapter. The
limit is so high that even a slow computer does not reach it. If a time-out would disturb a test,
the time-out is 512 intervals.
"""

from __future__ import annotations

import os
import signal
import socket
import struct
from collections.abc import Callable, Iterator

import pytest

from rcx_harness.enip.codec.forward_open import OpenRequest, decode_open_reply
from rcx_harness.enip.cyclic.connections import ConnectionKind, EndReason, OwnerState
from rcx_harness.enip.cyclic.shared import SharedImages, now_us
from rcx_harness.enip.errors import CipError, EnipError, ProcessDiedError
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner, no_packet
from rcx_harness.enip.target.adapter import Adapter
from structured_text.errors import InputError

HOST, SECOND = "127.6.0.1", "127.6.0.2"
OPTIONS = AdapterOptions(rpi_min_us=1_000)
TO_MASTER = bytes(range(1, 49))
TO_ROBOT = bytes(range(101, 149))


@pytest.fixture(scope="module")
def shared_adapter() -> Iterator[Adapter]:
    with Adapter(host=HOST, cyclic=0, options=OPTIONS) as adapter:
        yield adapter


@pytest.fixture
def adapter(shared_adapter: Adapter) -> Adapter:
    """Wait until the connections of the previous test are closed, and return the shared adapter."""
    eventually(shared_adapter, lambda: shared_adapter.shared.status().connections == 0)
    shared_adapter.write_to_master(TO_MASTER)
    return shared_adapter


def scan(
    adapter: Adapter,
    rpi_us: int = 4_000,
    *,
    multiplier: int = 7,
    kind: ConnectionKind = ConnectionKind.EXCLUSIVE_OWNER,
    address: str = HOST,
    io_port: int | None = 0,
    large: bool = False,
    size: int | None = None,
) -> Scanner:
    return Scanner(
        *(adapter.address[0], size or adapter.size, rpi_us),
        kind=kind,
        multiplier=multiplier,
        address=address,
        io_port=io_port,
        port=adapter.address[1],
        large=large,
        timeout_s=60.0,
    )


def eventually(adapter: Adapter, condition: Callable[[], bool]) -> None:
    """Send requests to the adapter until the condition is true."""
    with Client(*adapter.address, timeout_s=60.0) as client:
        for _ in range(100_000):
            if condition():
                return
            client.get_attribute(1, 1, 1)
    raise AssertionError("the condition did not become true within 100,000 requests")


def test_both_areas_are_exchanged(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        scanner.open()
        scanner.write(TO_ROBOT)
        eventually(adapter, lambda: scanner.read().image == TO_MASTER)
        eventually(adapter, lambda: adapter.read_to_robot() == TO_ROBOT)
        assert scanner.read().connected
        assert adapter.shared.owner is OwnerState.RUN


def test_each_scanner_and_each_opening_has_a_new_serial_number(
    adapter: Adapter, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each scanner and each opening has a new serial number, because the triad must be unique.

    Source: CIP volume 1, chapter 3, 5.5.1.5 to 5.5.1.7
    """
    sent: list[bytes] = []
    forward_open = OpenRequest.forward_open

    def recording(request: OpenRequest) -> bytes:
        sent.append(forward_open(request))
        return sent[-1]

    monkeypatch.setattr(OpenRequest, "forward_open", recording)
    for _ in range(2):
        with scan(adapter, kind=ConnectionKind.INPUT_ONLY) as scanner:
            scanner.open()
            scanner.open()
    serials = [message[16:18] for message in sent]
    originators = [message[20:24] for message in sent]
    assert serials[0] != serials[1]
    assert serials[2] != serials[3]
    assert originators[0] == originators[1] != originators[2] == originators[3]


def test_data_is_written_before_the_run_flag_and_read_after_the_state(
    adapter: Adapter, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[bytes] = []
    with scan(adapter) as scanner:
        images = scanner.shared
        monkeypatch.setattr(
            SharedImages,
            "run",
            property(lambda _: True, lambda of, _: seen.append(of.to_robot.read())),
        )
        scanner.write(TO_ROBOT)
        assert seen == [TO_ROBOT]

        def arriving(of: SharedImages) -> OwnerState:
            """Return the state of the owner, and let a packet arrive while the state is read."""
            of.to_master.write(TO_MASTER)
            of.arrive(now_us(), None)
            return OwnerState.RUN

        monkeypatch.setattr(SharedImages, "owner", property(arriving))
        assert images.to_master.read() == bytes(48)
        received = scanner.read()
        assert (received.connected, received.image) == (True, TO_MASTER)
        assert received.age_us is not None


def test_before_the_first_packet_the_image_is_zero(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        received = scanner.read()
        assert (received.image, received.age_us, received.connected) == (bytes(48), None, False)
        assert scanner.connection is None


def test_the_age_is_that_of_the_last_packet(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        scanner.open()
        eventually(adapter, lambda: scanner.read().connected)
        scanner.stop()
        first = scanner.read().age_us
        second = scanner.read().age_us
        assert first is not None
        assert second is not None
        assert 0 <= first <= 60_000_000


def test_the_adapter_detects_an_idle_program(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        scanner.write(TO_ROBOT, run=False)
        scanner.open()
        eventually(adapter, lambda: adapter.shared.owner is OwnerState.IDLE)


def test_the_agreed_parameters_can_be_read(adapter: Adapter) -> None:
    with scan(adapter, rpi_us=5_000) as scanner:
        scanner.open()
        agreed = scanner.connection
        assert agreed is not None
        assert (agreed.o_to_t_api_us, agreed.t_to_o_api_us) == (5_000, 5_000)
        assert (agreed.peer, agreed.destination_port) == (HOST, adapter.io_port)
        scanner.close_connection()
        assert scanner.connection is None


@pytest.mark.exhaustive
def test_no_packet_is_missing(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        before = adapter.shared.status()
        scanner.open()
        eventually(adapter, lambda: scanner.statistics().received >= 50)
        ours, theirs = scanner.statistics(), adapter.shared.status()
        assert (ours.missing, ours.dropped) == (0, 0)
        assert (theirs.missing, theirs.dropped) == (before.missing, before.dropped)
        assert 0 < ours.gap_median_us <= ours.gap_p99_us <= ours.gap_max_us


@pytest.mark.parametrize("large", [pytest.param(False, marks=pytest.mark.exhaustive), True])
def test_256_bytes_go_both_ways(large: bool) -> None:
    with Adapter(256, host=HOST, cyclic=0) as adapter, scan(adapter, large=large) as scanner:
        adapter.write_to_master(bytes(range(256)))
        scanner.write(bytes(range(255, -1, -1)))
        scanner.open()
        eventually(adapter, lambda: scanner.read().image == bytes(range(256)))
        eventually(adapter, lambda: adapter.read_to_robot() == bytes(range(255, -1, -1)))


def test_input_only_receives_and_sends_nothing(adapter: Adapter) -> None:
    before = adapter.shared.to_robot.version
    with scan(adapter, kind=ConnectionKind.INPUT_ONLY) as scanner:
        scanner.write(TO_ROBOT)
        scanner.open()
        eventually(adapter, lambda: scanner.read().image == TO_MASTER)
        status = adapter.shared.status()
        assert (status.owners, status.input_only) == (0, 1)
    assert adapter.shared.to_robot.version == before


def test_a_listener_receives_the_owners_data_and_ends_with_the_owner(adapter: Adapter) -> None:
    with scan(adapter) as owner:
        owner.open()
        listener = scan(adapter, kind=ConnectionKind.LISTEN_ONLY, address=SECOND)
        with listener:
            listener.open()
            eventually(adapter, lambda: listener.read().image == TO_MASTER)
            owner.close_connection()
            eventually(adapter, lambda: adapter.shared.status().connections == 0)
            with pytest.raises(CipError) as refused:
                listener.close_connection()
            assert (refused.value.status, refused.value.extended) == (0x01, (0x107,))


def test_a_second_owner_is_refused_in_words(adapter: Adapter) -> None:
    with scan(adapter) as owner, scan(adapter, address=SECOND) as second:
        owner.open()
        with pytest.raises(CipError) as refused:
            second.open()
        assert (refused.value.status, refused.value.extended) == (0x01, (0x106,))
        assert str(refused.value) == (
            "the connection (Forward Open) was refused: 0x01, connection failure; "
            "0x0106, another master owns the outputs"
        )
        eventually(adapter, lambda: owner.read().connected)


def test_areas_of_another_size_are_refused(adapter: Adapter) -> None:
    with scan(adapter, size=256) as scanner:
        with pytest.raises(CipError) as refused:
            scanner.open()
        assert refused.value.status == 0x01
        assert refused.value.extended[0] in (0x127, 0x128)
        assert not scanner.read().connected


def test_the_connection_ends_with_forward_close_not_with_the_session(
    adapter: Adapter,
) -> None:
    """The connection stays open when its session ends; Forward Close ends it over a new session."""
    with scan(adapter) as scanner:
        scanner.open()
        eventually(adapter, lambda: scanner.read().connected)
        scanner.client.close()
        received = scanner.statistics().received
        eventually(adapter, lambda: scanner.statistics().received >= received + 50)
        assert scanner.read().connected
        assert adapter.shared.status().owners == 1
        scanner.close_connection()
        eventually(adapter, lambda: adapter.shared.owner is OwnerState.CLOSED)
        assert adapter.shared.status().connections == 0
        assert not scanner.read().connected
    scanner.close()


def test_after_a_time_out_at_both_ends_open_connects_again(adapter: Adapter) -> None:
    with scan(adapter, rpi_us=1_000, multiplier=5) as scanner:
        scanner.open()
        eventually(adapter, lambda: scanner.statistics().received > 0)
        scanner.stop()
        eventually(adapter, lambda: adapter.shared.owner is OwnerState.TIMED_OUT)
        eventually(adapter, lambda: not scanner.read().connected)
        eventually(adapter, lambda: scanner.ended is EndReason.TIMED_OUT)
        received = scanner.statistics().received
        scanner.open()
        assert scanner.ended is None
        eventually(adapter, lambda: scanner.statistics().received > received)


def test_the_connection_is_lost_when_the_adapter_ends(adapter: Adapter) -> None:
    with Adapter(host=SECOND, cyclic=0, options=OPTIONS) as other:
        scanner = scan(other, rpi_us=1_000, multiplier=5)
        scanner.open()
        eventually(adapter, lambda: scanner.statistics().received > 0)
    with scanner:
        eventually(adapter, lambda: not scanner.read().connected)
        with pytest.raises(EnipError):
            scanner.open()


def test_a_scanner_whose_process_has_died_is_not_connected(adapter: Adapter) -> None:
    with scan(adapter) as scanner:
        scanner.open()
        eventually(adapter, lambda: scanner.read().connected)
        assert scanner.failure == ""
        os.kill(scanner.pid, signal.SIGKILL)
        eventually(adapter, lambda: not scanner.read().connected)
        killed = "the process of the cyclic I/O has ended by itself (killed by SIGKILL)"
        assert scanner.failure == killed
        with pytest.raises(ProcessDiedError, match="killed by SIGKILL"):
            scanner.open()
    assert scanner.failure == ""


@pytest.mark.parametrize(
    ("length", "text"),
    [(16, "sets a packet to it every 0 ms instead of every 4 ms"), (9, "is too short")],
)
def test_an_implausible_reply_opens_nothing_and_is_explained(
    adapter: Adapter, monkeypatch: pytest.MonkeyPatch, length: int, text: str
) -> None:
    """If the reply to a Forward Open is incomplete or has an interval of 0 us, opening fails.

    The scanner closes the connection that the adapter has opened.
    """
    rest = bytes(8 if length == 16 else 0)
    monkeypatch.setattr(
        "rcx_harness.enip.originator.scanner.decode_open_reply",
        lambda data: decode_open_reply(data[:length] + rest),
    )
    with scan(adapter) as scanner:
        with pytest.raises(EnipError, match=f"the reply to the Forward Open {text}"):
            scanner.open()
        assert scanner.connection is None
        eventually(adapter, lambda: adapter.shared.status().connections == 0)


@pytest.mark.parametrize(
    ("drops", "message"),
    [
        (
            "",
            "connected, but no packet came within 10 s; "
            "check that no firewall blocks UDP port 2222",
        ),
        (
            "of a wrong length (20 bytes instead of 50)",
            "connected, but none of the packets within 10 s can be used: they are of a wrong "
            "length (20 bytes instead of 50); compare the size of the areas, and find out who "
            "else sends to this address",
        ),
    ],
)
def test_unusable_packets_are_reported_instead_of_silence(drops: str, message: str) -> None:
    assert str(no_packet(drops, 10.0)) == message


def test_a_scanner_reports_why_it_drops_packets(adapter: Adapter) -> None:
    """The scanner reports that it has dropped a packet of 22 bytes instead of 50."""
    with scan(adapter) as scanner, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        scanner.open()
        assert scanner.connection is not None
        other.bind((HOST, 0))
        head = struct.pack("<HHHIIHH", 2, 0x8002, 8, scanner.connection.t_to_o_id, 1, 0xB1, 22)
        other.sendto(head + bytes(22), (HOST, scanner.io_port))
        eventually(adapter, lambda: scanner.drops() != "")
        assert scanner.drops() == "of a wrong length (22 bytes instead of 50)"


@pytest.mark.exhaustive
def test_if_the_usual_port_is_taken_another_port_is_used(adapter: Adapter) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first:
        first.bind(("127.6.0.3", 2222))
        with scan(adapter, address="127.6.0.3", io_port=None) as scanner:
            scanner.open()
            eventually(adapter, lambda: scanner.read().connected)


def test_a_chosen_port_must_be_free(adapter: Adapter) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first:
        first.bind((HOST, 0))
        with pytest.raises(EnipError, match="cannot use UDP port"):
            scan(adapter, io_port=first.getsockname()[1])


def test_without_an_adapter_there_is_no_scanner() -> None:
    with socket.socket() as free:
        free.bind((HOST, 0))
        port = free.getsockname()[1]
    with pytest.raises(EnipError, match="no connection to the EtherNet/IP adapter"):
        Scanner(HOST, port=port)


@pytest.mark.parametrize(
    ("size", "rpi_us", "multiplier", "message"),
    [
        (47, 10_000, 2, "an area of 47 bytes does not exist"),
        (48, 999, 2, "a packet interval of 999 us cannot be requested"),
        (48, 2**32, 2, "a packet interval of 4294967296 us cannot be requested"),
        (48, 10_000, 8, "the time-out multiplier must be 0 to 7"),
        (48, 10_000, -1, "the time-out multiplier must be 0 to 7"),
    ],
)
def test_invalid_parameters_are_refused_before_anything_is_sent(
    size: int, rpi_us: int, multiplier: int, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        Scanner("127.6.0.9", size, rpi_us, multiplier=multiplier)
