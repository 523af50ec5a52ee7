"""The encapsulation layer answers each request as specified, frame by frame in bytes.

A frame has command, length, session, status, sender context, options and data.
"""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import forward_open, opened
from rcx_harness.enip.target.device import Session

CONTEXT = "A1A2A3A4A5A6A7A8"
REGISTER = bytes.fromhex(f"6500 0400 00000000 00000000 {CONTEXT} 00000000 0100 0000")
REGISTERED = bytes.fromhex(f"6500 0400 01000000 00000000 {CONTEXT} 00000000 0100 0000")
# A request for the size of assembly 100: interface 0, time-out 0, a null address item, and
# unconnected data with service 0x0E and a path of three words to class 4, instance 100, attribute
# 4.
GET_SIZE_DATA = "00000000 0000 0200 0000 0000 B200 0800 0E03 2004 2464 3004"
GET_SIZE = bytes.fromhex(f"6F00 1800 01000000 00000000 {CONTEXT} 00000000 {GET_SIZE_DATA}")
SIZE_IS_48 = bytes.fromhex(
    f"6F00 1600 01000000 00000000 {CONTEXT} 00000000"
    "00000000 0000 0200 0000 0000 B200 0600 8E00 0000 3000"
)


def frame(
    command: str, data: str = "", session: int = 1, status: int = 0, options: int = 0
) -> bytes:
    """Return a frame with these data and with CONTEXT as sender context."""
    content = bytes.fromhex(data)
    numbers = session.to_bytes(4, "little") + status.to_bytes(4, "little")
    header = bytes.fromhex(command) + len(content).to_bytes(2, "little") + numbers
    return header + bytes.fromhex(CONTEXT) + options.to_bytes(4, "little") + content


def refused(command: str, status: int, session: int = 1) -> bytes:
    """Return the expected answer of a refused request: a header with an encapsulation status."""
    return frame(command, session=session, status=status)


def test_a_session_is_registered_and_the_senders_context_comes_back(session: Session) -> None:
    assert session.receive(REGISTER) == REGISTERED


def test_a_request_within_the_session_is_answered(registered: Session) -> None:
    assert registered.receive(GET_SIZE) == SIZE_IS_48


def test_a_session_handle_is_valid_on_its_own_connection_only(
    registered: Session, bench: Any
) -> None:
    second = bench.connect()
    assert second.receive(REGISTER)[4:8] == bytes.fromhex("02000000")
    assert second.receive(GET_SIZE) == refused("6F00", 0x64)
    assert registered.receive(GET_SIZE) == SIZE_IS_48


def test_a_second_registration_on_one_connection_is_an_invalid_command(registered: Session) -> None:
    assert registered.receive(frame("6500", "01000000")) == refused("6500", 0x01)
    assert registered.receive(GET_SIZE) == SIZE_IS_48


@pytest.mark.parametrize("data", ["0200 0000", "0000 0000", "0100 0100"])
def test_another_protocol_version_or_option_is_refused_with_the_one_supported(
    session: Session, data: str
) -> None:
    assert session.receive(frame("6500", data, session=0)) == frame(
        "6500", "0100 0000", session=0, status=0x69
    )
    assert session.receive(REGISTER) == REGISTERED


@pytest.mark.parametrize("data", ["", "0100", "0100 0000 00"])
def test_a_registration_of_another_length_is_refused(session: Session, data: str) -> None:
    assert session.receive(frame("6500", data, session=0)) == refused("6500", 0x65, session=0)


def test_a_request_before_the_registration_has_no_valid_session(session: Session) -> None:
    assert session.receive(frame("6F00", GET_SIZE_DATA, session=0)) == refused(
        "6F00", 0x64, session=0
    )
    assert session.receive(GET_SIZE) == refused("6F00", 0x64)


@pytest.mark.parametrize("command", ["0100", "7100", "7200", "FFFF"])
def test_an_unknown_command_is_answered_and_the_session_goes_on(
    registered: Session, command: str
) -> None:
    assert registered.receive(frame(command)) == refused(command, 0x01)
    assert registered.receive(GET_SIZE) == SIZE_IS_48


