"""The rules for the data that a controller sends, checked on the transmitted areas.

The monitor judges the controller's answers to the data that the PLC has sent. The monitor in
wire.py judges the data of the PLC. The virtual controller keeps these rules by design, so the
monitor is for recordings of other controllers.
"""

from __future__ import annotations

from rcx_harness.robot import Violation
from rcx_harness.spec import signals
from rcx_harness.spec.wire import DEDICATED_AT, ENDS, READY, RESERVED_AT, RUN, STATUS_NAMES
from rcx_harness.watch.wire import word
from structured_text.output.units import format_word

__all__ = ["AnswerMonitor"]

_RESPONSE = slice(2, DEDICATED_AT)
_RESERVED = slice(RESERVED_AT, RESERVED_AT + 2)
_CPU_OK = 0x02


class AnswerMonitor:
    """A monitor of a controller's answers, with three rules.

    `status`: The status is unknown, appears without a command, or disappears without a status reset
    (guide 1.2, 2 and 4.1). `response`: The response changes after the end status (guide 2).
    `reserved`: A reserved bit is set (chapter 5, 1).
    """

    def __init__(self) -> None:
        places = {(one.byte, one.bit) for one in signals().output}
        dedicated = (DEDICATED_AT, DEDICATED_AT + 1)
        self._known = {
            at: sum(1 << bit for bit in range(8) if (at, bit) in places) for at in dedicated
        }
        self._so = b""
        self._code = 0
        self._asked = self._changed = False

    def forget(self) -> None:
        """Forget the last areas after missing packets or a change of the connection."""
        self._so = b""

    def take(self, t_us: int, who: str, so: bytes, si: bytes) -> list[Violation]:
        """Judge the current areas.

        `who` begins the text of a finding: `robot, packet 12`. `si` is the area last sent to the
        controller; empty if no PLC sends one.
        """
        before, self._so = self._so, so
        code = word(si, 0) if si else 0
        if code != self._code:
            self._asked, self._changed = self._asked or code != 0, self._changed or self._code != 0
            self._code = code
        if len(before) != len(so):  # this is the first area, so earlier commands are unknown
            self._changed = word(so, 0) != READY
            self._asked = self._changed or code != 0
            return []
        found = []
        if so[RESERVED_AT:] != before[RESERVED_AT:] and any(so[_RESERVED]):
            found.append(
                ("reserved", f"the reserved bytes m+46, m+47 are {so[_RESERVED].hex(' ')}")
            )
        for at, known in self._known.items():
            if stray := so[at] & ~before[at] & ~known:
                found.append(("reserved", f"reserved bits of m+{at} are set: 2#{stray:08b}"))
        if so[:DEDICATED_AT] != before[:DEDICATED_AT]:
            found += self._answer(before, so)
        return [Violation(t_us, rule, f"{who}: {rule}: {text}") for rule, text in found]

    def _answer(self, before: bytes, so: bytes) -> list[tuple[str, str]]:
        was, status = word(before, 0), word(so, 0)
        found = []
        if status == was:
            if status in ENDS and so[_RESPONSE] != before[_RESPONSE]:
                found.append(("response", f"words changed after the status {format_word(status)}"))
            return found
        shown = f"the status went from {format_word(was)} to {format_word(status)}"
        if status not in STATUS_NAMES:
            found.append(("status", f"{shown}, which has no meaning"))
        elif was in ENDS and status != READY:
            found.append(("status", f"{shown}; after an end only 16#0000 may follow"))
        elif was in ENDS and self._code and not self._changed and so[DEDICATED_AT] & _CPU_OK:
            text = f"{shown}, although the code {format_word(self._code)} is still set"
            found.append(("status", f"{text}; only a status reset clears it"))
        elif was == READY and not self._asked:
            found.append(("status", f"{shown} without a remote command"))
        elif was == RUN and status == READY and not self._changed and so[DEDICATED_AT] & _CPU_OK:
            found.append(("status", f"{shown} without an end, and no code was changed"))
        if status == READY:
            self._asked, self._changed = self._code != 0, False
        return found
