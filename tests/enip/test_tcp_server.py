"""The TCP port with real sockets: how many, how slow, and what becomes of the others."""

from __future__ import annotations

import asyncio
import socket
import struct
from collections.abc import Awaitable, Callable
from contextlib import suppress
from typing import Any

import pytest

from forward_open_bytes import forward_open
from rcx_harness.enip.target.servers import MAX_CONNECTIONS_OF_PEER, TcpServer

LONG_S = 30.0
REGISTER = bytes.fromhex("6500 0400" + "00" * 20 + "0100 0000")
GET_SIZE = bytes.fromhex(
    "6F00 1800 01000000 00000000 0000000000000000 00000000"
    "00000000 0000 0200 0000 0000 B200 0800 0E03 2004 2464 3004"
)

Streams = tuple[asyncio.StreamReader, asyncio.StreamWriter]


def serve(bench: Any, talk: Callable[[TcpServer, int], Awaitable[None]]) -> None:
    """Run `talk` with a server of the bench's device on a port of 127.0.0.1."""

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
    assert failures == [], "an exception that nobody has taken"


async def say(streams: Streams, data: bytes, answer: int) -> bytes:
    """Send, and read that many bytes."""
    streams[1].write(data)
    return await streams[0].readexactly(answer)


async def has_ended(streams: Streams) -> bool:
    """Wait for the end of the connection, orderly or not."""
    with suppress(ConnectionError):
        await streams[0].read()
    return True


def test_one_machine_cannot_take_all_connections(bench: Any) -> None:
    """32 of one peer; one more is closed at once, and one may come when one has gone."""

    async def talk(tcp: TcpServer, port: int) -> None:
        all_streams = [
            await asyncio.open_connection("127.0.0.1", port) for _ in range(MAX_CONNECTIONS_OF_PEER)
        ]
        first = await say(all_streams[0], REGISTER, 28)
        for streams in all_streams[1:]:
            assert (await say(streams, REGISTER, 28))[8:12] == bytes(4)
        assert await has_ended(await asyncio.open_connection("127.0.0.1", port))
        neighbour = await asyncio.open_connection("127.0.0.1", port, local_addr=("127.0.0.9", 0))
        assert (await say(neighbour, REGISTER, 28))[8:12] == bytes(4)
        get_size = GET_SIZE[:4] + first[4:8] + GET_SIZE[8:]
        assert (await say(all_streams[0], get_size, 46))[-2:] == bytes.fromhex("3000")

        all_streams[1][1].close()
        await all_streams[1][1].wait_closed()
        while not tcp.has_room("127.0.0.1"):
            await asyncio.sleep(0)
        again = await asyncio.open_connection("127.0.0.1", port)
        assert (await say(again, REGISTER, 28))[8:12] == bytes(4)

    serve(bench, talk)


def test_two_machines_cannot_take_all_connections_from_a_third(bench: Any) -> None:
    """The last 8 of 64 are for addresses that have none yet; each gets connection and session."""

    async def talk(tcp: TcpServer, port: int) -> None:
        async def connect(host: str) -> Streams:
            return await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0))

        taken = []
        for host in ("127.0.0.5", "127.0.0.6"):
            for _ in range(64):
                streams = await connect(host)
                with suppress(asyncio.IncompleteReadError, ConnectionError):
                    await say(streams, REGISTER, 28)
                    taken.append(streams)
        assert len(taken) == 56
        for host in ("127.0.0.7", "127.0.0.8"):
            assert (await say(await connect(host), REGISTER, 28))[8:12] == bytes(4)

    serve(bench, talk)


