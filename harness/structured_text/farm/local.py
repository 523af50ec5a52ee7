"""Workers that are processes of this computer."""

from __future__ import annotations

import os
import pickle
import signal
import time
import weakref
from collections import deque
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from queue import SimpleQueue
from threading import Event, Thread
from typing import Any

from structured_text.farm.work import Died, Done, Ended, NotBegun, Work, attempt, doer
from structured_text.output.system import (
    be_apart,
    end_apart,
    interrupt_main_thread,
    interrupts_later,
)

__all__ = ["LocalCrew"]

#: A worker has the next item already when it has done one, if they take less than this [s]; behind
#: one that takes long it would wait while another worker is free.
_SHORT_S = 0.5
_ENDS_WITHIN_S = 5.0
#: So long has a worker that is to end in the middle of an item for what is temporary [s].
_GRACE_S = 2.0


@dataclass
class _Worker:
    """A process, our end of its pipe, and which items it has, the one that it does first."""

    process: SpawnProcess
    pipe: Connection[Any, Any]
    numbers: deque[int]
    since_s: float = 0.0
    """When it began with the first of them, as far as can be seen from here."""


class LocalCrew:
    """So many processes; one that ends is replaced.

    Args:
        work: What each of them does with an item.
        size: How many, at least 1.
    """

    attempts = 3

    def __init__(self, work: Work[Any, Any], size: int) -> None:
        self._work = pickle.dumps(work)
        self.size = size
        self._workers: list[_Worker] = []
        self._depth = 1
        self._close = weakref.finalize(self, _end, self._workers)

    def has_room(self) -> bool:
        """Would an item be begun now, or soon?"""
        return len(self._workers) < self.size or len(self._freest().numbers) < self._depth

    def give(self, number: int, item: Any) -> None:
        """Begin an item under a number of its own."""
        if len(self._workers) < self.size and all(one.numbers for one in self._workers):
            self._workers.append(self._started())
        worker = self._freest()
        if not worker.numbers:
            worker.since_s = time.monotonic()
        worker.numbers.append(number)
        with suppress(OSError):  # it has ended meanwhile; its pipe says so
            worker.pipe.send_bytes(pickle.dumps(item))

    def ended(self) -> Iterator[tuple[int, Ended]]:
        """Wait until some have ended; which, and how."""
        ready = wait([one.pipe for one in self._workers if one.numbers])
        for worker in [one for one in self._workers if one.pipe in ready]:
            try:
                done: Done = pickle.loads(worker.pipe.recv_bytes())
            except (EOFError, OSError):
                self._workers.remove(worker)
                worker.pipe.close()
                yield worker.numbers.popleft(), Died(_why(worker.process))
                yield from ((number, NotBegun()) for number in worker.numbers)
            else:
                took_s, worker.since_s = time.monotonic() - worker.since_s, time.monotonic()
                self._depth = 2 if took_s < _SHORT_S else 1
                yield worker.numbers.popleft(), done

    def _freest(self) -> _Worker:
        return min(self._workers, key=lambda one: len(one.numbers))

    def close(self) -> None:
        """End all of them, whatever they are doing."""
        self._close()

    def _started(self) -> _Worker:
        pipes: Any = get_context("spawn").Pipe()  # each system has a class of its own
        ours, theirs = pipes
        process = get_context("spawn").Process(target=_serve, args=(theirs, self._work))
        with interrupts_later():
            process.start()
        theirs.close()
        return _Worker(process, ours, deque())


def _end(workers: list[_Worker]) -> None:
    """End them; those in the middle of an item may remove what is temporary."""
    for worker in workers:
        worker.pipe.close()
        if not worker.numbers:
            _kill(worker.process)
    end_s = time.monotonic() + _GRACE_S
    for worker in workers:
        worker.process.join(max(0.0, end_s - time.monotonic()))
        _kill(worker.process)
        worker.process.join()
    workers.clear()


def _kill(process: SpawnProcess) -> None:
    if process.pid is not None:
        end_apart(process.pid, has_ended=process.exitcode is not None)


def _why(process: SpawnProcess) -> str:
    process.join(_ENDS_WITHIN_S)
    _kill(process)  # what it has started may still be there
    code = process.exitcode
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"


def _serve(pipe: Connection[Any, Any], work: bytes) -> None:
    """Do one item after the other until the pipe is closed, at the latest by the parent's end."""
    be_apart()
    items: SimpleQueue[bytes | None] = SimpleQueue()
    busy = Event()
    # The pipe is always read, so that nobody waits for room in it while the other side writes.
    Thread(target=_read, args=(pipe, items, busy), daemon=True).start()
    do: Any = None

    def one(item: bytes) -> Any:
        nonlocal do
        do = do or doer(pickle.loads(work))
        return do(pickle.loads(item))

    with suppress(OSError, KeyboardInterrupt):
        for item in iter(items.get, None):
            busy.set()
            result = attempt(partial(one, item))
            busy.clear()
            pipe.send_bytes(result)


def _read(pipe: Connection[Any, Any], items: SimpleQueue[bytes | None], busy: Event) -> None:
    with suppress(EOFError, OSError):
        while True:
            items.put(pipe.recv_bytes())
    if busy.is_set():
        interrupt_main_thread()  # nobody waits for the result
    items.put(None)
    time.sleep(_GRACE_S)
    end_apart(os.getpid())
