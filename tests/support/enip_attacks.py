"""A hostile peer of the EtherNet/IP adapter that draws its attacks from a seed."""

from __future__ import annotations

import socket
import struct
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from random import Random

from enip_frames import HEADER, READ_ONLY, frame, mutate, valid_frames

#: Source address of attacks. Well-behaved peers have other addresses.
ATTACKER = "127.0.0.3"
#: Longest wait for an answer or for the end of a connection [s]. Only a failure takes this long.
_PATIENCE_S = 20.0
_STATUSES = {0x00, 0x01, 0x02, 0x03, 0x64, 0x65, 0x69}
_HELD = 20
_SEND_RR = 0x6F
#: After the header: interface and time-out, number of items, empty address, data type and length.
_GENERAL_STATUS_AT = HEADER.size + 6 + 2 + 4 + 4 + 2


@dataclass(frozen=True)
class Target:
    """The data that the attacker knows: the adapter's addresses and its connection ids.

    Attributes:
        explicit: Host and port of explicit messages, TCP and UDP.
        cyclic: Host and port of cyclic packets.
        ids: Connection ids of the master's connection.
    """

    explicit: tuple[str, int]
    cyclic: tuple[str, int]
    ids: tuple[int, ...]


@dataclass
class Report:
    """Counters of the attacks and of the adapter's answers."""

    seed: int
    attacks: Counter[str] = field(default_factory=Counter)
    statuses: Counter[int] = field(default_factory=Counter)
    replies: Counter[int] = field(default_factory=Counter)
    silent: int = 0
    refused: int = 0
    checks: int = 0
    grown_kib: int = 0

    def text(self) -> str:
        """Return a readable summary of three lines."""
        kinds = ", ".join(f"{name} {number}" for name, number in sorted(self.attacks.items()))
        answers, replies = (
            ", ".join(f"0x{one:02X} {number}" for one, number in sorted(found.items()))
            for found in (self.statuses, self.replies)
        )
        return (
            f"{sum(self.attacks.values())} attacks with seed {self.seed}: {kinds}\n"
            f"encapsulation status {answers}; general status {replies}\n"
            f"{self.silent} connections without an answer, {self.refused} not accepted; "
            f"{self.checks} checks by well-behaved peers; memory grew by {self.grown_kib} KiB"
        )


class _NotTakenError(Exception):
    """The error for an adapter that accepts no more connections from this peer."""


