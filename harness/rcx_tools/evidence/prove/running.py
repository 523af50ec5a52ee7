"""Runs jobs in processes of their own; one that dies is an outcome, not the end of the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any, Protocol, TypeVar

from rcx_harness.enip.errors import ProcessDiedError
from rcx_tools.evidence.workers import results

__all__ = ["DIED", "HasKey", "outcomes"]

#: Why there is no answer, where the operating system has ended the process.
DIED = "the process of the solver has ended by itself; is there memory enough"


class HasKey(Protocol):
    """Something to be run."""

    @property
    def key(self) -> str:
        """Names it, with all that its outcome depends on; also among the entries of the outcome."""


Job = TypeVar("Job", bound=HasKey)
Run = Callable[[Job], dict[str, Any]]


def outcomes(run: Run[Job], jobs: Sequence[Job], workers: int, died: Run[Job]) -> Iterator[Any]:
    """Outcomes as they come, in any order.

    Args:
        run: Runs a job.
        jobs: What is to be run.
        workers: How many at a time; 0: in this process.
        died: The outcome of a job whose process has died.
    """
    waiting = {job.key: job for job in jobs}
    if not waiting:
        return
    if not workers:
        yield from map(run, jobs)
        return
    try:
        for outcome in results(run, list(waiting.values()), workers):
            del waiting[outcome["key"]]
            yield outcome
    except ProcessDiedError:
        yield from _one_by_one(run, waiting.values(), died)


def _one_by_one(run: Run[Job], jobs: Any, died: Run[Job]) -> Iterator[Any]:
    """The rest, so that it is known which job a process has died of."""
    waiting = list(jobs)
    while waiting:
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            try:
                while waiting:
                    yield pool.submit(run, waiting[0]).result()
                    del waiting[0]
            except BrokenProcessPool:
                yield died(waiting.pop(0))
