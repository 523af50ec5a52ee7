"""The values that are tried for each key of a robot file, and values that a difference suggests."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from datetime import datetime, timedelta
from itertools import combinations, pairwise
from typing import Any

from rcx_harness.look.compare.channels import Timeline
from rcx_harness.look.compare.delays import DELAYS, INPUTS
from rcx_harness.robot import RobotConfig
from rcx_harness.robot.config.checks import CHOICES, STORED
from rcx_harness.spec import commands
from rcx_harness.spec.wire import ABNORMAL_END, CYCLE_US, DEDICATED_AT

__all__ = ["DESCRIBED", "KNOBS", "Seen", "has_few_values", "seen_at", "values"]

#: Keys that describe the robot. The user must set them, so the fit does not change them.
DESCRIBED = (*STORED, "robot", "axes", "programs", "work_areas", "real_time_items", "size")
#: An alarm number that no other key uses.
_SOME_ALARM = "98.765"
_KINDS = {entry.name: str(entry.type) for entry in fields(RobotConfig)}
#: The keys that can be fitted: all except delays (which are measured) and descriptions.
KNOBS = tuple(name for name in _KINDS if name not in (*DESCRIBED, *DELAYS))
_NUMBERS: dict[str, tuple[float, ...]] = {
    "auto_speed": (100, 50, 10, 1),
    "program_speed": (100, 50, 10, 1),
    "manual_speed": (100, 50, 20, 10, 1),
    "inching_amount": (100, 10, 1, 10_000),
    "max_payload": (50, 0, 2_000_000),
    "alarm_history_length": (500, 100, 10, 1),
    "program_statements": (100, 10, 1, 1000),
    "tcounter_ms": (1, 10),
    "program_stack": (20, 10, 30, 5),
    "real_time_interval": (5.0, 10.0, 20.0, 50.0, 100.0),
    "host_version": (0x0108, 1),
    "host_revision": (0x0030, 1),
    "fpga_version": (0x1001, 1),
    "driver_version": (0x0101, 1),
    "ivy2_unit": (0, 1),
    "outer_angle": (3.0, 0.0, 10.0, 30.0),
}
_TUPLES: dict[str, tuple[tuple[int, ...], ...]] = {
    "scara_robots": tuple(
        chosen for count in range(5) for chosen in combinations((1, 2, 3, 4), count)
    ),
    "option_slots": ((0x0401, 0x0100, 0, 0), (1, 2, 3, 4)),
}
_LONGEST_INTERVAL_US = 1_000_000


@dataclass(frozen=True)
class Seen:
    """The values that the recording suggests at one point in time.

    Attributes:
        alarms: Numbers of the alarms in the recording.
        numbers: Pairs of numbers: the virtual controller's answer and the recorded answer.
        rows: Pairs like `numbers`, for answers with several numbers.
        clock: Date and time of the recorded answers, as a value of the key `clock`.
    """

    alarms: frozenset[str] = frozenset()
    numbers: frozenset[tuple[int, int]] = frozenset()
    rows: frozenset[tuple[tuple[int, ...], tuple[int, ...]]] = frozenset()
    clock: str = ""


def seen_at(t_us: int, si: bytes, recorded: bytes, virtual: bytes, clock: str) -> Seen:
    """Return the values that two answers at one time suggest: the recorded and the virtual answer.

    `si` contains the requested command. `recorded` and `virtual` are the areas of both controllers
    at this time. `clock` is the value of the key `clock`.
    """
    words, other = _words(recorded), _words(virtual)
    if words[0] == ABNORMAL_END:
        return Seen(alarms=frozenset({f"{words[1]}.{words[2]}"}))
    command = commands().get(_words(si)[0] & 0x0FFF)
    if command is None:
        return Seen()
    mine, theirs = command.read_response(words), command.read_response(other)
    alarms = set()
    if mine.get("alarm_group"):
        alarms.add(f"{mine['alarm_group']}.{mine['alarm_category']}")
    numbers = {
        pair
        for name, value in mine.items()
        for pair in zip(_parts(theirs[name]), _parts(value), strict=True)
    }
    rows = {
        (_parts(theirs[name]), _parts(value))
        for name, value in mine.items()
        if isinstance(value, tuple)
    }
    return Seen(frozenset(alarms), frozenset(numbers), frozenset(rows), _clock(t_us, mine, clock))


def _clock(t_us: int, fields_: Mapping[str, Any], clock: str) -> str:
    """Return the date and time of the controller at the start of the recording.

    They are computed from an answer to a clock reference.
    """
    try:
        shown = datetime.fromisoformat(clock) + timedelta(microseconds=t_us)
        if "year" in fields_:
            date = {name: fields_[name] for name in ("month", "day")}
            shown = shown.replace(year=2000 + fields_["year"], **date)
        elif "second" in fields_:
            shown = shown.replace(**{name: fields_[name] for name in ("hour", "minute", "second")})
        else:
            return ""
        return (shown - timedelta(microseconds=t_us)).isoformat(sep=" ", timespec="seconds")
    except (ValueError, TypeError):
        return ""


def _parts(value: Any) -> tuple[int, ...]:
    every = value if isinstance(value, tuple) else (value,)
    return tuple(one for one in every if isinstance(one, int))


def _words(area: bytes) -> Sequence[int]:
    return [int.from_bytes(area[at : at + 2], "little") for at in range(0, DEDICATED_AT, 2)]


def values(
    key: str,
    current: Any,
    seen: Seen,
    raised: Collection[str],
    asked: Mapping[str, Timeline],
) -> list[Any]:
    """Return the values to try instead of the current value.

    `key` is a member of KNOBS. `seen` has the values that the recording suggests. `raised` has the
    alarms of the controller, and `asked` the timeline of each dedicated input.
    """
    found: list[Any] = []
    for one in _values(key, current, seen, raised, asked):
        if one != current and one not in found:
            found.append(one)
    return found


def has_few_values(key: str) -> bool:
    """Return whether the key is a truth value or a choice of a few words."""
    return key in CHOICES or _KINDS[key] == "bool"


def _values(
    key: str,
    current: Any,
    seen: Seen,
    raised: Collection[str],
    asked: Mapping[str, Timeline],
) -> Iterator[Any]:
    kind = _KINDS[key]
    if key in CHOICES:
        yield from CHOICES[key]
    elif kind == "bool":
        yield from (True, False)
    elif key == "min_interval":
        yield from _intervals(asked)
    elif key == "clock":
        if seen.clock:
            yield seen.clock
        yield "2020-02-03 04:05:06"
    elif key.endswith("_alarms"):
        for number in sorted({*raised, *seen.alarms}):
            kept = tuple(one for one in current if one != number)
            yield kept if number in current else (*current, number)
    elif key.endswith("_alarm"):
        yield from sorted(seen.alarms)
        yield ""
        yield _SOME_ALARM
    elif key in _TUPLES:
        yield from (mine for theirs, mine in sorted(seen.rows) if theirs == current)
        yield from _TUPLES[key]
    else:
        whole = isinstance(current, int)
        yield from (mine for theirs, mine in sorted(seen.numbers) if theirs == current)
        yield from _NUMBERS[key]
        if whole:
            yield current + 1 if current < 2 else current - 1


def _intervals(asked: Mapping[str, Timeline]) -> Iterator[float]:
    """Yield values [ms] of the interval that two changes of inputs need to be recognised."""
    times = sorted({t_us for name in INPUTS for t_us in asked[name].times})
    gaps = {
        -(-(later - earlier) // CYCLE_US) * CYCLE_US
        for earlier, later in pairwise(times)
        if later - earlier <= _LONGEST_INTERVAL_US
    }
    yield 0.0
    yield 100.0
    for gap_us in sorted(gaps):
        yield gap_us / 1000
        yield (gap_us + CYCLE_US) / 1000
