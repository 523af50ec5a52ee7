"""Forward Open and Forward Close open and close connections of the allowed kinds and numbers."""

from __future__ import annotations

import inspect
import itertools
from typing import Any

import pytest

from forward_open_bytes import TRIAD, forward_close, forward_open, opened, refused
from rcx_harness.enip.codec.encapsulation import Item
from rcx_harness.enip.cyclic.connections import ConnectionKind, ConnectionParameters
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.target.connection_manager import Origin, random_id
from rcx_harness.enip.target.device import Device

OTHER = "0200 4D00 EFBEADDE"
INPUT_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C03 2C64"}
LISTEN_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C04 2C64"}
MULTICAST = "3228"


def origin(peer: str = "192.168.0.10", **addresses: str) -> Origin:
    items = {int(kind[1:], 16): bytes.fromhex(data) for kind, data in addresses.items()}
    return Origin(peer, "192.168.0.2", 1, items)


def test_an_exclusive_owner_is_opened_and_passed_to_the_cyclic_part(bench: Any) -> None:
    """An Exclusive Owner with 48 bytes in each direction is opened.

    Both directions have a sequence count, and the direction to the robot has a run/idle header.

    Source: manual chapter 1, 4.1
    """
    sender = origin()
    assert bench.ask(forward_open(), sender) == opened()
    assert bench.cyclic.added == [
        ConnectionParameters(
            number=1,
            kind=ConnectionKind.EXCLUSIVE_OWNER,
            o_to_t_id=0x00010001,
            t_to_o_id=0x12345678,
            o_to_t_api_us=10_000,
            t_to_o_api_us=10_000,
            o_to_t_size=48,
            t_to_o_size=48,
            multiplier=2,
            peer="192.168.0.10",
            destination="192.168.0.10",
            destination_port=2222,
            run_idle=True,
            multicast=False,
            dscp=47,
            first_packet_us=10_000_000,
        )
    ]
    # where the master must send its packets: AF_INET, port 2222, 192.168.0.2, big endian
    assert sender.items == [(0x8000, bytes.fromhex("0002 08AE C0A80002 0000000000000000"))]


def test_a_connection_of_256_bytes_needs_no_large_forward_open(make_bench: Any) -> None:
    """A normal Forward Open can open areas of 256 bytes.

    Its sizes are 262 bytes (0x106) and 258 bytes (0x102).

    Source: manual chapter 1, 4.2
    """
    bench = make_bench(size=256)
    assert bench.ask(forward_open(o_to_t="0649", t_to_o="0249")) == opened()
    assert bench.cyclic.added[0].o_to_t_size == bench.cyclic.added[0].t_to_o_size == 256
    assert bench.ask(forward_open(triad=OTHER)) == refused("2701 0601", triad=OTHER)


def test_variable_sizes_are_accepted_if_they_are_equal(bench: Any) -> None:
    assert bench.ask(forward_open(o_to_t="354A", t_to_o="324A")) == refused("2701 3600")
    assert bench.ask(forward_open(o_to_t="364A", t_to_o="324A")) == opened()


@pytest.mark.parametrize(
    ("size", "o_to_t", "t_to_o"), [(48, "36000048", "32000048"), (256, "06010048", "02010048")]
)
def test_a_large_forward_open_has_sizes_of_16_bits(
    make_bench: Any, size: int, o_to_t: str, t_to_o: str
) -> None:
    bench = make_bench(size=size)
    request = forward_open(service="5B", o_to_t=o_to_t, t_to_o=t_to_o)
    assert bench.ask(request) == opened(service="DB")
    assert bench.cyclic.added[0].o_to_t_size == bench.cyclic.added[0].t_to_o_size == size


