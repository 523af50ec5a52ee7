"""Time and mocks for the tests of TEST files.

The generated tests call functions of the framework, which this module answers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from typing import Any

from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.types import BlockType

__all__ = ["Mocks"]

_UNITS_NS = {"d": 86_400 * 10**9, "h": 3_600 * 10**9, "m": 60 * 10**9, "s": 10**9}
_UNITS_NS |= {"ms": 10**6, "us": 10**3, "ns": 1}
_PART = re.compile(r"([0-9.]+)(ms|us|ns|d|h|m|s)", re.IGNORECASE)


class Mocks:
    """The mocks of the test that runs; `end` removes them.

    Attributes:
        path: A function that returns the path of the test's instance.
    """

    def __init__(self, program: BuiltinProgram, path: Callable[[], str]) -> None:
        self.path = path
        self._program = program
        self._active = ExitStack()
        self._calls: dict[int, int] = {}

    def answers(self, words: Mapping[str, str]) -> dict[str, Callable[..., Any]]:
        """Return the Python functions that answer calls of the framework's functions, by name."""
        return {
            words["advance"]: self.advance,
            words["mock"]: self.mock,
            words["calls"]: self.calls,
            words["returns"]: self.returns,
        }

    def end(self) -> None:
        """Remove all mocks."""
        self._active.close()
        self._calls.clear()

    def advance(self, text: str) -> bool:
        """Advance the time by a number of nanoseconds or a duration."""
        if re.fullmatch(r"[0-9]+", text):
            self._program.advance(int(text))
        else:
            parts = _PART.findall(text.partition("#")[2])
            self._program.advance(round(sum(float(a) * _UNITS_NS[b.lower()] for a, b in parts)))
        return True

    def mock(self, name: str) -> bool:
        """Replace each call of an instance by an increment of its counter."""
        path = f"{self.path()}.{name}"
        kind = self._program.type_of(path)
        if not isinstance(kind, BlockType):
            raise InputError(f"MOCK {name}: it is not a function block")
        place = id(self._program.holder(path))
        self._calls[place] = 0
        self._active.enter_context(self._program.skipping(kind.name, place, self._called))
        return True

    def _called(self, place: int) -> None:
        self._calls[place] += 1

    def calls(self, name: str) -> int:
        """Return the number of calls of a mocked instance; raise InputError if it is not mocked."""
        found = self._calls.get(id(self._program.holder(f"{self.path()}.{name}")))
        if found is None:
            raise InputError(f"MOCK_VERIFY: {name} is not mocked", hint=f"write MOCK {name}; first")
        return found

    def returns(self, name: str, variable: str) -> bool:
        """Let a function return the present value of a variable of the test."""
        holder = self._program.holder(self.path())
        value = getattr(holder, variable.upper())
        self._active.enter_context(self._program.answering({name: lambda *_: value}))
        return True
