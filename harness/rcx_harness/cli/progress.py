"""Progress of long commands, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Timer

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeRemainingColumn

__all__ = ["RunProgress", "progress_bar"]

#: Shortest work for which progress is shown [s of real time].
_PATIENCE_S = 2.0


@contextmanager
def progress_bar(what: str, shown: bool) -> Iterator[Callable[[float], None]]:
    """Progress on stderr: a bar if the terminal shows nothing else, otherwise occasional lines.

    `what` names the work, such as `reading`. `shown` is False if the command prints its own lines
    of progress.
    """
    if shown and sys.stderr.isatty():
        with Progress(console=Console(stderr=True), transient=True) as drawn:
            task = drawn.add_task(what, total=1.0)
            yield lambda share: drawn.update(task, completed=share)
        return
    told = time.monotonic()

    def tell(share: float) -> None:
        nonlocal told
        if shown and time.monotonic() - told >= _PATIENCE_S:
            told = time.monotonic()
            print(f"{what}: {share:.0%}", file=sys.stderr, flush=True)

    yield tell


class RunProgress:
    """Progress of a run on stderr: a bar on a terminal, else a plain line every two seconds."""

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
        """Show the progress; the arguments are virtual times in microseconds."""
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

    def __exit__(self, *of: object) -> None:
        self._compiling.cancel()
        if self._task is not None:
            self._bar.stop()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)