@pytest.mark.parametrize(
    "path",
    [
        "2004 2C96 2C64",  # no configuration instance
        "2004 2401 2C96 2C64",
        "2004 2405 2C96 2C64",
        "2004 2497 2C96 2C64",
        "2004 2496 2464",  # instances instead of connection points
        "2004 2405 2C96 2C64 8000",  # a segment with configuration data of size 0
        "2100 0400 2500 0500 2D00 9600 2D00 6400",  # 16-bit segments
        "2004 2405 2004 2C96 2004 2C64",  # class repeated
        "3404 7C02 2B00 0500 0101 2004 2405 2C96 2C64",  # electronic key
        # an electronic key of zeros, which fits any device
        "3404 0000 0000 0000 0000 2004 2405 2C96 2C64",
        "3404 7C02 2B00 0500 0101 430A 2004 2405 2C96 2C64",  # inhibit time 10 ms
        "5002 10270000 2004 2405 2C96 2C64",  # inhibit time 10000 us
    ],
)
def test_a_path_may_be_written_in_several_ways(bench: Any, path: str) -> None:
    assert bench.ask(forward_open(path=path)) == opened()


def test_the_actual_interval_of_each_direction_is_the_requested_one(bench: Any) -> None:
    # intervals of 2 ms and 3.2 s
    request = forward_open(o_to_t_rpi="D0070000", t_to_o_rpi="00D43000")
    assert bench.ask(request) == opened(intervals="D0070000 00D43000")
    assert bench.cyclic.added[0].o_to_t_api_us == 2_000
    assert bench.cyclic.added[0].t_to_o_api_us == 3_200_000


@pytest.mark.parametrize(("low", "status"), [("E8030000", 0x00), ("E7030000", 0x01)])
def test_one_millisecond_is_an_option(make_bench: Any, low: str, status: int) -> None:
    bench = make_bench(options=AdapterOptions(rpi_min_us=1_000))
    assert bench.ask(forward_open(o_to_t_rpi=low, t_to_o_rpi=low))[2] == status


@pytest.mark.parametrize(
    ("t_to_o", "dscp"), [("3240", 31), ("3244", 43), ("3248", 47), ("324C", 55)]
)
def test_the_priority_of_the_packets_chooses_their_code_point(
    bench: Any, t_to_o: str, dscp: int
) -> None:
    assert bench.ask(forward_open(t_to_o=t_to_o)) == opened()
    assert bench.cyclic.added[0].dscp == dscp


def test_the_same_connection_twice_is_a_duplicate(bench: Any) -> None:
    """A second Forward Open with the same triad gets extended status 0x100.

    A null Forward Open for the same connection is not supported (0x132).
    """
    assert bench.ask(forward_open()) == opened()
    assert bench.ask(forward_open()) == refused("0001")
    assert bench.ask(forward_open(o_to_t="3608", t_to_o="3208")) == refused("3201")
    assert len(bench.cyclic.added) == 1


@pytest.mark.parametrize(
    "triad",
    [
        pytest.param("0200 4D00 EFBEADDE", id="another connection"),
        pytest.param("0100 4E00 EFBEADDE", id="another vendor"),
        pytest.param("0100 4D00 EFBEADDF", id="another device of the vendor"),
        pytest.param("0100 4D00 F0BEADDE", id="a device with the next serial number"),
    ],
)
def test_a_connection_is_identified_by_its_whole_triad(bench: Any, triad: str) -> None:
    """A request with another serial number, vendor or originator is for another connection.

    Source: CIP volume 1, chapter 3, 5.5.1.5 to 5.5.1.7 (serial number, vendor, originator)
    """
    assert bench.ask(forward_open()) == opened()
    close = forward_close(triad=triad, path="2004 2405 2C03 2C64")
    assert bench.ask(close) == refused("0701", "CE", triad)
    assert bench.ask(forward_open(**INPUT_ONLY, triad=triad)) == opened("02000100", triad=triad)
    assert bench.ask(close) == bytes.fromhex(f"CE00 0000 {triad} 00 00")
    assert bench.cyclic.removed == [2]
    assert bench.device.connections.is_owned


