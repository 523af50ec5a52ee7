"""The check that the controller executes every request exactly once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from rcx_harness.trace import Record, Scan
from rcx_tools.evidence.campaign.commands import COMMANDS, LEVELS, Telegrams
from rcx_tools.evidence.campaign.requests import Comparison, Request, hexed
from rcx_tools.evidence.campaign.station import Execution
from structured_text.engines.base import Program

__all__ = ["SEQUENCES", "Judge"]

#: Sequence blocks: the dedicated inputs that each block may switch ON, and the outputs that must
#: hold at Done (mask and value of word m + 32).
SEQUENCES: dict[str, tuple[int, tuple[int, int]]] = {
    "AlarmReset": (1 << 14, (1 << 3, 0)),
    "ServoOn": (1 << 1, (1 << 2, 1 << 2)),
    "ProgramReset": (1 << 13, (1 << 12, 1 << 12)),
    "AutoStart": (1 << 10, (1 << 11, 1 << 11)),
    "ProgramStop": (0, (1 << 11, 0)),
    "ProgramContinue": (1 << 10, (1 << 11, 1 << 11)),
    "EmergencyStop": (0, (1 << 0 | 1 << 2, 1 << 0)),
    "FromEmergency": (1 << 14 | 1 << 1, (1 << 0 | 1 << 2, 1 << 2)),
    "PowerUp": (1 << 14 | 1 << 1 | 1 << 13 | 1 << 10, (1 << 2, 1 << 2)),
    "ReturnToOrigin": (1 << 12 | 1 << 15, (1 << 9, 1 << 9)),
}
_JOGS = (0x0020, 0x0021, 0x0022)
_SI00, _SI06, _SI10 = 1 << 0, 1 << 6, 1 << 8


@dataclass
class _Watched:
    """A block whose Busy, Error and ErrorID are read in every scan."""

    name: str
    place: str
    telegrams: Telegrams | None = None
    level: bool = False
    busy: bool = False
    request: Request | None = None


class Judge:
    """Observer of the blocks that compares their requests with the controller's executions.

    Args:
        program: The running program.
        found: Function that is called with each finding: its kind, and a sentence.
    """

    def __init__(self, program: Program, found: Callable[[str, str], None]) -> None:
        self._program, self._found = program, found
        self._comparison = Comparison(lambda block, end: COMMANDS[block].shown(end), found)
        self.requests: list[Request] = []
        self.ends: dict[str, int] = {}
        """How often commands ended with `Done` or with an ErrorID such as `16#8011`."""
        self.done: dict[str, int] = {}
        """How often each block ended with Done."""
        commands = [_Watched(name, name, entry) for name, entry in COMMANDS.items()]
        commands += [_Watched(name, f"{name}.Job", one, True) for name, one in LEVELS.items()]
        self._blocks = commands + [_Watched(name, name) for name in SEQUENCES]
        pins = ("Busy", "Error", "ErrorID")
        self._look = program.reader(
            [f"Main.{one.place}.{pin}" for one in self._blocks for pin in pins]
            + ["Main.SequenceControl.Enable", "Main.EmergencyStopOk", "Main.StopOk"]
            + [
                "Main.Robot.Inner.Phase",
                "Main.GeneralWord",
                "Main.GeneralBit",
                "Main.Jog.Enable",
            ]
        )
        self._code = self._bits = 0
        self._points: dict[int, list[list[int]]] = {}

    def restart(self) -> None:
        """Delete the requests in progress. The PLC has lost its memory, so they never end."""
        for one in self._blocks:
            one.busy, one.request = False, None
        self._code = self._bits = 0

    @property
    def busy(self) -> list[str]:
        """Return the busy blocks."""
        return [one.name for one in self._blocks if one.busy]

    def take(self, record: Record) -> None:
        """Check a record of the trace if it is a scan."""
        if isinstance(record, Scan):
            self._scan(record)

    def _scan(self, scan: Scan) -> None:
        values = self._look()
        able, telegrams = 0, []
        outputs = int.from_bytes(scan.so[32:34], "little")
        for k, one in enumerate(self._blocks):
            busy, error, error_id = values[3 * k : 3 * k + 3]
            if busy and not one.busy:
                self._started(one, scan.t_us)
            if busy or one.busy:
                if one.request is not None:
                    telegrams.append(one.request.words)
                elif one.telegrams is None:
                    able |= SEQUENCES[one.name][0]
            if one.busy and not busy:
                self._ended(one, scan.t_us, error_id, outputs, done=not error)
            one.busy = busy
        enable, emergency_ok, stop_ok, phase, word, bit, jog = values[-7:]
        before = self._code
        able |= _SI10 * enable | _SI00 * emergency_ok | _SI06 * stop_ok
        self._follow_wire(scan, able, telegrams)
        if before in _JOGS and self._code in _JOGS and not jog and scan.si[32] & _SI06:
            self._found("jog goes on", "Jog.Enable is FALSE, SI(06) is ON and the code is out")
        if phase in ("PHASE_READY", "PHASE_STATUS_RESET") and scan.si[4:6] != word.to_bytes(
            2, "little"
        ):
            self._found("general word", f"{scan.si[4:6].hex()} is out between commands, not {word}")
        if scan.si[34] != bit:
            self._found("general bit", f"byte n+34 is {scan.si[34]:02x}, SI(20) is {bit}")

    def _follow_wire(self, scan: Scan, able: int, telegrams: Sequence[tuple[int, ...]]) -> None:
        code = scan.si[0] | scan.si[1] << 8
        if code and not self._code:
            words = tuple(int.from_bytes(scan.si[k : k + 2], "little") for k in range(0, 32, 2))
            if words not in telegrams:
                text = f"a telegram is sent without a request: {hexed(words)}"
                self._found("starts by itself", text)
        self._code = code
        bits = int.from_bytes(scan.si[32:34], "little")
        if rising := bits & ~self._bits & ~able:
            names = [f"SI{k >> 3}{k & 7}" for k in range(16) if rising >> k & 1]
            self._found("starts by itself", f"{', '.join(names)} goes ON, asked for by no block")
        self._bits = bits

    def _pin(self, one: _Watched, pin: str) -> Any:
        return self._program.read(f"Main.{one.name}.{pin}")

    def _started(self, one: _Watched, t_us: int) -> None:
        if one.telegrams is None:
            return
        pins = {pin: self._pin(one, pin) for pin in one.telegrams.inputs}
        one.request = Request(one.name, one.telegrams.words(pins), t_us, one.level)
        self.requests.append(one.request)
        if one.name == "WritePoint":
            self._points.setdefault(pins["Point"], []).append(pins["Pulses"])

    def _ended(self, one: _Watched, t_us: int, error_id: int, outputs: int, *, done: bool) -> None:
        if done:
            self.done[one.name] = self.done.get(one.name, 0) + 1
        request, one.request = one.request, None
        if request is None or one.telegrams is None:
            mask, value = SEQUENCES[one.name][1]
            if done and outputs & mask != value:
                text = f"{one.name}.Done, but the controller shows {outputs:04X} at m+32"
                self._found("Done without its effect", text)
            return
        request.end_us, request.error_id = t_us, error_id
        if one.level:
            return
        end = "Done" if done else f"16#{error_id:04X}"
        self.ends[end] = self.ends.get(end, 0) + 1
        request.alarm = (self._pin(one, "AlarmGroup"), self._pin(one, "AlarmCategory"))
        request.shown = {pin: self._pin(one, pin) for pin in one.telegrams.outputs}
        if done:
            self._follow_points(one)

    def _follow_points(self, one: _Watched) -> None:
        """Check that reading a point returns the position that was written last.

        After a write with unknown outcome, the old and the new position are possible.
        """
        if one.name not in ("WritePoint", "ReadPoint"):
            return
        number, pulses = self._pin(one, "Point"), self._pin(one, "Pulses")
        # The block samples its inputs at the edge. At its end they may already belong to the next
        # request.
        if one.name == "ReadPoint":
            number = self._pin(one, "PointRead")
            known = self._points.get(number)
            if known and len(known) == 1 and pulses != known[0]:
                text = f"point {number} was written as {known[0]} and is read as {pulses}"
                self._found("wrong data", text)

    def settle(self, executions: list[Execution]) -> int:
        """Compare all requests with the executions, and return the number of requests.

        Both lists are empty afterwards.
        """
        self._comparison.of(self.requests, executions)
        count = len(self.requests)
        self.requests.clear()
        executions.clear()
        return count
