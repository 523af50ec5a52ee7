"""A bench that runs all contract cases of a block between FB_ReadArea and FB_WriteArea.

The bench plays the robot. rcx_harness.watch.contract.ContractMonitor and contract_rules.Rules check
every scan.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from itertools import takewhile
from pathlib import Path
from typing import Any, NoReturn

from contract_cases import (
    HELD,
    NONE,
    Case,
    command_cases,
    composite_cases,
    level_cases,
    sequence_cases,
)
from contract_player import FATES, Player, Start, bit
from contract_rules import REQUESTS, SCAN_US, TIMEOUT_SCANS, Pins, Rules, Subject
from fault_cell import CaseFailure, library, place
from fault_scenarios import LEVELS, SCENARIOS
from plc_bench import LIBRARY
from rcx_harness.spec import commands
from rcx_harness.watch.calls_source import steady_instances
from rcx_harness.watch.contract import ContractMonitor
from rcx_tools.library.tables import library as table
from structured_text.engines import build
from structured_text.engines.base import Program
from structured_text.projects.needed import needed

#: Longest time from a block's last wait to its end, with the interval of input changes [scans].
_MOST_END_SCANS = 30
#: Longest time until all requests are withdrawn and no block uses a channel [scans].
_MOST_RELEASE_SCANS = 45
#: Number of scans in which a level block is enabled.
_ENABLED = 18
#: Duration of an undisturbed command, from the edge to its end [scans].
_PROMPT = 8
#: Blocks that send several commands for one rising edge, with their codes.
_SEVERAL = {"FB_PickPlace": (0x0001, 0x0301, 0x0304)}

_SERVO = Start(("SO02", "SO14"))
_RUNNING = Start(("SO02", "SO13"))
_STARTS: dict[str, Start] = {
    "FB_AlarmReset": Start(("SO03",)),
    "FB_AutoStart": _SERVO,
    "FB_EmergencyStop": _RUNNING,
    "FB_ProgramContinue": Start(("SO02",)),
    "FB_ProgramCall": _RUNNING,
    "FB_ProgramReset": Start(("SO02",)),
    "FB_ProgramStop": _RUNNING,
    "FB_ReturnToOrigin": _SERVO,
    "FB_ServoOnFromEmergencyStop": Start(("SO00", "SO03"), missing=("SO04",)),
    "FB_PowerUp": Start(missing=("SO01", "SO04", "SO10")),
    "FB_ServoOn": Start(),
}
#: Sequences that begin while another block holds SI(00) or SI(06) OFF.
_HELD = {"FB_ServoOnFromEmergencyStop": "HoldEmergency", "FB_ProgramContinue": "HoldStop"}
#: Codes of blocks that contain other command blocks. On this bench, each run sends one command.
_CODES = {
    "FB_MoveTable": {0x0001},
    "FB_PointBackup": {0x101},
    "FB_PointRestore": {0x100},
    "FB_Override": {0x039, 0x50A},
    "FB_ToolPosition": {0x506},
}
#: Number of scans in which a block checks its inputs before it sends a command.
_SCANS_BEFORE_CODE = {
    "FB_MoveTable": 1,
    "FB_PickPlace": 1,
    "FB_PointRestore": 2,
    "FB_ProgramCall": 1,
}
#: Blocks that refuse to start while servos are off or there is an alarm.
_NEED_SERVOS = ("FB_MoveTable", "FB_PickPlace")
#: Blocks that write general-purpose words and bits: SIW(2) to SIW(7), SI(20).
_GENERAL = ("FB_ProgramCall",)
#: Blocks that wait for a connection.
_WAIT_FOR_LINK = ("FB_PowerUp",)

#: Every block with Robot and Execute or Enable, found by its pins.
BLOCKS: tuple[str, ...] = (*library().edge, *library().level)

_ALARM = ("AlarmGroup", "AlarmCategory")

#: SO(00), SO(02), SO(03) in byte 32, and their values when movements are allowed.
_STOP_OUTPUTS, _READY = 0b1101, 0b0100

_PROGRAM = """PROGRAM Contract
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, EmergencyStopOk, StopOk : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Block : {block};
{declared}  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Block(Robot := Robot{given});
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := EmergencyStopOk, StopOk := StopOk);
END_PROGRAM
"""


class ContractBench:
    """A bench with one block that is ready to start.

    Args:
        block: Type of the block.
        lib: Files of the library.

    Attributes:
        connected: The status of the PLC's scanner.
        safe: The pins EmergencyStopOk and StopOk.
        player: The controller.
        scans: Number of scans that have been checked.
    """

    def __init__(self, block: str, lib: Sequence[Path] = LIBRARY) -> None:
        self.block = block
        self.scans = 0
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "Contract.st"
            made = {"declared": library().declared(block), "given": library().given(block)}
            file.write_text(_PROGRAM.format(block=block, **made), encoding="utf-8")
            files = needed([file], lib)
            self.program = build([file, *files], "builtin").program
            self._monitor = ContractMonitor(self.program, steady_instances([file], files))
        steady = [one.path for one in self._monitor.instances if one.steady]
        assert "Main.Block" in steady
        self.subject = _subject(block)
        self._rules = Rules(self.subject)
        self._pin = "Main.Block.Enable" if self.subject.level else "Main.Block.Execute"
        self._look = _pins(self.program, block)
        self._turns = self.program.reader(
            [
                f"Main.Robot.Inner.{channel}.{name}"
                for channel in ("Command", "Sequence")
                for name in ("Serving", "NextTicket")
            ]
        )
        self.player = Player()
        self._history: list[tuple[bytes, bytes, bool, Pins]] = []
        self._prepare()

    def _prepare(self) -> None:
        """Power up until SI(00) and SI(06) are ON and settled, except an input that is held OFF."""
        self._put("Main.Block.Timeout", f"T#{TIMEOUT_SCANS * SCAN_US // 1000}ms")
        if self.block in SCENARIOS:
            for name, value in SCENARIOS[self.block].inputs.items():
                self._put(f"Main.{place(self.block, name)}", value)
        if self.block == "FB_ReturnToOrigin":
            self._put("Main.Block.Confirm", "T#120ms")
        self._now_us = 0
        self._si = bytes(48)
        self._forget(Case(HELD))
        for scan in range(4 * TIMEOUT_SCANS):
            if scan == 2 * TIMEOUT_SCANS and self.block in _HELD:
                self._put(f"Main.Robot.Inner.{_HELD[self.block]}", True)
            so = self.player.step(self._si, True)
            self._step(so)
            self._monitor.scan(0, 0)
        self._start = (self.program.snapshot(), self._now_us, self._si, self._monitor.snapshot())

    def _put(self, path: str, value: Any) -> None:
        here = path.rpartition(".")[2] in library().pins[self.block]
        if here or ".Block." not in path:
            self.program.write(path, value)

    def _forget(self, case: Case) -> None:
        start = _STARTS.get(self.block, _SERVO)
        self.player.begin(start, case.fate, case.signal, case.shown, case.delay)
        self.player.takes_jobs = self.block in _GENERAL
        self.player.settle(int.from_bytes(self._si[32:34], "little"))
        self.connected, self.safe = True, (True, True)
        self._written = (True, True, True)
        self._execute = False

    def _step(self, so: bytes) -> None:
        self.program.write_bytes("Main.InputArea", so)
        self.program.scan(self._now_us)
        self._now_us += SCAN_US
        self._si = self.program.read_bytes("Main.OutputArea")[:48]

    @property
    def pins(self) -> Pins:
        """Return the block's outputs."""
        return self._look()

    @property
    def _judged(self) -> bytes:
        """Return the written area. General-purpose words and bits that the block may use are 0."""
        if self.block not in _GENERAL:
            return self._si
        return self._si[:4] + bytes(12) + self._si[16:34] + bytes(1) + self._si[35:]

    def _scan(self, execute: bool) -> Pins:
        """Run one scan, check all rules, and return the block's outputs."""
        if execute is not self._execute:
            self.program.write(self._pin, execute)
            self._execute = execute
        inputs = (self.connected, *self.safe)
        if inputs != self._written:
            for name, value in zip(("Connected", "EmergencyStopOk", "StopOk"), inputs, strict=True):
                self.program.write(f"Main.{name}", value)
            self._written = inputs
        so = self.player.step(self._si, self.connected)
        self._step(so)
        self.scans += 1
        pins = self.pins
        self._history.append((so, self._si, execute, pins))
        wrong = self._rules.scan(so, self._judged, self.connected, self.safe, execute, pins)
        if wrong:
            self._fail(wrong)
        found = self._monitor.scan(self._now_us, self.scans)
        if found:
            self._fail(found[0].text.partition("contract: ")[2])
        return pins

    def run(self, case: Case) -> None:
        """Run one case: the disturbed run, the recovery, then a normal run of the block.

        Raises:
            CaseFailure: the case failed; the message has the case and the last scans.
        """
        snapshot, self._now_us, self._si, monitor = self._start
        self.program.restore(snapshot)
        self._monitor.restore(monitor)  # type: ignore[arg-type]
        self._history.clear()
        self._forget(case)
        self._rules.begin(self._judged, self.pins)
        try:
            self._disturb(case)
            self._come_to_rest(case)
            self._work_again()
        except CaseFailure as failure:
            raise CaseFailure(f"{self.block}: {case}: {failure}") from None

    def _disturb(self, case: Case) -> None:
        ended, scan = -1, 0
        limit = TIMEOUT_SCANS * self._waits + _MOST_END_SCANS
        while scan <= max(case.at + 1, ended + 3) or (ended < 0 or self.pins.busy):
            if scan == case.at:
                case.event.set(self, True)
            if scan == case.at + case.event.lasts:
                case.event.set(self, False)
            pins = self._scan(case.pattern.on(scan, ended))
            over = scan >= _ENABLED if self.subject.level else not pins.busy
            if ended < 0 and over:
                ended = scan
                self._expect(case, pins)
            if scan > limit + max(ended, 0):
                self._fail(f"the block hangs: Busy for more than {limit} scans")
            if self.subject.level and ended >= 0:
                break
            scan += 1
        self._scan(False)

    def _expect(self, case: Case, pins: Pins) -> None:
        """Check the end of the block in a case without an event."""
        if case.event is not NONE:
            return
        if case.signal:
            wrong = {"normal": pins.error, "late": pins.error, "never": pins.done}
            if not self.subject.level and wrong.get(case.shown):
                self._fail(f"the block ended with {pins}, but the answer was {case.shown}")
        elif not self.subject.level and pins.error_id != case.fate.error:
            self._fail(f"the block ended with {pins}, expected 16#{case.fate.error:04X}")
        elif case.pattern is HELD and case.fate is FATES[0] and not pins.done:
            self._fail(f"{pins} instead of Valid")

    @property
    def _waits(self) -> int:
        return SCENARIOS[self.block].waits if self.block in SCENARIOS else 1

    def _come_to_rest(self, case: Case) -> None:
        """Reset Execute, remove all faults, and check that nothing starts and no job waits."""
        case.event.set(self, False)
        self.player.be_normal()
        self.connected, self.safe = True, (True, True)
        self._rules.quiet = True
        for _ in range(_MOST_RELEASE_SCANS):
            pins = self._scan(False)
            command, next_command, sequence, next_sequence = self._turns()
            free = command == next_command and sequence == next_sequence
            bits = int.from_bytes(self._si[32:34], "little")
            if free and not bits & REQUESTS and not any(self._judged[:32]) and not any(pins):
                break
        else:
            self._fail(f"not idle {_MOST_RELEASE_SCANS} scans after all faults are removed")
        for _ in range(3):
            self._scan(False)
        self._rules.quiet = False

    def _work_again(self) -> None:
        if not self.subject.codes or self.subject.level:
            return
        if self.block in _NEED_SERVOS and self._history[-1][0][32] & _STOP_OUTPUTS != _READY:
            return
        for _ in range(_PROMPT * self._waits):
            if self._scan(True).done:
                break
        else:
            self._fail(f"{self.pins} instead of Done after all faults are removed")
        self._scan(False)

    def _fail(self, text: str) -> NoReturn:
        first = max(0, len(self._history) - 14)
        lines = [
            f"    scan {k}: {_told(*self._history[k])}" for k in range(first, len(self._history))
        ]
        raise CaseFailure("\n".join([f"{text} (scan {len(self._history) - 1})", *lines]))


