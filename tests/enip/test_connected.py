"""Explicit messages within a class 3 connection are answered byte by byte as specified.

A SendUnitData frame contains interface 0, time-out 0 and two items: a connected address (0xA1), and
connected data (0xB1) that begin with the sequence count.
"""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import TRIAD, forward_close, forward_open, opened, refused
from rcx_harness.enip.target.connection_manager import Origin
from rcx_harness.enip.target.device import Session

CLASS_3 = {"transport": "A3", "path": "2002 2401", "o_to_t": "F843", "t_to_o": "F843"}
"""Fields of a class 3 Forward Open to the Message Router, with 504 bytes, variable."""

CONTEXT = "A1A2A3A4A5A6A7A8"
GET_SIZE = "0E03 2004 2464 3004"
SIZE_IS_48 = "8E00 0000 3000"


def unit(message: str, connection: str = "01000100", session: str = "01000000") -> bytes:
    """Return a SendUnitData frame with this message and connection id."""
    length = len(bytes.fromhex(message))
    data = f"00000000 0000 0200 A100 0400 {connection} B100 {length:02X}{0:02X} {message}"
    size = len(bytes.fromhex(data))
    return bytes.fromhex(f"7000 {size:02X}00 {session} 00000000 {CONTEXT} 00000000 {data}")


def reply(message: str) -> bytes:
    """Return the expected SendUnitData frame with a reply and the originator's connection id."""
    return unit(message, connection="78563412")


@pytest.fixture
def connected(bench: Any, registered: Session) -> Session:
    """Return session 1 with a class 3 connection.

    Its id is 0x00010001, its time-out 10 ms times 16.
    """
    assert bench.ask(forward_open(**CLASS_3)) == opened()
    return registered


def test_a_request_is_answered_with_its_sequence_count(connected: Session) -> None:
    assert connected.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {SIZE_IS_48}")
    assert connected.receive(unit(f"0200 {GET_SIZE}")) == reply(f"0200 {SIZE_IS_48}")


def test_a_repeated_sequence_count_only_repeats_the_reply(bench: Any, connected: Session) -> None:
    request = unit("0500 1003 2004 2496 3003" + "77" * 48)
    assert connected.receive(request) == reply("0500 9000 0000")
    assert connected.receive(request) == reply("0500 9000 0000")
    assert bench.robot_image.writes == 1
    assert connected.receive(unit(f"0500 {GET_SIZE}")) == reply("0500 9000 0000")
    assert connected.receive(unit(f"0600 {GET_SIZE}")) == reply(f"0600 {SIZE_IS_48}")


def test_a_refused_request_gets_its_status(connected: Session) -> None:
    assert connected.receive(unit("0100 0E03 2004 2465 3003")) == reply("0100 8E00 0500")


@pytest.mark.parametrize(
    "frame",
    [
        unit(f"0100 {GET_SIZE}", connection="02000100"),  # no such connection
        unit("0100 0E"),  # an incomplete request
        unit(""),
    ],
)
def test_a_message_without_connection_or_request_gets_no_reply(
    connected: Session, frame: bytes
) -> None:
    assert connected.receive(frame) == b""
    assert connected.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {SIZE_IS_48}")


def test_a_connection_belongs_to_its_session(bench: Any, connected: Session) -> None:
    other = bench.connect()
    other.receive(bytes.fromhex("6500 0400" + "00" * 20 + "0100 0000"))
    assert other.receive(unit(f"0100 {GET_SIZE}", session="02000000")) == b""
    assert connected.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {SIZE_IS_48}")


def test_a_wrong_session_handle_is_refused(connected: Session) -> None:
    """A message with another session handle gets encapsulation status 0x64."""
    assert connected.receive(unit(f"0100 {GET_SIZE}", session="09000000")) == bytes.fromhex(
        f"7000 0000 09000000 64000000 {CONTEXT} 00000000"
    )


@pytest.mark.parametrize(
    "data",
    [
        "",
        "00000000 0000 0100 A100 0400 01000100",  # no data item
        "01000000 0000 0200 A100 0400 01000100 B100 0200 0100",  # interface 1 instead of 0 (CIP)
        # a connection id of 2 instead of 4 bytes
        "00000000 0000 0200 A100 0200 0100 B100 0200 0100",
        "00000000 0000 0200 0000 0000 B200 0800 0E03 2004 2464 3004",  # an unconnected message
        # an item that is longer than the frame
        "00000000 0000 0200 A100 0400 01000100 B100 0900 0100",
    ],
)
def test_malformed_data_are_refused(connected: Session, data: str) -> None:
    """Malformed data get encapsulation status 0x03."""
    length = len(bytes.fromhex(data))
    head = f"01000000 00000000 {CONTEXT} 00000000"
    assert connected.receive(bytes.fromhex(f"7000 {length:02X}00 {head} {data}")) == bytes.fromhex(
        f"7000 0000 01000000 03000000 {CONTEXT} 00000000"
    )


