"""Movements, at most one for each robot, and the return-to-origin of the axes."""

from __future__ import annotations

import math
from collections.abc import Collection, Hashable, Iterable, Mapping
from dataclasses import dataclass

from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.paths import Path

__all__ = ["Motion", "Movement", "OriginRun", "Origins"]

_ABSOLUTE = ("absolute",)
_OTHERS = ("incremental", "semi_absolute")


@dataclass(eq=False)
class Movement:
    """The movement of one robot, and its progress.

    Attributes:
        duration_us: Time from start to target [us].
        relative: Identifies a relative movement (MOVEI, DRIVEI), so that its repetition is
            recognised; None for other movements.
        tolerance: For each axis, the distance to its target at which it counts as arrived [pulses].
        pushing: Whether the axis of the movement stops at a workpiece (PUSH).
        by_program: Whether a robot program has started the movement.
        out_positions: OUT position range of each axis [pulses]; None until a program needs it.
        continuous: Whether the next movement of the program may begin in the OUT position range.
        done: Whether all axes are within their tolerances, or the target is reached.
        finished: Whether the target is reached exactly.
        stopped_by: Number of the alarm that stopped the movement before its target; empty if no
            alarm has stopped it.
        blocked_us: Time since which a pushing axis is stopped by a workpiece, else None.
    """

    path: Path
    start_us: int
    relative: Hashable | None = None
    tolerance: Mapping[int, int] | None = None
    pushing: bool = False
    by_program: bool = False
    continuous: bool = False
    out_positions: Mapping[int, int] | None = None
    done: bool = False
    finished: bool = False
    stopped_by: str = ""
    blocked_us: int | None = None

    def __post_init__(self) -> None:
        """Calculate the duration from the path."""
        # Round to 0.001 us first, so that a rounding error does not add a cycle.
        self.duration_us = math.ceil(round(self.path.seconds * 1e6, 3))

    def advance(self, now_us: int, positions: list[int], workpieces: Mapping[int, int]) -> None:
        """Update the entries of the moving axes in `positions` [pulses] to the time `now_us`."""
        passed = now_us - self.start_us
        arrived = passed >= self.duration_us
        places = self.path.target if arrived else self.path.at(passed / 1e6)
        for index, place in places.items():
            positions[index] = round(place)
        blocked = self.pushing and self._hold_at(workpieces, positions)
        if not blocked:
            self.blocked_us = None
        elif self.blocked_us is None:
            self.blocked_us = now_us
        self.finished = arrived and not blocked
        near = passed >= self.path.approach * 1e6 and self._near(positions)
        self.done = self.finished or (near and not blocked)

    def is_near(self, now_us: int, positions: list[int], axes: Collection[int]) -> bool:
        """Return whether all moving axes of `axes` are within their tolerances."""
        if (now_us - self.start_us) < self.path.approach * 1e6:
            return self.path.target.keys().isdisjoint(axes)
        tolerance = self.tolerance or {}
        return all(
            abs(end - positions[index]) <= tolerance.get(index, 0)
            for index, end in self.path.target.items()
            if index in axes
        )

    def _hold_at(self, workpieces: Mapping[int, int], positions: list[int]) -> bool:
        """Stop the axes at workpieces on their path; return whether any axis was stopped."""
        held = False
        for index, start in self.path.at(0.0).items():
            if index in workpieces:
                place, now = workpieces[index], positions[index]
                if start <= place < now or now < place <= start:
                    positions[index] = place
                    held = True
        return held

    def _near(self, positions: list[int]) -> bool:
        if self.tolerance is None:
            return False
        for index, end in self.path.target.items():
            if abs(end - positions[index]) > self.tolerance.get(index, 0):
                return False
        return True