def _told(so: bytes, si: bytes, execute: bool, pins: Pins) -> str:
    words = [int.from_bytes(one[k : k + 2], "little") for one in (so, si) for k in (0, 32)]
    return "SO {1:016b} {0:04X} | SI {3:016b} {2:04X} | ".format(*words) + (
        f"{'Execute' if execute else '       '} -> {pins}"
    )


def _pins(program: Program, block: str) -> Callable[[], Pins]:
    """Return a function that reads the outputs.

    FB_Status has no Busy. Active and the two alarm outputs are optional.
    """
    names = ["Done" if block in library().edge else "Valid", "Error", "ErrorID", "Active"]
    there = list(takewhile(library().pins[block].__contains__, [*names, *_ALARM]))
    look = program.reader([f"Main.Block.{name}" for name in ("Busy", *there)[not _busy(block) :]])
    if _busy(block):
        return lambda: Pins(*look())
    return lambda: Pins(False, *look())


def _busy(block: str) -> bool:
    return "Busy" in library().pins[block]


def _subject(block: str) -> Subject:
    rows = table().blocks
    known = rows[block].commands if block in rows else ()
    codes = {one.code for one in known} | {*_SEVERAL.get(block, ())}
    if block == "FB_RemoteCommand":
        codes = {SCENARIOS[block].inputs["Code"]}
    codes |= _CODES.get(block, set())
    judged: dict[bytes, bool] = {}

    def legal(telegram: bytes) -> bool:
        if telegram not in judged:
            words = [telegram[k] | telegram[k + 1] << 8 for k in range(0, 32, 2)]
            judged[telegram] = commands()[words[0] & 0x0FFF].problem(words) == ""
        return judged[telegram]

    scenario = SCENARIOS.get(block) or LEVELS.get(block)
    mask = value = 0
    for name, on in (scenario.means if scenario else {}).items():
        mask |= bit(name)
        value |= bit(name) * on
    level = block in library().level
    means, ahead, several = (mask, value), _SCANS_BEFORE_CODE.get(block, 0), block in _SEVERAL
    return Subject(frozenset(codes), level, block in _WAIT_FOR_LINK, means, legal, several, ahead)


def cases(block: str) -> list[Case]:
    """Return all cases of a block."""
    if block in library().level:
        return level_cases(LEVELS[block].answers[0])
    if block in _SEVERAL:
        return composite_cases(2 * SCENARIOS[block].waits)
    if _subject(block).codes:
        return command_cases()
    return sequence_cases(SCENARIOS[block].answers, 14 if SCENARIOS[block].waits < 3 else 40)
