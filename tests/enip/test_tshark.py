"""Wireshark's dissector, an independent program, finds no mistake in the captured packets.

The tests are skipped if tshark is missing or may not capture on the loopback interface. On Debian,
`apt install tshark`, and run as root or in the group wireshark.
"""

from __future__ import annotations

import os
import queue
import shutil
import signal
import socket
import struct
import subprocess
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import pytest

from rcx_harness.enip.cyclic.connections import ConnectionKind
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.look.judge.judge import JudgeOptions, judge

TSHARK = shutil.which("tshark")
PORT, IO_PORT = 44818, 2222
PATIENCE_S = 30.0
ERROR = 0x00800000  # the number of severity "error" in tshark
LIST_IDENTITY = struct.pack("<HHII8sI", 0x63, 0, 0, 0, b"probe\0\0\0", 0)

pytestmark = pytest.mark.skipif(TSHARK is None, reason="tshark is not installed")


class Frame(NamedTuple):
    """The fields of a frame, as tshark prints them. A missing field is an empty text."""

    source: str
    destination: str
    protocol: str
    malformed: str
    severity: str
    complaint: str
    service: str
    status: str
    data: str


FIELDS = (
    *("ip.src", "ip.dst", "_ws.col.Protocol", "_ws.malformed", "_ws.expert.severity"),
    *("_ws.expert.message", "cip.service", "cip.genstat", "cipio.data"),
)


class Capture:
    """A capture by tshark on the loopback interface, for the address of one adapter."""

    def __init__(self, host: str, file: Path) -> None:
        assert TSHARK is not None
        self.file, self._host = file, host
        capture = f"host {host} and (udp port {IO_PORT} or port {PORT})"
        command = [TSHARK, "-n", "-l", "-i", "lo", "-f", capture, "-w", str(file)]
        command += ["-P", "-T", "fields", "-e", "udp.srcport"]
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self._lines: queue.Queue[str | None] = queue.Queue()
        threading.Thread(target=self._read, daemon=True).start()
        self.wait_for_probe()

    def wait_for_probe(self) -> None:
        """Send a datagram, and wait until tshark has captured it and all earlier packets."""
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind((self._host, 0))
            port = str(probe.getsockname()[1])
            for _ in range(int(PATIENCE_S / 0.1)):
                probe.sendto(LIST_IDENTITY, (self._host, PORT))
                with suppress(queue.Empty):
                    while (line := self._lines.get(timeout=0.1)) is not None:
                        if line.strip() == port:
                            return
                    assert self._process.stderr is not None
                    reason = self._process.stderr.read().strip().splitlines()
                    pytest.skip(f"tshark cannot capture: {' '.join(reason[-2:])}")
        pytest.fail("tshark has not captured the probe datagram")

    def stop(self) -> None:
        """Stop tshark, and wait until the file is complete."""
        self._process.send_signal(signal.SIGINT)
        self._process.wait(PATIENCE_S)

    def frames(self) -> list[Frame]:
        """Return the fields of all captured frames."""
        assert TSHARK is not None
        command = [TSHARK, "-n", "-2", "-r", str(self.file), "-T", "fields"]
        for name in FIELDS:
            command += ["-e", name]
        done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
        return [Frame(*line.split("\t")) for line in done.stdout.splitlines()]

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._lines.put(line)
        self._lines.put(None)


@pytest.fixture
def host() -> str:
    """Return a loopback address that only this test process uses, because the ports are fixed."""
    return f"127.44.{os.getpid() >> 8 & 0xFF}.{os.getpid() & 0xFF or 1}"


@pytest.fixture
def adapter(host: str) -> Iterator[Adapter]:
    with Adapter(48, host=host, port=PORT, cyclic=IO_PORT) as running:
        running.write_to_master(bytes(range(48)))
        yield running


def until_received(scanner: Scanner, packets: int) -> None:
    """Wait until the scanner has received `packets` packets, or fail after a long time."""
    waiting = threading.Event()
    for _ in range(int(PATIENCE_S / 0.01)):
        if scanner.statistics().received >= packets:
            return
        waiting.wait(0.01)
    pytest.fail(f"not {packets} packets: {scanner.statistics()}")


