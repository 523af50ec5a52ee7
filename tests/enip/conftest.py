"""Fixtures for a device without sockets in virtual time, and for frames that are sent to it."""

from __future__ import annotations

import itertools
import subprocess
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

import exchange_bench
from rcx_harness.enip.cyclic.connections import ConnectionParameters, OwnerState
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.cyclic.shared import SharedImages
from rcx_harness.enip.target.connection_manager import Origin
from rcx_harness.enip.target.device import Device, Session
from rcx_harness.enip.target.network_interface import NetworkInterface

LOCAL, PEER = ("192.168.0.2", 44818), "192.168.0.10"


def hexa(text: str) -> bytes:
    """Convert hexadecimal digits to bytes. Blanks and line ends are ignored."""
    return bytes.fromhex(text)


class MemoryImage:
    """A simulated assembly that counts how often it was written."""

    def __init__(self, size: int) -> None:
        self.data = bytes(size)
        self.writes = 0

    def read(self) -> bytes:
        """Return the data of the assembly."""
        return self.data

    def write(self, image: bytes) -> None:
        """Replace the data of the assembly, and count the call."""
        assert len(image) == len(self.data)
        self.data = image
        self.writes += 1


@dataclass
class FakeCyclicPart(CyclicControl):
    """A replacement for the process of the cyclic I/O.

    It records the Connection Manager's calls.
    """

    port: int = 2222
    added: list[ConnectionParameters] = field(default_factory=list)
    removed: list[int] = field(default_factory=list)

    def add(self, parameters: ConnectionParameters) -> None:
        """Record the parameters of an opened connection."""
        self.added.append(parameters)

    def remove(self, number: int) -> None:
        """Record the number of a closed connection."""
        self.removed.append(number)


class Bench:
    """The device under test, with simulated assemblies, cyclic I/O and time."""

    def __init__(self, size: int = 48, cyclic: bool = True, **settings: Any) -> None:
        self.now = 1000.0
        self.resets = 0
        self.owner = OwnerState.NONE
        self.master_image, self.robot_image = MemoryImage(size), MemoryImage(size)
        self.cyclic = FakeCyclicPart()
        settings.setdefault("draw_id", itertools.count(0x10001).__next__)
        self.device = Device(
            self.master_image,
            self.robot_image,
            cyclic=self.cyclic if cyclic else None,
            owner_state=lambda: self.owner,
            interface=NetworkInterface("192.168.0.2", "255.255.255.0", hexa("02A0B0C0D0E0")),
            clock=lambda: self.now,
            **settings,
        )
        self.device.on_reset = self._count_reset

    def _count_reset(self) -> None:
        self.resets += 1

    @property
    def to_master(self) -> bytes:
        """Return the data of assembly 100, which the robot writes."""
        return self.master_image.data

    @property
    def to_robot(self) -> bytes:
        """Return the data of assembly 150, which the master writes."""
        return self.robot_image.data

    def connect(self, peer: str = PEER) -> Session:
        """Open a TCP connection from `peer`, and return its session."""
        return self.device.connect(LOCAL, peer)

    def ask(self, request: str, origin: Origin | None = None) -> bytes:
        """Return the device's answer to a CIP request. The request is in hexadecimal digits."""
        return self.device.router.answer(hexa(request), origin or Origin(PEER, LOCAL[0], 1))


@pytest.fixture
def bench() -> Bench:
    return Bench()


@pytest.fixture
def make_bench() -> type[Bench]:
    """Return the class Bench, with which a test can make a device with other settings."""
    return Bench


@pytest.fixture
def session(bench: Bench) -> Session:
    """Return a new TCP connection without a registered session."""
    return bench.connect()


@pytest.fixture
def registered(bench: Bench) -> Session:
    """Return a TCP connection with a registered session, whose handle is 1."""
    connection = bench.connect()
    connection.receive(hexa("6500 0400 00000000 00000000 0000000000000000 00000000 0100 0000"))
    return connection


@pytest.fixture
def images() -> Iterator[SharedImages]:
    """Return shared areas of 48 bytes for a device with class 1 connections."""
    with SharedImages.create(48) as images:
        images.unlink()
        yield images


@pytest.fixture
def device(images: SharedImages) -> exchange_bench.Device:
    """Return a device that is the target of class 1 connections."""
    return exchange_bench.Device(images)


@pytest.fixture
def owned(device: exchange_bench.Device) -> exchange_bench.Device:
    """Return a target with an exclusive owner connection that was opened at time 0."""
    device.exchange.add(exchange_bench.OWNER, 0)
    return device


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[subprocess.Popen[str]]]:
    """Return a list that collects the adapter processes that the test starts."""
    started: list[subprocess.Popen[str]] = []
    popen = subprocess.Popen

    def recording(*args: Any, **kwargs: Any) -> subprocess.Popen[str]:
        started.append(popen(*args, **kwargs))
        return started[-1]

    monkeypatch.setattr("rcx_harness.enip.child.subprocess.Popen", recording)
    yield started
    for process in started:
        if process.poll() is None:
            process.kill()
            process.wait()
