"""The TCP server limits connections and slow clients, so that other clients are served.

The tests use real sockets.
"""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

import pytest

from enip_frames import frame, send_rr
from forward_open_bytes import forward_open
from rcx_harness.enip.target.servers import MAX_CONNECTIONS_OF_PEER, TcpServer

LONG_S = 30.0
REGISTER = frame(0x65, b"\x01\x00\x00\x00")
LIST_INTERFACES = frame(0x64)
GET_SIZE = bytes.fromhex("0E03 2004 2464 3004")

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


def serve(bench: Any, talk: Callable[[TcpServer, int], Awaitable[None]]) -> None:
    """Start a TCP server for the bench's device on 127.0.0.1, and run `talk` with it."""

    async def main() -> None:
        tcp = TcpServer(bench.device)
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(lambda _, context: failures.append(context))
        server = await loop.create_server(tcp.protocol, "127.0.0.1", 0, family=socket.AF_INET)
        try:
            await asyncio.wait_for(talk(tcp, server.sockets[0].getsockname()[1]), LONG_S)
        finally:
            tcp.abort_all()
            server.close()

    failures: list[dict[str, Any]] = []
    asyncio.run(main())
    assert failures == [], "an exception was not handled"


async def say(streams: Streams, data: bytes, answer: int) -> bytes:
    """Send data, and return the next `answer` bytes."""
    streams[1].write(data)
    return await streams[0].readexactly(answer)


async def connect(port: int, host: str = "127.0.0.1") -> Streams:
    """Open a TCP connection to the server from the address `host`."""
    return await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0))


async def register(streams: Streams) -> int:
    """Register a session, and return its handle."""
    answer = await say(streams, REGISTER, 28)
    assert answer[8:12] == bytes(4)
    return int.from_bytes(answer[4:8], "little")


async def read_size(streams: Streams, session: int) -> None:
    """Read the size of assembly 100, and check that it is 48."""
    assert (await say(streams, send_rr(GET_SIZE, session), 46))[-2:] == bytes.fromhex("3000")


async def has_ended(streams: Streams) -> bool:
    """Wait until the server has closed or reset the connection."""
    with suppress(ConnectionError):
        await streams[0].read()
    return True


def test_one_machine_cannot_take_all_connections(bench: Any) -> None:
    """One machine may have 32 connections; further ones are closed at once.

    When one of the 32 has ended, a new one is accepted.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        every = [await connect(port) for _ in range(MAX_CONNECTIONS_OF_PEER)]
        sessions = [await register(streams) for streams in every]
        assert await has_ended(await connect(port))
        await register(await connect(port, "127.0.0.9"))
        await read_size(every[0], sessions[0])

        every[1][1].close()
        await every[1][1].wait_closed()
        while not tcp.has_room("127.0.0.1"):
            await asyncio.sleep(0)
        await register(await connect(port))

    serve(bench, talk)


def test_two_machines_cannot_take_all_connections_from_a_third(bench: Any) -> None:
    """The last 8 of 64 connections are reserved for machines that have no connection."""

    async def talk(tcp: TcpServer, port: int) -> None:
        taken = []
        for number in range(128):
            streams = await connect(port, "127.0.0.5" if number < 64 else "127.0.0.6")
            with suppress(asyncio.IncompleteReadError, ConnectionError):
                await register(streams)
                taken.append(streams)
        assert len(taken) == 56
        for host in ("127.0.0.7", "127.0.0.8"):
            await register(await connect(port, host))

    serve(bench, talk)


def test_idle_connections_of_many_machines_do_not_block_a_new_master(bench: Any) -> None:
    """A 65th connection replaces the oldest idle one, but never the owner's.

    The 64 connections are the owner's, 40 without a session, and 23 with a session but no request.
    No time passes.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        owner = await connect(port, "127.0.1.200")
        opening = send_rr(bytes.fromhex(forward_open()), await register(owner))
        header = await say(owner, opening, 24)
        await owner[0].readexactly(int.from_bytes(header[2:4], "little"))
        assert bench.device.connections.is_owned

        silent, sessions = [], []
        for number in range(1, 81):
            bench.now += 0.001
            streams = await connect(port, f"127.0.1.{number}")
            if number % 2:
                await register(streams)
                sessions.append(streams)
            else:
                while len(tcp.connections) < min(number + 1, 64):
                    await asyncio.sleep(0)
                silent.append(streams)
        await register(await connect(port, "127.0.1.201"))
        assert len(tcp.connections) == 64
        assert await has_ended(silent[0]), (
            "the oldest connection without a session has been closed first"
        )
        await say(sessions[0], LIST_INTERFACES, 26)
        await say(owner, LIST_INTERFACES, 26)

    serve(bench, talk)


