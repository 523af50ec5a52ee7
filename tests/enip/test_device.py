"""The device has the right status word, protects owned outputs, and handles reset and routing."""

from __future__ import annotations

from typing import Any

import pytest

from forward_open_bytes import TRIAD, forward_close, forward_open, opened, refused
from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.enip.target.device import Session

OTHER = "0200 4D00 EFBEADDE"
INPUT_ONLY = {"o_to_t": "0248", "path": "2004 2405 2C03 2C64"}
STATUS = "0E03 2001 2401 3005"


@pytest.mark.parametrize(
    ("state", "word"),
    [
        (OwnerState.WAITING, "7100"),
        (OwnerState.IDLE, "7100"),
        (OwnerState.RUN, "6100"),
        # there is a new owner, but the state is still that of the previous one
        (OwnerState.TIMED_OUT, "7100"),
    ],
)
def test_the_status_word_says_owned_and_whether_the_master_runs(
    bench: Any, state: OwnerState, word: str
) -> None:
    """Bit 0 of the status word means "owned". Bits 4 to 7 are 6 in RUN, and 7 if all are idle."""
    bench.ask(forward_open())
    bench.owner = state
    assert bench.ask(STATUS) == bytes.fromhex(f"8E00 0000 {word}")


@pytest.mark.parametrize(
    ("state", "word"),
    [(OwnerState.NONE, "3000"), (OwnerState.CLOSED, "3000"), (OwnerState.TIMED_OUT, "2000")],
)
def test_without_connections_the_status_word_says_none_or_faulted(
    bench: Any, state: OwnerState, word: str
) -> None:
    bench.ask(forward_open())
    bench.device.connections.ended(1)
    bench.owner = state
    assert bench.ask(STATUS) == bytes.fromhex(f"8E00 0000 {word}")


def test_an_input_only_connection_does_not_own(bench: Any) -> None:
    bench.ask(forward_open(**INPUT_ONLY))
    assert bench.ask(STATUS) == bytes.fromhex("8E00 0000 7000")


def test_list_identity_shows_the_same_status(bench: Any, session: Session) -> None:
    bench.ask(forward_open())
    bench.owner = OwnerState.RUN
    answer = session.receive(bytes.fromhex("6300 0000") + bytes(20))
    assert answer[24 + 6 + 18 :][8:10] == bytes.fromhex("6100")


def test_outputs_that_are_owned_cannot_be_set_by_messages(bench: Any) -> None:
    """While a connection owns the outputs, a message that sets them gets status 0x0C.

    Each client may read the outputs, and may set them when there is no owner.
    """
    write = "1003 2004 2496 3003" + "55" * 48
    bench.ask(forward_open())
    assert bench.ask(write) == bytes.fromhex("9000 0C00")
    assert bench.robot_image.writes == 0
    assert bench.ask("0E03 2004 2496 3003") == bytes.fromhex("8E00 0000") + bytes(48)
    bench.ask(forward_close())
    assert bench.ask(write) == bytes.fromhex("9000 0000")
    assert bench.to_robot == b"\x55" * 48


@pytest.mark.parametrize("request_", ["0502 2001 2401", "0502 2001 2401 00"])
def test_a_reset_closes_all_connections(bench: Any, registered: Session, request_: str) -> None:
    bench.ask(forward_open(**INPUT_ONLY))
    bench.ask(forward_open(o_to_t="0248", path="2004 2405 2C04 2C64", triad=OTHER))
    explicit = {"transport": "A3", "path": "2002 2401", "triad": "0300 4D00 EFBEADDE"}
    bench.ask(forward_open(**explicit))
    assert bench.ask(request_) == bytes.fromhex("8500 0000")
    assert bench.cyclic.removed == [1], "the listener ends with the owner"
    assert bench.device.connections.cyclic_connections == ()
    assert bench.resets == 1


