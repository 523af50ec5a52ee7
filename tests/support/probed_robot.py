"""A controller as in `rcx serve` but in virtual time, and a network line to it for probes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rcx_harness.enip.cyclic.connections import OwnerState
from rcx_harness.look.probe.catalogue import questions
from rcx_harness.look.probe.line import LostError, NetworkLine, NotConnectedError
from rcx_harness.look.probe.question import Question
from rcx_harness.look.probe.run import Outcome, Person, probe
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.serve.station import Station
from rcx_harness.spec.wire import CYCLE_US
from served import NetworkInMemory

_TIMEOUT_US = 160_000


class StationLine(NetworkLine):
    """A network line for rcx_harness.look.probe.

    The station at its end steps as virtual time passes.
    """

    step_us = packet_us = CYCLE_US
    tolerance_us = 2 * CYCLE_US
    now_us = 0

    def __init__(self, config: RobotConfig, seed: int = 3) -> None:
        self.controller = Controller(config, seed)
        self.size = config.size
        self.identity = ["a virtual controller"]
        self.closed = False
        self.lost_after_us: int | None = None
        self._images = NetworkInMemory(config.size)
        self._station = Station(self.controller, self._images)
        self._silent_us: int | None = None
        self._open = False
        self.wait(50_000)

    @property
    def sent(self) -> int:
        """Return the number of packets sent: one every `packet_us`."""
        return self.now_us // self.packet_us

    def open(self, first: bytes) -> None:
        """Connect."""
        if not self.controller.online:
            raise NotConnectedError("it does not answer", "look at the cable")
        self._images.to_robot.write(first)
        self._become(OwnerState.RUN)
        self._open, self._silent_us = True, None

    def drop(self) -> None:
        """Stop sending."""
        self._open, self._silent_us = False, self.now_us

    def write(self, area: bytes, *, run: bool = True) -> None:
        """Send an area to the controller, as a master does."""
        self._images.to_robot.write(area)
        self._become(OwnerState.RUN if run else OwnerState.IDLE)

    def read(self) -> bytes:
        """Return the area that the controller sent last."""
        if self.lost_after_us is not None and self.now_us >= self.lost_after_us:
            raise LostError("no packets arrive any more")
        return self._images.to_master.read()

    def wait(self, us: int) -> None:
        """Run controller cycles for this time [us]."""
        end_us = self.now_us + us
        while self.now_us < end_us:
            if self._silent_us is not None and self.now_us - self._silent_us >= _TIMEOUT_US:
                self._become(OwnerState.TIMED_OUT)
            if not self.controller.online:
                self._become(OwnerState.TIMED_OUT)
            self._station.step(self.now_us)
            self.now_us += CYCLE_US

    def close(self) -> None:
        """Send zeros, then close the connection."""
        self.sent_last = self._images.to_robot.read()
        if self._open:
            self._images.to_robot.write(bytes(self.size))
            self.wait(50_000)
        self._become(OwnerState.CLOSED)
        self.closed = True

    def _become(self, owner: OwnerState) -> None:
        if owner is not self._images.owner:
            self._images.become(owner)

    def read_inputs(self) -> bytes:
        """Return the area that the controller received last."""
        return self._images.to_robot.read()

    def happen(self, text: str, event: str) -> bool:
        """Inject the event that the probe requests from the person at the cell."""
        self._station.happen(event)
        return True


def question(name: str) -> Question:
    """Return the probe's question with this id."""
    return next(one for one in questions() if one.id == name)


def rehearsed(
    *names: str, prepare: Callable[[StationLine], None] = lambda line: None, **config: Any
) -> Outcome:
    """Ask these questions (or all) of a virtual controller whose configuration has these keys."""
    line = StationLine(RobotConfig(**config))
    prepare(line)
    asked = [question(name) for name in names] or questions()
    told: list[str] = []
    outcome = probe(line, asked, Person(lambda one: True, line.happen, told.append))
    assert line.closed
    return outcome
