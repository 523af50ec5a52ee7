"""The model of a Sequential Function Chart of Logix.

Source: Rockwell 1756-PM006, sequential function charts; 1756-RM084, their elements in an L5X.
"""

from __future__ import annotations

from dataclasses import dataclass

from structured_text.language.source import Line

__all__ = ["QUALIFIERS", "Action", "Chart", "Step", "Transition"]

#: The qualifiers of actions in a file, and their letters in the standard. P is both P1 and P0.
QUALIFIERS = {
    "NonStored": "N",
    "Reset": "R",
    "Stored": "S",
    "TimeLimited": "L",
    "TimeDelayed": "D",
    "Pulse": "P",
    "PulseRisingEdge": "P1",
    "PulseFallingEdge": "P0",
    "StoredTimeLimited": "SL",
    "StoredTimeDelayed": "SD",
    "TimeDelayedStored": "DS",
}


@dataclass(frozen=True)
class Action:
    """An action of a step.

    Attributes:
        tag: Its tag; an action that resets another one has the tag of that one.
        qualifier: One of the letters in `QUALIFIERS`.
        body: Its statements; empty for a Boolean action, which only has the bit Q of its tag.
        indicator: The BOOL tag that shows its bit Q; may be empty.
        at: Line in the file.
    """

    tag: str
    qualifier: str = "N"
    body: tuple[Line, ...] = ()
    indicator: str = ""
    at: int = 1


@dataclass(frozen=True)
class Step:
    """A step, or a stop, which nothing follows."""

    tag: str
    initial: bool = False
    stop: bool = False
    actions: tuple[Action, ...] = ()
    at: int = 1


@dataclass(frozen=True)
class Transition:
    """A transition from steps that must all be active to steps that become active.

    Attributes:
        tag: Its tag.
        sources: The tags of the steps above it.
        targets: The tags of the steps and stops below it.
        condition: The lines of its condition.
        rivals: The tags of the transitions that are left of it in a selection.
        at: Line in the file.
    """

    tag: str
    sources: tuple[str, ...]
    targets: tuple[str, ...]
    condition: tuple[Line, ...]
    rivals: tuple[str, ...] = ()
    at: int = 1


@dataclass(frozen=True)
class Chart:
    """A chart; its elements are in the order of the file."""

    steps: tuple[Step, ...]
    transitions: tuple[Transition, ...]
    at: int = 1
