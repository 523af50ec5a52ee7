"""The rules for the data that a program sends, checked on the PLC's side, scan by scan.

The controller reports faults in the data that it receives. This monitor reports faults in the data
that the program writes, even if the network happens to hide them. It judges only while the PLC's
scanner is connected, because other writes reach no controller.
"""

from __future__ import annotations

from rcx_harness.robot import Violation
from rcx_harness.spec import signals
from rcx_harness.spec.wire import DEDICATED_AT, ENDS, RESERVED_AT, RUN, SIZE
from structured_text.output.units import format_us, format_word

__all__ = ["INTERVAL_US", "WireMonitor", "word"]

#: Shortest time between two changes of dedicated inputs, of the same or of different inputs
#: (chapter 5, 3, caution).
INTERVAL_US = 100_000


_SAFETY = ("SI(00)", "SI(06)")
#: For each input that starts something, the inputs that must be ON. With SI(00) OFF nothing moves,
#: and SI(06) OFF stops programs and movements (manual chapter 5, 2 and 3.2; chapter 4, 4: 12.400).
_STARTS = {
    "SI(01)": ("SI(00)",),
    "SI(12)": ("SI(00)", "SI(06)"),
    "SI(14)": ("SI(00)", "SI(06)"),
    "SI(17)": ("SI(00)", "SI(06)"),
}
_CODE, _NONE = slice(0, 2), bytes(2)
_DEDICATED = slice(DEDICATED_AT, DEDICATED_AT + 2)
_DATA = slice(2, DEDICATED_AT)
_RESERVED = slice(RESERVED_AT, RESERVED_AT + 2)
_CPU_OK = 0x02


def word(area: bytes, offset: int) -> int:
    """Return the word at `offset`; areas are little endian (guide chapter 1, 1.1)."""
    return area[offset] | area[offset + 1] << 8


