"""A small model of the controller, which answers as in the manual after any delay.

It models the remote status, the dedicated outputs and the link. It may fail in any scan. An action
that takes time in a real controller may happen in any later scan, but only one action per scan.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

from rcx_harness.spec.wire import ABNORMAL_END, DEDICATED_AT, ENDS, NORMAL_END, READY, RUN

__all__ = ["FAULTS", "MOVES", "Small", "Wire"]

#: Faults that may occur, each with its description.
FAULTS = {
    "link": "the link is lost and comes back",
    "alarm": "the controller has an alarm",
    "abnormal": "a remote command ends with 16#4000",
}
#: All moves of the controller, each with its description.
MOVES = {
    "": "",
    "run": "status 16#0100",
    "end": "status 16#0200",
    "abnormal": "status 16#4000",
    "ready": "status 16#0000",
    "servo": "SO(02) ON: servos on",
    "reset": "SO(03) OFF: alarm reset",
    "program reset": "SO(14) ON: program reset",
    "start": "SO(13) ON: program runs",
    "origin": "SO(11) ON: return-to-origin complete",
    "alarm": "SO(03) ON: alarm",
    "link": "link lost",
    "link up": "link up",
}

# Dedicated outputs, SO(00) to SO(15) (docs/reference/signals.md).
_EMERGENCY, _CPU_OK, _SERVO, _ALARM, _MP_RDY = (1 << bit for bit in range(5))
_AUTO, _ORIGIN, _SEQUENCE, _PROGRAM, _WAS_RESET = (1 << bit for bit in range(8, 13))
# Dedicated inputs, SI(00) to SI(17).
_SI00, _SI01, _SI06, _SI10 = 0x0001, 0x0002, 0x0040, 0x0100
_SI12, _SI14, _SI15, _SI16, _SI17 = 0x0400, 0x1000, 0x2000, 0x4000, 0x8000
_EDGES = _SI01 | _SI12 | _SI14 | _SI15 | _SI16 | _SI17
#: The second word of an abnormal end, from which the alarm group and category are read.
_ALARM_WORD = 12


class Wire(NamedTuple):
    """The outputs of the PLC: the remote command code and the dedicated inputs."""

    code: int = 0
    bits: int = 0

    @classmethod
    def of(cls, area: bytes) -> Wire:
        """Return the code and the dedicated inputs of an area."""
        bits = area[DEDICATED_AT : DEDICATED_AT + 2]
        return cls(int.from_bytes(area[:2], "little"), int.from_bytes(bits, "little"))


class Small(NamedTuple):
    """The state of the small controller at one moment.

    Attributes:
        link: Whether the connection exists.
        status: The remote status.
        so: The dedicated outputs.
        asked: Rising edges of dedicated inputs that the controller has not answered yet.
        bits: The dedicated inputs that the controller read last.
    """

    link: bool = True
    status: int = READY
    so: int = _EMERGENCY | _CPU_OK | _MP_RDY | _AUTO
    asked: int = 0
    bits: int = 0

    def seen(self, wire: Wire) -> Small:
        """Return the state after the controller has read the outputs of the PLC."""
        if not self.link:
            return self
        # Levels act at once: SI(00) OFF is an emergency stop, SI(06) OFF stops the
        # program, and SI(10) sets the sequence output. Edges are stored in `asked`. The controller
        # may answer them in a later scan (see `moves`). An emergency stop
        # deletes the edges that the controller then ignores.
        so, asked = self.so, self.asked | (wire.bits & ~self.bits & _EDGES)
        if wire.bits & _SI00:
            so &= ~_EMERGENCY
        else:
            so = (so | _EMERGENCY) & ~(_SERVO | _PROGRAM)
            asked &= ~(_SI01 | _SI12 | _SI14 | _SI17)
        if not wire.bits & _SI06:
            so &= ~_PROGRAM
            asked &= ~(_SI12 | _SI14 | _SI17)
        so = so | _SEQUENCE if wire.bits & _SI10 else so & ~_SEQUENCE
        return self._replace(so=so, asked=asked, bits=wire.bits)

    def moves(self, wire: Wire, faults: frozenset[str]) -> Iterator[str]:
        """Yield the moves that the controller may make after it has read these outputs."""
        yield ""
        if not self.link:
            yield "link up"
            return
        if self.status == READY and wire.code:
            yield "run"
        if self.status == RUN:
            yield "end"
        if self.status == RUN and "abnormal" in faults:
            yield "abnormal"
        if self.status in ENDS and not wire.code:
            yield "ready"
        if self.asked & _SI01 and not self.so & (_ALARM | _EMERGENCY):
            yield "servo"
        if self.asked & _SI16 and self.so & _ALARM:
            yield "reset"
        if self.asked & _SI15:
            yield "program reset"
        if self.asked & _SI12 and self.so & _SERVO:
            yield "start"
        if self.asked & (_SI14 | _SI17) and self.so & _SERVO:
            yield "origin"
        if "alarm" in faults and not self.so & _ALARM:
            yield "alarm"
        if "link" in faults:
            yield "link"

    def after(self, move: str) -> Small:
        """Return the state of the controller after one of its moves."""
        status = {"run": RUN, "end": NORMAL_END, "abnormal": ABNORMAL_END, "ready": READY}
        if move in status:
            return self._replace(status=status[move])
        if move == "link":  # the controller stops as at an emergency stop (manual chapter 1, 5.2)
            return Small(link=False, bits=0xFFFF)  # the first image after a loss has no edges
        if move == "link up":
            return self._replace(link=True)
        on, off, asked = _DONE.get(move, (0, 0, 0))
        return self._replace(so=(self.so | on) & ~off, asked=self.asked & ~asked)

    def area(self, size: int) -> bytes:
        """Return the area that the PLC reads."""
        area = bytearray(size)
        area[0:2] = self.status.to_bytes(2, "little")
        if self.status == ABNORMAL_END:
            area[2:4] = _ALARM_WORD.to_bytes(2, "little")
        area[DEDICATED_AT : DEDICATED_AT + 2] = self.so.to_bytes(2, "little")
        return bytes(area)


#: Maps a move to the dedicated outputs that go ON and OFF, and to the edges that it answers.
_DONE = {
    "servo": (_SERVO, 0, _SI01),
    "reset": (_MP_RDY, _ALARM, _SI16),
    "program reset": (_WAS_RESET, _PROGRAM, _SI15),
    "start": (_PROGRAM, _WAS_RESET, _SI12),
    "origin": (_ORIGIN, 0, _SI14 | _SI17),
    "alarm": (_ALARM, _SERVO | _MP_RDY | _PROGRAM, _EDGES),
}
