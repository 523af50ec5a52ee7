"""The client for explicit messages reports adapters that are missing, silent or wrong."""

from __future__ import annotations

import socket
import threading
from collections.abc import Callable, Iterator

import pytest

from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.originator.client import Client
from structured_text.errors import InputError

REGISTERED = bytes.fromhex("6500 0400 07000000 00000000 0100000000000000 00000000 0100 0000")
HEAD = "07000000 00000000 0200000000000000 00000000 00000000 0000 0200 0000 0000 B200"
# A SendRRData frame: reply of Get_Attribute_Single with the value 0x0030, little endian
SIZE_IS_48 = bytes.fromhex(f"6F00 1600 {HEAD} 0600 8E00 0000 3000")

Serve = Callable[..., tuple[str, int]]


@pytest.fixture
def adapter_that_says() -> Iterator[Serve]:
    """Return a function that starts a simulated adapter with a list of answers."""
    ends: list[Callable[[], None]] = []

    def serve(*answers: bytes) -> tuple[str, int]:
        server = socket.create_server(("127.0.0.1", 0))

        def talk() -> None:
            wire, _ = server.accept()
            with wire:
                for answer in answers:
                    wire.recv(4096)
                    wire.sendall(answer)
                if answers and answers[-1] == b"":
                    wire.recv(4096)

        thread = threading.Thread(target=talk)
        thread.start()
        ends.extend([thread.join, server.close])
        host, port = server.getsockname()
        return host, port

    yield serve
    for end in ends:
        end()


def test_the_time_limit_applies_to_the_whole_answer(
    adapter_that_says: Serve,
) -> None:
    """The limit of 5 s applies to the whole answer, not to each byte.

    The first byte arrives after 1 s. After 6 s the client does not wait for more bytes.
    """
    times = iter([0.0, 1.0, 6.0])
    host, port = adapter_that_says(REGISTERED[:1])
    with pytest.raises(EnipError, match="nothing within 5 s"):
        Client(host, port, clock=lambda: next(times))


def test_requests_are_the_bytes_of_the_protocol() -> None:
    sent = []
    with socket.create_server(("127.0.0.1", 0)) as server:

        def talk() -> None:
            wire, _ = server.accept()
            with wire:
                for answer in (REGISTERED, SIZE_IS_48, b""):
                    sent.append(wire.recv(4096))
                    wire.sendall(answer)

        thread = threading.Thread(target=talk)
        thread.start()
        with Client(*server.getsockname()) as master:
            assert master.get_attribute(4, 0x164, 4) == bytes.fromhex("3000")
        thread.join()
    context = "0200000000000000"
    assert sent == [
        bytes.fromhex("6500 0400 00000000 00000000 0100000000000000 00000000 0100 0000"),
        bytes.fromhex(
            f"6F00 1A00 07000000 00000000 {context} 00000000"
            "00000000 0000 0200 0000 0000 B200 0A00 0E04 2004 2500 6401 3004"
        ),
        bytes.fromhex("6600 0000 07000000 00000000 0000000000000000 00000000"),
    ]


def test_a_missing_adapter_is_reported() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        host, port = server.getsockname()
    with pytest.raises(
        InputError, match=f"no connection .* at {host}:{port}.*check that it is running"
    ):
        Client(host, port)


@pytest.mark.parametrize(("host", "port"), [("127.0.0.1", 70000), ("not..a.name", 1)])
def test_an_invalid_address_is_reported(host: str, port: int) -> None:
    with pytest.raises(EnipError, match=f"no connection .* at {host}:{port}"):
        Client(host, port)


def test_an_adapter_that_does_not_answer_is_reported(adapter_that_says: Serve) -> None:
    with pytest.raises(EnipError, match=r"nothing within 0\.05 s"):
        Client(*adapter_that_says(b""), timeout_s=0.05)


def test_an_adapter_that_ends_the_connection_is_reported(adapter_that_says: Serve) -> None:
    with pytest.raises(EnipError, match="the end of the connection"):
        Client(*adapter_that_says(REGISTERED[:20]))


def test_an_encapsulation_status_is_reported(adapter_that_says: Serve) -> None:
    refused = bytes.fromhex("6500 0000 00000000 69000000 0100000000000000 00000000")
    with pytest.raises(EnipError, match="encapsulation status 0x69"):
        Client(*adapter_that_says(refused))


@pytest.mark.parametrize(
    ("why", "answer"),
    [
        ("another command", b"\x70" + SIZE_IS_48[1:]),
        ("another context", SIZE_IS_48.replace(bytes.fromhex("02" + "00" * 7), b"\xff" * 8, 1)),
        ("another service", SIZE_IS_48.replace(b"\x8e", b"\x90")),
        ("a request instead of a reply", SIZE_IS_48.replace(b"\x8e", b"\x0e")),
        ("a reply cut off", bytes.fromhex(f"6F00 1300 {HEAD} 0300 8E00 00")),
        ("no message in it", bytes.fromhex(f"6F00 0800 {HEAD[:44]} 00000000 0000 0000")),
    ],
)
def test_an_answer_that_does_not_belong_to_the_request_is_refused(
    adapter_that_says: Serve, why: str, answer: bytes
) -> None:
    client = Client(*adapter_that_says(REGISTERED, answer))
    with pytest.raises(EnipError, match="does not belong"):
        client.get_attribute(4, 100, 4)
    with pytest.raises(EnipError, match="failed to answer"):
        client.get_attribute(4, 100, 4)
    client.close()


def test_an_answer_in_pieces_is_put_together(adapter_that_says: Serve) -> None:
    address = adapter_that_says(REGISTERED + SIZE_IS_48[:30], SIZE_IS_48[30:])
    with Client(*address) as client:
        assert client.get_attribute(4, 100, 4) == bytes.fromhex("3000")
