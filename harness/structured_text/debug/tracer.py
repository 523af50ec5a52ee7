"""Runs one scan and looks at every statement of it, with the interpreter's own hook.

The code that runs is the same with and without it. A stop is a call that does not return; leaving
a scan in its middle is an exception that no program sees.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import FrameType
from typing import Any

from structured_text.debug.places import Code, Places

__all__ = ["Entry", "Lines", "Tracer"]

#: Lines of the module that are looked at, by the upper-case name of the POU.
Lines = Mapping[str, frozenset[int]]


@dataclass
class Entry:
    """A POU under way: its code, its Python frame, and where it is.

    Attributes:
        line: Line of the source whose statement runs, or is about to.
        at: The same line of the module.
        fresh: Whether that is the first statement of this call.
    """

    code: Code
    frame: FrameType
    line: int = 0
    at: int = 0
    fresh: bool = True


class Tracer:
    """Looks at the statements of a program, one scan at a time.

    Attributes:
        stack: The POUs under way, the program first.
        depths: How deep each statement of this scan so far was called, from 1.
        roots: How many programs have begun in this scan.
    """

    def __init__(self, places: Places) -> None:
        self.places = places
        self.stack: list[Entry] = []
        self.depths: list[int] = []
        self.roots = 0
        self._look: Callable[[], None] = lambda: None
        self._lines: Lines = {}
        self._hit: Callable[[Code, int, FrameType], None] = lambda *_: None

    @property
    def step(self) -> int:
        """The number of the statement in its scan, from 1; 0 between two scans."""
        return len(self.depths)

    def clear(self) -> None:
        """Between two scans."""
        self.stack, self.depths, self.roots = [], [], 0

    def every(self, scan: Callable[[], None], look: Callable[[], None]) -> None:
        """Run a scan; `look` is called before each statement."""
        self.clear()
        self._look = look
        self._run(scan, self._call)

    def some(
        self,
        scan: Callable[[], None],
        lines: Lines,
        hit: Callable[[Code, int, FrameType], None],
    ) -> None:
        """Run a scan; `hit` is called before the statements in these lines only."""
        self.clear()
        self._lines, self._hit = lines, hit
        self._run(scan, self._call_of_some)

    def _run(self, scan: Callable[[], None], trace: Any) -> None:
        before = sys.gettrace()
        sys.settrace(trace)
        try:
            scan()
        finally:
            sys.settrace(before)

    # --- every statement ---

    def _call(self, frame: FrameType, event: str, arg: object) -> Any:
        code = self.places.of(frame.f_code)
        if code is None:
            return None
        if not self.stack:
            self.roots += 1
        self.stack.append(Entry(code, frame))
        return self._local

    def _local(self, frame: FrameType, event: str, arg: object) -> Any:
        if event == "line":
            entry = self.stack[-1]
            at = frame.f_lineno
            line = entry.code.begins.get(at)
            if line is not None and entry.frame is frame:
                came_from, entry.at = entry.at, at
                if entry.code.rounds.get(at, -1) != came_from:
                    entry.fresh = not entry.line
                    entry.line = line
                    self.depths.append(len(self.stack))
                    self._look()
        elif event == "return":
            self.stack.pop()
        return self._local

    # --- some lines ---

    def _call_of_some(self, frame: FrameType, event: str, arg: object) -> Any:
        key = self.places.key_of(frame.f_code)
        return self._local_of_some if key is not None and key in self._lines else None

    def _local_of_some(self, frame: FrameType, event: str, arg: object) -> Any:
        if event == "line":
            code = self.places.of(frame.f_code)
            assert code is not None
            at = frame.f_lineno
            if at in self._lines[code.pou.name.upper()]:
                self._hit(code, at, frame)
        return self._local_of_some
