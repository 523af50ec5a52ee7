"""The features of a run: what it has exercised. A run with a new feature is worth continuing."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from hashlib import blake2b
from typing import Any

from rcx_harness.cell.stimulus import Entry
from rcx_harness.spec.wire import DEDICATED_AT
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.moments import own_variables
from structured_text.engines.base import Program
from structured_text.engines.builtin.collector import Collector
from structured_text.language.types import EnumType

__all__ = ["Met", "Observer", "digest"]

#: A state of the user's blocks that a run has met: variable, value, and a fault that was present
#: (empty: none).
Met = tuple[str, str, str]

#: An event without a duration counts as present for this time [us].
_MOMENT_US = 100_000
#: Numbers above this value count as equal, because counters would always be new.
_MOST = 8
#: Greatest number of the user's variables whose values are combined in pairs.
_MOST_PAIRED = 48


def digest(*parts: object) -> int:
    """Return a number of 64 bits for these parts; it is the same in all processes."""
    return int.from_bytes(blake2b(repr(parts).encode(), digest_size=8).digest(), "little")


class Observer:
    """The observer of a cell that collects the features of a run, scan by scan.

    Features are: a vector of conditions of a decision (MC/DC); a phase of a block together with
    the state of the controllers and the faults that are present; and each pair of values of the
    user's variables.

    Args:
        inputs: The operator's variables. They are no states of the program.
        new: Function that is called in a scan with a new feature.
    """

    def __init__(
        self,
        course: Course,
        library: Collection[str],
        inputs: Collection[str],
        collector: Collector,
        new: Callable[[], None],
    ) -> None:
        self._course, self._cell, self._new = course, course.cell, new
        program = course.cell.program
        own = [path for path in own_variables(program, library) if path not in inputs]
        self._own = own[:_MOST_PAIRED]
        phases = set(_enumerations(program))
        self._states = [path for path in self._own if path in phases]
        further = [path for path in sorted(phases) if path not in self._own]
        self._paths = [*self._own, *further]
        self._read = program.reader(self._paths)
        self._seen = [seen for one in collector.counted for seen in one.counts.seen]
        self._memory: dict[Any, int] = {}
        self.begin(frozenset())
        course.cell.trace.listen(self._take)

    def begin(self, known: Collection[int]) -> None:
        """Forget all features, because a run begins; `known` are features of earlier runs."""
        self._known = known
        self.found: dict[int, None] = {}
        self.met: set[Met] = set()
        self._last: Any = None
        self._before: tuple[Any, ...] = ()
        self._vectors = 0
        for seen in self._seen:
            seen.clear()

    @property
    def states(self) -> Sequence[str]:
        """Return the user's variables that are states (enumerations)."""
        return self._states

    def rest(self) -> int:
        """Return a digest of states and flags; equal ones recover alike, as a rule."""
        values = zip(self._own, self._read(), strict=False)
        told = [v for path, v in values if isinstance(v, bool) or path in self._states]
        return digest("rest", *told, self._controllers())

    def _take(self, record: Any) -> None:
        if not self._cell.ends_scan(record):
            return
        now = tuple(map(_plain, self._read())), self._controllers(), self._faults()
        vectors = sum(map(len, self._seen))
        if now == self._last and vectors == self._vectors:
            return
        begin = len(self.found)
        fresh = False
        for feature in self._features(now, vectors):
            if feature not in self.found:
                self.found[feature] = None
                fresh = fresh or feature not in self._known
        self._last, self._vectors = now, vectors
        if fresh and len(self.found) > begin:
            self._new()

    def _features(self, now: Any, vectors: int) -> Iterator[int]:
        values, controllers, faults = now
        if vectors != self._vectors:
            for number, seen in enumerate(self._seen):
                for vector in seen:
                    yield self._of(("vector", number, vector))
        if now == self._last:
            return
        size = len(self._own)
        for place, value in enumerate(values):
            if place >= size or self._paths[place] in self._states:
                yield self._of(("phase", place, value, controllers, faults))
        for path in self._states:
            value = str(values[self._paths.index(path)])
            self.met.add((path, value, ""))
            self.met.update((path, value, fault) for fault, _ in faults)
        before = self._before if len(self._before) == len(values) else (object(),) * len(values)
        changed = [k for k in range(size) if values[k] != before[k]]
        for k in changed:
            for other in range(size):
                if other != k:
                    a, b = sorted((k, other))
                    yield self._of(("pair", a, values[a], b, values[b]))
        self._before = values

    def _of(self, parts: Any) -> int:
        found = self._memory.get(parts)
        if found is None:
            found = self._memory[parts] = digest(*parts)
        return found

    def _controllers(self) -> tuple[tuple[int, int], ...]:
        """Return remote status and dedicated outputs of each controller."""
        return tuple(
            (
                int.from_bytes(read[:2], "little"),
                int.from_bytes(read[DEDICATED_AT : DEDICATED_AT + 2], "little"),
            )
            for read, _ in self._cell.exchanged()
        )

    def _faults(self) -> tuple[tuple[str, int], ...]:
        """Return the faults that are present, each with its controller."""
        now_us = self._cell.now_us
        return tuple(
            sorted(
                {
                    (name, act.controller)
                    for act in self._course.done
                    if act.events and act.t_us <= now_us < _end_of(act)
                    for name, _ in act.events
                }
            )
        )


def _end_of(act: Entry) -> int:
    return act.t_us + (_MOMENT_US if act.held_us is None else act.held_us)


def _plain(value: Any) -> Any:
    """Return a value with large numbers made equal; words are codes, and stay."""
    if isinstance(value, int) and not isinstance(value, bool) and _MOST < value < 0x100:
        return _MOST
    return value


def _enumerations(program: Program) -> Iterator[str]:
    for path, kind in program.walk():
        if isinstance(kind, EnumType):
            yield path
