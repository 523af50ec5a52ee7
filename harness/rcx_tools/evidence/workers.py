"""Work shared out to several processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import TypeVar

from rcx_harness.enip.errors import ProcessDiedError

__all__ = ["results"]

Job = TypeVar("Job")
Result = TypeVar("Result")


def results(run: Callable[[Job], Result], jobs: Sequence[Job], workers: int) -> Iterator[Result]:
    """Results as they come, in any order.

    Raises:
        ProcessDiedError: a worker has ended by itself; `multiprocessing.Pool` would wait for ever.
    """
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        waiting = [pool.submit(run, job) for job in jobs]
        try:
            for one in as_completed(waiting):
                yield one.result()
        except BrokenProcessPool:
            raise ProcessDiedError(
                "a worker has ended by itself", hint="is there memory enough for all of them"
            ) from None
        finally:
            for one in waiting:
                one.cancel()
