"""Observers of robot programs: they count lines or stop at them, and change nothing."""

from __future__ import annotations

from typing import Any, Protocol

__all__ = ["Observer", "Observers"]


class Observer(Protocol):
    """The callbacks at each instruction of the robot programs of a controller.

    An instruction that waits or moves takes several controller cycles, but begins and ends once.
    """

    def begins(self, task: Any, at: int) -> None:
        """Observe that a RobotTask is about to begin the instruction at a position."""

    def ends(self, task: Any, at: int, to: int) -> None:
        """Observe that an instruction has ended; `to` is the next position, or NEXT."""


class Observers(list[Observer]):
    """The observers of a controller; all its snapshots share them."""

    def __deepcopy__(self, memo: object) -> Observers:
        """Return the list itself."""
        return self
