"""What `rcx run` tells on the way and at the end."""

from __future__ import annotations

import os
import shutil
import sys
import time
from threading import Timer
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

from rcx_harness.cli.run import Outcome
from rcx_harness.trace.chart import text_chart
from rcx_harness.units import format_us

__all__ = ["RunProgress", "print_outcome"]

#: Nothing is said of what takes less than this [s of real time].
_PATIENCE_S = 2.0
_MOST_SHOWN = 20


class RunProgress:
    """Progress on stderr: a bar on a terminal, else a plain line every two seconds."""

    def __init__(self) -> None:
        self._bar = Progress(
            TextColumn("running"),
            BarColumn(),
            TextColumn("{task.completed:.1f} of {task.total:.1f} s"),
            TimeRemainingColumn(),
            console=Console(stderr=True),
            transient=True,
        )
        self._task: TaskID | None = None
        self._told = time.monotonic()
        self._compiling = Timer(_PATIENCE_S, _say, ["compiling ..."])
        self._compiling.daemon = True

    def __enter__(self) -> RunProgress:
        self._compiling.start()
        return self

    def __call__(self, done_us: int, total_us: int) -> None:
        """Tell how far it is, in virtual microseconds."""
        self._compiling.cancel()
        if not sys.stderr.isatty():
            if time.monotonic() - self._told >= _PATIENCE_S:
                self._told = time.monotonic()
                _say(f"running: {done_us / 1e6:.1f} of {total_us / 1e6:.1f} s")
            return
        if self._task is None:
            self._bar.start()
            self._task = self._bar.add_task("run", total=total_us / 1e6)
        self._bar.update(self._task, completed=done_us / 1e6)

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._compiling.cancel()
        if self._task is not None:
            self._bar.stop()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def print_outcome(outcome: Outcome, *, show: bool) -> None:
    """Print chart (if wanted), violations and summary."""
    if show:
        width = min(shutil.get_terminal_size((100, 24)).columns, 120)
        print(text_chart(outcome.timeline, width, ascii_only=not _unicode()))
    if outcome.notice:
        print(outcome.notice)
    if not outcome.matched:
        print("no connection: the areas of PLC and robot differ in size")
    elif not outcome.ever_connected:
        print("no connection in the whole run")
    for violation in outcome.violations[:_MOST_SHOWN]:
        print(f"violation at {format_us(violation.t_us)}: {violation.text}")
    rest = len(outcome.violations) - _MOST_SHOWN
    if rest > 0:
        print(f"... and {_count(rest, 'further violation')}")
    print(
        f"{outcome.duration_us / 1e6:g} s on the {outcome.engine} engine: "
        f"{_count(outcome.scans, 'scan')}, {_count(outcome.cycles, 'controller cycle')}, "
        f"{_count(outcome.commands, 'remote command')}, "
        f"{_count(len(outcome.violations), 'violation')}"
    )
    if outcome.written:
        print("written: " + ", ".join(os.fspath(path) for path in outcome.written))


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def _unicode() -> bool:
    return "utf" in (sys.stdout.encoding or "").lower()