def test_a_connection_id_is_used_again_only_after_its_connection_was_closed(
    make_bench: Any,
) -> None:
    """A connection id is used again only after its connection was closed.

    The test supplies the ids 0 to 7 repeatedly. The id 0 is never used.
    """
    bench = make_bench(draw_id=itertools.cycle(range(8)).__next__)
    class_3 = {"transport": "A3", "path": "2002 2401", "o_to_t": "F843", "t_to_o": "F843"}
    group = {**INPUT_ONLY, "t_to_o": MULTICAST}
    triads = [f"{serial:02X}00 4D00 EFBEADDE" for serial in (0x11, 0x12, 0x13)]
    replies = [
        bench.ask(forward_open(triad=triads[0])),
        bench.ask(forward_open(**class_3, triad=triads[1])),
    ]
    replies += [bench.ask(forward_open(**group, triad=triads[2]))]
    living = {reply[4:8] for reply in replies} | {replies[2][8:12]}
    assert len(living) == 4
    for _ in range(20):
        reply = bench.ask(forward_open(**INPUT_ONLY))
        assert reply[2] == 0
        assert reply[4:8] not in {*living, bytes(4)}
        assert bench.ask(forward_close(path=INPUT_ONLY["path"]))[2] == 0


@pytest.mark.parametrize("peer", ["192.168.0.10", "192.168.0.11"])
def test_a_second_owner_is_a_conflict(bench: Any, peer: str) -> None:
    """A second owner gets extended status 0x106, even from the machine of the first owner."""
    assert bench.ask(forward_open()) == opened()
    assert bench.ask(forward_open(triad=OTHER), origin(peer)) == refused("0601", triad=OTHER)


def test_after_a_time_out_an_owner_may_open_a_new_connection(bench: Any) -> None:
    assert bench.ask(forward_open()) == opened()
    bench.device.connections.ended(1)
    assert bench.ask(forward_open()) == opened("02000100")
    assert [each.number for each in bench.cyclic.added] == [1, 2]


@pytest.mark.parametrize(("o_to_t", "run_idle"), [("0048", False), ("0248", False), ("0648", True)])
def test_a_heartbeat_has_no_data(bench: Any, o_to_t: str, run_idle: bool) -> None:
    request = forward_open(o_to_t=o_to_t, path="2004 2405 2C03 2C64")
    assert bench.ask(request) == opened()
    (parameters,) = bench.cyclic.added
    assert parameters.kind is ConnectionKind.INPUT_ONLY
    assert (parameters.o_to_t_size, parameters.t_to_o_size) == (0, 48)
    assert parameters.run_idle is run_idle


def test_owner_input_only_and_listen_only_work_at_the_same_time(bench: Any) -> None:
    assert bench.ask(forward_open()) == opened()
    assert bench.ask(forward_open(**INPUT_ONLY, triad=OTHER))[2] == 0
    assert bench.ask(forward_open(**LISTEN_ONLY, triad="0300 4D00 EFBEADDE"))[2] == 0
    kinds = [each.kind.value for each in bench.cyclic.added]
    assert kinds == ["exclusive owner", "input only", "listen only"]


def test_listeners_end_with_the_last_connection_of_another_kind(bench: Any) -> None:
    """If the owner closes its connection, the listener's connection ends as well.

    The cyclic process ends listeners itself, so the Connection Manager does not remove them.
    """
    assert bench.ask(forward_open()) == opened()
    assert bench.ask(forward_open(**LISTEN_ONLY, triad=OTHER))[2] == 0
    assert bench.ask(forward_close()) == bytes.fromhex(f"CE00 0000 {TRIAD} 00 00")
    assert bench.cyclic.removed == [1]
    assert bench.device.connections.cyclic_connections == ()
    assert bench.ask(forward_open(**LISTEN_ONLY, triad=OTHER)) == refused("1901", triad=OTHER)


def test_listeners_stay_while_an_input_only_connection_is_open(bench: Any) -> None:
    bench.ask(forward_open())
    bench.ask(forward_open(**INPUT_ONLY, triad=OTHER))
    bench.ask(forward_open(**LISTEN_ONLY, triad="0300 4D00 EFBEADDE"))
    bench.device.connections.ended(1)
    assert [each.number for each in bench.device.connections.cyclic_connections] == [2, 3]
    bench.device.connections.ended(2)
    assert bench.device.connections.cyclic_connections == ()