@pytest.mark.parametrize(
    "data",
    [
        "",  # no data at all
        "00000000 0000",  # no items
        "00000000 0000 0000",  # no item
        "00000000 0000 0100 0000 0000",  # no data item
        # interface 1 instead of 0 (CIP)
        "01000000 0000 0200 0000 0000 B200 0800 0E03 2004 2464 3004",
        # an item that is longer than the frame
        "00000000 0000 0200 0000 0000 B200 0900 0E03 2004 2464 3004",
        "00000000 0000 0200 0000 0000 B200 0800 0E03 2004 2464 3004 00",  # a byte too many
        "00000000 0000 0300 0000 0000 B200 0800 0E03 2004 2464 3004",  # a missing item
        # a connected message
        "00000000 0000 0200 A100 0400 01000000 B100 0800 0E03 2004 2464 3004",
        "00000000 0000 0200 0000 0200 0000 B200 0800 0E03 2004 2464 3004",  # null address with data
        "00000000 0000 0200 0000 0000 B200 0100 0E",  # an incomplete CIP request
    ],
)
def test_data_without_an_unconnected_message_are_refused(registered: Session, data: str) -> None:
    assert registered.receive(frame("6F00", data)) == refused("6F00", 0x03)
    assert registered.receive(GET_SIZE) == SIZE_IS_48


def test_socket_addresses_behind_the_message_are_allowed(registered: Session) -> None:
    data = (
        "00000000 0000 0300 0000 0000 B200 0800 0E03 2004 2464 3004"
        "0180 1000 0002 08AE 00000000 0000000000000000"
    )
    assert registered.receive(frame("6F00", data)) == SIZE_IS_48


@pytest.mark.parametrize("data", ["", "00", "DEADBEEF"])
def test_nop_is_never_answered(registered: Session, data: str) -> None:
    assert registered.receive(frame("0000", data)) == b""
    assert registered.receive(GET_SIZE) == SIZE_IS_48


def test_requests_with_options_or_a_status_are_discarded(registered: Session) -> None:
    assert registered.receive(frame("6F00", GET_SIZE_DATA, options=1)) == b""
    assert registered.receive(frame("6F00", GET_SIZE_DATA, status=1)) == b""
    assert registered.receive(GET_SIZE) == SIZE_IS_48


def test_frames_that_arrive_byte_by_byte_are_put_together(session: Session) -> None:
    answers = [session.receive(bytes([byte])) for byte in REGISTER + GET_SIZE]
    whole = {27: REGISTERED, 28 + 47: SIZE_IS_48}
    assert answers == [whole.get(index, b"") for index in range(28 + 48)]


def test_frames_that_arrive_together_are_answered_in_order(session: Session) -> None:
    head = GET_SIZE[:30]
    assert session.receive(REGISTER + GET_SIZE + head) == REGISTERED + SIZE_IS_48
    assert session.receive(GET_SIZE[30:]) == SIZE_IS_48


def test_unregistering_ends_the_connection_without_an_answer(registered: Session) -> None:
    assert registered.receive(frame("6600") + GET_SIZE) == b""
    assert registered.ended


def test_unregistering_another_session_is_refused(registered: Session) -> None:
    assert registered.receive(frame("6600", session=2)) == refused("6600", 0x64, session=2)
    assert not registered.ended


def test_list_identity_needs_no_session(session: Session) -> None:
    """The answer has one item: type 0x0C, length 57, version, socket address, attributes 1 to 8.

    The attributes are vendor 636 (0x027C), device type 43 (0x2B), product code 5, revision 1.1,
    status
    0x0030, serial number 1, a name of 23 letters, and state 3.

    Source: manual chapter 5, 4 (device type)
    """
    name = b"RCX3 virtual controller".hex()
    assert session.receive(frame("6300", session=0)) == frame(
        "6300",
        "0100 0C00 3900 0100 0002AF12C0A800020000000000000000"
        f"7C02 2B00 0500 01 01 3000 01000000 17{name} 03",
        session=0,
    )


@pytest.mark.parametrize(("cyclic", "flags"), [(True, "2001"), (False, "2000")])
def test_list_services_offers_cip_over_tcp_and_cyclic_io_over_udp(
    make_bench: Any, cyclic: bool, flags: str
) -> None:
    name = b"Communications\0\0".hex()
    assert make_bench(cyclic=cyclic).connect().receive(frame("0400", session=0)) == frame(
        "0400", f"0100 0001 1400 0100 {flags} {name}", session=0
    )


def test_list_interfaces_has_none(session: Session) -> None:
    assert session.receive(frame("6400", session=0)) == frame("6400", "0000", session=0)


@pytest.mark.parametrize("command", ["0400", "6300", "6400"])
def test_a_list_command_has_no_data(session: Session, command: str) -> None:
    assert session.receive(frame(command, "00", session=0)) == refused(command, 0x65, session=0)


