"""The decisions of the bridge: data for PLC and robot in each exchange, without sockets or clock.

The words in the PLC's holding registers are sent to the robot only while both sides are connected.
After a loss the robot receives zeros until the PLC has shown that it has noticed the loss. Zeros
mean SI(00) and SI(06) OFF, which stop the robot like a lost connection (manual chapter 1, 5), but
within one packet. The connection to the robot stays open, so that the robot's state remains
visible.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import Enum

from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError
from structured_text.output.units import format_us, format_word

__all__ = [
    "Actions",
    "Bridge",
    "Limits",
    "Lost",
    "PlcSeen",
    "Registers",
    "State",
    "area_of",
    "words_of",
]

_LAST = 0xFFFF
_AT_ONCE = 120
"""The largest number of registers in one request: Modbus allows 125 to be read and 123 to be
written. The number is even, so that no double word of the area is divided."""


def words_of(area: bytes) -> tuple[int, ...]:
    """Convert an area to words; byte 2k is the low half of word k (manual chapter 1, 4.1)."""
    return struct.unpack(f"<{len(area) // 2}H", area)


def area_of(words: Sequence[int]) -> bytes:
    """Convert words, each 0 to 65535, to the bytes of an area."""
    return struct.pack(f"<{len(words)}H", *words)


@dataclass(frozen=True)
class Registers:
    """The PLC's registers that the bridge reads and writes.

    One more register follows each area: the PLC's heartbeat follows the area that the bridge reads,
    and the bridge's life word follows the area that it writes.

    Attributes:
        read: First register of the area to the robot; OpenPLC: %QW0 is 0.
        write: First register of the area from the robot; OpenPLC: %MW0 is 1024.
        size: Bytes of each area, 48 or 256.

    Raises:
        InputError: no area has the size, or registers do not exist, or they overlap.
    """

    read: int = 0
    write: int = 1024
    size: int = SIZE

    def __post_init__(self) -> None:
        """Raise InputError if the size or a register is invalid."""
        check_size(self.size)
        for name, first in (("--read", self.read), ("--write", self.write)):
            if not 0 <= first <= _LAST - self.words:
                raise InputError(
                    f"{name} {first}: there are no registers {first} to {first + self.words}",
                    hint=f"with {self.size} bytes use 0 to {_LAST - self.words}",
                )
        if abs(self.read - self.write) <= self.words:
            raise InputError(
                f"the registers {self.text(self.read)} and {self.text(self.write)} overlap",
                hint=f"leave {self.words + 1} registers between --read and --write",
            )

    @property
    def words(self) -> int:
        """Return the number of words of an area, without the register that follows it."""
        return self.size // 2

    def text(self, first: int) -> str:
        """Return the registers of an area and the register after it as text, such as `0 to 24`."""
        return f"{first} to {first + self.words}"

    def parts(self, first: int) -> Iterator[tuple[int, int]]:
        """Yield the first register and the number of registers of each request for an area.

        The requests include the register after the area. With 48 bytes one request is enough, so
        all words come from the same scan of the PLC. With 256 bytes a second request has the last
        few words.
        """
        end = first + self.words + 1
        for start in range(first, end, _AT_ONCE):
            yield start, min(_AT_ONCE, end - start)


_CODE, _DEDICATED = 0, 16
"""The words that the PLC must clear after a loss: the command code, and SI(00) to SI(17)."""
_LAST_LIFE = 0xFFFF
_SCANS = 2
"""Number of heartbeats that prove that a whole scan of the PLC has used the written data."""


class State(str, Enum):
    """The state of the bridge: RUN, or the kind of reason why it waits."""

    NO_PLC = "no PLC"
    STANDING = "the PLC's program stands still"
    NO_ROBOT = "no robot"
    CLEARING = "both sides are connected; waiting for the PLC to clear its outputs"
    RUN = "running"


@dataclass(frozen=True)
class Limits:
    """The time limits of the bridge, in microseconds.

    Attributes:
        gap_us: Longest time from a request to the answer of the next request; after a longer time
            the PLC counts as lost.
        beat_us: Longest time without a change of the PLC's heartbeat; 0: the PLC has no heartbeat.
        hold_us: Shortest time for which the PLC receives life word 0 after a loss.
    """

    gap_us: int = 100_000
    beat_us: int = 500_000
    hold_us: int = 200_000


@dataclass(frozen=True)
class PlcSeen:
    """The data that the PLC has returned. The PLC has also accepted the previous write.

    Attributes:
        asked_us: Time of the request, in microseconds of the clock of `Bridge.step`.
    """

    area: bytes
    beat: int
    asked_us: int


@dataclass(frozen=True)
class Lost:
    """The loss of a side of the bridge, with the reason in words."""

    reason: str


@dataclass(frozen=True)
class Actions:
    """The outputs of one step.

    Attributes:
        to_robot: Assembly 150 for the next packet.
        to_plc: The area from the robot, as words.
        life: The word that follows `to_plc`: 0 tells the PLC that its robot is not connected;
            otherwise a number from 1 to 65535 that changes in each step.
        reason: The reason in words; empty while the bridge runs.
    """

    to_robot: bytes
    to_plc: tuple[int, ...]
    life: int
    state: State
    reason: str


class Bridge:
    """The state machine between PLC and robot.

    The handshake after a loss has three parts. First the PLC receives life word 0 and zeros for at
    least `hold_us`. Then the PLC's heartbeat, if there is one, must change twice: this proves that
    a whole scan of the program has run since the PLC accepted the zeros. Last, the PLC must have
    cleared the remote command and the dedicated inputs. Only then does the bridge run, because a
    command from before the loss would start the robot again.
    """

    def __init__(self, size: int, limits: Limits) -> None:
        self._limits = limits
        self._nothing = bytes(size)
        self._state = State.NO_PLC
        self._life = 0
        self._asked_us = 0
        self._beat: int | None = None
        self._beat_us = 0
        self._beats = 0
        self._zero_us: int | None = None
        """Time at which the PLC accepted the zeros after a loss [us]; None: not yet."""

    def step(self, now_us: int, plc: PlcSeen | Lost, robot: bytes | Lost) -> Actions:
        """Evaluate both sides once and return the outputs.

        `plc` is the answer of the PLC; it is `Lost` if the last read or write failed. `robot` is
        the latest area from the robot; it is `Lost` if no packets arrive. `now_us` must never go
        back.
        """
        self._watch_plc(now_us, plc)
        state, reason = self._judge(now_us, plc, robot)
        stopped = self._state is State.RUN and state is not State.RUN
        if stopped or state in (State.NO_PLC, State.STANDING):
            self._zero_us = None
        self._state = state
        if state is State.RUN and isinstance(plc, PlcSeen) and isinstance(robot, bytes):
            self._life = self._life % _LAST_LIFE + 1
            return Actions(plc.area, words_of(robot), self._life, state, "")
        return Actions(self._nothing, words_of(self._nothing), 0, state, reason)

    def _watch_plc(self, now_us: int, plc: PlcSeen | Lost) -> None:
        """Track the PLC's heartbeat, and the time at which the PLC accepted the zeros.

        The first answer after a loss is ignored, because the bridge has not written yet. The second
        answer proves that the PLC has accepted the zeros. From then on heartbeats are counted.
        """
        if isinstance(plc, Lost):
            self._beat = self._zero_us = None
            return
        if self._beat is None:  # the first answer has no previous heartbeat
            self._beat, self._beat_us = plc.beat, now_us
            return
        if self._zero_us is None and self._state is not State.RUN:
            # The PLC has answered after the bridge wrote zeros, so the PLC has accepted the zeros.
            self._zero_us, self._beats = now_us, 0
        elif plc.beat != self._beat:
            self._beats += 1
        if plc.beat != self._beat:
            self._beat, self._beat_us = plc.beat, now_us

    def _judge(self, now_us: int, plc: PlcSeen | Lost, robot: bytes | Lost) -> tuple[State, str]:
        """Return the new state and its reason.

        The faults are checked in this order: no answer of the PLC, a gap between two requests that
        is too long, a heartbeat that does not change, no robot. Without a fault, a running bridge
        continues. A waiting bridge must first complete the handshake of `_clearing`.
        """
        if isinstance(plc, Lost):
            return State.NO_PLC, plc.reason
        asked_us, self._asked_us = self._asked_us, plc.asked_us
        gap_us = now_us - asked_us
        if self._state is State.RUN and gap_us > self._limits.gap_us:
            limit = format_us(self._limits.gap_us)
            return State.NO_PLC, f"{format_us(gap_us)} between two readings; limit {limit}"
        still_us = now_us - self._beat_us
        if self._limits.beat_us and still_us > self._limits.beat_us:
            return State.STANDING, f"its heartbeat has been {plc.beat} for {format_us(still_us)}"
        if isinstance(robot, Lost):
            return State.NO_ROBOT, robot.reason
        if self._state is State.RUN:
            return State.RUN, ""
        return self._clearing(now_us, plc)

    def _clearing(self, now_us: int, plc: PlcSeen) -> tuple[State, str]:
        """Check whether the PLC has noticed the loss and has cleared its commands."""
        if self._zero_us is None or now_us - self._zero_us < self._limits.hold_us:
            return State.CLEARING, "it is being informed that there was no connection"
        if self._limits.beat_us and self._beats < _SCANS:
            return State.CLEARING, "its program has not run since"
        words = words_of(plc.area)
        if words[_CODE]:
            return State.CLEARING, f"it still holds the remote command {format_word(words[_CODE])}"
        if words[_DEDICATED]:
            return (
                State.CLEARING,
                f"it still holds dedicated inputs, {format_word(words[_DEDICATED])}",
            )
        return State.RUN, ""
