"""Rules for the words on the wire and the pins of one block. Each scan must obey them.

The rules follow the manual and the design. They are independent of rcx_harness.watch.wire, which
watches cells. The program is scanned every SCAN_US, and its Margin is 20 ms.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

SCAN_US = 40_000
#: Time between two changes of dedicated inputs in the written area: 100 ms + the margin.
SPACING_US = 120_000
#: Timeout of the blocks, in scans.
TIMEOUT_SCANS = 10

#: SI(00), SI(01), SI(06), SI(10), SI(12), SI(14) to SI(17): the inputs that exist.
_INPUTS = 0b1111_0101_0100_0011
#: SI(00) and SI(06), which are switched off without delay.
_SAFETY = 0b0100_0001
#: Inputs that sequences request.
REQUESTS = _INPUTS & ~_SAFETY
_ENDS = (0x0200, 0x4000)
_JOG = (0x020, 0x021, 0x022)
_CONTINUOUS = (0x505, 0x506)

#: Every ErrorID with which an edge-triggered block may end on this bench.
CODES = frozenset({*range(0x8001, 0x800D), *range(0x8010, 0x8016), 0x8020, *range(0x8080, 0x8086)})


class Pins(NamedTuple):
    """Outputs of a block; Valid of a level block is `done`."""

    busy: bool
    done: bool
    error: bool
    error_id: int
    active: bool = False
    group: int = 0
    category: int = 0

    def __str__(self) -> str:
        named = zip(("Busy", "Done/Valid", "Error", "Active"), self[:3] + self[4:5], strict=True)
        shown = " ".join(name for name, on in named if on)
        return f"{shown or '-'}{f' 16#{self.error_id:04X}' if self.error_id else ''}"


class Subject(NamedTuple):
    """The properties of the block under test.

    Attributes:
        codes: Remote commands that the block may send; empty for a sequence.
        level: Whether the block works while Enable is TRUE.
        patient: Whether the block waits for the connection instead of ending without it.
        means: Dedicated outputs that Done (Valid) confirms, as mask and value.
        legal: A function that returns whether a telegram of 16 words is legal.
        several: Whether the block sends several commands for one rising edge.
        ahead: Number of scans in which the block works before it sends its code.
    """

    codes: frozenset[int]
    level: bool
    patient: bool
    means: tuple[int, int]
    legal: Callable[[bytes], bool]
    several: bool = False
    ahead: int = 0


def _word(area: bytes, at: int) -> int:
    return area[at] | area[at + 1] << 8


class Rules:
    """The rules for one block. `begin` starts a new case, and `scan` checks a scan."""

    def __init__(self, subject: Subject) -> None:
        self.subject = subject
        self.begin(bytes(48), Pins(False, False, False, 0))

    def begin(self, si: bytes, pins: Pins) -> None:
        """Start from a quiet state that has lasted for a long time."""
        self._si, self._pins = si, pins
        self._scan = 0
        self._changed = self._live = -TIMEOUT_SCANS
        self._was_connected = self._was_live = True
        self._answered = False
        self._execute = False
        self._active = -1
        self._begun = -1
        self._sent = 0
        self._ready = False
        self.quiet = False

    def scan(
        self,
        so: bytes,
        si: bytes,
        connected: bool,
        safe: tuple[bool, bool],
        start: bool,
        pins: Pins,
    ) -> str:
        """Check one scan.

        Args:
            so: The area that the program has read.
            si: The area that the program has written.
            connected: The status of the scanner.
            safe: The pins EmergencyStopOk and StopOk.
            start: Execute or Enable.
            pins: The block's outputs after the scan.

        Returns:
            The first broken rule as a text, or an empty text.
        """
        self._scan += 1
        live = connected and bool(so[32] & 2)
        if live and not self._was_live:
            self._live = self._scan
        if connected and not self._was_connected:
            self._changed = self._scan
        status = _word(so, 0) if connected else 0
        wrong = (
            self._command(si, status, live)
            or self._dedicated(si, connected, safe)
            or self._block(so, si, status, connected, live, start, pins)
        )
        self._si, self._pins, self._execute = si, pins, start
        self._was_connected, self._was_live = connected, live
        return wrong

    # --- the remote command (guide chapters 1 and 2) ------------------------------------------

    def _command(self, si: bytes, status: int, live: bool) -> str:
        before = self._si
        was, code = _word(before, 0), _word(si, 0)
        if not live:
            return f"the code 0x{code:04X} is out without connection or CPU_OK" if code else ""
        if was:
            if status in _ENDS:
                return "the code stays although the end status has come" if code else ""
            if status:
                self._answered = True
            lost = status == 0 and self._answered
            endless = was & 0x0FFF in _CONTINUOUS and before[2] & 1 and status == 0x0100
            if lost and code:
                return "the code stays although the status has fallen back"
            if lost:  # as after a restart of the controller
                self._live = self._scan
            if code != was and (code or not (lost or endless)):
                return f"the code 0x{was:04X} became 0x{code:04X} before an end status"
            if code and si[2:32] != before[2:32]:
                return "data changed while the code was out"
            return ""
        if not code:
            return ""
        self._answered = False
        self._sent += 1
        if status:
            return f"the code went out while the status was 0x{status:04X}"
        if si[2:32] != before[2:32]:
            return "the data came together with the code, not before it"
        if (self._scan - self._live) * SCAN_US < SPACING_US:
            return "the code went out before the controller can have seen 0x0000"
        if code & 0x0FFF not in self.subject.codes:
            return f"the code 0x{code:04X} is not a command of this block"
        if not self.subject.legal(si[:32]):
            return "the telegram is not legal"
        return "a command is sent without a request" if self.quiet else ""

    # --- dedicated inputs (chapter 5, 3, caution) ---------------------------------------------

    def _dedicated(self, si: bytes, connected: bool, safe: tuple[bool, bool]) -> str:
        before, now = _word(self._si, 32), _word(si, 32)
        if si[34:48] != self._si[34:48] or now & ~_INPUTS:
            return "reserved or general-purpose bits were written"
        for mask, allowed, pin in ((1, safe[0], "EmergencyStopOk"), (1 << 6, safe[1], "StopOk")):
            if now & mask and not (connected and allowed):
                return f"the input of {pin} is ON without connection or without its pin"
        changed = before ^ now
        if not changed:
            return ""
        since = (self._scan - self._changed) * SCAN_US
        self._changed = self._scan
        if changed & ~(_SAFETY & before):
            if changed & changed - 1:
                return f"several inputs changed in one scan: {changed:016b}"
            if since < SPACING_US:
                return f"{changed:016b} changed {since // 1000} ms after the last change"
        if self.quiet and now & ~before & REQUESTS:
            return "an input is switched ON without a request"
        return ""

    # --- the block (design of the library, 3) -------------------------------------------------

    def _block(
        self,
        so: bytes,
        si: bytes,
        status: int,
        connected: bool,
        live: bool,
        start: bool,
        pins: Pins,
    ) -> str:
        was = self._pins
        means, value = self.subject.means
        said = _word(so, 32) & means == value
        if pins.done and (not was.done or self.subject.level) and connected and not said:
            return f"{pins}, but the controller's outputs do not confirm it"
        if self.subject.level:
            return self._level(si, status, start, pins)
        if pins.busy and not was.busy:
            self._begun, self._active, self._sent = self._scan, -1, 0
            at_rest = not _word(self._si, 0) and not status
            self._ready = at_rest and live and self._scan - self._live > TIMEOUT_SCANS // 2
            if not start or self._execute:
                return "Busy without a rising edge"
        if pins.active and self._active < 0:
            self._active = self._scan
        if not was.busy or (pins.busy and self._begun == self._scan):
            return ""
        if pins.busy:
            return self._still(si, status, connected, live)
        return self._end(so, status, connected, live, pins)

    def _still(self, si: bytes, status: int, connected: bool, live: bool) -> str:
        """Return why the block must not stay Busy, or an empty text if it may."""
        if not connected and not self.subject.patient:
            return "Busy without a connection"
        if not self.subject.codes:
            return ""
        if connected and not live:
            return "Busy without CPU_OK"
        if self.subject.several:
            return ""
        if _word(self._si, 0) and status in _ENDS and self._sent:
            return "Busy although the end status has come"
        due = self._begun + 1 + self.subject.ahead
        if self._ready and due == self._scan and not status and not _word(si, 0):
            return "the code is not out one scan after the edge"
        return ""

    def _end(self, so: bytes, status: int, connected: bool, live: bool, pins: Pins) -> str:
        was, number = _word(self._si, 0), pins.error_id
        alarm = (_word(so, 2), _word(so, 4)) if number == 0x8020 else (0, 0)
        late = self._active >= 0 and self._scan - self._active >= TIMEOUT_SCANS
        commands = bool(self.subject.codes) and not self.subject.several
        if commands and (pins.group, pins.category) != alarm:
            return f"alarm {pins.group}.{pins.category}, expected {alarm[0]}.{alarm[1]}"
        if number and number not in CODES:
            return f"the ErrorID 16#{number:04X} is not expected on this bench"
        if commands and self._sent > 1:
            return f"{self._sent} telegrams for one rising edge"
        true = {
            0: not commands or (status == 0x0200 and was != 0 and self._sent == 1),
            0x8001: not connected or (self.subject.ahead > 0 and not self._was_connected),
            0x8002: connected and not live,
            0x8010: late or not commands,
            0x8011: late and was != 0,
            0x8014: status == 0 and was != 0,
            0x8015: late and self._sent == 0,
            0x8020: status == 0x4000 and was != 0,
        }
        if not true.get(number, True):
            return f"the block ended with {pins}, but its cause did not occur"
        if not connected and number != 0x8001 and not self.subject.patient:
            return f"without a connection the block ended with {pins}"
        return ""

    def _level(self, si: bytes, status: int, start: bool, pins: Pins) -> str:
        shown = pins.busy + pins.done + pins.error
        if shown != start:
            return f"Enable is {start}, but the outputs are {pins}"
        code = _word(si, 0) & 0x0FFF
        if code in _JOG and not start and si[32] & 1 << 6:
            return "the jog continues with SI(06) ON although Enable is FALSE"
        if code in _CONTINUOUS and si[2] & 1 and not start and status == 0x0100:
            return "the continuous output continues although Enable is FALSE"
        return ""