def test_eighty_idle_connections_of_eighty_machines_keep_no_new_master_out(bench: Any) -> None:
    """Who has said nothing gives way, the oldest first; an owner's session never does.

    64 connections are all there can be: the owner's, 40 without a session and 23 with one that has
    asked for nothing. No time passes.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        async def connect(number: int) -> Streams:
            host = f"127.0.1.{number}"
            return await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0))

        owner = await connect(200)
        session = (await say(owner, REGISTER, 28))[4:8]
        message = bytes.fromhex(forward_open())
        items = bytes.fromhex("00000000 0000 0200 0000 0000 B200") + struct.pack("<H", len(message))
        head = bytes.fromhex("6F00") + struct.pack("<H", len(items + message)) + session + bytes(16)
        header = await say(owner, head + items + message, 24)
        await owner[0].readexactly(int.from_bytes(header[2:4], "little"))
        assert bench.device.connections.is_owned

        silent, sessions = [], []
        for number in range(1, 81):
            bench.now += 0.001
            streams = await connect(number)
            if number % 2:
                await say(streams, REGISTER, 28)
                sessions.append(streams)
            else:
                while len(tcp.connections) < min(number + 1, 64):
                    await asyncio.sleep(0)
                silent.append(streams)
        master = await connect(201)
        assert (await say(master, REGISTER, 28))[8:12] == bytes(4)
        assert len(tcp.connections) == 64
        assert await has_ended(silent[0]), "the oldest without a session has gone first"
        await say(sessions[0], bytes.fromhex("6400 0000") + bytes(20), 26)
        await say(owner, bytes.fromhex("6400 0000") + bytes(20), 26)

    serve(bench, talk)


@pytest.mark.parametrize(("silent_s", "gets_in"), [(9.9, False), (10.0, True)])
def test_a_session_that_works_gives_way_only_after_ten_seconds_of_silence(
    bench: Any, silent_s: float, gets_in: bool
) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        async def connect(number: int) -> Streams:
            host = f"127.0.1.{number}"
            return await asyncio.open_connection("127.0.0.1", port, local_addr=(host, 0))

        working = [await connect(number) for number in range(1, 65)]
        for streams in working:
            session = (await say(streams, REGISTER, 28))[4:8]
            await say(streams, GET_SIZE[:4] + session + GET_SIZE[8:], 46)
        bench.now += silent_s
        late = await connect(100)
        late[1].write(REGISTER)
        answer = b""
        with suppress(ConnectionError):
            answer = await late[0].read(28)
        assert len(answer) == (28 if gets_in else 0)
        assert len(tcp.connections) == len(working)

    serve(bench, talk)


def test_the_overdue_are_closed_and_the_others_stay(bench: Any) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        silent, slow, busy = [await asyncio.open_connection("127.0.0.1", port) for _ in range(3)]
        for streams in (silent, slow, busy):
            await say(streams, REGISTER, 28)
        bench.now += 111
        slow[1].write(GET_SIZE + GET_SIZE[:9])
        await slow[0].readexactly(24)
        await say(busy, bytes.fromhex("6400 0000") + bytes(20), 26)
        bench.now += 10
        await say(busy, bytes.fromhex("6400 0000") + bytes(20), 26)
        tcp.close_overdue()
        assert await has_ended(silent)
        assert await has_ended(slow)
        await say(busy, bytes.fromhex("6400 0000") + bytes(20), 26)

    serve(bench, talk)


def test_an_oversized_frame_closes_its_connection_only(bench: Any) -> None:
    async def talk(tcp: TcpServer, port: int) -> None:
        bad, good = [await asyncio.open_connection("127.0.0.1", port) for _ in range(2)]
        answer = await say(bad, bytes.fromhex("6F00 FFFF") + bytes(20) + bytes(100), 24)
        assert answer[8:12] == bytes.fromhex("65000000")
        assert await has_ended(bad)
        await say(good, REGISTER, 28)

    serve(bench, talk)


def test_a_frame_longer_than_one_turn_is_answered_as_one(bench: Any) -> None:
    """Set of assembly 150 with 3,000 bytes: too many, status 0x15; then the next request.

    Source: CIP volume 1, appendix B, general status codes.
    """

    async def talk(tcp: TcpServer, port: int) -> None:
        streams = await asyncio.open_connection("127.0.0.1", port)
        session = (await say(streams, REGISTER, 28))[4:8]
        message = bytes.fromhex("1003 2004 2496 3003") + bytes(3000)
        items = bytes.fromhex("00000000 0000 0200 0000 0000 B200") + len(message).to_bytes(
            2, "little"
        )
        length = (len(items) + len(message)).to_bytes(2, "little")
        head = bytes.fromhex("6F00") + length + session + bytes(16)
        answer = await say(streams, head + items + message, 44)
        assert answer[-4:] == bytes.fromhex("90001500")
        get_size = GET_SIZE[:4] + session + GET_SIZE[8:]
        assert (await say(streams, get_size, 46))[-2:] == bytes.fromhex("3000")

    serve(bench, talk)


def test_who_asks_without_end_leaves_the_others_their_turn(
    bench: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two thousand requests in one piece; a neighbour's answer does not wait for all of them."""
    listing = bench.device.listing
    answer, asked = listing.answer, []

    def counting(*args: Any) -> Any:
        asked.append(args)
        return answer(*args)

    monkeypatch.setattr(listing, "answer", counting)
    list_services = bytes.fromhex("0400 0000") + bytes(20)

    async def talk(tcp: TcpServer, port: int) -> None:
        greedy, neighbour = [await asyncio.open_connection("127.0.0.1", port) for _ in range(2)]
        (length,) = {len(await say(greedy, list_services, 50))}
        greedy[1].write(2000 * list_services)
        while len(asked) < 10:
            await asyncio.sleep(0)
        assert (await say(neighbour, REGISTER, 28))[8:12] == bytes(4)
        assert len(asked) < 1500
        await greedy[0].readexactly(2000 * length)
        assert len(asked) == 2001

    serve(bench, talk)


def test_who_takes_no_answers_is_not_listened_to(bench: Any) -> None:
    """What waits for a peer is bounded: its requests stay in its own machine."""

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
        question = bytes.fromhex("6300 0000") + bytes(20)
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
def test_explicit_messages_bear_their_code_point(bench: Any, code_point: int, tos: int) -> None:
    """Attribute 8 of the QoS object, for connections that come afterwards."""
    bench.ask(f"1003 2048 2401 3008 {code_point:02X}")

    async def talk(tcp: TcpServer, port: int) -> None:
        await say(await asyncio.open_connection("127.0.0.1", port), REGISTER, 28)
        (connection,) = tcp.connections
        wire = connection.transport.get_extra_info("socket")
        assert wire.getsockopt(socket.IPPROTO_IP, socket.IP_TOS) == tos

    serve(bench, talk)