class Attacker:
    """A hostile peer that carries out attacks of every kind."""

    def __init__(self, target: Target, draw: Random, report: Report) -> None:
        self._target, self._draw, self._report = target, draw, report
        self._held: list[socket.socket] = []
        self._slow: list[tuple[socket.socket, bytes]] = []
        self._udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._udp.bind((ATTACKER, 0))
        self.last = b""
        self._kinds: list[tuple[int, Callable[[], None]]] = [
            *((50, self._mutated), (8, self._pieces), (6, self._abandoned), (4, self._oversized)),
            *((6, self._never_closed), (3, self._flood), (8, self._slowly)),
            *((5, self._never_reading), (8, self._udp_explicit), (12, self._udp_cyclic)),
        ]

    def attack(self) -> None:
        """Carry out one attack of a random kind."""
        weights = [weight for weight, _ in self._kinds]
        kind = self._draw.choices([one for _, one in self._kinds], weights)[0]
        self._report.attacks[kind.__name__.lstrip("_").replace("_", " ")] += 1
        with suppress(_NotTakenError):
            kind()

    def close(self) -> None:
        """Close all connections."""
        for one in (*self._held, *(one for one, _ in self._slow), self._udp):
            one.close()

    def _connect(self, receive_buffer: int = 0) -> socket.socket:
        """Connect to the adapter, and return the socket."""
        made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        try:
            made.settimeout(_PATIENCE_S)
            if receive_buffer:
                made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
            made.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            made.bind((ATTACKER, 0))
            made.connect(self._target.explicit)
        except ConnectionError:
            made.close()
            self._report.refused += 1
            raise _NotTakenError from None
        except BaseException:
            made.close()
            raise
        return made

    def _register(self, peer: socket.socket) -> int:
        """Register a session and return its handle, or 0 if the adapter does not give one."""
        try:
            peer.sendall(frame(0x65, b"\x01\x00\x00\x00"))
            answer = _receive(peer, HEADER.size + 4)
        except ConnectionError:
            return 0
        return int(HEADER.unpack_from(answer)[2]) if len(answer) == HEADER.size + 4 else 0

    def _mutated(self) -> None:
        """Send damaged frames in a session, and check that all answers are whole frames."""
        with self._connect() as peer:
            session = self._register(peer)
            frames = valid_frames(self._draw, session)
            chosen = self._draw.choices(frames, k=self._draw.randrange(1, 6))
            self._send_all(peer, b"".join(mutate(self._draw, one) for one in chosen))
            self._take_answers(peer)

    def _pieces(self) -> None:
        """Send frames of random bytes, or valid frames cut at a random place."""
        with self._connect() as peer:
            session = self._register(peer)
            data = b"".join(self._draw.choices(valid_frames(self._draw, session), k=4))
            if self._draw.random() < 0.3:
                data = self._draw.randbytes(self._draw.randrange(1, 400))
            while data:
                size = self._draw.randrange(1, 60)
                self._send_all(peer, data[:size])
                data = data[size:]
            self._take_answers(peer)

    def _abandoned(self) -> None:
        """Send a part of a frame, then reset the connection."""
        with self._connect() as peer:
            peer.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
            whole = self._draw.choice(valid_frames(self._draw, 1))
            self._send_all(peer, whole[: self._draw.randrange(len(whole) + 1)])

    def _oversized(self) -> None:
        """Send a frame of the largest possible length, or only its header."""
        with self._connect() as peer:
            session = self._register(peer)
            command = self._draw.choice((0x00, 0x04, 0x63, 0x65, 0x6F, 0x70, 0xFFFF))
            whole = frame(command, self._draw.randbytes(0xFFFF), session)
            self._send_all(peer, whole[: self._draw.choice((30, 20_000, len(whole)))])
            self._take_answers(peer)

    def _never_closed(self) -> None:
        """Open a connection, with or without a session, and do not close it."""
        peer = self._connect()
        if self._draw.random() < 0.7:
            self._register(peer)
        self._held.append(peer)
        if len(self._held) > _HELD:
            self._held.pop(self._draw.randrange(_HELD)).close()

    def _flood(self) -> None:
        """Open many connections at once."""
        with ExitStack() as peers:
            for _ in range(30):
                with suppress(_NotTakenError):
                    peers.enter_context(self._connect())

    def _slowly(self) -> None:
        """Send a frame byte by byte, between other attacks."""
        if len(self._slow) < 8:
            with suppress(_NotTakenError):
                peer = self._connect()
                self._slow.append((peer, self._draw.choice(valid_frames(self._draw, 1))))
        rest = []
        for peer, data in self._slow:
            self._send_all(peer, data[:3])
            if data[3:]:
                rest.append((peer, data[3:]))
            else:
                peer.close()
        self._slow = rest

    def _never_reading(self) -> None:
        """Send requests without end, and read no answer."""
        with self._connect(receive_buffer=4096) as peer:
            peer.setblocking(False)
            data = self._draw.choice(READ_ONLY) * 100
            self.last = data[:24]
            # the buffers are full, or the adapter has closed the connection
            with suppress(OSError):
                for _ in range(40):
                    peer.send(data)

    def _udp_explicit(self) -> None:
        """Send datagrams to the explicit port."""
        self._send_to(mutate(self._draw, self._draw.choice(valid_frames(self._draw, 0))))

    def _udp_cyclic(self) -> None:
        """Send datagrams to the cyclic port, most of them with ids of the running connection."""
        number = self._draw.choice((*self._target.ids, self._draw.randrange(1 << 32)))
        data = struct.pack("<HI", self._draw.randrange(0x10000), self._draw.choice((1, 0, 3)))
        data += self._draw.randbytes(48)
        sequence = self._draw.choice((0, 1, 0x7FFFFFFF, 0xFFFFFFFF, self._draw.randrange(1 << 32)))
        packet = struct.pack("<HHHIIHH", 2, 0x8002, 8, number, sequence, 0x00B1, len(data)) + data
        if self._draw.random() < 0.5:
            packet = mutate(self._draw, packet)
        self.last = packet
        with suppress(OSError):
            self._udp.sendto(packet, self._target.cyclic)

    def _send_to(self, data: bytes) -> None:
        self.last = data
        with suppress(OSError):
            self._udp.sendto(data, self._target.explicit)

    def _send_all(self, peer: socket.socket, data: bytes) -> None:
        self.last = data
        with suppress(ConnectionError):  # the adapter may close the connection
            peer.sendall(data)

    def _take_answers(self, peer: socket.socket) -> None:
        """Stop sending, and check that the adapter sends only whole frames until it closes."""
        with suppress(OSError):
            peer.shutdown(socket.SHUT_WR)
        data = b""
        try:
            while piece := peer.recv(65536):
                data += piece
        except ConnectionError:
            return  # a reset also discards answers under way
        except TimeoutError:
            raise AssertionError("a connection that the peer ended stays open") from None
        self._report.silent += not data
        while data:
            assert len(data) >= HEADER.size, f"not a frame: {data.hex(' ')}"
            command, length, _, status, _, options = HEADER.unpack_from(data)
            assert status in _STATUSES, f"encapsulation status 0x{status:02X}"
            assert options == 0
            assert len(data) >= HEADER.size + length, f"an unfinished frame: {data.hex(' ')}"
            self._report.statuses[status] += 1
            if command == _SEND_RR and not status:
                self._report.replies[data[_GENERAL_STATUS_AT]] += 1
            data = data[HEADER.size + length :]


def _receive(peer: socket.socket, size: int) -> bytes:
    data = b""
    while len(data) < size and (piece := peer.recv(size - len(data))):
        data += piece
    return data
