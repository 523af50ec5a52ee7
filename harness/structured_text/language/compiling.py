"""What compiling asks of Python: room for deep recursion, and no search for cycles meanwhile."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

__all__ = ["MOST_OPERATORS", "deeply", "uncollected"]

#: Operators, brackets and calls of one expression that may lie inside each other; those of a sum
#: of so many terms do.
MOST_OPERATORS = 10_000

_STACK, _FRAMES = 256 << 20, 100_000

_T = TypeVar("_T")


def deeply(work: Callable[[], _T]) -> _T:
    """What `work` gives; where Python's usual stack is too small, it is done again on a large one.

    Raises:
        RecursionError: that was too small, too.
    """
    try:
        return work()
    except RecursionError:
        pass
    results: list[_T] = []
    errors: list[BaseException] = []

    def run() -> None:
        try:
            results.append(work())
        except BaseException as error:
            errors.append(error)

    frames, stack = sys.getrecursionlimit(), threading.stack_size(_STACK)
    try:
        sys.setrecursionlimit(max(frames, _FRAMES))
        thread = threading.Thread(target=run, daemon=True)
        thread.start()
        thread.join()
    finally:
        threading.stack_size(stack)
        sys.setrecursionlimit(frames)
    if errors:
        raise errors[0]
    return results[0]


@contextmanager
def uncollected() -> Iterator[None]:
    """Pause Python's search for unreachable cycles: a tree that is being built has none.

    Without this, a seventh of the time that a library takes to compile goes into that search.
    """
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()
