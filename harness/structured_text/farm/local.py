"""Workers that are processes of this computer.

Each worker has a pipe: items go in, pickled `Done` objects come out. If a pipe ends, its worker has
ended: the first of its items has failed, the others were not begun.
"""

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

#: Limit of the time of an item [s]. If items take less, each worker gets its next item in advance.
#: If they take longer, an item in advance would wait although another worker may be free.
_SHORT_S = 0.5
_ENDS_WITHIN_S = 5.0
#: Time for a worker to remove its temporary files if it must end during an item [s].
_GRACE_S = 2.0


@dataclass
class _Worker:
    """A process, our end of its pipe, and the numbers of its items in order of execution."""

    process: SpawnProcess
    pipe: Connection[Any, Any]
    numbers: deque[int]
    since_s: float = 0.0
    """The time at which the first item was started [s], by the clock of this process."""


class LocalCrew:
    """A crew of processes on this computer; a process that ends is replaced."""

    attempts = 3

    def __init__(self, work: Work[Any, Any], size: int) -> None:
        self._work = pickle.dumps(work)
        self.size = size
        self._workers: list[_Worker] = []
        self._depth = 1
        self._close = weakref.finalize(self, _end, self._workers)

    def has_room(self) -> bool:
        """Return whether a new item would be started now or soon."""
        return len(self._workers) < self.size or len(self._freest().numbers) < self._depth

    def give(self, number: int, item: Any) -> None:
        """Give an item, with its number, to a process."""
        if len(self._workers) < self.size and all(one.numbers for one in self._workers):
            self._workers.append(self._started())
        worker = self._freest()
        if not worker.numbers:
            worker.since_s = time.monotonic()
        worker.numbers.append(number)
        with suppress(OSError):  # the process has ended, which the end of its pipe will report
            worker.pipe.send_bytes(pickle.dumps(item))

    def ended(self) -> Iterator[tuple[int, Ended]]:
        """Wait until items end; yield their numbers and outcomes."""
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
        """End all processes, even if they are executing items."""
        self._close()

    def _started(self) -> _Worker:
        pipes: Any = get_context("spawn").Pipe()  # the class of a pipe differs between systems
        ours, theirs = pipes
        process = get_context("spawn").Process(target=_serve, args=(theirs, self._work))
        with interrupts_later():
            process.start()
        theirs.close()
        return _Worker(process, ours, deque())


def _end(workers: list[_Worker]) -> None:
    """End the processes; a process that executes an item gets time to remove temporary files."""
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
    _kill(process)  # the child processes of the worker may still run
    code = process.exitcode
    if code is not None and code < 0:
        with suppress(ValueError):
            return f"ended by {signal.Signals(-code).name}"
    return f"ended with exit code {code}"


def _serve(pipe: Connection[Any, Any], work: bytes) -> None:
    """Execute items until the pipe is closed, which happens at the latest when the parent ends."""
    be_apart()
    items: SimpleQueue[bytes | None] = SimpleQueue()
    busy = Event()
    # A thread reads the pipe all the time. Otherwise both sides could block while they write.
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
        interrupt_main_thread()  # nobody reads the result any more
    items.put(None)
    time.sleep(_GRACE_S)
    end_apart(os.getpid())
