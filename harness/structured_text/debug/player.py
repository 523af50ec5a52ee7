"""Goes to any moment of a run: the nearest snapshot before it, and what follows once more.

A moment is a scan and the number of a statement in it; what was changed by hand is done again
where it was done. A cell is deterministic, so that what is run again is what was.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any, NamedTuple

from structured_text.debug.machine import Machine
from structured_text.debug.places import Code, Places
from structured_text.debug.tracer import Lines, Tracer

__all__ = ["Edit", "Moment", "Player"]

#: The first snapshots are so many scans apart; when there are too many, every other one goes.
_STRIDE, _MOST = 32, 1000


class Moment(NamedTuple):
    """Before the statement `step` (from 1) of the scan, or with 0 before the scan itself."""

    scan: int
    step: int = 0


class Edit(NamedTuple):
    """A change that was made by hand, at a moment; `number` is their order."""

    at: Moment
    number: int
    apply: Callable[[], None]


class Player:
    """Moves a machine in time.

    Attributes:
        machine: What is moved.
        tracer: Looks at its statements.
        rerun: How many scans have been run again so far.
    """

    def __init__(self, machine: Machine, places: Places) -> None:
        self.machine = machine
        self.tracer = Tracer(places)
        self.rerun = 0
        self._kept: dict[int, Any] = {}
        self._order: list[int] = []
        self._stride = _STRIDE
        self._edits: list[Edit] = []
        self._furthest = 0
        self._whole = True
        self._keep()

    @property
    def kept(self) -> int:
        """How many snapshots there are."""
        return len(self._order)

    @property
    def stride(self) -> int:
        """How many scans lie between two of them."""
        return self._stride

    @property
    def now(self) -> Moment:
        """Where it is."""
        return Moment(self.machine.scans, self.tracer.step)

    # --- forwards ---

    def plain(self) -> None:
        """Run a scan."""
        if self._has_edits(self.machine.scans):
            self.every(lambda: None)
        else:
            self._guarded(self.machine.scan)

    def some(self, lines: Lines, hit: Callable[[Code, int, FrameType], None]) -> None:
        """Run a scan; `hit` is called before statements in these lines (`Tracer.some`)."""
        if self._has_edits(self.machine.scans):
            self.every(lambda: self._look_for(lines, hit))
        else:
            self._guarded(lambda: self.tracer.some(self.machine.scan, lines, hit))

    def _look_for(self, lines: Lines, hit: Callable[[Code, int, FrameType], None]) -> None:
        entry = self.tracer.stack[-1]
        if entry.at in lines.get(entry.code.pou.name.upper(), ()):
            hit(entry.code, entry.at, entry.frame)

    def every(self, look: Callable[[], None]) -> None:
        """Run a scan; `look` is called before each statement."""
        scan = self.machine.scans
        edits = [one for one in self._edits if one.at.scan == scan and one.at.step]

        def changed() -> None:
            for one in edits:
                if one.at.step == self.tracer.step:
                    one.apply()
            look()

        self._guarded(lambda: self.tracer.every(self.machine.scan, changed if edits else look))

    def _guarded(self, run: Callable[[], None]) -> None:
        if self.machine.scans < self._furthest:
            self.rerun += 1
        self._whole = False
        run()
        self.tracer.clear()
        self._whole = True
        self._furthest = max(self._furthest, self.machine.scans)
        self._keep()
        self._arrive()

    def _arrive(self) -> None:
        """Change again what was changed by hand between the last scan and the next."""
        for one in self._edits:
            if one.at == (self.machine.scans, 0):
                one.apply()

    # --- backwards ---

    def seek(self, scan: int, pause: Callable[[], None] = lambda: None) -> None:
        """Go to where this scan is about to begin; `pause` is called on the way."""
        self.tracer.clear()
        start = self._order[bisect_right(self._order, scan) - 1]
        if not (self._whole and start <= self.machine.scans <= scan):
            self._restore(start)
        while self.machine.scans < scan:
            pause()
            self.plain()

    def stretches(self, end: int) -> Iterator[tuple[int, int]]:
        """Stretches of scans between snapshots, from `end` back to the start; each is set up."""
        while end > 0:
            start = self._order[bisect_right(self._order, end - 1) - 1]
            self._restore(start)
            yield start, end
            end = start

    def _restore(self, scan: int) -> None:
        self.machine.restore(self._kept[scan])
        self.tracer.clear()
        self._whole = True
        self._arrive()

    # --- snapshots ---

    def _keep(self) -> None:
        scan = self.machine.scans
        if scan % self._stride or scan in self._kept:
            return
        self._kept[scan] = self.machine.snapshot()
        insort(self._order, scan)
        if len(self._order) > _MOST:
            self._stride *= 2
            self._order = [one for one in self._order if one % self._stride == 0]
            self._kept = {one: self._kept[one] for one in self._order}

    # --- changes ---

    def edit(self, apply: Callable[[], None]) -> bool:
        """Change something now, and again whenever this moment comes.

        Returns:
            Whether what was known of the time after it is no longer true.
        """
        apply()
        now = self.now
        self._edits = [one for one in self._edits if one.at <= now]
        self._edits.append(Edit(now, len(self._edits), apply))
        for scan in [one for one in self._order if one > now.scan]:
            del self._kept[scan]
        self._order = [one for one in self._order if one <= now.scan]
        later = self._furthest > now.scan
        self._furthest = now.scan
        return later

    def _has_edits(self, scan: int) -> bool:
        return any(one.at.scan == scan and one.at.step for one in self._edits)
