"""The real time output: words 24 to 127 of the extended area show what was defined for them.

Definitions and the parameter that enables them are stored, as I/O parameters are (guide, 4.9).
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass

from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import HIGH_WORD, QUANTITIES_OF_AXIS

__all__ = ["Definition", "RealTimeOutput"]

_EXTENDED = 256


@dataclass(frozen=True)
class Definition:
    """What a word shows: the item's number, and its options (of an axis: robot and axis)."""

    item: int = 0
    option1: int = 0
    option2: int = 0

    def name(self, config: RobotConfig) -> str:
        """The quantity that it shows; empty for an item that the configuration does not name."""
        return config.real_time_items.get(self.item, "")

    def axis(self, config: RobotConfig) -> int | None:
        """Index of the axis that the options name; None if it is not there."""
        every = config.axes_of(self.option1) if self.option1 else ()
        return every[self.option2 - 1] if 1 <= self.option2 <= len(every) else None

    def sound(self, config: RobotConfig) -> bool:
        """Its item is not one of an axis, or the axis is there."""
        of_axis = self.name(config).removesuffix(HIGH_WORD) in QUANTITIES_OF_AXIS
        return not of_axis or self.axis(config) is not None


class RealTimeOutput:
    """All definitions.

    Attributes:
        enabled: They are put out.
        definitions: By number of the word, 24 to 127.
        words: What is put out at present, by number of the word.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
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

    def observe(self, now_us: int, read: Callable[[str, int], int]) -> None:
        """Update the words, at the interval of the configuration.

        Args:
            now_us: Time of this cycle.
            read: Gives a quantity as a word, by its name and the index of the axis; an item
                without a name is 0.
        """
        config = self._config
        if not self.enabled or now_us < self._due_us or config.size < _EXTENDED:
            return
        named = (
            (word, one.name(config), one.axis(config)) for word, one in self.definitions.items()
        )
        self.words = {word: read(name, axis or 0) if name else 0 for word, name, axis in named}
        self._due_us = now_us + round(config.real_time_interval * 1000)

    def lay_over(self, area: bytearray) -> None:
        """Put the words into an area."""
        for word, value in self.words.items():
            struct.pack_into("<H", area, 2 * word, value)
