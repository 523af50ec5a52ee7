"""Over UDP, the device answers three encapsulation commands, by unicast or broadcast."""

from __future__ import annotations

import asyncio
import socket
import sys
from typing import Any

import pytest

from rcx_harness.enip.target.listing import Datagrams, Delayed
from rcx_harness.enip.target.servers import UdpServer

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


def test_a_direct_question_for_the_identity_is_answered_at_once(datagrams: Datagrams) -> None:
    assert datagrams.answer(frame("6300"), LOCAL, False) == Delayed(frame("6300", IDENTITY), 0.0)


@pytest.mark.parametrize(
    ("longest", "delay_s"),
    [
        ("0000", 1.0),  # half of 2 s, the default
        ("0100", 0.25),  # half of 500 ms, the minimum
        ("F401", 0.25),
        ("E803", 0.5),  # half of 1000 ms
        ("FFFF", 32.7675),
    ],
)
def test_the_answer_to_a_broadcast_has_a_random_delay(
    datagrams: Datagrams, longest: str, delay_s: float
) -> None:
    """An answer to a broadcast is delayed at random, up to the time [ms] in the sender context.

    Here the random number is one half.
    """
    context = f"{longest} A3A4A5A6A7A8"
    answer = datagrams.answer(frame("6300", context=context), LOCAL, True)
    assert answer == Delayed(frame("6300", IDENTITY, context=context), delay_s)


@pytest.mark.parametrize("command", ["6500", "6600", "6F00", "7000", "0100", "FFFF"])
def test_commands_that_need_a_session_are_refused_over_udp(
    datagrams: Datagrams, command: str
) -> None:
    """Other commands get encapsulation status 0x01 over UDP. A broadcast gets no answer."""
    request = frame(command, "0100 0000" if command == "6500" else "")
    answer = frame(command, status="01000000")
    assert datagrams.answer(request, LOCAL, False) == Delayed(answer, 0.0)
    assert datagrams.answer(request, LOCAL, True) is None


def test_a_list_command_with_data_has_a_wrong_length(datagrams: Datagrams) -> None:
    """A list command with data gets encapsulation status 0x65. A broadcast gets no answer."""
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


@pytest.mark.skipif(sys.platform != "linux", reason="broadcasts on the loopback are Linux's")
def test_after_eighty_broadcasts_of_one_machine_all_are_answered(bench: Any) -> None:
    """One machine's broadcasts have at most eight delayed answers; others are sent at once.

    The sender context FFFF allows a delay of 65.5 s.
    """
    draws = iter([1.0] * 80)
    datagrams = Datagrams(bench.device.listing, lambda: next(draws, 0.0001))
    patient, hasty = (
        frame("6300", context="FFFF000000000000"),
        frame("6300", context="01" + "00" * 7),
    )

    async def main() -> None:
        with udp("127.0.0.3") as free:
            port = free.getsockname()[1]
        server = UdpServer(datagrams, ("127.0.0.3", port), ["127.255.255.255"])
        await server.start()
        to_all = ("127.255.255.255", port)
        loop = asyncio.get_running_loop()
        with udp("127.0.0.5") as noisy, udp("127.0.0.6") as other:
            for _ in range(80):
                noisy.sendto(patient, to_all)
            for _ in range(72):
                assert (await asyncio.wait_for(loop.sock_recv(noisy, 1500), 30))[:2] == b"\x63\x00"
            assert server.delayed == ["127.0.0.5"] * 8
            for asking in (other, noisy):
                asking.sendto(hasty, to_all)
                answer = await asyncio.wait_for(loop.sock_recv(asking, 1500), 30)
                assert answer[12:14] == b"\x01\x00"

    def udp(host: str) -> socket.socket:
        wire = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        wire.setblocking(False)
        wire.bind((host, 0))
        return wire

    asyncio.run(main())
