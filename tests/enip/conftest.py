"""A device of 48 bytes without sockets, and the frames to speak to it."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field

import pytest

from rcx_harness.enip.identity import Identity
from rcx_harness.enip.objects import ObjectModel
from rcx_harness.enip.router import Router
from rcx_harness.enip.session import Session


def hexa(text: str) -> bytes:
    """Bytes from hexadecimal digits; blanks and line ends are for the reader."""
    return bytes.fromhex(text)


@dataclass
class Device:
    """The device under test with its two images."""

    to_master: bytearray = field(default_factory=lambda: bytearray(48))
    to_robot: bytearray = field(default_factory=lambda: bytearray(48))

    def __post_init__(self) -> None:
        identity = Identity()
        images = memoryview(self.to_master), memoryview(self.to_robot)
        self.router = Router(ObjectModel(*images, identity), identity)
        handles = itertools.count(1)
        # AF_INET (2), port 44818 (0xAF12), 192.168.0.2, big endian
        address = hexa("0002 AF12 C0A80002 0000000000000000")
        self.connect: Callable[[], Session] = lambda: Session(
            self.router, handles.__next__, address
        )

    def ask(self, request: str) -> bytes:
        """Answer to a CIP request given in hexadecimal digits."""
        return self.router.answer(hexa(request))


@pytest.fixture
def device() -> Device:
    return Device()


@pytest.fixture
def session(device: Device) -> Session:
    """A connection on which nothing has been said yet."""
    return device.connect()


@pytest.fixture
def registered(device: Device) -> Session:
    """A connection whose session handle is 1."""
    connection = device.connect()
    connection.receive(hexa("6500 0400 00000000 00000000 0000000000000000 00000000 0100 0000"))
    return connection
