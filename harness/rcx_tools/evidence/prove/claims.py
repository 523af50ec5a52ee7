"""What breaks a property in a run, judged on the engine by plain Python: no solver, no formulas.

Each judge sees a scan: what was read, what was written, and the pins of the client program.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from datetime import timedelta

from rcx_harness.engine.base import Program
from rcx_harness.spec import commands
from rcx_harness.spec.wire import DEDICATED_AT, SIZE
from rcx_harness.watch.contract import ContractMonitor
from rcx_harness.watch.wire import WireMonitor, word

__all__ = ["CLAIMS", "Judges", "Seen"]

#: Of each property: the findings that refute it.
CLAIMS = {
    "interval": ("interval",),
    "telegram-legal": ("telegram",),
    "telegram-pins": ("pins",),
}
#: SI(00) and SI(06), whose switch-off goes out at once.
_STOPS = 0x0041
#: Scans with a quiet environment after which the channels have to be free.
QUIET = 120


@dataclass(frozen=True)
class Seen:
    """A scan: what the PLC read, and for how many scans nobody has asked for anything."""

    t_us: int
    number: int
    so: bytes
    connected: bool
    quiet: int = 0


class Judges:
    """All of them, on one program in a run from its start.

    Args:
        program: The client.
        steady: Instances that are called once in every scan.
        sends: It is not FB_RemoteCommand that sends: telegrams are legal.
    """

    def __init__(self, program: Program, steady: set[str], *, sends: bool):
        self._program = program
        self._wire = WireMonitor(SIZE)
        self._contract = ContractMonitor(program, steady)
        self._pins = program.reader(
            [
                f"Main.WriteArea.{name}"
                for name in ("EmergencyStopOk", "StopOk", "Interval", "Margin")
            ]
        )
        self._channels = program.reader(
            [
                f"Main.Robot.Inner.{name}.{part}"
                for name in ("Command", "Sequence")
                for part in ("Serving", "NextTicket")
            ]
        )
        self._legal = commands() if sends else {}
        self._before = bytes(SIZE)
        self._changed_us: int | None = None
        self.telegrams: list[tuple[int, bytes]] = []
        """What has gone out, with the number of its scan."""

    def scan(self, seen: Seen) -> list[tuple[str, str]]:
        """What a scan breaks: the kind of it, and what it is."""
        si = self._program.read_bytes("Main.OutputArea")
        found = [
            *self._outside(si),
            *self._interval(seen, si),
            *self._levels(seen, si),
            *self._telegram(seen, si),
            *self._hang(seen),
        ]
        wire = self._wire.scan(seen.t_us, seen.number, seen.so, si[:SIZE], seen.connected)
        found += [(one.rule, one.text) for one in wire]
        contract = self._contract.scan(seen.t_us, seen.number)
        found += [(one.rule, one.text) for one in contract]
        self._before = si[:SIZE]
        return found

    def _interval(self, seen: Seen, si: bytes) -> Iterator[tuple[str, str]]:
        """Chapter 5, 3, caution; with what Interval and Margin ask for besides."""
        before, now = word(self._before, DEDICATED_AT), word(si, DEDICATED_AT)
        changed = before ^ now
        if not changed:
            return
        _, _, interval, margin = self._pins()
        zero, least = timedelta(0), timedelta(milliseconds=100)
        spacing = max(least, interval) + max(zero, margin)
        last, self._changed_us = self._changed_us, seen.t_us
        if not changed & ~_STOPS and not now & changed:
            return
        if changed & changed - 1:
            yield "interval", f"{changed:#06x} change in one scan"
        if last is not None and timedelta(microseconds=seen.t_us - last) < spacing:
            yield "interval", f"{changed:#06x} changes {seen.t_us - last} us after the last change"

    def _levels(self, seen: Seen, si: bytes) -> Iterator[tuple[str, str]]:
        """SI(00) and SI(06) follow their pins and the link, at once where they go OFF."""
        emergency_ok, stop_ok, _, _ = self._pins()
        for bit, allowed in ((0x01, emergency_ok), (0x40, stop_ok)):
            if si[DEDICATED_AT] & bit and not (allowed and seen.connected):
                yield "levels", f"bit {bit:#x} is ON without its pin, or without the link"

    def _outside(self, si: bytes) -> Iterator[tuple[str, str]]:
        if any(si[34:]):
            yield "outside", "bytes beyond n + 33 were written"

    def _telegram(self, seen: Seen, si: bytes) -> Iterator[tuple[str, str]]:
        code = word(si, 0)
        if not code or code == word(self._before, 0):
            return
        self.telegrams.append((seen.number, si[:DEDICATED_AT]))
        words = [word(si, at) for at in range(0, DEDICATED_AT, 2)]
        if self._legal:
            command = self._legal.get(code & 0x0FFF)
            why = "there is no such command" if command is None else command.problem(words)
            if why:
                yield "telegram", f"{code:#06x} went out: {why}"

    def _hang(self, seen: Seen) -> Iterator[tuple[str, str]]:
        if seen.quiet == QUIET:
            serving, following, sequence, last = self._channels()
            if serving != following:
                yield "hang", f"the command channel still serves {serving}"
            if sequence != last:
                yield "hang", f"the sequence channel still serves {sequence}"
