"""Judges of a run in plain Python: they find violations on the engine without the solver."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from rcx_harness.spec import commands
from rcx_harness.spec.wire import DEDICATED_AT, SIZE
from rcx_harness.watch.contract import ContractMonitor
from rcx_harness.watch.wire import WireMonitor, word
from rcx_tools.evidence.prove.client import IMAGE_BYTES, Client
from rcx_tools.evidence.prove.environment import Moment
from rcx_tools.evidence.prove.library import Library
from structured_text.engines.base import Program

__all__ = ["CLAIMS", "DIFFERS", "HANG", "QUIET", "RESULT", "STOPS", "About", "Judges"]

#: Kinds of findings. STOPS: a fault stops the program. HANG: a channel is not free in a quiet
#: environment. The others: telegram, area, outputs of blocks or results of functions differ from
#: those of the unchanged library, which is proved.
STOPS, HANG, PINS, BYTES, SHOWN, RESULT = "stops", "hang", "pins", "bytes", "shown", "result"
DIFFERS = (PINS, BYTES, SHOWN, RESULT)
_HELD = ("command held", "data before code", "ready before code")
_TURNS = ("both", "order", HANG, SHOWN)

#: For each property: the kinds of findings that refute it.
CLAIMS: Mapping[str, tuple[str, ...]] = {
    "interval": ("interval",),
    "stop-inputs": ("levels", BYTES),
    "restart": ("restart", "start against stop", BYTES),
    "handshake": _HELD,
    "response": ("owned", SHOWN),
    "guarantee": ("owned", *_HELD, "interval", "levels", "start against stop", BYTES),
    "place": ("place", BYTES),
    "bytes": ("outside", BYTES),
    "reserved": ("reserved", BYTES),
    "contract": ("contract", SHOWN),
    "safety": (STOPS, SHOWN),
    "functions": (RESULT,),
    "overflow": (STOPS, SHOWN, BYTES),
    "telegram-legal": ("telegram",),
    "telegram-pins": (PINS,),
    **dict.fromkeys(
        ("turn-hands", "turn-once", "turn-order", "turn-back", "turn-free", "turn-limit"), _TURNS
    ),
}
#: SI(00) and SI(06): switching them OFF takes effect at once.
_STOPS = 0x0041
#: Scans in a quiet environment after which the channels must be free.
QUIET = 120

Findings = Iterator[tuple[str, str]]


@dataclass(frozen=True)
class About:
    """The subject of a run.

    Attributes:
        library: The library with the blocks of the client.
        client: The client program.
        blocks: The numbers of the blocks that are called, from 1.
        steady: Instances that are called once in every scan.
        n: The offset of the output area in its image.
        kinds: The kinds of findings to report.
    """

    library: Library
    client: Client
    blocks: tuple[int, ...]
    steady: set[str]
    n: int
    kinds: frozenset[str]

    def pins(self, section: str) -> Iterator[str]:
        """Yield the paths of the inputs or outputs of the blocks that are called."""
        for number in self.blocks:
            block = self.client.blocks[number - 1]
            for symbol in self.library.pou(block.upper()).section(section):
                yield f"Main.B{number}.{symbol.name}"


class Judges:
    """All judges for some kinds of findings, on one program in a run from its start.

    Args:
        program: The client, compiled.
        about: The subject of the run.

    Attributes:
        written: The area as it was written in the last scan.
    """

    def __init__(self, program: Program, about: About) -> None:
        self.written = bytes(SIZE)
        self._program, self._about = program, about
        kinds = about.kinds
        self._whole = bytes(IMAGE_BYTES)
        self._wire = WireMonitor(SIZE)
        pins = ("EmergencyStopOk", "StopOk", "Interval", "Margin")
        self._pins = program.reader([f"Main.WriteArea.{name}" for name in pins])
        owned = ("Connected", "Status", "Response")
        self._owned = program.reader([f"Main.Robot.{name}" for name in owned])
        places = [f"Main.{place}{n}" for n in about.blocks for place in about.client.places[:2]]
        self._placed = program.reader([] if about.client.steady else places)
        self._look = program.reader(list(about.pins("VAR_OUTPUT")) if SHOWN in kinds else [])
        functions = range(1, len(about.client.functions) + 1)
        self._results = program.reader([f"Main.F{number}" for number in functions])
        edges = [p for p in about.pins("VAR_INPUT") if p.endswith(("Execute", "Enable"))]
        self._edges = program.reader(edges)
        self._asked: tuple[object, ...] = (False,) * len(edges)
        self._was_lost = False
        parts = [
            f"{channel}.{part}"
            for channel in ("Command", "Sequence")
            for part in ("Serving", "NextTicket")
        ]
        self._channels = program.reader([f"Main.Robot.Inner.{part}" for part in parts])
        called = [about.client.blocks[number - 1] for number in about.blocks]
        self._legal = commands() if "FB_RemoteCommand" not in called else {}
        self._general = any(block.startswith("FB_Write") for block in called)
        self._changed_us: int | None = None
        self._telegrams: list[bytes] = []
        self._seen: dict[str, object] = {}
        self._checks = list(self._chosen(kinds))

    def _chosen(self, kinds: Collection[str]) -> Iterator[Callable[[Moment, bytes], Findings]]:
        """Yield the checks that can find something of these kinds."""
        if {"telegram", PINS} & set(kinds):
            yield self._telegram
        named = {
            "outside": self._outside,
            "interval": self._interval,
            "levels": self._levels,
            "place": self._place,
            "owned": self._owner,
            "restart": self._restart,
            HANG: self._hang,
        }
        yield from (check for kind, check in named.items() if kind in kinds)
        if {"both", "order"} & set(kinds):
            yield _Jobs(self._program, self._about).scan
        if {*_HELD, "interval", "reserved", "start against stop"} & set(kinds):
            yield self._monitored
        if "contract" in kinds:
            monitor = ContractMonitor(self._program, self._about.steady)
            yield lambda moment, _: (
                (one.rule, one.text)
                for one in monitor.scan(moment.t_us, moment.number)
                if "16#8017" not in one.text  # out of place: an error of the caller
            )

    def scan(self, moment: Moment) -> list[tuple[str, str]]:
        """Return the findings of a scan, each with its kind and a text."""
        self._whole = self._program.read_bytes("Main.OutputArea")
        si = self._whole[self._about.n : self._about.n + SIZE]
        found = [one for check in self._checks for one in check(moment, si)]
        self.written = si
        self._seen = {
            BYTES: self._whole,
            SHOWN: self._look(),
            RESULT: self._results(),
        }
        return [one for one in found if one[0] in self._about.kinds]

    def differs(self, other: Judges) -> bool:
        """Return whether the last scan differs from that of the other run."""
        kinds = self._about.kinds
        if PINS in kinds and any(
            one != two for one, two in zip(self._telegrams, other._telegrams, strict=False)
        ):
            return True
        pairs = [(self._seen[k], other._seen[k]) for k in (BYTES, SHOWN, RESULT) if k in kinds]
        return any(one != two and repr(one) != repr(two) for one, two in pairs)  # NaN != NaN

    def _monitored(self, moment: Moment, si: bytes) -> Findings:
        at = moment.t_us, moment.number
        for one in self._wire.scan(*at, moment.area, si, moment.connected):
            yield one.rule, one.text

    def _interval(self, moment: Moment, si: bytes) -> Findings:
        """Check the spacing of changes by Interval and Margin (chapter 5, 3, caution)."""
        before, now = word(self.written, DEDICATED_AT), word(si, DEDICATED_AT)
        changed = before ^ now
        if not changed:
            return
        _, _, interval, margin = self._pins()
        spacing = max(timedelta(milliseconds=100), interval) + max(timedelta(0), margin)
        last, self._changed_us = self._changed_us, moment.t_us
        if not changed & ~_STOPS and not now & changed:
            return
        if changed & changed - 1:
            yield "interval", f"{changed:#06x} change in one scan"
        if last is not None and timedelta(microseconds=moment.t_us - last) < spacing:
            text = f"{changed:#06x} changes {moment.t_us - last} us after the last change"
            yield "interval", text

    def _levels(self, moment: Moment, si: bytes) -> Findings:
        """Check that SI(00) and SI(06) follow their pins and the link, and go OFF at once."""
        emergency_ok, stop_ok, _, _ = self._pins()
        for bit, allowed in ((0x01, emergency_ok), (0x40, stop_ok)):
            if si[DEDICATED_AT] & bit and not (allowed and moment.connected):
                yield "levels", f"bit {bit:#x} is ON without its pin, or without the link"

    def _place(self, _: Moment, si: bytes) -> Findings:
        """Check that requests go out only in a scan in which a block is called in its place."""
        rising = word(si, DEDICATED_AT) & ~word(self.written, DEDICATED_AT) & ~_STOPS
        if (rising or (word(si, 0) and not word(self.written, 0))) and not any(self._placed()):
            yield "place", "something goes out, and no block was called in its place"

    def _outside(self, _: Moment, si: bytes) -> Findings:
        n = self._about.n
        if (any(self._whole[:n]) or any(self._whole[n + 34 :])) and not self._general:
            yield "outside", "bytes before n or beyond n + 33 were written"

    def _telegram(self, moment: Moment, si: bytes) -> Findings:
        code = word(si, 0)
        if not code or code == word(self.written, 0):
            return
        self._telegrams.append(si[:DEDICATED_AT])
        words = [word(si, at) for at in range(0, DEDICATED_AT, 2)]
        if self._legal:
            command = self._legal.get(code & 0x0FFF)
            why = "there is no such command" if command is None else command.problem(words)
            if why:
                yield "telegram", f"{code:#06x} went out: {why}"

    def _owner(self, moment: Moment, _: bytes) -> Findings:
        """Check that Connected, Status and Response of FB_ReadArea hold the values read."""
        area = moment.area if moment.connected else bytes(SIZE)
        words = [word(area, at) for at in range(0, DEDICATED_AT, 2)]
        if self._owned() != (moment.connected, words[0], words[1:]):
            yield "owned", "Robot.Connected, Status or Response are not what was read"

    def _restart(self, moment: Moment, si: bytes) -> Findings:
        """Check that after a link loss only SI(00) and SI(06) come back without a new edge."""
        now = self._edges()
        edge = any(new and not old for new, old in zip(now, self._asked, strict=True))
        self._asked = now
        self._was_lost = not moment.connected or (self._was_lost and not edge)
        if self._was_lost:
            rising = word(si, DEDICATED_AT) & ~word(self.written, DEDICATED_AT) & ~_STOPS
            if rising or (word(si, 0) and not word(self.written, 0)):
                yield "restart", "something starts after a lost link without a new edge"

    def _hang(self, moment: Moment, _: bytes) -> Findings:
        if moment.quiet == QUIET:
            command, last, sequence, latest = self._channels()
            if command != last:
                yield HANG, f"the command channel still serves {command}"
            if sequence != latest:
                yield HANG, f"the sequence channel still serves {sequence}"


class _Jobs:
    """Check of the turns by the pins: one active job per channel, first come, first served."""

    def __init__(self, program: Program, about: About) -> None:
        self._turns: dict[str, list[int]] = {}
        paths: list[str] = []
        for number in about.blocks:
            pou = about.library.pou(about.client.blocks[number - 1].upper())
            if "ACTIVE" in pou.symbols:
                kind = "sequence" if Path(pou.file).parent.name == "sequence" else "command"
                self._turns.setdefault(kind, []).append(len(paths) // 4)
                once = ("Connected", "Connected") if about.client.steady else ("Call", "Late")
                calls = [f"Main.{name}{'' if about.client.steady else number}" for name in once]
                paths += [f"Main.B{number}.Busy", f"Main.B{number}.Active", *calls]
        self._look = program.reader(paths)
        self._since: dict[int, int] = {}
        self._scans = 0

    def scan(self, *_: Any) -> Findings:
        """Judge a scan."""
        self._scans += 1
        seen = self._look()
        pins = [
            (seen[at], seen[at + 1], seen[at + 2] or seen[at + 3]) for at in range(0, len(seen), 4)
        ]
        for place, (busy, _, called) in enumerate(pins):
            if not busy:
                self._since.pop(place, None)
            elif not called:
                self._since[place] = self._scans  # it may have lost its place in the queue
            else:
                self._since.setdefault(place, self._scans)
        for kind, places in self._turns.items():
            active = [place for place in places if pins[place][1] and pins[place][2]]
            if len(active) > 1:
                yield "both", f"two blocks have the turn of the {kind} channel"
            for place in places:
                busy, has_turn, called = pins[place]
                if busy and called and not has_turn:
                    older = self._since[place]
                    if any(self._since.get(one, 0) > older for one in active):
                        yield "order", f"a later comer has the turn of the {kind} channel"
