"""Movement to any moment of a run: the run is repeated from the nearest snapshot before it.

A moment is a scan and the number of a statement in it. Changes by the user are repeated at the
moment where they were made. The machine is deterministic, so a repeated scan equals the first.
"""

from __future__ import annotations

from bisect import bisect_right, insort
from collections.abc import Callable, Iterator
from types import FrameType
from typing import Any, NamedTuple

from structured_text.debug.devices import DeviceStep
from structured_text.debug.machine import Machine
from structured_text.debug.places import Code, Places
from structured_text.debug.tracer import Lines, Tracer

__all__ = ["Edit", "Moment", "Player"]

#: Initial number of scans between two snapshots, and the greatest number of snapshots. When there
#: are more, every other snapshot is removed and the distance doubles. Memory stays bounded, and the
#: nearest snapshot is at most one distance away.
_STRIDE, _MOST = 32, 1000


class Moment(NamedTuple):
    """The moment before statement `step` of a scan (from 1); 0 is the moment before the scan."""

    scan: int
    step: int = 0


class Edit(NamedTuple):
    """A change by the user, at a moment; `number` is its order among the changes."""

    at: Moment
    number: int
    apply: Callable[[], None]


class Player:
    """A machine with snapshots, which can go to any moment of its run.

    Attributes:
        tracer: The hooks on the statements of the program.
        rerun: Number of scans that have been repeated so far.
    """

    def __init__(self, machine: Machine, places: Places) -> None:
        self.machine = machine
        self.tracer = Tracer(places, machine.devices)
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
        """Return the number of snapshots."""
        return len(self._order)

    @property
    def stride(self) -> int:
        """Return the number of scans between two snapshots."""
        return self._stride

    @property
    def now(self) -> Moment:
        """Return the current moment."""
        return Moment(self.machine.scans, self.tracer.step)

    # --- forwards ---

    def plain(self) -> None:
        """Run a scan without hooks.

        If the user has made changes in the middle of this scan, hooks are set to repeat the
        changes.
        """
        if self._has_edits(self.machine.scans):
            self.every(lambda: None)
        else:
            self._guarded(self.machine.scan)

    def some(
        self,
        lines: Lines,
        hit: Callable[[Code, int, FrameType], None],
        device: Callable[[DeviceStep], None] | None = None,
    ) -> None:
        """Run a scan; call `hit` before statements in these lines (`Tracer.some`).

        `device` is called before each line of a device's program.
        """
        if self._has_edits(self.machine.scans):
            self.every(lambda: self._look_for(lines, hit, device))
        else:
            self._guarded(lambda: self.tracer.some(self.machine.scan, lines, hit, device))

    def _look_for(
        self,
        lines: Lines,
        hit: Callable[[Code, int, FrameType], None],
        device: Callable[[DeviceStep], None] | None,
    ) -> None:
        if self.tracer.device is not None:
            if device is not None:
                device(self.tracer.device)
            return
        entry = self.tracer.stack[-1]
        if entry.at in lines.get(entry.code.pou.name.upper(), ()):
            hit(entry.code, entry.at, entry.frame)

    def every(self, look: Callable[[], None]) -> None:
        """Run a scan; call `look` before each statement."""
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
        """Repeat the user's changes that were made between the last scan and the next scan."""
        for one in self._edits:
            if one.at == (self.machine.scans, 0):
                one.apply()

    # --- backwards ---

    def seek(self, scan: int, pause: Callable[[], None] = lambda: None) -> None:
        """Go to the beginning of this scan; call `pause` before each scan on the way.

        If the current moment lies between the nearest snapshot and this scan, the run continues
        from here. Otherwise, and always after an abandoned scan (`_whole` is false), the snapshot
        is restored first.
        """
        self.tracer.clear()
        start = self._order[bisect_right(self._order, scan) - 1]
        if not (self._whole and start <= self.machine.scans <= scan):
            self._restore(start)
        while self.machine.scans < scan:
            pause()
            self.plain()

    def stretches(self, end: int) -> Iterator[tuple[int, int]]:
        """Yield the ranges of scans between snapshots, backwards from `end`.

        The machine is restored to the beginning of each range before it is yielded.
        """
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
        """Apply a change now, and again whenever the run passes this moment.

        Returns:
            Whether the run had already gone beyond this moment. If so, everything after this moment
            is discarded.
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
