"""The asker: writes inputs and telegrams as a careful PLC does, and measures the answers."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from rcx_harness.look.probe.line import LostError, NetworkLine
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.area import input_words
from rcx_harness.spec import FieldValue, command, commands, signals
from rcx_harness.spec.wire import ABNORMAL_END, CYCLE_US, ENDS, NORMAL_END, READY, RUN
from rcx_harness.trace import Scan, Trace
from structured_text.output.units import format_word

__all__ = ["Answer", "Asker", "Finding", "History", "NoAnswerError", "SkipError", "telegram"]

#: Time between two changes of dedicated inputs: 100 ms (manual) plus a reserve for the packets.
_INTERVAL_US = 130_000
_PATIENCE_US = 3_000_000
_SETTLED_US = 300_000
#: Written data are sent with the second packet at the latest; the first may already be prepared.
_PACKETS = 2
_DEFAULTS = RobotConfig()
_BITS = {one.short: (one.byte, 1 << one.bit) for one in (*signals().input, *signals().output)}
_MOST_MESSAGES = 500
#: Number of messages that are compared at each end of the alarm history.
_END = 6


class SkipError(Exception):
    """The error if a question cannot be asked, or if its answer decides nothing.

    The text of the error is the reason.
    """


@dataclass(frozen=True)
class Finding:
    """The conclusion from an answer about one rule and its key.

    Attributes:
        rule: The name of the rule.
        knob: The key of the rule; empty if the rule has none.
        values: Values that the controller may have; with `between`, (lowest, highest).
        expected: The assumed value.
        text: The evidence, in words.
        between: True if `values` are limits: the value is above the first and at most the second.
    """

    rule: str
    knob: str
    values: tuple[Any, ...]
    expected: Any
    text: str
    between: bool = False

    @property
    def verdict(self) -> str:
        """Return `confirmed`, `refuted`, or `open` if several values are possible."""
        if self.between:
            low, high = self.values
            return "confirmed" if low < self.expected <= high else "refuted"
        if self.expected not in self.values:
            return "refuted"
        return "confirmed" if len(self.values) == 1 else "open"


@dataclass(frozen=True)
class Answer:
    """The end of a remote command.

    Attributes:
        words: The words m to m+30.
        fields: Values of the answer by field name, after a normal end.
        alarm: Alarm of an abnormal end, such as `"12.600"`. Empty after a normal end.
        ran: Whether 0x0100 was seen.
        accepted_us: Time from the code to the first status, without transmission times.
        ended_us: Time from the first status to the end status.
        reset_us: Time from the status reset to the ready status, without transmission times.
    """

    status: int
    words: tuple[int, ...]
    fields: Mapping[str, Any]
    alarm: str
    ran: bool
    accepted_us: int
    ended_us: int
    reset_us: int


@dataclass(frozen=True)
class History:
    """The alarm history: the number of messages, the first messages and the last messages."""

    count: int
    head: tuple[str, ...]
    tail: tuple[str, ...]

    def new_since(self, before: History) -> set[str]:
        """Return the alarms that are new since the history `before`.

        New alarms may be at the beginning or at the end of the history.
        """
        grown = min(self.count - before.count, _END)
        if self.head[: len(before.head)] == before.head and grown > 0:
            return set(self.tail[-grown:])
        if grown > 0:
            return set(self.head[:grown])
        return (set(self.head) - set(before.head)) | (set(self.tail) - set(before.tail))

    def newest_first(self, before: History, latest: str) -> bool | None:
        """Return whether new alarms are before older alarms.

        Return None if the order cannot be seen. `before` is the history before new alarms were
        raised, and `latest` is the last new alarm.
        """
        ends = (self.head[:1] == (latest,), self.tail[-1:] == (latest,))
        if ends[0] != ends[1]:
            return ends[0]
        if not before.count or self.count <= before.count:
            return None
        return self.head[: len(before.head)] != before.head


class NoAnswerError(SkipError):
    """The error if a remote command does not begin or end, or if its status is not reset."""


class Asker:
    """A connection to a controller, with the findings of all questions.

    Args:
        person: Function that asks the person at the cell to act. It returns False if the person
            declines.
        trace: Records every change of an area, as evidence.
    """

    def __init__(
        self,
        line: NetworkLine,
        person: Callable[[str, str], bool],
        trace: Trace | None = None,
        patience_us: int = _PATIENCE_US,
    ) -> None:
        self.line = line
        self.findings: list[Finding] = []
        self._person, self._trace, self._patience_us = person, trace, patience_us
        self._si, self._so = bytearray(line.size), bytes(line.size)
        self._seen: tuple[bytes, bytes] = (b"", b"")
        self._run = True
        self._looks = 0
        self._changed_us = -_INTERVAL_US
        self._decides: Mapping[str, tuple[str, ...]] = {}

    # --- reports of findings ---

    def begin(self, decides: Mapping[str, tuple[str, ...]]) -> None:
        """Assign all later findings to these rules and their keys."""
        self._decides = decides

    def knob(self, name: str, *values: Any, text: str) -> None:
        """Report that the key of the current rule has one of these values in the controller."""
        self._found(name, values, text, between=False)

    def between(self, name: str, low: float, high: float, text: str) -> None:
        """Report that the value of the key is more than `low` and at most `high`."""
        self._found(name, (low, high), text, between=True)

    def delay(self, name: str, us: int, text: str) -> None:
        """Report a measured delay.

        The real delay may be shorter by the tolerance of the connection.
        """
        low = max(0.0, (us - self.line.tolerance_us) / 1000)
        self._found(name, (low - 0.001, us / 1000 + self.line.step_us / 1000), text, between=True)

    def rule(self, name: str, holds: bool, text: str) -> None:
        """Report whether a rule that has no key holds."""
        self.findings.append(Finding(name, "", (holds,), True, text))

    def _found(self, name: str, values: tuple[Any, ...], text: str, *, between: bool) -> None:
        for rule, knobs in self._decides.items():
            if name in knobs:
                expected = getattr(_DEFAULTS, name)
                self.findings.append(Finding(rule, name, values, expected, text, between))

    # --- dedicated inputs, dedicated outputs and words ---

    def on(self, name: str) -> bool:
        """Return the state of a dedicated output in the area that was received last."""
        at, mask = _BITS[name]
        return bool(self._so[at] & mask)

    def is_set(self, name: str) -> bool:
        """Return the state of a dedicated input in the area that is sent."""
        at, mask = _BITS[name]
        return bool(self._si[at] & mask)

    @property
    def words(self) -> tuple[int, ...]:
        """Return the words m to m+30 of the area from the controller."""
        return input_words(self._so)

    @property
    def status(self) -> int:
        """Return the remote status in the area that was received last."""
        return self.words[0]

    def byte(self, at: int) -> int:
        """Return byte m+`at` of the area from the controller."""
        return self._so[at]

    def turn(self, name: str, on: bool, *, after_us: int = _INTERVAL_US) -> None:
        """Change a dedicated input, not earlier than `after_us` after the last change."""
        at, mask = _BITS[name]
        if bool(self._si[at] & mask) == on:
            return
        self.wait(max(0, self._changed_us + after_us - self.line.now_us))
        self._si[at] ^= mask
        self._changed_us = self.line.now_us
        self._write()

    def pulse(self, name: str) -> None:
        """Turn an input ON and OFF again, and wait for its effect."""
        self.turn(name, True)
        self.wait(_INTERVAL_US)
        self.turn(name, False)
        self.wait(_INTERVAL_US)

    def send(self, words: tuple[int, ...]) -> None:
        """Send the words n to n+30 in one packet."""
        for k, word in enumerate(words):
            self._si[2 * k : 2 * k + 2] = word.to_bytes(2, "little")
        self._write()

    def idle(self, on: bool) -> None:
        """Send the idle header, as a PLC in STOP does."""
        self._run = not on
        self._write()

    def wait(self, us: int) -> None:
        """Wait for a time, and record all changes of the areas."""
        end_us = self.line.now_us + us
        while self.line.now_us < end_us:
            self.line.wait(min(self.line.step_us, end_us - self.line.now_us))
            self._look()

    def until(self, seen: Callable[[], bool], within_us: int = _PATIENCE_US) -> int | None:
        """Wait for a condition; return the elapsed time [us], or None if it did not come true."""
        begin_us = self.line.now_us
        while not seen():
            if self.line.now_us - begin_us >= within_us:
                return None
            self.line.wait(self.line.step_us)
            self._look()
        return max(0, self.line.now_us - begin_us - self.line.step_us)

    def person(self, text: str, event: str = "") -> None:
        """Ask the person to do something at the cell.

        `text` is the request to the person. In a rehearsal with a virtual controller, `event`
        replaces the action.

        Raises:
            SkipError: the person declines.
        """
        self.needs_person(text, event)
        self.wait(_SETTLED_US)

    def needs_person(self, text: str, event: str) -> None:
        """Ask the person to act while there is no connection.

        If the person declines, raise SkipError.
        """
        if not self._person(text, event):
            raise SkipError(f"not done: {text}")

    # --- opening and closing of the connection ---

    def open(self, *on: str, code: int = 0) -> None:
        """Connect, with these inputs and this code in the first packet."""
        self._si[:] = bytes(len(self._si))
        for name in on:
            at, mask = _BITS[name]
            self._si[at] |= mask
        self._si[:2] = code.to_bytes(2, "little")
        self._run = True
        self._changed_us = self.line.now_us
        self.line.open(bytes(self._si))
        self.wait(_SETTLED_US)

    def open_within(self, us: int) -> None:
        """Connect as soon as the controller answers, within a time limit."""
        end_us = self.line.now_us + us
        while True:
            try:
                self.open()
            except LostError:
                if self.line.now_us > end_us:
                    raise
                self.line.wait(_SETTLED_US)
            else:
                return

    def drop(self, us: int) -> None:
        """Send no packets until the controller has detected the loss of its master."""
        self.line.drop()
        self.line.wait(us)

    def rest(self) -> None:
        """Switch all inputs OFF and end the command, before and after each question."""
        if self._si[0] or self._si[1]:
            self.send((0,) * 16)
        self._run = True
        for name in ("SI06", "SI00"):
            self.turn(name, False)
        for name in sorted(_BITS):
            if name.startswith("SI"):
                self.turn(name, False)
        if any(self._si):
            self._si[:] = bytes(len(self._si))
            self._write()
        self.until(lambda: self.status == READY)
        self.wait(_INTERVAL_US)

    # --- remote commands ---

    def command(self, name: str, robot: int = 0, **fields: FieldValue) -> Answer:
        """Execute a remote command by its name; see `telegram`."""
        return self.telegram(telegram(name, robot, **fields))

    def telegram(self, words: tuple[int, ...]) -> Answer:
        """Execute a remote command, given as 16 words, until the controller is ready again.

        The data reach the controller before the code is sent (guide 2, steps 1 and 2).

        Raises:
            NoAnswerError: the controller is not ready before the command, shows no end status, or
                is not ready after the reset. The code is set to 0 even if there is no end status.
        """
        self._until_ready("without a command")
        self.send((0, *words[1:]))
        self._deliver()
        self.send(words)
        accepted_us = self.until(lambda: self.status != READY, self._patience_us)
        begin_us, ran = self.line.now_us, self.status == RUN
        if accepted_us is None or self.until(self._has_ended, self._patience_us) is None:
            text = f"no end within {self._patience}, the status was {format_word(self.status)}"
            self.send((0,) * 16)
            raise NoAnswerError(text)
        ended_us = self.line.now_us - begin_us
        status, shown = self.status, self.words
        fields: Mapping[str, Any] = {}
        entry = commands().get(words[0] & 0x0FFF)
        if entry is not None and status == NORMAL_END:
            fields = entry.read_response(shown)
        alarm = f"{shown[1]}.{shown[2]}" if status == ABNORMAL_END else ""
        self.send((0,) * 16)
        reset_us = self._until_ready("after the status reset")
        self.wait(2 * self.line.step_us)
        return Answer(status, shown, fields, alarm, ran, accepted_us, ended_us, reset_us)

    @property
    def _patience(self) -> str:
        return f"{self._patience_us / 1e6:g} s"

    def _has_ended(self) -> bool:
        return self.status in ENDS

    def _until_ready(self, when: str) -> int:
        us = self.until(lambda: self.status == READY, self._patience_us)
        if us is None:
            text = f"the status is {format_word(self.status)} {when}"
            raise NoAnswerError(f"{text}, {self._patience} long")
        return us

    def _deliver(self) -> None:
        """Wait until packets with the written data have been sent."""
        last = self.line.sent + _PACKETS
        if self.until(lambda: self.line.sent >= last) is None:
            raise LostError("no packets are sent any more")
        self.wait(2 * CYCLE_US)

    def needs(self, held: bool, text: str) -> None:
        """Raise SkipError with this reason unless the condition holds."""
        if not held:
            raise SkipError(text)

    def history(self) -> History:
        """Return the alarm history from the message reference."""
        known: dict[int, str] = {}
        low, high = 0, 1
        while high <= _MOST_MESSAGES and self._message(high, known):
            low, high = high, high * 2
        high = min(high, _MOST_MESSAGES + 1)
        while high - low > 1:
            middle = (low + high) // 2
            if self._message(middle, known):
                low = middle
            else:
                high = middle
        head = [self._message(number, known) for number in range(1, min(low, _END) + 1)]
        tail = [self._message(number, known) for number in range(max(1, low + 1 - _END), low + 1)]
        return History(low, tuple(head), tuple(tail))

    def _message(self, number: int, known: dict[int, str]) -> str:
        if number not in known:
            fields = self.command("ReadMessage", message=number).fields
            some = fields.get("alarm_group")
            known[number] = f"{fields['alarm_group']}.{fields['alarm_category']}" if some else ""
        return known[number]

    def _write(self) -> None:
        self.line.write(bytes(self._si), run=self._run)

    def _look(self) -> None:
        self._so = self.line.read()
        seen = (self._so, bytes(self._si))
        if seen != self._seen:
            self._seen = seen
            if self._trace is not None:
                self._trace.add(Scan(self.line.now_us, self._looks, *seen))
        self._looks += 1


def telegram(name: str, robot: int = 0, **fields: FieldValue) -> tuple[int, ...]:
    """Return the 16 words of a request.

    They are not checked, because some questions send wrong words on purpose.
    """
    entry = command(name)
    words = [0] * 16
    for part in entry.request:
        if part.name in fields or part.fixed is not None:
            part.write(words, fields.get(part.name, part.fixed or 0))
    return (entry.code | robot << 12, *words[1:])
