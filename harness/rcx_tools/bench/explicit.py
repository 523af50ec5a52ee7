"""Explicit messages a second beside stock cpppo, and scans a second in lock-step.

The peer is cpppo's own server with the same two assemblies as tags, started for the run. Both are
asked in turn, in short slices, so that what else the machine does hits both, by the same client: a
plain socket that sends the same bytes again and again, so that the servers are compared. All run
on the same processor. A server that looks at nothing and sends bytes it has ready is asked, too:
no server in Python is faster on this machine. Where RCX_OPENER names the program of OpENer, an
adapter in C, it is the peer of another run.
"""

from __future__ import annotations

import os
import socket
import struct
import subprocess
import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from statistics import median

from rcx_harness.enip.codec.cip import (
    Service,
    Status,
    decode_reply,
    encode_path,
    encode_reply,
    encode_request,
)
from rcx_harness.enip.codec.encapsulation import (
    HEADER_SIZE,
    PROTOCOL_VERSION,
    Command,
    Frame,
    next_frame,
    unconnected,
    unconnected_items,
)
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.target.adapter import Adapter
from rcx_tools.bench.figure import OUT_OF_REACH, Figure, Options, at_least, missing, shown
from rcx_tools.bench.processes import first_line, on_one_processor, running
from rcx_tools.bench.simulation import demo_cell

__all__ = ["GET", "HOST", "Asker", "echo", "measure"]

HOST, _PORT, _SIZE = "127.0.77.9", 44818, 48
_LOOPBACK = "127.0.0.1"
_TAGS = ("IN_100@4/100/3=USINT[48]", "OUT_150@4/150/3=USINT[48]")
GET = encode_request(Service.GET_ATTRIBUTE_SINGLE, encode_path(4, 100, 3))
_SET = encode_request(Service.SET_ATTRIBUTE_SINGLE, encode_path(4, 150, 3), bytes(_SIZE))
_START_S, _LOOK_S = 20.0, 0.1
_SLICES = 10
#: What a request for a session, or for its end, does not exceed [bytes].
_SESSION_REQUEST = HEADER_SIZE + 4


def measure(options: Options) -> dict[str, Figure]:
    """Get/s and Set/s of the adapter and of stock cpppo; scans/s in lock-step."""
    slice_s = (1.0 if options.quick else options.seconds) / _SLICES / 2
    with on_one_processor(), ExitStack() as held:
        stock = held.enter_context(
            running("cpppo.server.enip", ["--no-udp", "--address", f"{HOST}:{_PORT}", *_TAGS])
        )
        theirs = held.enter_context(_asker_of(stock.poll))
        adapter = held.enter_context(Adapter(_SIZE))
        ours = held.enter_context(Asker(*adapter.address))
        bare = held.enter_context(running(__name__, []))
        echoes = held.enter_context(Asker(HOST, int(first_line(bare))))
        gets: list[tuple[float, float]] = []
        sets: list[tuple[float, float]] = []
        fastest: list[float] = []
        for _ in range(_SLICES):
            gets.append((_rate(ours, GET, slice_s), _rate(theirs, GET, slice_s)))
            sets.append((_rate(ours, _SET, slice_s), _rate(theirs, _SET, slice_s)))
            fastest.append(_rate(echoes, GET, slice_s))
    found: dict[str, Figure] = {}
    for name, rates in (("get", gets), ("set", sets)):
        own, peer = median(a for a, _ in rates), median(b for _, b in rates)
        ratio = median(a / b for a, b in rates)
        found[f"explicit_{name}"] = shown(round(own), "requests/s")
        beside = f"stock cpppo {peer:.0f}/s, same client"
        found[f"explicit_{name}_ratio"] = at_least(ratio, "of cpppo", 40, beside)
    ceiling = median(a / b for a, (_, b) in zip(fastest, gets, strict=True))
    beside = f"a server that only sends: {median(fastest):.0f}/s"
    found["explicit_get_ceiling"] = shown(ceiling, "of cpppo", beside)
    found |= _beside_opener(slice_s)
    return found | {"lockstep": at_least(_lockstep(slice_s), "scans/s", 500)}