@pytest.mark.parametrize("command", ["6F00", "7000", "0000", "0100"])
def test_an_oversized_frame_is_refused_by_its_header_and_ends_the_connection(
    registered: Session, command: str
) -> None:
    """A frame of more than 4160 bytes is refused as soon as its header has arrived."""
    header = bytes.fromhex(f"{command} 4110 01000000 00000000 {CONTEXT} 00000000")
    assert registered.receive(GET_SIZE + header + b"\x00") == SIZE_IS_48 + refused(command, 0x65)
    assert registered.ended
    assert registered.receive(GET_SIZE) == b""


def test_the_longest_frame_is_taken(registered: Session) -> None:
    """A frame with 4160 bytes (0x1040) of data is accepted."""
    header = bytes.fromhex(f"0000 4010 01000000 00000000 {CONTEXT} 00000000")
    assert registered.receive(header + bytes(4160) + GET_SIZE) == SIZE_IS_48


@pytest.mark.parametrize(("sent", "answer"), [(GET_SIZE, SIZE_IS_48), (frame("0000"), b"")])
def test_a_connection_is_overdue_after_120_seconds_without_a_frame(
    bench: Any, registered: Session, sent: bytes, answer: bytes
) -> None:
    """A TCP connection is overdue 120 s after its last frame; a NOP counts as a frame as well."""
    bench.now += 119.9
    assert not registered.is_overdue()
    assert registered.receive(sent) == answer
    bench.now += 119.9
    assert not registered.is_overdue()
    bench.now += 0.1
    assert registered.is_overdue()


def test_the_inactivity_is_attribute_13_of_the_tcp_ip_interface(
    bench: Any, registered: Session
) -> None:
    """Attribute 13 sets the time without frames: 0x000A is 10 s, and 0 means no limit."""
    bench.ask("1003 20F5 2401 300D 0A00")
    bench.now += 10
    assert registered.is_overdue()
    bench.ask("1003 20F5 2401 300D 0000")
    bench.now += 1e6
    assert not registered.is_overdue()


def test_a_frame_that_trickles_in_is_overdue_after_ten_seconds(
    bench: Any, registered: Session
) -> None:
    for byte in GET_SIZE[:20]:
        assert registered.receive(bytes([byte])) == b""
        assert not registered.is_overdue()
        bench.now += 0.5
    assert registered.is_overdue()


def test_the_limit_of_ten_seconds_applies_to_each_frame(bench: Any, registered: Session) -> None:
    for _ in range(5):
        assert registered.receive(GET_SIZE[:30]) == b""
        bench.now += 9
        assert registered.receive(GET_SIZE[30:] + GET_SIZE[:3]) == SIZE_IS_48
        bench.now += 9
        assert not registered.is_overdue()
        assert registered.receive(GET_SIZE[3:]) == SIZE_IS_48


def test_the_65th_session_is_refused_until_another_ends(bench: Any) -> None:
    """The 65th session gets encapsulation status 0x02, insufficient memory."""
    sessions = [bench.connect() for _ in range(65)]
    answers = [session.receive(REGISTER) for session in sessions]
    assert {answer[8:12] for answer in answers[:64]} == {bytes(4)}
    assert len({answer[4:8] for answer in answers[:64]}) == 64
    assert answers[64] == frame("6500", "0100 0000", session=0, status=2)
    sessions[5].close()
    assert sessions[64].receive(REGISTER)[8:12] == bytes(4)


def test_the_reply_to_a_forward_open_has_the_socket_address(registered: Session) -> None:
    """The answer to a Forward Open ends with the socket address of the cyclic I/O (item 0x8000).

    The item has AF_INET, port 2222 and the device's address. The request has a T->O item with port
    0x1234, which is accepted.
    """
    message = forward_open()
    length = len(bytes.fromhex(message))
    data = (
        f"00000000 0000 0300 0000 0000 B200 {length:02X}00 {message}"
        "0180 1000 0002 1234 00000000 0000000000000000"
    )
    assert registered.receive(frame("6F00", data)) == frame(
        "6F00",
        f"00000000 0000 0300 0000 0000 B200 1E00 {opened().hex()}"
        "0080 1000 0002 08AE C0A80002 0000000000000000",
    )


def test_the_reply_to_a_refused_forward_open_has_no_socket_address(registered: Session) -> None:
    message = forward_open(multiplier="08")
    data = f"00000000 0000 0200 0000 0000 B200 {len(bytes.fromhex(message)):02X}00 {message}"
    assert registered.receive(frame("6F00", data)) == frame(
        "6F00", "00000000 0000 0200 0000 0000 B200 1000 D400 0101 3301 0100 4D00 EFBEADDE 0000"
    )
