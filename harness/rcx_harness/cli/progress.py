"""Progress of long commands, on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import Progress

__all__ = ["progress_bar"]

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
