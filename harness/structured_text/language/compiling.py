"""Settings of Python while it compiles: a larger stack, and no garbage collection."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeVar

__all__ = ["MOST_OPERATORS", "deeply", "uncollected"]

#: Deepest nesting of operators, brackets and calls in an expression. A sum of n terms is n deep.
MOST_OPERATORS = 10_000

_STACK, _FRAMES = 256 << 20, 100_000

_T = TypeVar("_T")


def deeply(work: Callable[[], _T]) -> _T:
    """Return the result of `work`; repeat it on a large stack if the usual one is too small.

    Raise RecursionError if the large stack was too small, too.
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
    """Pause Python's search for unreachable cycles.

    A tree under construction has none. Without the pause, the search takes a seventh of the time
    that a library needs to compile.
    """
    running = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if running:
            gc.enable()
