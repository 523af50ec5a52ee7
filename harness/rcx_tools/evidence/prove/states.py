"""Random values and states. Edges, limits and equal numbers are frequent."""

from __future__ import annotations

import math
from ctypes import c_float
from random import Random
from typing import Any

from structured_text.language.scalars import (
    ANY_DATE,
    ANY_REAL,
    INT_RANGE,
    MOMENTS,
    STRING_MAX,
    string_length,
)
from structured_text.language.types import ArrayType, ElementaryType, EnumType, Type
from structured_text.language.values import array_length

__all__ = ["States"]

_MS = 1_000_000
_LIMIT = (1 << 63) - 1
_REALS: tuple[float, ...] = (
    *(0.0, -0.0, 1.0, -1.0, 0.5, 1.5, 2.5, -0.5, 0.1, 8388608.0, 16777216.0, 16777217.0),
    *(2.0**-149, 2.0**-126, -(2.0**-127), 3.4028234663852886e38, 99999.99, -1234.567, 32767.5),
    *(math.inf, -math.inf, math.nan, 2147483648.0, -2147483649.0, 1e30),
)
_PRINTABLE = [chr(code) for code in range(32, 127)]


class States:
    """A source of random values in the representation of the built-in engine.

    Args:
        seed: Seed. The same seed always gives the same values.
    """

    def __init__(self, seed: str) -> None:
        self.random = Random(seed)
        self.now = 0
        self._on = 0.5
        self._numbers: list[int] = [0]

    def begin(self) -> None:
        """Begin a new state: draw numbers that several values use, and the share of TRUE BOOLs."""
        draw = self.random
        self._on = draw.choice((0.1, 0.3, 0.5, 0.7, 0.9))
        self._numbers = [draw.choice((draw.randint(0, 20), draw.getrandbits(16))) for _ in range(3)]
        self.now = draw.choice((0, draw.randint(0, 10_000) * _MS, draw.getrandbits(60)))

    def later(self) -> None:
        """Advance the time by a random step, which may be zero."""
        steps = (0, 1, 1, 10, 10, 50, 99, 100, 101, 500, 1000, 5000, 60_000)
        self.now += self.random.choice(steps) * _MS + self.random.choice((0, 0, 0, 1, -1, 999))
        self.now = max(self.now, 0)

    def chance(self, share: float) -> bool:
        """Return True with the given probability."""
        return self.random.random() < share

    def value(self, kind: Type, name: str = "") -> Any:
        """Return a value of a scalar type, or the elements of an array of scalars."""
        if isinstance(kind, EnumType):
            return self.random.randrange(len(kind.members))
        if isinstance(kind, ArrayType):
            return self._array(kind)
        assert isinstance(kind, ElementaryType)
        if kind.name == "BOOL":
            return self.chance(self._on)
        if name == "phase":
            return self.random.choice((0, 1, 1, 2, 2, 255))
        if kind.name in ANY_REAL:
            return self._real(kind.name)
        if kind.name == "STRING":
            return self._text()[: string_length(kind)]
        if kind.name == "CHAR":
            return chr(self._whole(0, 255))
        if kind.name in MOMENTS:
            time = self._time()
            return abs(time) if kind.name in ANY_DATE else time
        return self._whole(*INT_RANGE[kind.name])

    def _whole(self, low: int, high: int) -> int:
        draw = self.random
        way = draw.random()
        if way < 0.3:
            value = draw.choice(self._numbers)
        elif way < 0.6:
            value = draw.randint(-2, 18)
        elif way < 0.75:
            value = (1 << draw.randrange(high.bit_length())) + draw.randint(-1, 1)
            value *= draw.choice((1, -1))
        elif way < 0.85:
            value = draw.choice((low, high, low + 1, high - 1))
        else:
            value = draw.randint(low, high)
        return (value - low) % (high - low + 1) + low

    def _time(self) -> int:
        draw = self.random
        way = draw.random()
        if way < 0.3:
            return self.now - draw.choice((0, 1, 10, 99, 100, 101, 1000, 5000, 30_000)) * _MS
        if way < 0.6:
            return draw.choice((0, 1, 10, 100, 150, 500, 1000, 2000, 60_000)) * _MS
        if way < 0.7:
            return draw.choice((-1, -_MS, -100 * _MS, -5000 * _MS, 1, _MS - 1, _MS // 2))
        if way < 0.75:
            return draw.choice((_LIMIT, -_LIMIT - 1, 1 << 53, 1_728_000_000 * _MS))
        return draw.randint(-(1 << draw.randint(10, 62)), 1 << draw.randint(10, 62))

    def _real(self, name: str) -> float:
        draw = self.random
        way = draw.random()
        if way < 0.5:
            value = draw.choice(_REALS)
        elif way < 0.8:
            value = round(draw.uniform(-10_000, 10_000), draw.randint(0, 3))
        else:
            value = math.ldexp(draw.uniform(-1, 1), draw.randint(-150, 129))
        return c_float(value).value if name == "REAL" else value

    def _text(self) -> str:
        draw = self.random
        size = draw.choice((0, 1, 1, 2, 8, 8, 16, draw.randint(0, 40), STRING_MAX))
        letters = [draw.choice(_PRINTABLE) for _ in range(size)]
        if letters and self.chance(0.3):
            odd = (0, 10, 32, 32, 39, 127, 176, 255)
            letters[draw.randrange(size)] = chr(draw.choice(odd))
        return "".join(letters)

    def _array(self, kind: ArrayType) -> list[Any]:
        count, share = array_length(kind), self.random.choice((0.0, 0.05, 0.5, 1.0))
        blank = False if getattr(kind.element, "name", "") == "BOOL" else 0
        return [self.value(kind.element) if self.chance(share) else blank for _ in range(count)]
