"""The return-to-origin by SI(14) and SI(17), by axis type (manual chapter 5, 2)."""

from __future__ import annotations

from rcx_harness.robot.config import RobotConfig

__all__ = ["Origins"]

_ABSOLUTE = ("absolute",)
_OTHERS = ("incremental", "semi_absolute")


class Origins:
    """Which axes know their origin, and which are on the way to it.

    Attributes:
        complete: Per axis: its return-to-origin is complete.
        under_way: Groups of axes that one return-to-origin performs one after the other; the first
            is moving.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.complete = [config.origin_complete] * len(config.axes)
        self.under_way: list[tuple[int, ...]] = []

    def plan(self, name: str) -> list[tuple[int, ...]]:
        """The groups of axes that an input (`SI14`, `SI17`) moves; none if it has no effect."""
        if name == "SI14":
            return [group] if (group := self._axes(_OTHERS)) else []
        marked = [k for k, axis in enumerate(self._config.axes) if axis.origin_method == "mark"]
        if not all(self.complete[k] for k in marked):
            return []
        types = (_ABSOLUTE, _OTHERS) if self._config.di17_mode == "ABS/ORG" else (_ABSOLUTE,)
        return [group for kind in types if (group := self._axes(kind))]

    def begin(self, groups: list[tuple[int, ...]]) -> None:
        """Start with the first group."""
        self.under_way = groups
        if self._config.origin_clears_complete:
            self._mark(groups[0], False)

    def arrive(self, positions: list[int]) -> bool:
        """The first group has arrived; True if another one follows."""
        group = self.under_way.pop(0)
        self._mark(group, True)
        for k in group:
            if self._config.axes[k].type != "semi_absolute":
                positions[k] = 0
        if self.under_way:
            self.begin(self.under_way)
        return bool(self.under_way)

    def interrupt(self) -> None:
        """A stop: what was moving has no origin now, what was to follow does not move."""
        if self.under_way:
            self._mark(self.under_way[0], False)
            self.under_way = []

    def lose_power(self) -> None:
        """Without power only absolute axes keep their origin."""
        self.interrupt()
        if self._config.power_loses_origin:
            kept = self._config.axes
            self.complete = [
                done and axis.type == "absolute"
                for done, axis in zip(self.complete, kept, strict=True)
            ]

    def _axes(self, types: tuple[str, ...]) -> tuple[int, ...]:
        axes = self._config.axes
        return tuple(
            k for k, axis in enumerate(axes) if axis.type in types and axis.origin_method != "mark"
        )

    def _mark(self, group: tuple[int, ...], complete: bool) -> None:
        for k in group:
            self.complete[k] = complete
