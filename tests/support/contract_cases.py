"""The contract cases of every block: all combinations of Execute patterns, answers and moments."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import TYPE_CHECKING, NamedTuple

from contract_player import FATES, SIGNAL_FATES, Fate

if TYPE_CHECKING:
    from contract_bench import ContractBench


#: Calculates Execute from the scan and the scan in which the block ended (-1: not yet).
Shape = Callable[[int, int], bool]


class Pattern(NamedTuple):
    """The values of Execute or Enable over the scans."""

    name: str
    on: Shape


def _while_busy(shape: Callable[[int], bool]) -> Shape:
    """Return a pattern that follows `shape`, at most until two scans after the block's end."""
    return lambda scan, ended: shape(scan) and (ended < 0 or scan <= ended + 2)


HELD = Pattern("held", _while_busy(lambda scan: True))
ONE_SCAN = Pattern("one scan", _while_busy(lambda scan: scan == 0))
AGAIN = Pattern("raised again while busy", _while_busy(lambda scan: scan != 1))
TOGGLED = Pattern("toggled every scan", lambda scan, ended: scan % 2 == 0 and ended < 0)
AT_THE_END = Pattern(
    "raised in the scan after the end", lambda scan, ended: scan == 0 or 0 <= ended == scan - 1
)
#: Delays of the controller's answers that the cases use [scans].
_DELAYS = (0, 2)
#: In a sequence of this length or more, the patterns alternate [scans].
_LONG = 20
_PATTERNS = (HELD, ONE_SCAN, AGAIN, TOGGLED, AT_THE_END)


def _dropped(at: int) -> Pattern:
    return Pattern(f"dropped at scan {at}", _while_busy(lambda scan: scan < at))


class Event(NamedTuple):
    """An event in the cell that lasts until the block has ended, or for some scans."""

    name: str
    set: Callable[[ContractBench, bool], None]
    lasts: int = 1 << 30


def _link(bench: ContractBench, on: bool) -> None:
    bench.connected = not on


def _cpu(bench: ContractBench, on: bool) -> None:
    bench.player.cpu_ok = not on


def _emergency(bench: ContractBench, on: bool) -> None:
    bench.player.emergency = on


def _auto(bench: ContractBench, on: bool) -> None:
    bench.player.auto = not on


def _alarm(bench: ContractBench, on: bool) -> None:
    bench.player.alarm = bench.player.alarm or on


def _safe(bench: ContractBench, on: bool) -> None:
    bench.safe = (not on, bench.safe[1])


def _stop(bench: ContractBench, on: bool) -> None:
    bench.safe = (bench.safe[0], not on)


def _nothing(bench: ContractBench, on: bool) -> None:
    """Do nothing."""


NONE = Event("nothing", _nothing)
_LOSSES = (
    Event("the link is lost", _link),
    Event("the link is lost for one scan", _link, 1),
    Event("CPU_OK goes OFF", _cpu),
    Event("CPU_OK is OFF for two scans", _cpu, 2),
)
_STOPS = (
    Event("an emergency stop", _emergency),
    Event("an emergency stop for two scans", _emergency, 2),
    Event("an alarm", _alarm, 1),
    Event("AUTO mode is left", _auto),
    Event("EmergencyStopOk is FALSE", _safe),
    Event("EmergencyStopOk is FALSE for one scan", _safe, 1),
    Event("StopOk is FALSE", _stop),
    Event("StopOk is FALSE for one scan", _stop, 1),
)


class Case(NamedTuple):
    """One run of one block.

    Attributes:
        pattern: The values of Execute over the scans.
        fate: The controller's answers to a remote command over the scans.
        signal: The dedicated output that answers the block; empty if a command does.
        shown: How the controller shows this output, one of SIGNAL_FATES.
        delay: Delay of the controller's answers [scans].
        event: An additional event in the cell.
        at: Scan of the event, counted from the rising edge of Execute.
    """

    pattern: Pattern
    fate: Fate = FATES[0]
    signal: str = ""
    shown: str = "normal"
    delay: int = 0
    event: Event = NONE
    at: int = 0

    def __str__(self) -> str:
        answer = f"{self.signal} {self.shown}" if self.signal else self.fate.name
        event = "" if self.event is NONE else f", {self.event.name} at scan {self.at}"
        return f"{self.pattern.name}, answer {answer} after {self.delay} scans{event}"


def command_cases() -> list[Case]:
    """Return the cases of a block with one remote command."""
    return [*_answers(_PATTERNS), *_drops(range(2, 9)), *_events(_LOSSES, range(9), 1)]


def composite_cases(length: int) -> list[Case]:
    """Return the cases of a block that sends several commands in `length` scans."""
    events = _events((*_LOSSES, *_STOPS), range(length + 2), 1)
    return [*_answers(_PATTERNS), *_drops(range(2, length)), *events]


def sequence_cases(signals: Sequence[str], length: int) -> list[Case]:
    """Return the cases of a sequence of `length` scans with these answering outputs."""
    events = _events((*_LOSSES, *_STOPS), range(length + 2), 0)
    return [*_shown(_PATTERNS, signals), *_drops(range(2, length)), *events]


def level_cases(signal: str) -> list[Case]:
    """Return the cases of a level block.

    `signal` is the output that answers the block, or `Status` for a command.
    """
    patterns = [HELD, ONE_SCAN, TOGGLED, *map(_dropped, range(2, 12))]
    events = [
        Case(pattern, event=event, at=at)
        for event in (*_LOSSES, *_STOPS)
        for at in range(10)
        for pattern in (HELD, TOGGLED, _dropped(at), _dropped(at + 2))
    ]
    answers = _answers(patterns) if signal == "Status" else _shown(patterns, [signal])
    return [*answers, *events]


def one_of_each_kind(cases: Sequence[Case]) -> list[Case]:
    """Return one case for each answer and each event, taken from the middle of its cases."""
    kinds: dict[object, list[Case]] = {}
    for case in cases:
        kind = (case.fate.name, case.signal, case.shown, case.event.name)
        kinds.setdefault(kind, []).append(case)
    return [like[len(like) // 2] for like in kinds.values()]


def _answers(patterns: Sequence[Pattern]) -> Iterator[Case]:
    for fate in FATES:
        for delay in _DELAYS:
            yield from (Case(pattern, fate, delay=delay) for pattern in patterns)


def _shown(patterns: Sequence[Pattern], signals: Sequence[str]) -> Iterator[Case]:
    for signal, shown in product(signals, SIGNAL_FATES):
        for delay in _DELAYS:
            for pattern in patterns:
                yield Case(pattern, signal=signal, shown=shown, delay=delay)


def _drops(moments: range) -> Iterator[Case]:
    yield from (Case(_dropped(at), delay=1) for at in moments)


def _events(events: Sequence[Event], moments: range, delay: int) -> Iterator[Case]:
    patterns = (HELD, ONE_SCAN, TOGGLED)
    for event in events:
        for at in moments:
            taken = [patterns[at % 3]] if len(moments) > _LONG else patterns
            yield from (Case(pattern, delay=delay, event=event, at=at) for pattern in taken)