class WireMonitor:
    """A monitor that checks the areas that a program writes against the areas that it has read.

    A command is a handshake over several scans. The data must be set one scan before the code. The
    code may be set only while the program reads status 16#0000. Code and data must then stay
    unchanged until the program reads an end status. Changes of dedicated inputs must be 100 ms
    apart, except that SI(00) and SI(06) may go OFF at any time.

    Args:
        size: Bytes of the area; before the first scan all are zero.
        interval_us: Minimum time between two changes of dedicated inputs.

    Rules: `interval`, `start against stop`, `reserved`, `data before code`, `command held`,
    `ready before code`.
    """

    def __init__(self, size: int = SIZE, interval_us: int = INTERVAL_US) -> None:
        self._interval_us = interval_us
        self.commands = 0
        """Number of remote commands whose end status the PLC has read."""
        self._names = {(one.byte, one.bit): one.signal for one in signals().input}
        self._places = {name: place for place, name in self._names.items()}
        self._si = bytes(size)
        self._connected = True
        self._changed_us: int | None = None
        self._changed_what = ""
        self._ended = False
        self._ran = False
        self._judged = False

    def scan(self, t_us: int, scan: int, so: bytes, si: bytes, connected: bool) -> list[Violation]:
        """Judge the areas that the program has written in one scan; return the broken rules."""
        before, self._si = self._si, si
        judged, self._connected = connected and self._connected, connected
        if not judged:
            self._changed_us = None
            self._judged = False
            return []
        if before[_CODE] != _NONE:
            self._follow(word(so, 0))
        if si == before:
            return []
        found: list[tuple[str, str]] = []
        if si[_DEDICATED] != before[_DEDICATED]:
            found += self._dedicated(t_us, before, si)
        if si[_RESERVED] != before[_RESERVED] and any(si[_RESERVED]):
            found.append(
                ("reserved", f"the reserved bytes n+46, n+47 became {si[_RESERVED].hex(' ')}")
            )
        if si[:DEDICATED_AT] != before[:DEDICATED_AT]:
            found += self._command(before, si, so)
        return [Violation(t_us, rule, f"plc, scan {scan}: {rule}: {text}") for rule, text in found]

    def snapshot(self) -> object:
        """Return the complete state."""
        return tuple(vars(self).items())

    def restore(self, snapshot: tuple[tuple[str, object], ...]) -> None:
        """Restore the state from `snapshot`."""
        vars(self).update(snapshot)

    def _dedicated(self, t_us: int, before: bytes, si: bytes) -> list[tuple[str, str]]:
        found = []
        changes: list[str] = []
        paced = 0
        for byte in (DEDICATED_AT, DEDICATED_AT + 1):
            for bit in range(8):
                if not (before[byte] ^ si[byte]) >> bit & 1:
                    continue
                on = si[byte] >> bit & 1
                signal = self._names.get((byte, bit))
                if signal is None:
                    if on:
                        text = f"the reserved bit (n+{byte}) {bit} was set; it must stay OFF"
                        found.append(("reserved", text))
                    continue
                changes.append(f"{signal} {'ON' if on else 'OFF'}")
                if on and (stops := self._off(signal, si)):
                    text = f"{signal} ON while {stops} OFF; wait until no stop is requested"
                    found.append(("start against stop", text))
                paced += on or signal not in _SAFETY
        what = " and ".join(changes)
        gap = None if self._changed_us is None else t_us - self._changed_us
        if paced and len(changes) > 1:
            found.append(("interval", f"{what} in one scan; one change at a time, 100 ms apart"))
        elif paced and gap is not None and gap < self._interval_us:
            text = f"{what} only {format_us(gap)} after {self._changed_what}; at least 100 ms"
            found.append(("interval", text))
        if changes:
            self._changed_us, self._changed_what = t_us, what
        return found

    def _off(self, signal: str, si: bytes) -> str:
        """Return the inputs that an input needs and that are OFF, followed by "is" or "are"."""
        places = ((needed, *self._places[needed]) for needed in _STARTS.get(signal, ()))
        off = [needed for needed, byte, bit in places if not si[byte] >> bit & 1]
        return f"{' and '.join(off)} {'is' if len(off) == 1 else 'are'}" if off else ""

    def _command(self, before: bytes, si: bytes, so: bytes) -> list[tuple[str, str]]:
        """Judge a change of code or data against the status that the program has read."""
        was, code, status = word(before, 0), word(si, 0), word(so, 0)
        same_data = si[_DATA] == before[_DATA]
        found = []
        if was and self._judged and not self._may_change(was, before, so):
            if code != was:
                text = f"the code changed from {format_word(was)} to {format_word(code)}"
            else:
                text = f"{_changed_words(before, si)} changed with the code {format_word(code)} out"
            text += f" while the status read was {format_word(status)}; "
            text += "held until 16#0200 or 16#4000 is read"
            found.append(("command held", text))
        if code and code != was:
            if was == 0 and not same_data:
                text = f"{_changed_words(before, si)} changed together with the code "
                text += f"{format_word(code)}; data must be there one scan before"
                found.append(("data before code", text))
            if status and not found:
                text = f"the code {format_word(code)} went out while the status read was "
                text += f"{format_word(status)}; expected 16#0000"
                found.append(("ready before code", text))
            self._ended = self._ran = False
            self._judged = True
        return found

    def _follow(self, status: int) -> None:
        if self._judged and status in ENDS and not self._ended:
            self._ended = True
            self.commands += 1
        self._ran = self._ran or status == RUN

    def _may_change(self, was: int, before: bytes, so: bytes) -> bool:
        """Return whether code and data may change: after an end or loss, or to stop an output."""
        status = word(so, 0)
        lost = not so[DEDICATED_AT] & _CPU_OK or (self._ran and status == 0)
        continuous = was & 0x0FFF in (0x505, 0x506) and before[2] & 1 and self._ran
        return self._ended or lost or bool(continuous)


def _changed_words(before: bytes, si: bytes) -> str:
    changed = [f"n+{k}" for k in range(2, DEDICATED_AT, 2) if si[k : k + 2] != before[k : k + 2]]
    return ", ".join(changed)
