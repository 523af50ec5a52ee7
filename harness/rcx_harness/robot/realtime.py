"""The real time output: words 24 to 127 of the extended area show what was defined for them.

Definitions and the parameter that enables them are stored, as I/O parameters are (guide, 4.9).
"""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import TYPE_CHECKING

from rcx_harness.robot.quantities import quantity, take_axis
from rcx_harness.spec.wire import EXTENDED_SIZE

if TYPE_CHECKING:
    from rcx_harness.robot.config import RobotConfig
    from rcx_harness.robot.machine import Machine

__all__ = ["Definition", "RealTimeOutput"]


@dataclass(frozen=True)
class Definition:
    """What a word shows: the item's number, and its options (of an axis: robot and axis)."""

    item: int = 0
    option1: int = 0
    option2: int = 0

    def axis(self, config: RobotConfig) -> int | None:
        """Index of the axis that the options name; None if it is not there."""
        every = config.axes_of(self.option1) if self.option1 else ()
        return every[self.option2 - 1] if 1 <= self.option2 <= len(every) else None

    def sound(self, config: RobotConfig) -> bool:
        """Its item is not one of an axis, or the axis is there."""
        name = config.real_time_items.get(self.item, "")
        return not take_axis(name) or self.axis(config) is not None

    def value(self, machine: Machine) -> int:
        """The word now; 0 for items that the configuration does not name."""
        name = machine.config.real_time_items.get(self.item, "")
        return quantity(machine, name, self.axis(machine.config) or 0) if name else 0


class RealTimeOutput:
    """All definitions.

    Attributes:
        enabled: They are put out.
        definitions: By number of the word, 24 to 127.
        words: What is put out at present, by number of the word.
    """

    def __init__(self) -> None:
        self.enabled = False
        self.definitions: dict[int, Definition] = {}
        self.words: dict[int, int] = {}
        self._due_us = 0

    def define(self, word: int, definition: Definition) -> None:
        """Define a word anew; it is taken up at the next update."""
        self.definitions[word] = definition
        self._due_us = 0

    def enable(self, enabled: bool) -> None:
        """Begin or end to put them out; words that are not put out are the robot programs'."""
        self.enabled = enabled
        self._due_us = 0
        if not enabled:
            self.words.clear()

    def next_due_us(self) -> int | None:
        """When the next update is due; None if nothing is put out."""
        return self._due_us if self.enabled and self.definitions else None

    def observe(self, machine: Machine) -> None:
        """Update the words, at the interval of the configuration."""
        if not self.enabled or machine.now_us < self._due_us or machine.config.size < EXTENDED_SIZE:
            return
        self.words = {word: one.value(machine) for word, one in self.definitions.items()}
        self._due_us = machine.now_us + round(machine.config.real_time_interval * 1000)

    def lay_over(self, area: bytearray) -> None:
        """Put the words into an area."""
        for word, value in self.words.items():
            struct.pack_into("<H", area, 2 * word, value)
