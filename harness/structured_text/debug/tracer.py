"""One scan under the interpreter's trace hook, which can stop before every statement.

The program's code is the same with and without the hook. A stop is a call of the hook that blocks
until the user continues. A scan is left in its middle by an exception, which no program catches.
Each statement counts as a step of the scan. A line of a device's program that begins during the
scan also counts as a step.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from types import FrameType
from typing import Any

from structured_text.debug.devices import Devices, DeviceStep
from structured_text.debug.places import Code, Places

__all__ = ["Entry", "Lines", "Tracer"]

#: Traced lines of the generated Python module, by the upper-case name of the POU.
Lines = Mapping[str, frozenset[int]]


@dataclass
class Entry:
    """An active call of a POU: its code, its Python frame, and its position.

    Attributes:
        line: Line of the source with the statement that runs, or is about to run.
        at: Line of the Python module for the same statement.
        fresh: Whether this statement is the first one of the call.
    """

    code: Code
    frame: FrameType
    line: int = 0
    at: int = 0
    fresh: bool = True


class Tracer:
    """The trace hooks on the statements of a program, for one scan at a time.

    Attributes:
        stack: The active calls of POUs, the program first.
        depths: Call depth of each statement of this scan so far, from 1.
        tasks: The task of a device for each step of this scan; 0 for a statement of the program.
        device: The line of a device's program that is about to begin; None at a statement.
        roots: Number of programs that have begun in this scan.
    """

    def __init__(self, places: Places, devices: Devices | None = None) -> None:
        self.places = places
        self.stack: list[Entry] = []
        self.depths: list[int] = []
        self.tasks: list[int] = []
        self.device: DeviceStep | None = None
        self.roots = 0
        self._devices = devices
        self._look: Callable[[], None] = lambda: None
        self._lines: Lines = {}
        self._hit: Callable[[Code, int, FrameType], None] = lambda *_: None

    @property
    def step(self) -> int:
        """Return the number of the current statement in its scan, from 1; 0 between two scans."""
        return len(self.depths)

    def clear(self) -> None:
        """Reset the hooks to their state between two scans."""
        self.stack, self.depths, self.tasks, self.roots = [], [], [], 0
        self.device = None

    def every(self, scan: Callable[[], None], look: Callable[[], None]) -> None:
        """Run a scan; call `look` before each statement."""
        self.clear()
        self._look = look
        self._run(scan, self._call, self._step_of_device)

    def some(
        self,
        scan: Callable[[], None],
        lines: Lines,
        hit: Callable[[Code, int, FrameType], None],
        device: Callable[[DeviceStep], None] | None = None,
    ) -> None:
        """Run a scan; call `hit` only before statements in the given lines.

        `device` is called before each line of a device's program.
        """
        self.clear()
        self._lines, self._hit = lines, hit
        self._run(scan, self._call_of_some if lines else None, device)

    def _run(
        self, scan: Callable[[], None], trace: Any, device: Callable[[DeviceStep], None] | None
    ) -> None:
        before = sys.gettrace()
        if self._devices is not None:
            self._devices.watch(device)
        if trace is not None:
            sys.settrace(trace)
        try:
            scan()
        finally:
            sys.settrace(before)
            if self._devices is not None:
                self._devices.watch(None)

    # --- lines of devices ---

    def _step_of_device(self, step: DeviceStep) -> None:
        """Count a line of a device's program as a step of the scan."""
        self.device = step
        self.depths.append(step.depth)
        self.tasks.append(step.task)
        trace = sys.gettrace()
        sys.settrace(None)  # the debugger itself calls POUs when it evaluates an expression
        try:
            self._look()
        finally:
            sys.settrace(trace)

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
                    self.device = None
                    self.depths.append(len(self.stack))
                    self.tasks.append(0)
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
