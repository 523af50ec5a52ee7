"""A world of numbers for tests of explorations. Each worker process can import this module."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import NamedTuple

from structured_text.errors import InputError
from structured_text.explore.search import World


class Choice(NamedTuple):
    """A choice in an exploration: it doubles the number and adds `add`."""

    number: int


EVERY = (Choice(0), Choice(1), Choice(2))


@dataclass
class Numbers(World[Choice]):
    """A world with steps from n to 2 n, 2 n + 1 and 2 n + 2, modulo a size.

    From 0, all numbers are reached.

    Attributes:
        size: Number of states.
        broken: For a number, the rules that the step to it breaks.
        refused: Numbers for which `check` raises an error.
        deaths: A folder of files. Each step from 20 removes a file and kills its process.
    """

    size: int
    broken: Mapping[int, str] = field(default_factory=dict)
    refused: Sequence[int] = ()
    deaths: Path | None = None

    def first(self) -> bytes:
        """Return 0."""
        return b"0"

    def choices(self, state: bytes) -> Sequence[Choice]:
        """Return the same choices for every state."""
        return EVERY

    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Return the next number."""
        if self.deaths is not None and state == b"20" and (left := sorted(self.deaths.iterdir())):
            left[0].unlink()
            os.kill(os.getpid(), signal.SIGKILL)
        following = (2 * int(state) + choice.number) % self.size
        return b"%d" % following, [self.broken[following]] if following in self.broken else []

    def check(self, state: bytes, choice: Choice, following: bytes, random: Random) -> None:
        """Raise an error for refused numbers."""
        if int(state) in self.refused:
            raise InputError(f"{state.decode()} is refused")