@pytest.mark.parametrize(("silent_s", "gets_in"), [(9.9, False), (10.0, True)])
def test_a_used_session_is_replaced_only_after_ten_seconds_of_silence(
    bench: Any, silent_s: float, gets_in: bool
) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        working = [await connect(port, f"127.0.1.{number}") for number in range(1, 65)]
        for streams in working:
            await read_size(streams, await register(streams))
        bench.now += silent_s
        late = await connect(port, "127.0.1.100")
        late[1].write(REGISTER)
        answer = b""
        with suppress(ConnectionError):
            answer = await late[0].read(28)
        assert len(answer) == (28 if gets_in else 0)
        assert len(tcp.connections) == len(working)

    serve(bench, talk)


def test_only_overdue_connections_are_closed(bench: Any) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        silent, slow, busy = [await connect(port) for _ in range(3)]
        for streams in (silent, slow, busy):
            session = await register(streams)
        bench.now += 111
        asked = send_rr(GET_SIZE, session)
        slow[1].write(asked + asked[:9])
        await slow[0].readexactly(24)
        await say(busy, LIST_INTERFACES, 26)
        bench.now += 10
        await say(busy, LIST_INTERFACES, 26)
        tcp.close_overdue()
        assert await has_ended(silent)
        assert await has_ended(slow)
        await say(busy, LIST_INTERFACES, 26)

    serve(bench, talk)


def test_an_oversized_frame_closes_its_connection_only(bench: Any) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        bad, good = [await connect(port) for _ in range(2)]
        answer = await say(bad, bytes.fromhex("6F00 FFFF") + bytes(20) + bytes(100), 24)
        assert answer[8:12] == bytes.fromhex("65000000")
        assert await has_ended(bad)
        await register(good)

    serve(bench, talk)


def test_a_long_frame_gets_one_answer(bench: Any) -> None:
    """A write request with 3,000 bytes gets one answer, status 0x15 (too much data).

    The next request is answered as well.

    Source: CIP volume 1, appendix B, general status codes.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        streams = await connect(port)
        session = await register(streams)
        message = bytes.fromhex("1003 2004 2496 3003") + bytes(3000)
        answer = await say(streams, send_rr(message, session), 44)
        assert answer[-4:] == bytes.fromhex("90001500")
        await read_size(streams, session)

    serve(bench, talk)


def test_endless_requests_of_one_peer_do_not_block_the_others(
    bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If one client sends 2,000 requests at once, other clients are answered in between."""
    listing = bench.device.listing
    answer, asked = listing.answer, []

    def counting(*args: Any) -> Any:
        asked.append(args)
        return answer(*args)

    monkeypatch.setattr(listing, "answer", counting)

    async def talk(tcp: TcpServer, port: int) -> None:
        greedy, neighbour = [await connect(port) for _ in range(2)]
        length = len(await say(greedy, frame(0x04), 50))
        greedy[1].write(2000 * frame(0x04))
        while len(asked) < 10:
            await asyncio.sleep(0)
        await register(neighbour)
        assert len(asked) < 1500
        await greedy[0].readexactly(2000 * length)
        assert len(asked) == 2001

    serve(bench, talk)


def test_requests_of_a_client_that_reads_no_answers_are_not_read(bench: Any) -> None:
    """If a client does not read its answers, the server stops reading its requests.

    So the server's memory for waiting answers is limited.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        small = socket.socket()
        small.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        small.connect(("127.0.0.1", port))
        reader, writer = await asyncio.open_connection(sock=small)
        while not tcp.connections:
            await asyncio.sleep(0)
        (connection,) = tcp.connections
        transport = connection.transport
        wire = transport.get_extra_info("socket")
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
        question = frame(0x63)
        writer.transport.pause_reading()  # type: ignore[attr-defined]
        while transport.is_reading():
            writer.write(question * 200)
            await asyncio.sleep(0)
        waiting = transport.get_write_buffer_size()
        assert waiting < 2_000_000
        for _ in range(20):
            writer.write(question * 200)
            await asyncio.sleep(0)
        assert transport.get_write_buffer_size() <= waiting

        writer.transport.resume_reading()  # type: ignore[attr-defined]
        while not transport.is_reading():
            assert await reader.read(1 << 20)

    serve(bench, talk)


@pytest.mark.parametrize(("code_point", "tos"), [(27, 108), (5, 20)])
def test_explicit_messages_have_their_code_point(bench: Any, code_point: int, tos: int) -> None:
    """New TCP connections have the code point of attribute 8 of the QoS object."""
    bench.ask(f"1003 2048 2401 3008 {code_point:02X}")

    async def talk(tcp: TcpServer, port: int) -> None:
        await register(await connect(port))
        (connection,) = tcp.connections
        wire = connection.transport.get_extra_info("socket")
        assert wire.getsockopt(socket.IPPROTO_IP, socket.IP_TOS) == tos

    serve(bench, talk)
