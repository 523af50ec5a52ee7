"""The return-to-origin by SI(14) and SI(17), by axis type (manual chapter 5, 2)."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass

from rcx_harness.robot.config import RobotConfig

__all__ = ["OriginRun", "Origins"]

_ABSOLUTE = ("absolute",)
_OTHERS = ("incremental", "semi_absolute")


@dataclass(eq=False)
class OriginRun:
    """One return-to-origin.

    Attributes:
        groups: Axes that are on their way; one group after the other, the first is moving.
        done: All have arrived.
        stopped_by: Number of the alarm that stopped it, else empty.
        by_command: A remote command waits for its end, and tells the alarm that stops it.
    """

    groups: list[tuple[int, ...]]
    by_command: bool = False
    done: bool = False
    stopped_by: str = ""

    @property
    def axes(self) -> set[int]:
        """The axes that have not arrived."""
        return {index for group in self.groups for index in group}


class Origins:
    """Which axes know their origin, and which are on the way to it.

    Attributes:
        complete: Per axis: its return-to-origin is complete.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.complete = [config.origin_complete] * len(config.axes)
        self._run: OriginRun | None = None

    def plan(self, name: str) -> list[tuple[int, ...]]:
        """The groups of axes that an input (`SI14`, `SI17`) moves; none if it has no effect."""
        if name == "SI14":
            return [group] if (group := self._axes(_OTHERS)) else []
        marked = [k for k, axis in enumerate(self._config.axes) if axis.origin_method == "mark"]
        if not all(self.complete[k] for k in marked):
            return []
        types = (_ABSOLUTE, _OTHERS) if self._config.di17_mode == "ABS/ORG" else (_ABSOLUTE,)
        return [group for kind in types if (group := self._axes(kind))]

    def moves(self, axes: Collection[int]) -> bool:
        """Any of these axes is on its way, or will be."""
        return self._run is not None and not self._run.axes.isdisjoint(axes)

    def begin(self, groups: Iterable[tuple[int, ...]], *, by_command: bool = False) -> OriginRun:
        """Start with the first group."""
        self._run = OriginRun(list(groups), by_command)
        self._leave(self._run)
        return self._run

    def arrive(self, positions: list[int]) -> bool:
        """The first group has arrived; True if another one follows."""
        run = self._run
        if run is None:
            return False
        group = run.groups.pop(0)
        self._mark(group, True)
        for k in group:
            if self._config.axes[k].type != "semi_absolute":
                positions[k] = 0
        if run.groups:
            self._leave(run)
            return True
        run.done = True
        self._run = None
        return False

    def interrupt(self, number: str) -> OriginRun | None:
        """A stop: what was moving has no origin now, what was to follow does not move."""
        run, self._run = self._run, None
        if run:
            self._mark(run.groups[0], False)
            run.stopped_by = number
        return run

    def lose_power(self) -> None:
        """Without power only absolute axes keep their origin."""
        if self._config.power_loses_origin:
            kept = self._config.axes
            self.complete = [
                done and axis.type == "absolute"
                for done, axis in zip(self.complete, kept, strict=True)
            ]

    def _leave(self, run: OriginRun) -> None:
        """The first group leaves its place."""
        if self._config.origin_clears_complete:
            self._mark(run.groups[0], False)

    def _axes(self, types: tuple[str, ...]) -> tuple[int, ...]:
        axes = self._config.axes
        return tuple(
            k for k, axis in enumerate(axes) if axis.type in types and axis.origin_method != "mark"
        )

    def _mark(self, group: tuple[int, ...], complete: bool) -> None:
        for k in group:
            self.complete[k] = complete