class Motion:
    """The movements of all robots.

    Attributes:
        workpieces: Position [pulses] of the workpiece that stops a pushing axis, by axis index.
    """

    def __init__(self) -> None:
        self.workpieces: dict[int, int] = {}
        self._movements: dict[int, Movement] = {}
        self._interrupted: dict[int, tuple[Hashable, Mapping[int, int]]] = {}

    @property
    def under_way(self) -> bool:
        """Return whether any robot is moving."""
        return bool(self._movements)

    def moving(self, robot: int) -> bool:
        """Return whether the robot with this number is moving."""
        movement = self._movements.get(robot)
        return movement is not None and not movement.done

    def under_way_of(self, robot: int) -> Movement | None:
        """Return the unfinished movement of a robot; None if there is none."""
        return self._movements.get(robot)

    def start(self, robot: int, movement: Movement) -> None:
        """Start a movement of a robot, and forget the interrupted movement of this robot."""
        self.forget(robot)
        self._movements[robot] = movement

    def advance(self, now_us: int, positions: list[int]) -> None:
        """Advance the movements of all robots."""
        for robot, movement in list(self._movements.items()):
            movement.advance(now_us, positions, self.workpieces)
            if movement.finished:
                del self._movements[robot]

    def stop(
        self, now_us: int, positions: list[int], number: str, axes: Collection[int] | None = None
    ) -> None:
        """Stop movements at their current positions because of the alarm `number`.

        The entries of `positions` [pulses] are updated. If `axes` are given, only movements of
        these axes stop.
        """
        self.advance(now_us, positions)
        for robot, movement in list(self._movements.items()):
            if axes is None or not movement.path.target.keys().isdisjoint(axes):
                del self._movements[robot]
                if movement.done:
                    continue
                movement.stopped_by = number
                if movement.relative is not None:
                    self._interrupted[robot] = (movement.relative, movement.path.target)

    def cancel(self, robot: int) -> None:
        """End the movement of a robot at its current position, without an alarm."""
        self._movements.pop(robot, None)

    def forget(self, robot: int | None = None) -> None:
        """Forget the interrupted relative movement of a robot, or of all robots.

        A repetition of the movement then starts from the current position.
        """
        if robot is None:
            self._interrupted.clear()
        else:
            self._interrupted.pop(robot, None)

    def kept_target(self, robot: int, relative: Hashable) -> Mapping[int, int] | None:
        """Return the target of the interrupted movement [pulses]; None if `relative` differs."""
        key, target = self._interrupted.get(robot, (None, None))
        return target if key == relative else None


@dataclass(eq=False)
class OriginRun:
    """A running return-to-origin.

    Attributes:
        groups: Axes that have not arrived, in groups that move in sequence; the first group is
            moving now.
        done: Whether all axes have arrived.
        stopped_by: Number of the alarm that stopped the return-to-origin; empty if no alarm has
            stopped it.
        by_command: Whether a remote command has started it. The command waits for its end and
            reports an alarm that stops it.
    """

    groups: list[tuple[int, ...]]
    by_command: bool = False
    done: bool = False
    stopped_by: str = ""

    @property
    def axes(self) -> set[int]:
        """Return the axes that have not arrived."""
        return {index for group in self.groups for index in group}


class Origins:
    """The origin state of each axis, and the return-to-origin under way.

    Attributes:
        complete: For each axis, whether its return-to-origin is complete.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.complete = [config.origin_complete] * len(config.axes)
        self._run: OriginRun | None = None

    def plan(self, name: str) -> list[tuple[int, ...]]:
        """Return the groups of axes that the input `SI14` or `SI17` moves; empty if none."""
        if name == "SI14":
            return [group] if (group := self._axes(_OTHERS)) else []
        marked = [k for k, axis in enumerate(self._config.axes) if axis.origin_method == "mark"]
        if not all(self.complete[k] for k in marked):
            return []
        types = (_ABSOLUTE, _OTHERS) if self._config.di17_mode == "ABS/ORG" else (_ABSOLUTE,)
        return [group for kind in types if (group := self._axes(kind))]

    def moves(self, axes: Collection[int]) -> bool:
        """Return whether a return-to-origin still has to move one of these axes."""
        return self._run is not None and not self._run.axes.isdisjoint(axes)

    def begin(self, groups: Iterable[tuple[int, ...]], *, by_command: bool = False) -> OriginRun:
        """Start a return-to-origin with the first group."""
        self._run = OriginRun(list(groups), by_command)
        self._leave(self._run)
        return self._run

    def arrive(self, positions: list[int]) -> bool:
        """End the movement of the first group; return True if another group follows."""
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
        """Stop the return-to-origin; moving axes lose their origin, later groups do not move."""
        run, self._run = self._run, None
        if run:
            self._mark(run.groups[0], False)
            run.stopped_by = number
        return run

    def lose_power(self) -> None:
        """If so configured, reset the origins of all axes that are not absolute."""
        if self._config.power_loses_origin:
            kept = self._config.axes
            self.complete = [
                done and axis.type == "absolute"
                for done, axis in zip(self.complete, kept, strict=True)
            ]

    def _leave(self, run: OriginRun) -> None:
        """Start the first group of axes.

        If so configured, the axes lose their origin at the start.
        """
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
