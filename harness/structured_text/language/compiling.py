"""Settings of Python while it compiles: a larger stack, and no garbage collection."""

from __future__ import annotations

import gc
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TypeVar

__all__ = ["MOST_OPERATORS", "deeply", "uncollected"]

#: Deepest nesting of operators, brackets and calls in an expression. A sum of n terms has a depth
#: of n.
MOST_OPERATORS = 10_000

_STACK, _FRAMES = 256 << 20, 100_000

_T = TypeVar("_T")


def deeply(work: Callable[[], _T]) -> _T:
    """Return the result of `work`; on a stack overflow, run `work` again on a larger stack.

    Raise RecursionError if even the large stack is too small.
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
    """Pause Python's search for unreachable cycles, until the last of several pauses has ended.

    A tree under construction has no such cycle. Without the pause, the search takes a seventh of
    the time that a library needs to compile.
    """
    with _pauses.lock:
        if not _pauses.count:
            _pauses.was_enabled = gc.isenabled()
            gc.disable()
        _pauses.count += 1
    try:
        yield
    finally:
        with _pauses.lock:
            _pauses.count -= 1
            if not _pauses.count and _pauses.was_enabled:
                gc.enable()


@dataclass
class _Pauses:
    """The number of pauses that have not ended yet, in all threads."""

    lock: threading.Lock = field(default_factory=threading.Lock)
    count: int = 0
    was_enabled: bool = True


_pauses = _Pauses()