@pytest.mark.parametrize("fields", [INPUT_ONLY, LISTEN_ONLY])
def test_the_number_of_connections_is_limited(bench: Any, fields: dict[str, str]) -> None:
    """One machine cannot open all connections of a kind; further ones get extended status 0x113.

    Other machines, other kinds, and the owner can still open connections.
    """
    assert bench.ask(forward_open(**INPUT_ONLY, triad="0000 4D00 EFBEADDE"))[2] == 0
    triads = [f"{serial:02X}00 4D00 EFBEADDE" for serial in range(0x10, 0x20)]
    replies = [bench.ask(forward_open(**fields, triad=triad)) for triad in triads]
    limit = 6 if fields is INPUT_ONLY else 7
    assert all(reply[2] == 0 for reply in replies[:limit])
    assert replies[limit:] == [refused("1301", triad=triad) for triad in triads[limit:]]
    eighth = bench.ask(forward_open(**fields, triad=triads[limit]), origin("192.168.0.11"))
    assert eighth[2] == 0
    ninth = bench.ask(forward_open(**fields, triad=triads[-1]), origin("192.168.0.12"))
    assert ninth == refused("1301", triad=triads[-1])
    assert bench.ask(forward_open())[2] == 0


def test_without_cyclic_io_a_forward_open_is_refused(make_bench: Any) -> None:
    assert make_bench(cyclic=False).ask(forward_open()) == refused("1301")


def test_if_the_cyclic_process_has_ended_nothing_is_opened(bench: Any) -> None:
    def fail(_: object) -> None:
        raise EnipError("it has ended")

    bench.ask(forward_open())
    bench.cyclic.remove = bench.cyclic.add = fail
    assert bench.ask(forward_close())[2] == 0
    assert bench.ask(forward_open()) == refused("1301")
    assert not bench.device.connections.is_owned


def test_multicast_connections_share_one_production(bench: Any) -> None:
    """All multicast connections have the same connection id, group, port and interval.

    The group belongs to 192.168.0.2 (host number 2), and the port is 2222. A request with another
    interval is refused, and the reply has the right interval (0x112, code 4).
    """
    sender = origin()
    assert bench.ask(forward_open(t_to_o=MULTICAST), sender) == opened("02000100", "01000100")
    assert sender.items == [
        (0x8000, bytes.fromhex("0002 08AE C0A80002 0000000000000000")),
        (0x8001, bytes.fromhex("0002 08AE EFC00120 0000000000000000")),
    ]
    second = forward_open(**INPUT_ONLY, t_to_o=MULTICAST, triad=OTHER)
    assert bench.ask(second) == opened("03000100", "01000100", triad=OTHER)
    first, other = bench.cyclic.added
    assert first.multicast
    assert other.multicast
    assert first.destination == other.destination == "239.192.1.32"

    third = "0300 4D00 EFBEADDE"
    slower = {"t_to_o": MULTICAST, "t_to_o_rpi": "204E0000", "triad": third}
    assert bench.ask(forward_open(**{**INPUT_ONLY, **slower})) == refused(
        "1201 0004 10270000 10270000", triad=third
    )
    assert bench.ask(forward_open(**{**INPUT_ONLY, **slower, "t_to_o": "3248"}))[2] == 0


def test_the_originator_may_choose_its_udp_port(bench: Any) -> None:
    sender = origin(x8001="0002 1234 00000000 0000000000000000")
    assert bench.ask(forward_open(), sender) == opened()
    assert bench.cyclic.added[0].destination == "192.168.0.10"
    assert bench.cyclic.added[0].destination_port == 0x1234


