"""Observers of robot programs. They count executed lines or stop at a line, and change no state."""

from __future__ import annotations

from typing import Any, Protocol

__all__ = ["Observer", "Observers"]


class Observer(Protocol):
    """The callbacks at each instruction of the robot programs of a controller.

    An instruction that waits or moves takes several controller cycles, but begins and ends once.
    """

    def begins(self, task: Any, at: int) -> None:
        """Observe that the task is about to begin the instruction at position `at`."""

    def ends(self, task: Any, at: int, to: int) -> None:
        """Observe the end of the instruction at `at`; `to` is the next position, or NEXT."""


class Observers(list[Observer]):
    """The observers of the robot programs of a controller; all its snapshots share them."""

    def __deepcopy__(self, memo: object) -> Observers:
        """Return the list itself, because snapshots share the observers."""
        return self