def _beside_opener(slice_s: float) -> dict[str, Figure]:
    """Get/s of the adapter beside OpENer, which listens on all addresses of the loopback."""
    program = os.environ.get("RCX_OPENER", "")
    if not program:
        why = "OpENer is not found: RCX_OPENER"
        return {"explicit_get_opener": missing("of OpENer", ">= 1", why)}
    with on_one_processor(), ExitStack() as held:
        peer = subprocess.Popen([program, "lo"], stdout=subprocess.DEVNULL)
        held.callback(peer.wait)
        held.callback(peer.terminate)
        theirs = held.enter_context(_asker_of(peer.poll, _LOOPBACK))
        adapter = held.enter_context(Adapter(_SIZE, host=HOST))
        ours = held.enter_context(Asker(*adapter.address))
        rates = [(_rate(ours, GET, slice_s), _rate(theirs, GET, slice_s)) for _ in range(_SLICES)]
    beside = f"OpENer {median(b for _, b in rates):.0f}/s, one client on one processor"
    ratio = median(a / b for a, b in rates)
    return {"explicit_get_opener": at_least(ratio, "of OpENer", 1, beside + OUT_OF_REACH)}


class Asker:
    """A session that asks for one thing again and again, and only looks whether it came.

    Raises:
        EnipError: nobody listens there, or the answer is none.
    """

    def __init__(self, host: str, port: int) -> None:
        with Client(host, port):  # says what is wrong if nobody listens
            pass
        self._socket = socket.create_connection((host, port))
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._frames: dict[bytes, bytes] = {}
        version = struct.pack("<HH", PROTOCOL_VERSION, 0)
        self._session = self._exchange(
            Frame(Command.REGISTER_SESSION, data=version).encode()
        ).session

    def ask(self, message: bytes) -> bytes:
        """Send a CIP request and take its answer, a whole frame."""
        frame = self._frames.get(message)
        if frame is None:
            whole = Frame(Command.SEND_RR_DATA, self._session, data=unconnected(message))
            frame = self._frames[message] = whole.encode()
            answer = unconnected_items(self._exchange(frame).data)
            reply = decode_reply(answer[0]) if answer else None
            if reply is None or reply.status:
                raise EnipError("the bench's request is refused")
        self._socket.sendall(frame)
        return self._whole()

    def _exchange(self, frame: bytes) -> Frame:
        self._socket.sendall(frame)
        found = next_frame(bytearray(self._whole()))
        assert found is not None
        return found

    def _whole(self) -> bytes:
        received = self._socket.recv(4096)
        while len(received) < HEADER_SIZE + int.from_bytes(received[2:4], "little"):
            more = self._socket.recv(4096)
            if not more:
                raise EnipError("the server has closed the connection")
            received += more
        return received

    def __enter__(self) -> Asker:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()


def _asker_of(ended: Callable[[], int | None], host: str = HOST) -> Asker:
    """A session with a peer as soon as it listens.

    Raises:
        EnipError: it does not.
    """
    limit = time.monotonic() + _START_S
    while ended() is None:
        try:
            return Asker(host, _PORT)
        except EnipError:
            if time.monotonic() > limit:
                raise
            time.sleep(_LOOK_S)
    raise EnipError("a peer of this bench has ended at once")


def _rate(asker: Asker, message: bytes, seconds: float) -> float:
    """Requests a second, one after the other."""
    count, start = 0, time.perf_counter()
    while (passed := time.perf_counter() - start) < seconds or not count:
        asker.ask(message)
        count += 1
    return count / passed if passed else 0.0


def _lockstep(seconds: float) -> float:
    """Scans a second of the demo, every packet an exchange over EtherNet/IP; the median."""
    with demo_cell("builtin", link="enip") as cell:
        rates = []
        for _ in range(_SLICES):
            before, start = cell.scans, time.perf_counter()
            while (passed := time.perf_counter() - start) < seconds:
                cell.scan(10)
            rates.append((cell.scans - before) / passed)
    return median(rates)


def echo() -> None:
    """Serve the bench's client without a look at what it sends, until ended."""
    reply = encode_reply(Service.GET_ATTRIBUTE_SINGLE, Status.SUCCESS, bytes(_SIZE))
    answer = Frame(Command.SEND_RR_DATA, data=unconnected(reply)).encode()
    with socket.create_server((HOST, 0)) as server:
        print(server.getsockname()[1], flush=True)
        while True:
            asker, _ = server.accept()
            asker.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            with asker, suppress(ConnectionError):  # it does not wait for the end of its session
                while received := asker.recv(4096):
                    asker.sendall(answer if len(received) > _SESSION_REQUEST else received)


if __name__ == "__main__":
    echo()