@pytest.mark.parametrize(
    ("o_to_t", "t_to_o", "answer"), [("0942", "F843", "8E00 1500"), ("F843", "0742", "8E00 1100")]
)
def test_messages_and_replies_fit_the_connections_size(
    bench: Any, registered: Session, o_to_t: str, t_to_o: str, answer: str
) -> None:
    """A message or reply that is longer than the connection's size is refused.

    10 bytes to the device do not fit into 9 bytes (status 0x15). 8 bytes from the device do not fit
    into 7 bytes (status 0x11).
    """
    bench.ask(forward_open(**{**CLASS_3, "o_to_t": o_to_t, "t_to_o": t_to_o}))
    assert registered.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {answer}")


def test_messages_and_replies_may_be_as_long_as_the_connections_size(
    bench: Any, registered: Session
) -> None:
    bench.ask(forward_open(**{**CLASS_3, "o_to_t": "0A42", "t_to_o": "0842"}))
    assert registered.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {SIZE_IS_48}")


@pytest.mark.parametrize("transport", ["83", "93", "A3"])
def test_every_trigger_of_a_server_is_accepted(bench: Any, transport: str) -> None:
    assert bench.ask(forward_open(**{**CLASS_3, "transport": transport})) == opened()


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"path": "2004 2464"}, "2F01"),
        ({"path": "2002 2402"}, "2F01"),
        ({"path": "2002"}, "2F01"),
        ({"path": "2002 2401 2C64"}, "2F01"),
        ({"t_to_o": "F823"}, "2401"),  # multicast
        ({"o_to_t": "0042"}, "2701 A20F"),
        ({"t_to_o": "0042"}, "2801 A20F"),
        ({"o_to_t_rpi": "00000000"}, "1201 0200 E8030000 10270000"),
    ],
)
def test_a_refused_connection_has_its_status(
    bench: Any, fields: dict[str, str], words: str
) -> None:
    assert bench.ask(forward_open(**{**CLASS_3, **fields})) == refused(words)


def test_a_large_connection_has_4002_bytes_at_most(bench: Any) -> None:
    large = {**CLASS_3, "service": "5B", "t_to_o": "A20F0042"}
    assert bench.ask(forward_open(**{**large, "o_to_t": "A30F0042"})) == refused(
        "2701 A20F", service="DB"
    )
    assert bench.ask(forward_open(**{**large, "o_to_t": "A20F0042"})) == opened(service="DB")


@pytest.mark.parametrize("path", ["2002 2401", ""])
def test_a_class_3_connection_is_closed_by_its_triad_with_any_path(
    connected: Session, bench: Any, path: str
) -> None:
    """Forward Close finds a connection by its triad; the path has no effect.

    Source: CIP volume 1, chapter 3, 5.5.3 (Forward Close).
    """
    assert bench.ask(forward_close(path=path)) == bytes.fromhex(f"CE00 0000 {TRIAD} 00 00")
    assert connected.receive(unit(f"0100 {GET_SIZE}")) == b""
    assert bench.ask(forward_close(path=path)) == refused("0701", "CE")


def test_a_class_3_connection_is_closed_with_its_session(connected: Session, bench: Any) -> None:
    connected.close()
    assert bench.ask(forward_open(**CLASS_3)) == opened("02000100")


def test_a_class_3_connection_times_out_after_interval_times_multiplier(
    connected: Session, bench: Any
) -> None:
    """The connection times out after 16 intervals of 10 ms, or 10 s before the first message."""
    bench.now += 9.9
    assert connected.receive(unit(f"0100 {GET_SIZE}")) == reply(f"0100 {SIZE_IS_48}")
    bench.now += 0.159
    assert connected.receive(unit(f"0200 {GET_SIZE}")) == reply(f"0200 {SIZE_IS_48}")
    bench.now += 0.161
    assert connected.receive(unit(f"0300 {GET_SIZE}")) == b""
    assert bench.ask(forward_open(**CLASS_3)) == opened("02000100")


def test_a_connection_never_used_times_out_after_ten_seconds(bench: Any) -> None:
    bench.ask(forward_open(**CLASS_3))
    bench.now += 9.99
    bench.device.connections.expire()
    assert bench.ask(forward_open(**CLASS_3)) == refused("0001")
    bench.now += 0.02
    bench.device.connections.expire()
    assert bench.ask(forward_open(**CLASS_3)) == opened("02000100")


def test_the_number_of_class_3_connections_is_limited(bench: Any) -> None:
    """One machine may have 16 connections, and all machines together 32.

    Further connections get extended status 0x113. The last four are reserved for machines without a
    connection.
    """

    def open_from(peer: str, serial: int) -> bytes:
        triad = f"{serial:02X}00 4D00 EFBEADDE"
        request = bytes.fromhex(forward_open(**CLASS_3, triad=triad))
        reply: bytes = bench.device.router.answer(request, Origin(peer, "192.168.0.2", 1))
        return reply

    assert all(open_from("192.168.0.10", serial)[2] == 0 for serial in range(16))
    assert open_from("192.168.0.10", 16)[2:6] == bytes.fromhex("0101 1301")
    assert all(open_from("192.168.0.11", serial)[2] == 0 for serial in range(16, 28))
    assert open_from("192.168.0.11", 28)[2:6] == bytes.fromhex("0101 1301")
    others = [f"192.168.0.{host}" for host in range(12, 16)]
    assert all(open_from(host, 28 + at)[2] == 0 for at, host in enumerate(others))
    assert open_from("192.168.0.16", 32)[2:6] == bytes.fromhex("0101 1301")
