"""A small robot controller for thousands of runs that gives the answers of a case."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

#: Delay of an answer that comes after the blocks' Timeout, but before twice the Timeout [scans].
TOO_LATE = 14

_ENDLESS = 1 << 30


class Fate(NamedTuple):
    """The controller's answers to a remote command over the scans.

    Attributes:
        name: Name of the case for messages.
        silent: Number of scans with the status 0x0000 after the code has come.
        running: Number of scans with the status 0x0100 after the silent scans.
        end: The end status; 0x0000 for a command that is lost.
        response: Words that come with the end status.
        reset: Number of scans in which the end status stays after the code 0x0000.
        stale: Number of scans from the start with a status 0x0200 that was not requested.
        error: ErrorID of the block if no other event happens; 0x0000 for Done.
    """

    name: str
    silent: int = 0
    running: int = 0
    end: int = 0x0200
    response: Sequence[int] = ()
    reset: int = 0
    stale: int = 0
    error: int = 0


_ALARM = (12, 600)

#: Possible courses of the answers to a command.
FATES = (
    Fate("normal"),
    Fate("normal, by 0x0100", running=2),
    Fate("abnormal", end=0x4000, response=_ALARM, error=0x8020),
    Fate("abnormal, by 0x0100", running=1, end=0x4000, response=_ALARM, error=0x8020),
    Fate("too late", running=TOO_LATE, error=0x8011),
    Fate(
        "too late and abnormal, without 0x0100",
        silent=TOO_LATE,
        end=0x4000,
        response=_ALARM,
        error=0x8011,
    ),
    Fate("never", silent=_ENDLESS, error=0x8011),
    Fate("never, with 0x0100", running=_ENDLESS, error=0x8011),
    Fate("status falls back to 0x0000", running=2, end=0, error=0x8014),
    Fate("slow status reset", reset=4),
    Fate("not ready for a while", stale=4),
    Fate("not ready for too long", stale=TOO_LATE, error=0x8015),
)

#: Ways in which the controller shows a dedicated output that answers a block.
SIGNAL_FATES = ("normal", "late", "too late", "never", "withdrawn", "flickering")

_LATE = 3
_JOG = (0x020, 0x021, 0x022)
_CONTINUOUS = (0x505, 0x506)
#: Codes of the commands that write a bit of a port, and read a port.
_WRITE, _READ = 0x301, 0x304
_OUTPUTS = 34


def bit(signal: str) -> int:
    """Return the bit of an output such as `SO13` in the word of dedicated outputs."""
    return 1 << (8 * int(signal[2]) + int(signal[3]))


_ESTOP, _CPU, _SERVO, _ALARMED, _MP = (bit(f"SO0{k}") for k in range(5))
_AUTO, _ORIGIN, _SEQUENCE, _RUNS, _RESET = (bit(f"SO1{k}") for k in range(5))


class Start(NamedTuple):
    """State of the controller at the start of a case.

    Attributes:
        outputs: Dedicated outputs that are ON besides CPU_OK, MP RDY and AUTO mode.
        missing: The outputs among SO01, SO04 and SO10 that are OFF at first and turn ON later.
    """

    outputs: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()

    @property
    def word(self) -> int:
        """Return all dedicated outputs as one word."""
        there = {"SO01", "SO04", "SO10", *self.outputs}.difference(self.missing)
        return sum(bit(name) for name in there)


class Player:
    """The controller: each call of `step` takes the written area and returns the area to read.

    Attributes:
        emergency: Whether an emergency stop is active that does not come from SI(00).
        alarm: Whether an alarm comes with the next call.
        cpu_ok: Whether the controller is in its normal state.
        auto: Whether the controller is in AUTO mode.
        takes_jobs: Whether a robot program takes jobs of FB_ProgramCall and completes them at once.
    """

    def __init__(self) -> None:
        self.begin(Start(), FATES[0], "", "normal", 0)

    def begin(self, start: Start, fate: Fate, signal: str, shown: str, delay: int) -> None:
        """Begin a case.

        Args:
            start: State of the controller at the beginning.
            fate: The controller's answers to commands.
            signal: The dedicated output to which `shown` applies; empty for none.
            shown: How the controller shows that output, one of SIGNAL_FATES.
            delay: Number of scans by which the PLC's data arrive late.
        """
        self._bits = self._first = start.word
        self._fate = fate
        self._mask = bit(signal) if signal else 0
        self._shown = shown
        self._gone = 0
        self._lag: deque[tuple[int, int, int, int, int, int]] = deque(maxlen=delay + 1)
        self.takes_jobs = False
        self._ticket, self._taken = 1, False
        self._port = 0
        self._si = 0
        self._code = 0
        self._age = 0
        self._status = 0
        self._stale = fate.stale
        self._leaving = 0
        self.emergency = self.alarm = False
        self.cpu_ok = self.auto = True

    def settle(self, inputs: int) -> None:
        """Set the dedicated inputs, as if the controller had seen them for a long time."""
        self._si = inputs

    def be_normal(self) -> None:
        """Remove all faults, and answer normally and at once from now on."""
        self._fate, self._shown, self._stale = FATES[0], "normal", 0
        self._lag = deque(self._lag, 1)
        self.emergency = self.alarm = False
        self.cpu_ok = self.auto = True

    def step(self, si: bytes, connected: bool) -> bytes:
        """Take the area that the PLC has written, and return the area that it reads next."""
        now = (0, 0, 0, 0, 0, 0)
        if connected:
            head = si[0] | si[1] << 8, si[2] | si[3] << 8, si[32] | si[33] << 8
            now = (*head, si[6], si[6] | si[7] << 8, si[34] & 1)
        self._lag.append(now)
        code, data, inputs, written, ticket, strobe = self._lag[0]
        response = self._command(code, data, inputs)
        if self._status == 0x0200 and code in (_WRITE, _READ):
            self._port = written if code == _WRITE else self._port
            response = (0, 0, self._port)
        self._dedicated(inputs)
        words = [self._status, *response, *[0] * (15 - len(response))]
        bits = self._masked()
        general = bytearray(48 - _OUTPUTS)
        if self.takes_jobs:
            general[0] = self._job(ticket, strobe)
            if not self._status:
                words[2:4] = self._ticket, 1
        shown = b"".join(word.to_bytes(2, "little") for word in words)
        return shown + bits.to_bytes(2, "little") + bytes(general)

    def _job(self, ticket: int, strobe: int) -> int:
        """Return SO(20) and SO(21).

        While the strobe is ON, both are ON: job acknowledged and complete.
        """
        if strobe and not self._taken:
            self._ticket = ticket
        self._taken = bool(strobe)
        return 0b11 if strobe else 0b10

    def _command(self, code: int, data: int, inputs: int) -> Sequence[int]:
        fate = self._fate
        if not self.cpu_ok:
            self._code = self._age = self._status = 0
            return ()
        if self._stale:
            self._stale -= 1
            self._status = 0x0200
            return ()
        if not code:
            if self._code:
                self._leaving = fate.reset
            self._code = self._age = 0
            self._leaving -= self._leaving > 0
            self._status = self._status if self._leaving else 0
            return ()
        self._code = code
        self._age += 1
        what = code & 0x0FFF
        if what in _CONTINUOUS and data & 1:
            self._status = 0x0100 if self._age > fate.silent else 0
            return ()
        if what in _JOG and not self._status & 0x4200 and self._age > fate.silent:
            stopped = not inputs & 1 << 6
            self._status = 0x4000 if stopped else 0x0100
            return (12, 400) if stopped else ()
        if what in _JOG:
            return (12, 400)
        if self._age <= fate.silent:
            self._status = 0
        elif self._age <= fate.silent + fate.running:
            self._status = 0x0100
        else:
            self._status = fate.end
            return fate.response
        return ()

    def _dedicated(self, inputs: int) -> None:
        rises, bits = inputs & ~self._si, self._bits
        self._si = inputs
        if self.emergency or not inputs & 1:
            if not bits & _ESTOP:
                bits |= _ESTOP | _ALARMED
            bits &= ~(_SERVO | _RUNS | _MP)
        else:
            bits = bits & ~_ESTOP | _MP
        if self.alarm:
            self.alarm = False
            bits = (bits | _ALARMED) & ~(_SERVO | _RUNS)
        if not inputs & 1 << 6:
            bits &= ~_RUNS
        bits = bits | _CPU if self.cpu_ok else bits & ~_CPU
        bits = bits | _AUTO if self.auto else bits & ~(_AUTO | _RUNS)
        if rises & 1 << 14 and not bits & _ESTOP:
            bits &= ~_ALARMED
        if rises & 1 << 1 and not bits & (_ESTOP | _ALARMED):
            bits |= _SERVO
        if rises & 1 << 13:
            bits |= _RESET
        if rises & 1 << 10 and bits & _AUTO and bits & _SERVO and inputs & 1 << 6:
            bits = (bits | _RUNS) & ~_RESET
        if rises & (1 << 12 | 1 << 15) and bits & _SERVO:
            bits |= _ORIGIN
        self._bits = bits | _SEQUENCE if inputs & 1 << 8 else bits & ~_SEQUENCE

    def _masked(self) -> int:
        """Return the dedicated outputs as the controller shows them in this case."""
        if self._shown == "normal" or not (self._bits ^ self._first) & self._mask:
            self._gone = 0
            return self._bits
        self._gone += 1
        hidden = {
            "late": self._gone <= _LATE,
            "too late": self._gone <= TOO_LATE,
            "never": True,
            "withdrawn": self._gone > 1,
            "flickering": 1 < self._gone < 4,
        }[self._shown]
        return self._bits & ~self._mask | self._first & self._mask if hidden else self._bits
