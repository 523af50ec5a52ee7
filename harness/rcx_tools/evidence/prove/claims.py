"""What breaks a property in a run, judged on the engine by plain Python: no solver, no formulas."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from datetime import timedelta

from rcx_harness.engine.base import Program
from rcx_harness.spec import commands
from rcx_harness.spec.wire import DEDICATED_AT, SIZE
from rcx_harness.watch.contract import ContractMonitor
from rcx_harness.watch.wire import WireMonitor, word
from rcx_tools.evidence.prove.client import Client, Moment
from rcx_tools.evidence.prove.library import Library

__all__ = ["CLAIMS", "DIFFERS", "HANG", "QUIET", "STOPS", "Judges"]

#: Kinds of findings: the program cannot go on; a channel is not free in a quiet environment;
#: another telegram, another area, other outputs of blocks than with the library as it is, which
#: is proved.
STOPS, HANG, PINS, BYTES, SHOWN = "stops", "hang", "pins", "bytes", "shown"
DIFFERS = (PINS, BYTES, SHOWN)
_HELD = ("command held", "data before code", "ready before code")
_TURNS = ("both", "order", HANG, SHOWN)

#: Of each property: the kinds of findings that refute it.
CLAIMS: Mapping[str, tuple[str, ...]] = {
    "interval": ("interval",),
    "stop-inputs": ("levels",),
    "restart": ("restart", "start against stop", BYTES),
    "handshake": _HELD,
    "response": ("owned", SHOWN),
    "guarantee": ("owned", *_HELD, "interval", "levels", "start against stop", BYTES),
    "bytes": ("outside", BYTES),
    "reserved": ("reserved", BYTES),
    "contract": ("contract", SHOWN),
    "safety": (STOPS, SHOWN),
    "functions": (SHOWN,),
    "telegram-legal": ("telegram",),
    "telegram-pins": (PINS,),
    **dict.fromkeys(
        ("turn-hands", "turn-once", "turn-order", "turn-back", "turn-free", "turn-limit"), _TURNS
    ),
}
#: SI(00) and SI(06), whose switch-off goes out at once.
_STOPS = 0x0041
#: Scans with a quiet environment after which the channels have to be free.
QUIET = 120

Findings = Iterator[tuple[str, str]]


class Judges:
    """All of them, on one program in a run from its start.

    Args:
        program: The client, compiled.
        library: Where its blocks are.
        client: What it is.
        steady: Instances that are called once in every scan.

    Attributes:
        written: The area as it was written in the last scan.
    """

    def __init__(
        self, program: Program, library: Library, client: Client, steady: set[str]
    ) -> None:
        self.written = bytes(SIZE)
        self._program = program
        self._wire = WireMonitor(SIZE)
        self._contract = ContractMonitor(program, steady)
        pins = ("EmergencyStopOk", "StopOk", "Interval", "Margin")
        self._pins = program.reader([f"Main.WriteArea.{name}" for name in pins])
        owned = ("Connected", "Status", "Response")
        self._owned = program.reader([f"Main.Robot.{name}" for name in owned])
        outputs = [
            f"Main.B{number}.{symbol.name}"
            for number, block in enumerate(client.blocks, 1)
            for symbol in library.pou(block.upper()).section("VAR_OUTPUT")
        ]
        self._look = program.reader(outputs)
        edges = [path for path in _scalars(library, client) if path.endswith(("Execute", "Enable"))]
        self._edges = program.reader(edges)
        self._asked: tuple[object, ...] = (False,) * len(edges)
        self._was_lost = False
        parts = [
            f"{channel}.{part}"
            for channel in ("Command", "Sequence")
            for part in ("Serving", "NextTicket")
        ]
        self._channels = program.reader([f"Main.Robot.Inner.{part}" for part in parts])
        self._jobs = _Jobs(program, library, client)
        sends = all("RemoteCommand" not in block for block in client.blocks)
        self._legal = commands() if sends else {}
        self._general = any(block.startswith("FB_Write") for block in client.blocks)
        self._changed_us: int | None = None
        self._outputs: list[bytes] = []
        self._shown: list[tuple[object, ...]] = []
        self._telegrams: list[tuple[int, bytes]] = []

    def scan(self, moment: Moment) -> list[tuple[str, str]]:
        """What a scan breaks: the kind of it, and what it is."""
        si = self._program.read_bytes("Main.OutputArea")
        found = [
            *self._outside(si),
            *self._interval(moment, si),
            *self._levels(moment, si),
            *self._telegram(moment, si),
            *self._owner(moment),
            *self._restart(moment, si),
            *self._jobs.scan(),
            *self._hang(moment),
        ]
        at, number, so = moment.t_us, moment.number, moment.area
        monitors = self._wire.scan(at, number, so, si[:SIZE], moment.connected)
        found += [(one.rule, one.text) for one in monitors + self._contract.scan(at, number)]
        self.written = si[:SIZE]
        self._outputs.append(si)
        self._shown.append(self._look())
        return found

    def differs(self, other: Judges, kinds: Collection[str]) -> int | None:
        """The number of the scan in which something else went out than in the other run."""
        if PINS in kinds:
            for one, two in zip(self._telegrams, other._telegrams, strict=False):
                if one[1] != two[1]:
                    return max(one[0], two[0])
        pairs: list[Iterator[tuple[object, object]]] = []
        if BYTES in kinds:
            pairs.append(zip(self._outputs, other._outputs, strict=False))
        if SHOWN in kinds:
            pairs.append(zip(self._shown, other._shown, strict=False))
        for number, seen in enumerate(zip(*pairs, strict=False)):
            if any(left != right for left, right in seen):
                return number
        return None

    def _interval(self, moment: Moment, si: bytes) -> Findings:
        """Chapter 5, 3, caution; with what Interval and Margin ask for besides."""
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
        """SI(00) and SI(06) follow their pins and the link, at once where they go OFF."""
        emergency_ok, stop_ok, _, _ = self._pins()
        for bit, allowed in ((0x01, emergency_ok), (0x40, stop_ok)):
            if si[DEDICATED_AT] & bit and not (allowed and moment.connected):
                yield "levels", f"bit {bit:#x} is ON without its pin, or without the link"

    def _outside(self, si: bytes) -> Findings:
        if any(si[34:]) and not self._general:
            yield "outside", "bytes beyond n + 33 were written"

    def _telegram(self, moment: Moment, si: bytes) -> Findings:
        code = word(si, 0)
        if not code or code == word(self.written, 0):
            return
        self._telegrams.append((moment.number, si[:DEDICATED_AT]))
        words = [word(si, at) for at in range(0, DEDICATED_AT, 2)]
        if self._legal:
            command = self._legal.get(code & 0x0FFF)
            why = "there is no such command" if command is None else command.problem(words)
            if why:
                yield "telegram", f"{code:#06x} went out: {why}"

    def _owner(self, moment: Moment) -> Findings:
        """What FB_ReadArea owns is as it was read."""
        area = moment.area if moment.connected else bytes(SIZE)
        words = [word(area, at) for at in range(0, DEDICATED_AT, 2)]
        if self._owned() != (moment.connected, words[0], words[1:]):
            yield "owned", "Robot.Connected, Status or Response are not what was read"

    def _restart(self, moment: Moment, si: bytes) -> Findings:
        """After a loss nothing but SI(00) and SI(06) without a new edge."""
        now = self._edges()
        edge = any(new and not old for new, old in zip(now, self._asked, strict=True))
        self._asked = now
        self._was_lost = not moment.connected or (self._was_lost and not edge)
        if self._was_lost:
            rising = word(si, DEDICATED_AT) & ~word(self.written, DEDICATED_AT) & ~_STOPS
            if rising or (word(si, 0) and not word(self.written, 0)):
                yield "restart", "something starts after a lost link without a new edge"

    def _hang(self, moment: Moment) -> Findings:
        if moment.quiet == QUIET:
            command, last, sequence, latest = self._channels()
            if command != last:
                yield HANG, f"the command channel still serves {command}"
            if sequence != latest:
                yield HANG, f"the sequence channel still serves {sequence}"


def _scalars(library: Library, client: Client) -> Iterator[str]:
    """The inputs of the blocks."""
    for number, block in enumerate(client.blocks, 1):
        for symbol in library.pou(block.upper()).section("VAR_INPUT"):
            yield f"Main.B{number}.{symbol.name}"


class _Jobs:
    """Whose turn it is, by the pins: one at a time, first come, first served."""

    def __init__(self, program: Program, library: Library, client: Client) -> None:
        self._turns: dict[str, list[int]] = {}
        paths: list[str] = []
        for number, block in enumerate(client.blocks, 1):
            pou = library.pou(block.upper())
            if "ACTIVE" in pou.symbols:
                kind = "sequence" if "sequence" in pou.file else "command"
                self._turns.setdefault(kind, []).append(len(paths) // 3)
                call = "Main.Connected" if client.steady else f"Main.Call{number}"
                paths += [f"Main.B{number}.Busy", f"Main.B{number}.Active", call]
        self._look = program.reader(paths)
        self._since: dict[int, int] = {}
        self._scans = 0

    def scan(self) -> Findings:
        """Judge a scan."""
        self._scans += 1
        seen = self._look()
        pins = [seen[at : at + 3] for at in range(0, len(seen), 3)]
        for place, (busy, _, called) in enumerate(pins):
            if not busy:
                self._since.pop(place, None)
            elif not called:
                self._since[place] = self._scans  # it may have lost its place
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
