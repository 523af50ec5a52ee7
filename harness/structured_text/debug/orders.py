"""The orders of the user to the debugger, and the stops that it reports to the user."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from structured_text.debug.breakpoints import DataWatch

__all__ = ["Back", "Forward", "Front", "Order", "Quit", "Stop"]


@dataclass(frozen=True)
class Stop:
    """The reason for a stop of the run.

    Attributes:
        reason: Name of the reason in the protocol.
        text: A text of one line for the user.
        hits: The breakpoints that were hit.
    """

    reason: str
    text: str = ""
    hits: tuple[int, ...] = ()


@dataclass(frozen=True)
class Forward:
    """An order to continue: `until` is continue, in, over, out or scan.

    `scans` is the number of scans if `until` is scan. `task` is the task of a device in which a
    step ends; 0 stands for the PLC's program.
    """

    until: str = "continue"
    scans: int = 1
    task: int = 0


@dataclass(frozen=True)
class Back:
    """An order to go back: `until` is step, continue, scan, change (of `watch`) or start.

    `task` is the task of a device in which a step ends; 0 stands for the PLC's program.
    """

    until: str
    scans: int = 1
    watch: DataWatch | None = None
    task: int = 0


@dataclass(frozen=True)
class Quit:
    """The order to end the session."""


Order = Forward | Back | Quit


class Front(Protocol):
    """The user interface of the debugger."""

    def wait(self, stop: Stop) -> Order:
        """Report a stop, and return the next order."""

    def poll(self) -> Quit | None:
        """Return Quit if the user wants to end while the program runs."""

    def log(self, text: str) -> None:
        """Print the message of a logpoint."""