@pytest.mark.parametrize(
    "item",
    [
        "0002 1234 C0A8000B 0000000000000000",  # address 192.168.0.11 of another machine
        "000A 1234 00000000 0000000000000000",  # not IPv4
        "0002 1234 00000000",  # too short
    ],
)
def test_a_socket_address_of_another_machine_is_refused(bench: Any, item: str) -> None:
    """A socket address item with another machine's address gets extended status 0x205."""
    assert bench.ask(forward_open(), origin(x8001=item)) == refused("0502")
    assert bench.cyclic.added == []


def test_a_reply_names_the_port_of_the_cyclic_part(bench: Any) -> None:
    bench.cyclic.port = 0x4321
    sender = origin()
    bench.ask(forward_open(), sender)
    assert dict(sender.items)[Item.O_TO_T_ADDRESS][2:4] == bytes.fromhex("4321")


@pytest.mark.parametrize(
    "path",
    [
        pytest.param("2004 2405 2C96 2C64", id="the path that was opened"),
        pytest.param("3404 0000 0000 0000 0000 2004 2405 2C96 2C64", id="with an electronic key"),
        pytest.param("2004 2C96 2C64", id="without its configuration instance"),
        pytest.param("2002 2401", id="the Message Router, as in an example of Omron"),
        pytest.param("2006 2401", id="the Connection Manager"),
        pytest.param("0100 2002 2401", id="a route to the backplane"),
        pytest.param("", id="none"),
        pytest.param("2004 0100", id="no path at all"),
    ],
)
def test_a_connection_is_closed_by_its_triad_with_any_path(bench: Any, path: str) -> None:
    """Forward Close accepts any path, as OpENer does. Source: CIP volume 1, chapter 3, 5.5.3."""
    bench.ask(forward_open(path="3404 7C02 2B00 0500 0101 2004 2405 2C96 2C64 8000"))
    assert bench.ask(forward_close(path=path)) == bytes.fromhex(f"CE00 0000 {TRIAD} 00 00")
    assert bench.cyclic.removed == [1]
    assert not bench.device.connections.is_owned
    assert bench.ask(forward_close(path=path)) == refused("0701", "CE")


@pytest.mark.parametrize(
    ("request_", "peer", "reply"),
    [
        (forward_close(triad=OTHER), "192.168.0.10", refused("0701", "CE", OTHER)),
        (forward_close(), "192.168.0.11", bytes.fromhex(f"CE00 0F00 {TRIAD} 00 00")),
    ],
)
def test_a_refused_forward_close_leaves_the_connection(
    bench: Any, request_: str, peer: str, reply: bytes
) -> None:
    """A wrong triad gets extended status 0x107. Another machine gets status 0x0F."""
    bench.ask(forward_open())
    assert bench.ask(request_, origin(peer)) == reply
    assert bench.device.connections.is_owned
    assert bench.cyclic.removed == []


def test_connection_ids_are_random(make_bench: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Connection ids are random, so no originator can guess the owner's id from its own id."""
    drawn = iter([0x8C3F01A7, 0x0152E9D4])
    monkeypatch.setattr("secrets.randbits", lambda bits: next(drawn) if bits == 32 else 0)
    bench = make_bench(draw_id=random_id)
    assert inspect.signature(Device).parameters["draw_id"].default is random_id
    assert bench.ask(forward_open()) == opened("A7013F8C")
    assert bench.ask(forward_open(**INPUT_ONLY, triad=OTHER)) == opened("D4E95201", triad=OTHER)


def test_a_connection_stays_open_when_its_session_ends(bench: Any) -> None:
    bench.ask(forward_open())
    bench.device.unregister(1)
    assert bench.device.connections.is_owned
    assert bench.cyclic.removed == []


def test_other_services_of_the_connection_manager_are_not_supported(bench: Any) -> None:
    for service in ("4D", "56", "57", "5A", "01"):
        reply = bytes([int(service, 16) | 0x80, 0, 0x08, 0])
        assert bench.ask(f"{service} 02 2006 2401") == reply
    assert bench.ask("54 02 2006 2402" + "00" * 36)[2] == 0x05
