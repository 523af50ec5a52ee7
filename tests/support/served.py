"""A served controller without sockets, processes or a clock, for the tests of `rcx serve`."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from rcx_harness.enip.cyclic.connections import ConnectionKind, OwnerState
from rcx_harness.enip.cyclic.journal import ConnectionEvent, Journal, RefusedOpen
from rcx_harness.enip.cyclic.shared import Drop, LinkState, Status, Word
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.serve.host import Host, Settings
from rcx_harness.serve.station import Station
from rcx_harness.serve.status import Status as Report
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import Trace


def image(bits: int, code: int = 0) -> bytes:
    """Return an area of 48 bytes to the robot: the inputs SI(00) to SI(07) and a command code."""
    return struct.pack("<H30xB15x", code, bits)


class ImageInMemory:
    """An area."""

    def __init__(self, size: int) -> None:
        self.image = bytes(size)

    def read(self) -> bytes:
        """Return the image that was written last."""
        return self.image

    def write(self, image: bytes, /) -> None:
        """Store an image."""
        self.image = bytes(image)


class NetworkInMemory:
    """The adapter as the station sees it; the test is the master."""

    def __init__(self, size: int = 48) -> None:
        self.to_master = ImageInMemory(size)
        self.to_robot = ImageInMemory(size)
        self.link = LinkState.UP
        self.owner = OwnerState.NONE
        self.generation = 0
        self.listeners = 0
        self.now_us = 0
        self.drops = [0] * len(Drop)
        self.lengths = (0, 0)
        self.heard = {Word.CYCLIC_ALIVE: 0, Word.ADAPTER_ALIVE: 0}
        self.events, self.refusals = (
            Journal(memoryview(bytearray(Journal.NEEDS))) for _ in range(2)
        )

    def become(self, owner: OwnerState) -> None:
        """Change the state of the owner's connection now."""
        self.owner = owner
        self.generation += 1
        self.tell(ConnectionKind.EXCLUSIVE_OWNER, owner.name.lower().replace("_", " "))

    def tell(self, kind: ConnectionKind, state: str, peer: str = "192.168.0.10") -> None:
        """Write a connection change to the journal, as the cyclic process does."""
        event = ConnectionEvent(self.now_us, kind, state, peer, 10_000, 10_000, self.listeners)
        self.events.write(asdict(event))

    def refuse(self, text: str) -> None:
        """Write a refused connection to the journal, as the adapter's process does."""
        self.refusals.write(asdict(RefusedOpen(self.now_us, text)))

    def heard_us(self, part: Word) -> int:
        """Return when a process last showed that it is alive [us]."""
        return self.heard[part]

    def send(self, image: bytes) -> None:
        """Send a packet as a master in RUN mode."""
        self.to_robot.write(image)
        if self.owner is not OwnerState.RUN:
            self.become(OwnerState.RUN)

    def status(self) -> Status:
        """Return the connection status, as the cyclic process reports it."""
        there = self.owner in (OwnerState.WAITING, OwnerState.RUN, OwnerState.IDLE)
        return Status(
            owner=self.owner,
            generation=self.generation,
            peer="192.168.0.10" if there else "",
            o_to_t_api_us=10_000 if there else 0,
            t_to_o_api_us=10_000 if there else 0,
            owners=int(there),
            input_only=0,
            listen_only=self.listeners,
            received=0,
            sent=0,
            drops=tuple(self.drops),
            missing=0,
            skipped=0,
            wrong_length=self.lengths[0],
            right_length=self.lengths[1],
        )


class ServedHost(Host):
    """A host with a controller that runs in this process, in virtual time."""

    def __init__(
        self,
        config: RobotConfig | None = None,
        *,
        address: str = "127.0.0.1",
        trace: Trace | None = None,
    ) -> None:
        super().__init__(Settings(host=address))
        config = config or RobotConfig()
        self.size = config.size
        self.network = NetworkInMemory(config.size)
        self.station = Station(Controller(config), self.network, trace, address)
        self.now_us = -CYCLE_US
        self.run(0)

    def run(self, milliseconds: int) -> Report:
        """Run the controller for this time, at least one cycle, and return its report."""
        for _ in range(max(1, milliseconds * 1000 // CYCLE_US)):
            self.now_us += CYCLE_US
            self.station.step(self.now_us)
        self.network.now_us = self.now_us
        self.take(Report.from_table(json.loads(self.station.report().to_json())))
        return self.status

    async def ask(self, message: Mapping[str, Any]) -> int:
        """Pass a message to the station, run one cycle, and return the message's time [us]."""
        self.station.obey(message)
        t_us = self.station.now_us
        self.run(0)
        return t_us
