"""A run-time monitor of the block calls that the check of the source cannot decide.

The engine must report each call. The C code of matiec reports no calls, so the monitor finds
nothing on matiec.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from rcx_harness.robot import Violation
from rcx_harness.watch.calls_source import AREAS, CallPlan
from structured_text.engines.base import Program
from structured_text.language.types import BlockType

__all__ = ["CallMonitor"]


class _Watched(NamedTuple):
    """A watched instance: path, area (`read`, `write` or empty), and the pin Busy or None."""

    path: str
    area: str
    busy: str


class CallMonitor:
    """A monitor that demands one call per scan, for one robot, and no skipped call while busy.

    Args:
        plan: The calls that the source does not decide. If there are none, the monitor does
            nothing.
    """

    def __init__(self, program: Program, plan: CallPlan) -> None:
        self._program = program
        self._log = program.note_calls(plan.blocks) if plan.blocks else None
        self._watched: dict[int, _Watched] = {}
        if self._log is not None:
            for name, kind in program.instances().items():
                if isinstance(kind, BlockType):
                    for one in _inside(name, kind, plan):
                        self._watched[self._log.key(one.path)] = one
        self._robots: dict[int, int] = {}
        """The robot of each instance's last call."""
        self._before: frozenset[str] = frozenset()
        """The faults of the previous scan, because a lasting fault is reported only once."""
        self._earlier: list[tuple[int, int]] = []
        """Calls that were taken from the log and not judged yet."""

    def scan(self, t_us: int, scan: int) -> list[Violation]:
        """Judge the calls of a scan."""
        if self._log is None:
            return []
        taken, self._earlier = [*self._earlier, *self._log.take()], []
        calls = [(key, robot) for key, robot in taken if key in self._watched]
        broken = dict.fromkeys(self._judge(calls))
        found = [text for text in broken if text not in self._before]
        self._before = frozenset(broken)
        return [Violation(t_us, "calls", f"plc, scan {scan}: calls: {text}") for text in found]

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Do not judge the calls inside the `with` statement, because they belong to a trial."""
        if self._log is None:
            yield
            return
        self._earlier += self._log.take()
        try:
            yield
        finally:
            self._log.take()

    def snapshot(self) -> object:
        """Return the data of earlier scans that the monitor needs."""
        return dict(self._robots), self._before

    def restore(self, snapshot: tuple[dict[int, int], frozenset[str]]) -> None:
        """Restore the state from `snapshot`."""
        robots, self._before = snapshot
        self._robots = dict(robots)

    def begin(self) -> None:
        """Do nothing after a start of the PLC; the monitor uses no retained variables."""

    def _judge(self, calls: list[tuple[int, int]]) -> Iterator[str]:
        times = Counter(key for key, _ in calls)
        for key, number in times.items():
            if number > 1:
                yield (
                    f"{self._watched[key].path} was called {number} times in one scan; call it "
                    f"once, because otherwise its time limits are wrong"
                )
        areas: dict[tuple[int, str], dict[str, None]] = defaultdict(dict)
        for key, robot in calls:
            one = self._watched[key]
            if one.area:
                areas[robot, one.area][one.path] = None
            if self._robots.setdefault(key, robot) != robot:
                yield f"{one.path} was called for two robots; declare an instance for each"
            self._robots[key] = robot
        for (_, area), paths in areas.items():
            if len(paths) > 1:
                yield f"{' and '.join(paths)} both {area} the area of one robot; call one of them"
        written = {robot for robot, area in areas if area == "write"}
        for key, one in self._watched.items():
            left_out = key not in times and one.busy and self._robots.get(key) in written
            if left_out and self._program.read(one.busy):
                yield (
                    f"{one.path} was not called though it is busy: it loses its turn (16#8013); "
                    "call it in every scan, outside of any IF"
                )


def _inside(path: str, owner: BlockType, plan: CallPlan) -> Iterator[_Watched]:
    """Yield the watched instances in a user's program or block, and the instances inside them."""
    names = plan.owners.get(owner.name.upper())
    if names is None:
        return
    for variable in owner.variables:
        block = variable.type
        if variable.section != "VAR" or not isinstance(block, BlockType):
            continue
        inner = f"{path}.{variable.name}"
        if variable.name.upper() in names:
            busy = [pin.name for pin in block.variables if pin.name.upper() == "BUSY"]
            area = AREAS.get(block.name.upper(), "")
            yield _Watched(inner, area, f"{inner}.{busy[0]}" if busy else "")
        yield from _inside(inner, block, plan)