@pytest.mark.parametrize(
    ("request_", "status"),
    [("0502 2001 2401 01", 0x20), ("0502 2001 2401 02", 0x20), ("0502 2001 2401 0000", 0x15)],
)
def test_another_reset_is_refused(bench: Any, request_: str, status: int) -> None:
    assert bench.ask(request_) == bytes([0x85, 0, status, 0])
    assert bench.resets == 0


def test_a_device_that_is_owned_cannot_be_reset(bench: Any) -> None:
    """A reset of an owned device gets status 0x10, as it would disconnect the robot's master."""
    bench.ask(forward_open())
    assert bench.ask("0502 2001 2401") == bytes.fromhex("8500 1000")
    assert bench.resets == 0
    assert bench.device.connections.is_owned


GET_SIZE = "0E03 2004 2464 3004"
ODD = "1003 2048 2401 3004 3F"  # nine bytes


@pytest.mark.parametrize(
    ("data", "reply"),
    [
        (f"0A0E 0800 {GET_SIZE} 00 00", "8E00 0000 3000"),  # no route: for this device
        # the usual route over port 1, address 0
        (f"0A0E 0800 {GET_SIZE} 01 00 0100", "8E00 0000 3000"),
        (f"0A0E 0900 {ODD} 00 00 00", "9000 0000"),  # a pad byte after an odd length
        (f"0A0E 0900 {ODD} 00 01 00 0100", "9000 0000"),
        ("0A0E 0800 0E03 2004 2465 3004 00 00", "8E00 0500"),  # the message itself is refused
        (f"0A0E 0800 {GET_SIZE} 01 00 0101", "D200 0101 1203 0100"),  # another slot
        (f"0A0E 0800 {GET_SIZE} 01 00 0200", "D200 0101 1103 0100"),  # another port
        (f"0A0E 0800 {GET_SIZE} 02 00 0100 0101", "D200 0101 1203 0200"),  # a route over two ports
        (f"0A0E 0800 {GET_SIZE} 01 00", "D200 1300"),  # no route although a length is given
        (f"0A0E 0800 {GET_SIZE}", "D200 1300"),
        (f"0A0E 0900 {GET_SIZE}", "D200 1300"),
        ("0A0E", "D200 1300"),
        (f"0A0E 0800 {GET_SIZE} 00 00 00", "D200 1500"),
        ("0A0E 0000 00 00", "D200 0101 0502"),  # no message
        ("0A0E 0100 0E 00 00 00", "D200 0101 0502"),  # an incomplete message
    ],
)
def test_unconnected_send_to_ourselves(bench: Any, data: str, reply: str) -> None:
    assert bench.ask(f"52 02 2006 2401 {data}") == bytes.fromhex(reply)


def test_unconnected_send_opens_and_closes_connections(bench: Any) -> None:
    request = forward_open()
    length = len(bytes.fromhex(request))
    send = f"52 02 2006 2401 0A0E {length:02X}00 {request} 01 00 0100"
    assert bench.ask(send) == opened()
    assert bench.ask(send) == refused("0001")
    assert bench.ask(forward_close()) == bytes.fromhex(f"CE00 0000 {TRIAD} 00 00")


def test_unconnected_send_is_not_nested(bench: Any) -> None:
    """An Unconnected Send inside an Unconnected Send gets extended status 0x205."""
    inner = f"52 02 2006 2401 0A0E 0800 {GET_SIZE} 00 00"
    length = len(bytes.fromhex(inner))
    assert bench.ask(f"52 02 2006 2401 0A0E {length:02X}00 {inner} 00 00") == bytes.fromhex(
        "D200 0101 0502"
    )


def test_if_the_cyclic_process_is_lost_its_connections_are_closed(bench: Any) -> None:
    bench.ask(forward_open())
    bench.ask(forward_open(transport="A3", path="2002 2401", triad=OTHER))
    bench.device.connections.forget_cyclic()
    assert bench.ask(STATUS) == bytes.fromhex("8E00 0000 3000")
    assert bench.ask(forward_close(path="", triad=OTHER))[2] == 0
    assert bench.ask(forward_open())[2] == 0
