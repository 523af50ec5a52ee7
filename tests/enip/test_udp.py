"""The encapsulation over UDP: three commands, to us or to everybody."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.enip.udp import Datagrams, Delayed

LOCAL = ("192.168.0.2", 44818)
CONTEXT = "0000A3A4A5A6A7A8"
NAME = b"RCX3 virtual controller".hex()
IDENTITY = (
    "0100 0C00 3900 0100 0002AF12C0A800020000000000000000"
    f"7C02 2B00 0500 01 01 3000 01000000 17{NAME} 03"
)


def frame(command: str, data: str = "", context: str = CONTEXT, status: str = "00000000") -> bytes:
    content = bytes.fromhex(data)
    head = f"{command} {len(content):02X}00 00000000 {status} {context} 00000000"
    return bytes.fromhex(head) + content


@pytest.fixture
def datagrams(bench: Any) -> Datagrams:
    return Datagrams(bench.device.listing, lambda: 0.5)


@pytest.mark.parametrize("broadcast", [False, True])
@pytest.mark.parametrize(
    ("command", "data"),
    [("0400", f"0100 0001 1400 0100 2001 {b'Communications'.hex()} 0000"), ("6400", "0000")],
)
def test_services_and_interfaces_are_listed_at_once(
    datagrams: Datagrams, command: str, data: str, broadcast: bool
) -> None:
    assert datagrams.answer(frame(command), LOCAL, broadcast) == Delayed(frame(command, data), 0.0)


def test_the_identity_is_told_at_once_to_who_asks_us(datagrams: Datagrams) -> None:
    assert datagrams.answer(frame("6300"), LOCAL, False) == Delayed(frame("6300", IDENTITY), 0.0)


@pytest.mark.parametrize(
    ("longest", "delay_s"),
    [
        ("0000", 1.0),  # 2 s where nothing is said
        ("0100", 0.25),  # at least 500 ms
        ("F401", 0.25),
        ("E803", 0.5),  # 1000 ms
        ("FFFF", 32.7675),
    ],
)
def test_the_answer_to_everybody_comes_after_a_random_delay(
    datagrams: Datagrams, longest: str, delay_s: float
) -> None:
    """The longest is in the sender context, in ms; here the dice show one half."""
    context = f"{longest} A3A4A5A6A7A8"
    answer = datagrams.answer(frame("6300", context=context), LOCAL, True)
    assert answer == Delayed(frame("6300", IDENTITY, context=context), delay_s)


@pytest.mark.parametrize("command", ["6500", "6600", "6F00", "7000", "0100", "FFFF"])
def test_what_needs_a_session_is_no_command_here(datagrams: Datagrams, command: str) -> None:
    """Encapsulation status 0x01; nothing if it was said to everybody."""
    request = frame(command, "0100 0000" if command == "6500" else "")
    answer = frame(command, status="01000000")
    assert datagrams.answer(request, LOCAL, False) == Delayed(answer, 0.0)
    assert datagrams.answer(request, LOCAL, True) is None


def test_a_list_command_with_data_has_a_wrong_length(datagrams: Datagrams) -> None:
    """Encapsulation status 0x65; nothing if it was said to everybody."""
    answer = frame("6300", status="65000000")
    assert datagrams.answer(frame("6300", "00"), LOCAL, False) == Delayed(answer, 0.0)
    assert datagrams.answer(frame("6300", "00"), LOCAL, True) is None


@pytest.mark.parametrize(
    ("why", "datagram"),
    [
        ("nothing", b""),
        ("no whole header", frame("6300")[:23]),
        ("shorter than it says", frame("6300", "0102")[:-1]),
        ("longer than it says", frame("6300") + b"\x00"),
        ("two frames", frame("6300") * 2),
        ("NOP", frame("0000")),
        ("an answer", frame("6300", status="01000000")),
        ("options", frame("6300")[:20] + b"\x01\x00\x00\x00"),
    ],
)
@pytest.mark.parametrize("broadcast", [False, True])
def test_anything_else_is_discarded(
    datagrams: Datagrams, why: str, datagram: bytes, broadcast: bool
) -> None:
    assert datagrams.answer(datagram, LOCAL, broadcast) is None, why
