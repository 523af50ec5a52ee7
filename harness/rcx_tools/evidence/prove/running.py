"""Runs jobs in processes of their own; one that dies is an outcome, not the end of the run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, TypeVar

from structured_text.farm import Farm, Lost

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
        jobs: What is to be run; of one key once.
        workers: How many at a time; 0: in this process.
        died: The outcome of a job whose process has died.
    """

    def lost(one: Lost[Job]) -> dict[str, Any]:
        return died(one.item)

    different = {job.key: job for job in jobs}.values()
    for _, outcome in Farm(workers).as_ready(run, different, lost=lost):
        yield outcome
