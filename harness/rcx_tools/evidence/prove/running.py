"""Execution of jobs in worker processes.

If a process dies, the job gets an outcome and others run on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from structured_text.farm import Farm, Lost

__all__ = ["DIED", "HasKey", "outcomes"]

#: Reason in the outcome if the operating system has ended the process.
DIED = "the process of the solver has ended by itself; is there memory enough"


class HasKey(Protocol):
    """Protocol of a job that has a key."""

    @property
    def key(self) -> str:
        """Return the key: a hash of the job and of all its inputs. The outcome contains the key."""


Job = TypeVar("Job", bound=HasKey)
Run = Callable[[Job], dict[str, Any]]


def outcomes(run: Run[Job], jobs: Sequence[Job], workers: int, died: Run[Job]) -> Iterator[Any]:
    """Run jobs, and yield each outcome as soon as it is known, in any order.

    Args:
        run: Function that runs a job.
        jobs: Jobs to run. If several jobs have the same key, only one of them is run.
        workers: Number of worker processes; 0 means that the jobs run in this process.
        died: Function that returns the outcome of a job whose process has died.
    """

    def lost(one: Lost[Job]) -> dict[str, Any]:
        return died(one.item)

    different = {job.key: job for job in jobs}.values()
    for _, outcome in Farm(workers).as_ready(run, different, lost=lost):
        yield outcome
