"""One controller in a recording: signals and commands in words, response times, broken rules."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import replace

from rcx_harness.look.judge.network import Sample
from rcx_harness.robot import Violation
from rcx_harness.spec import commands, signals
from rcx_harness.spec.plain import request_text, response_text
from rcx_harness.spec.wire import DEDICATED_AT, ENDS, READY, RUN
from rcx_harness.watch.answers import AnswerMonitor
from rcx_harness.watch.wire import INTERVAL_US, WireMonitor, word
from structured_text.output.units import format_us, format_word

__all__ = ["ANSWERS", "Follower", "Times", "ordered"]

_DEDICATED = slice(DEDICATED_AT, DEDICATED_AT + 2)
_DATA = slice(2, DEDICATED_AT)
_WORDS = 16
#: Dedicated inputs and the outputs that answer them, with their levels (manual chapter 5, 2 and 3).
ANSWERS = (
    ("SI00", 0, "SO00", 1),
    ("SI00", 0, "SO02", 0),
    ("SI00", 1, "SO00", 0),
    ("SI01", 1, "SO02", 1),
    ("SI06", 0, "SO13", 0),
    ("SI10", 1, "SO12", 1),
    ("SI10", 0, "SO12", 0),
    ("SI12", 1, "SO13", 1),
    ("SI14", 1, "SO11", 1),
    ("SI15", 1, "SO14", 1),
    ("SI16", 1, "SO03", 0),
    ("SI17", 1, "SO11", 1),
)
#: Number of times that are stored exactly. Further times are only counted in classes, so that the
#: memory stays small. The upper limit of a class is the previous limit multiplied by this factor.
_EXACT, _STEP = 1_000, math.log(1.01)
_PLACES = {
    one.short: (one.byte, one.bit) for table in (signals().input, signals().output) for one in table
}
_INPUTS = [(one.byte, one.bit, one.signal, one.title) for one in signals().input]
_OUTPUTS = [(one.byte, one.bit, one.signal, one.title) for one in signals().output]


class Times:
    """The response times of one kind of answer, in microseconds.

    Attributes:
        open: Number of requests without an answer.
    """

    def __init__(self) -> None:
        self.count = self.longest_us = self.open = 0
        self._exact: list[int] = []
        self._steps: Counter[int] = Counter()

    def add(self, time_us: int) -> None:
        """Add a response time [us]."""
        self.count += 1
        self.longest_us = max(self.longest_us, time_us)
        if self.count <= _EXACT:
            self._exact.append(time_us)
        self._steps[math.floor(math.log(max(time_us, 1)) / _STEP)] += 1

    @property
    def exact(self) -> bool:
        """Return whether the percentiles are exact.

        With more than 1,000 measured times, the error of a percentile is up to 0.5 %.
        """
        return self.count <= _EXACT

    def percentile_us(self, share: float) -> int:
        """Return the percentile `share` (0 to 1) of the times [us]; 0 without times."""
        left = math.ceil(share * self.count)
        if self.exact and self.count:
            return sorted(self._exact)[left - 1]
        for step in sorted(self._steps):
            left -= self._steps[step]
            if left <= 0:
                return min(round(math.exp((step + 0.5) * _STEP)), self.longest_us)
        return 0


class Follower:
    """The analysis of the samples of one controller.

    Args:
        tell: Function that is called with the time and a line for each event.
        report: Function that is called with each broken rule.
        at: Name of a sample in texts: packet, scan or cycle.
        tolerance_us: Tolerance of the rule that two changes are 100 ms apart.

    Attributes:
        times: Response times by the name of the answer.
        commands: Number of remote commands that were sent.
        gaps: How often an area changed while packets were missing. No rule is judged across such a
            gap.
        together: How often new data arrived in the same packet as their code. The program may have
            set both in different scans without a packet in between, so the order is unknown.
    """

    def __init__(
        self,
        size: int,
        tell: Callable[[int, str], None],
        report: Callable[[Violation], None],
        at: str,
        tolerance_us: int = 0,
    ) -> None:
        self.times: dict[str, Times] = {}
        self.commands = self.gaps = self.together = 0
        self._tell, self._report, self._at = tell, report, at
        self._wire = WireMonitor(size, INTERVAL_US - tolerance_us)
        self._answers = AnswerMonitor()
        self._si = self._so = b""
        self._fresh = True
        self._asked: dict[int, int] = {}
        self._code = self._status = 0
        self._name = ""
        self._request: tuple[int, ...] = ()
        self._code_us: int | None = None
        self._run_us: int | None = None
        self._reset_us: int | None = None

    def take(self, sample: Sample) -> None:
        """Analyse the next sample of the controller."""
        if not sample.whole:
            self.gaps += 1
        if not sample.connected or not sample.whole or not sample.so:
            self._forget()
        self._judge(sample)
        if sample.so and sample.so != self._so:
            self._dedicated(sample.t_us, self._so, sample.so, _OUTPUTS)
        if sample.si and sample.si != self._si:
            self._dedicated(sample.t_us, self._si, sample.si, _INPUTS)
        self._time_dedicated(sample)
        if sample.si:
            self._follow_code(sample)
        if sample.so:
            self._follow_status(sample)
        self._si, self._so = sample.si or self._si, sample.so or self._so

    def finish(self) -> None:
        """End the recording: count requests without an answer as open."""
        for number in list(self._asked):
            self._of(_answer_name(number)).open += 1
        self._asked.clear()

    def _of(self, what: str) -> Times:
        return self.times.setdefault(what, Times())

    def _forget(self) -> None:
        """Discard all pending measurements, because the recording has a gap."""
        self._fresh = True
        self._asked.clear()
        self._code_us = self._run_us = self._reset_us = None
        self._answers.forget()

    def _judge(self, sample: Sample) -> None:
        who, at = f"{self._at} {sample.number}", (sample.t_us, sample.number)
        if sample.si and sample.so and sample.connected:
            read = self._so if sample.at_once and self._so else sample.so
            # after a gap in the recording, the first area is not judged as a change
            scans = [(False, sample.si)] if self._fresh else []
            if not self._fresh and _with_data(self._si, sample.si):
                self.together += 1
                scans.append((True, bytes(2) + sample.si[2:]))
            self._fresh = False
            for connected, si in [*scans, (True, sample.si)]:
                for one in self._wire.scan(*at, read, si, connected):
                    text = one.text.replace(f"plc, scan {sample.number}", f"plc, {who}", 1)
                    self._report(replace(one, text=text))
        if sample.so:
            for one in self._answers.take(sample.t_us, f"robot, {who}", sample.so, sample.si):
                self._report(one)

    def _dedicated(
        self, t_us: int, before: bytes, after: bytes, table: list[tuple[int, int, str, str]]
    ) -> None:
        if before[_DEDICATED] == after[_DEDICATED]:
            return
        for byte, bit, signal, title in table:
            now = after[byte] >> bit & 1
            if now != (before[byte] >> bit & 1 if before else 0):
                self._tell(t_us, f"{signal} {'ON ' if now else 'OFF'}  {title}")

    def _time_dedicated(self, sample: Sample) -> None:
        """Start and stop the measurements of answers to dedicated inputs."""
        if sample.so and sample.so[_DEDICATED] != self._so[_DEDICATED]:
            for number in list(self._asked):
                _, _, answer, target = ANSWERS[number]
                if _level(sample.so, answer) == target:
                    passed_us = sample.t_us - self._asked.pop(number)
                    self._of(_answer_name(number)).add(passed_us)
        judged = sample.connected and self._si and sample.si and sample.so
        if not judged or sample.si[_DEDICATED] == self._si[_DEDICATED]:
            return
        for number, (asked, to, answer, target) in enumerate(ANSWERS):
            now = _level(sample.si, asked)
            if now != to or now == _level(self._si, asked) or _level(sample.so, answer) == target:
                continue
            if number in self._asked:
                self._of(_answer_name(number)).open += 1
            self._asked[number] = sample.t_us

    def _follow_code(self, sample: Sample) -> None:
        before, self._code = self._code, word(sample.si, 0)
        if self._code == before:
            return
        if not self._code:
            self._reset_us = sample.t_us
            return
        words = tuple(word(sample.si, 2 * k) for k in range(_WORDS))
        self._request = words
        command = commands().get(self._code & 0x0FFF)
        self._name = command.name if command else format_word(self._code)
        self.commands += 1
        self._tell(sample.t_us, request_text(words))
        self._code_us, self._run_us, self._reset_us = sample.t_us, None, None

    def _follow_status(self, sample: Sample) -> None:
        before, self._status = self._status, word(sample.so, 0)
        status, t_us = self._status, sample.t_us
        if status == before:
            return
        passed = ""
        if status == READY:
            if self._reset_us is not None:
                passed = f", {format_us(t_us - self._reset_us)} after the reset"
                self._time("reset", t_us - self._reset_us)
            self._reset_us = self._code_us = self._run_us = None
            self._tell(t_us, f"  ready{passed}")
            return
        if before == READY and self._code_us is not None:
            passed = f", {format_us(t_us - self._code_us)} after the code"
            self._time("accepted", t_us - self._code_us)
        if status == RUN:
            self._run_us = t_us
        elif status in ENDS and self._code_us is not None:
            if self._run_us is not None:
                passed = f", {format_us(t_us - self._run_us)} later"
                self._time("ran", t_us - self._run_us)
            self._time("from code to end", t_us - self._code_us)
            self._code_us = None
        words = tuple(word(sample.so, 2 * k) for k in range(_WORDS))
        text, _, fields = response_text(self._request[0] if self._request else 0, words).partition(
            "; "
        )
        self._tell(t_us, f"  {text}{passed}{f'; {fields}' if fields else ''}")

    def _time(self, what: str, time_us: int) -> None:
        self._of(f"all commands: {what}").add(time_us)
        self._of(f"{self._name}: {what}").add(time_us)


def ordered(times: dict[str, Times]) -> Iterator[tuple[str, Times]]:
    """Yield the times of dedicated answers by signal, of all commands, and of each command."""
    names = [_answer_name(number) for number in range(len(ANSWERS))]
    rank = {name: number for number, name in enumerate(names)}
    every = len(rank)

    def key(name: str) -> tuple[int, str]:
        return rank.get(name, every + (not name.startswith("all "))), name.partition(":")[0]

    for name in sorted(times, key=key):
        yield name, times[name]


def _with_data(before: bytes, si: bytes) -> bool:
    """Return whether the packet with a new command code also had new data."""
    return not word(before, 0) and bool(word(si, 0)) and si[_DATA] != before[_DATA]


def _answer_name(number: int) -> str:
    asked, to, answer, target = ANSWERS[number]
    return f"{_shown(asked, to)}: {_shown(answer, target)}"


def _shown(short: str, level: int) -> str:
    return f"{short[:2]}({short[2:]}) {'ON' if level else 'OFF'}"


def _level(area: bytes, short: str) -> int:
    byte, bit = _PLACES[short]
    return area[byte] >> bit & 1
