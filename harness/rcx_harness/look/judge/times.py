"""The times of answers: exact counts and longest times, percentiles to half a per cent."""

from __future__ import annotations

import math
from collections import Counter

__all__ = ["Times"]

#: Number of times that are stored exactly. Further times are only counted in steps that differ by
#: this factor, so that the memory is bounded.
_EXACT, _STEP = 1_000, math.log(1.01)


class Times:
    """The times of one kind of answer, in microseconds.

    Attributes:
        open: Number of requests without an answer.
    """

    def __init__(self) -> None:
        self.count = self.longest_us = self.open = 0
        self._exact: list[int] = []
        self._steps: Counter[int] = Counter()

    def add(self, time_us: int) -> None:
        """Add a time."""
        self.count += 1
        self.longest_us = max(self.longest_us, time_us)
        if self.count <= _EXACT:
            self._exact.append(time_us)
        self._steps[math.floor(math.log(max(time_us, 1)) / _STEP)] += 1

    @property
    def exact(self) -> bool:
        """Return whether percentiles are exact; beyond 1,000 times they are right to 0.5 %."""
        return self.count <= _EXACT

    def percentile_us(self, share: float) -> int:
        """Return the time that this share (0 to 1) did not exceed; 0 without any."""
        left = math.ceil(share * self.count)
        if self.exact and self.count:
            return sorted(self._exact)[left - 1]
        for step in sorted(self._steps):
            left -= self._steps[step]
            if left <= 0:
                return min(round(math.exp((step + 0.5) * _STEP)), self.longest_us)
        return 0