def test_a_cyclic_session_is_dissected_without_a_malformed_mark(
    adapter: Adapter, host: str, tmp_path: Path
) -> None:
    """No frame of a session is marked as malformed by tshark.

    The session has explicit messages, Forward Open and Close, and packets of an owner and an Input
    Only connection. `rcx judge` counts the same number of packets per connection and direction.
    """
    capture = Capture(host, tmp_path / "session.pcapng")
    with (
        Scanner(host, multiplier=7, address="127.0.0.2", io_port=IO_PORT) as owner,
        Scanner(
            host, kind=ConnectionKind.INPUT_ONLY, multiplier=7, address="127.0.0.4", large=True
        ) as reader,
        Client(host) as client,
    ):
        client.get_attribute(1, 1, 7)
        client.get_assembly(100)
        owner.write(bytes(range(100, 148)))
        owner.open()
        reader.open()
        until_received(owner, 20)
        until_received(reader, 20)
    capture.wait_for_probe()
    capture.stop()

    frames = capture.frames()
    judged = judge(JudgeOptions(capture.file), lambda line: None)
    assert judged.network is not None
    (robot,) = judged.network.robots.values()
    for one, source in zip(robot.connections, ("127.0.0.2", "127.0.0.4"), strict=True):
        for way, ends in ((one.to_robot, (source, host)), (one.to_master, (host, source))):
            told = [f for f in frames if (f.source, f.destination) == ends]
            assert way.packets == sum(one.protocol == "CIP I/O" for one in told) >= 20
            assert (way.lost, way.doubled, way.late, way.wrong) == (0, 0, 0, 0)
    assert [one.malformed for one in frames if one.malformed] == []
    errors = [one for one in frames if any(int(each) >= ERROR for each in split(one.severity))]
    assert errors == []
    cyclic = [one for one in frames if one.protocol == "CIP I/O"]
    assert len(cyclic) >= 40

    # 0x54 Forward Open, 0x5B Large Forward Open, 0x4E Forward Close: requests, then replies.
    managed = [one for one in frames if one.protocol == "CIP CM"]
    requests = Counter(int(one.service, 16) for one in managed if not one.status)
    assert requests == {0x54: 1, 0x5B: 1, 0x4E: 2}
    replies = Counter((int(one.service, 16), int(one.status, 16)) for one in managed if one.status)
    assert replies == {(0xD4, 0x00): 1, (0xDB, 0x00): 1, (0xCE, 0x00): 2}

    # A Forward Open must be captured before its packets, or tshark does not know the connection.
    sent = [one.data for one in cyclic if one.source == "127.0.0.2"]
    assert len(sent) >= 20
    assert set(sent) == {bytes(range(100, 148)).hex()}
    heartbeats = [one.data for one in cyclic if one.source == "127.0.0.4"]
    assert len(heartbeats) >= 20
    assert set(heartbeats) <= {"", "<none>"}
    received = [one for one in cyclic if one.source == host]
    assert {one.destination for one in received} == {"127.0.0.2", "127.0.0.4"}
    assert {one.data for one in received} == {bytes(range(48)).hex()}


def split(field: str) -> list[str]:
    """Return the values of a field that can occur several times in one frame."""
    return field.split(",") if field else []


def test_tshark_marks_a_malformed_frame(adapter: Adapter, host: str, tmp_path: Path) -> None:
    """A ListIdentity answer that is cut off is marked by tshark, so the other test could fail."""
    capture = Capture(host, tmp_path / "cut.pcapng")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as broken:
        broken.bind((host, 0))
        items = struct.pack("<HHH", 1, 0x0C, 40) + bytes(10)
        broken.sendto(struct.pack("<HHII8sI", 0x63, 16, 0, 0, bytes(8), 0) + items, (host, PORT))
    capture.wait_for_probe()
    capture.stop()
    assert [one for one in capture.frames() if one.malformed]
