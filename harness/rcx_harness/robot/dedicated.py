"""The recognition of the dedicated inputs: edges, levels and the minimum interval.

Two changes must be at least 100 ms apart (`min_interval`). `_actual` has the inputs of the last
exchange, and `_taken` has the recognised levels.
"""

from __future__ import annotations

from rcx_harness.robot.area import DEDICATED, INPUTS, RESERVED, dedicated_word, reserved_bytes_of
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.findings import Findings
from rcx_harness.spec import Signal, signals
from structured_text.output.units import format_us

__all__ = ["DedicatedInputs"]

_STOPS = INPUTS["SI00"] | INPUTS["SI06"]
_BY_MASK: dict[int, Signal] = {INPUTS[signal.short]: signal for signal in signals().input}


class DedicatedInputs:
    """The dedicated inputs (bytes n+32 and n+33): recognised levels and violations of the rules."""

    def __init__(self, config: RobotConfig, findings: Findings) -> None:
        self._interval_us = round(config.min_interval * 1000)
        self._late_levels = config.late_levels
        self._recovery_edges = config.recovery_edges
        self._findings = findings
        self._actual: int  # The first image sets `_actual` and `_taken`.
        self._taken: int
        self._reserved: tuple[int, bytes] = (0, bytes(len(signals().reserved_bytes)))
        self._changed_us: int | None = None
        self._last_change = ""
        self._connected = False

    def disconnect(self) -> None:
        """Process the loss of the connection. The inputs are unknown until the next image."""
        self._connected = False

    def take(self, now_us: int, area: bytes) -> set[str]:
        """Process the inputs of one exchange.

        Returns:
            Short names (`SI01`) of the inputs with a recognised OFF to ON edge.
        """
        self._check_reserved(now_us, area)
        now = dedicated_word(area) & DEDICATED
        if not self._connected:
            return self._connect(now)
        changed = now ^ self._actual
        rising = 0
        if changed:
            rising = self._change(now_us, changed, now)
        elif self._unsettled and self._settled_at() <= now_us:
            self._taken = now
        return _named(rising) if rising else set()

    def is_on(self, short: str) -> bool:
        """Return the recognised level of an input."""
        return bool(self._taken & INPUTS[short])

    def next_due_us(self) -> int | None:
        """Return when an unrecognised level will be recognised [us]; None if there is none."""
        return self._settled_at() if self._connected and self._unsettled else None

    @property
    def _unsettled(self) -> bool:
        return self._late_levels and self._taken != self._actual

    def _settled_at(self) -> int:
        return (self._changed_us or 0) + self._interval_us

    def _connect(self, now: int) -> set[str]:
        """Process the first image of a connection, which is not a change by the master."""
        self._connected = True
        self._actual = self._taken = now
        self._changed_us = None
        return _named(now) if self._recovery_edges else set()

    def _change(self, now_us: int, changed: int, now: int) -> int:
        """Process a change of the inputs; return the mask of recognised OFF to ON edges."""
        before = self._actual
        self._actual = now
        # SI(00) and SI(06) turning OFF are always recognised at once. One other change in the same
        # exchange is not recognised, but it is not a violation either: the master may have made
        # that change earlier within the same packet interval.
        stops = changed & before & _STOPS
        others = changed & ~stops
        self._taken &= ~stops
        rising = 0
        if others:
            reason = self._refusal(now_us, others)
            if reason:
                self._findings.add(now_us, "interval", f"{_describe(others, now)} {reason}")
            elif not stops or not self._interval_us:
                rising = others & now & ~self._taken
                self._taken = self._taken & ~others | now & others
        self._changed_us = now_us
        self._last_change = _describe(changed, now)
        return rising

    def _refusal(self, now_us: int, others: int) -> str:
        """Describe the rule that a change of the bits `others` breaks; empty if it breaks no rule.

        A change that breaks a rule is not recognised.
        """
        least = f"at least {format_us(self._interval_us)} are needed; not recognised"
        if self._interval_us and others.bit_count() > 1:
            return f"in the same exchange, {least}"
        if self._changed_us is not None and now_us - self._changed_us < self._interval_us:
            passed = format_us(now_us - self._changed_us)
            return f"{passed} after {self._last_change}, {least}"
        return ""

    def _check_reserved(self, now_us: int, area: bytes) -> None:
        reserved = (dedicated_word(area) & RESERVED, reserved_bytes_of(area))
        if reserved == self._reserved:
            return
        self._reserved = reserved
        bits, others = reserved
        if bits or any(others):
            where = [f"n+{32 + bit // 8} bit {bit % 8}" for bit in range(16) if bits >> bit & 1]
            pairs = zip(signals().reserved_bytes, others, strict=True)
            where += [f"n+{at} = 16#{value:02X}" for at, value in pairs if value]
            text = f"the master writes to the reserved area: {', '.join(where)}"
            self._findings.add(now_us, "reserved", text)


def _named(bits: int) -> set[str]:
    """Return the short names of the inputs whose bits are set."""
    return {signal.short for mask, signal in _BY_MASK.items() if bits & mask}


def _describe(mask: int, now: int) -> str:
    """Describe the changes of the inputs, for example `SI(01) Servo ON input ON`."""
    return " and ".join(
        f"{signal.signal} {signal.title} {'ON' if now & bit else 'OFF'}"
        for bit, signal in _BY_MASK.items()
        if mask & bit
    )
