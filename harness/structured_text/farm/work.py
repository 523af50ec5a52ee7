"""The work of a farm, and the outcome of an item, in the form that all kinds of workers use."""

from __future__ import annotations

import pickle
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from structured_text.errors import InputError

__all__ = [
    "Died",
    "Done",
    "Ended",
    "Item",
    "Lost",
    "LostError",
    "NotBegun",
    "Prepared",
    "RemoteError",
    "Work",
    "attempt",
    "doer",
]

ItemIn = TypeVar("ItemIn", contravariant=True)
ResultOut = TypeVar("ResultOut", covariant=True)
Item = TypeVar("Item")


class Prepared(Protocol[ItemIn, ResultOut]):
    """Work with a set-up that each worker makes once, before its first item."""

    def prepare(self) -> Callable[[ItemIn], ResultOut]:
        """Set up (for example, compile the program) and return the function of one item."""


Work = Callable[[ItemIn], ResultOut] | Prepared[ItemIn, ResultOut]
"""A function at the top level of a module, or an object to be prepared; either is picklable."""


class LostError(InputError):
    """The error for an item that ended the process of each worker that tried it."""

    exit_code = 1


class RemoteError(Exception):
    """The cause of an error that came from a worker; its text is the traceback in the worker."""

    def __str__(self) -> str:
        return f"in a worker:\n{self.args[0]}"


@dataclass(frozen=True)
class Lost(Generic[Item]):
    """An item that has ended all workers that tried it."""

    item: Item
    times: int
    """Number of workers that have ended while they executed the item."""
    why: str
    """The reason why the last worker ended, in words for users."""

    def error(self) -> LostError:
        """Return the error to raise for the lost item."""
        return LostError(
            f"{self.times} workers died while they worked on {self.item!r}: {self.why}",
            hint="check that the memory is enough for all workers, or start fewer",
        )


@dataclass(frozen=True)
class Done:
    """The result of an item, or the error that the item raised."""

    result: Any = None
    error: Exception | None = None
    where: str = ""
    """The traceback of an error that is not an InputError."""
    is_lost: bool = False
    """True if no worker returned a result.

    Such an outcome is not saved, because another call may get a result.
    """

    def get(self) -> Any:
        """Return the result.

        Raises:
            Exception: The error, as it was raised in the worker.
        """
        if self.error is None:
            return self.result
        raise self.error from (RemoteError(self.where) if self.where else None)


@dataclass(frozen=True)
class Died:
    """The outcome of an item that has ended its worker.

    Attributes:
        why: The reason why the worker ended, in words for users.
        workers: Number of workers that the item has ended, one after the other.
    """

    why: str
    workers: int = 1


@dataclass(frozen=True)
class NotBegun:
    """The outcome of an item that was not begun, because its worker ended with another item."""


Ended = Done | Died | NotBegun


def doer(work: Work[Any, Any]) -> Callable[[Any], Any]:
    """Set up the work in this process and return the function of one item."""
    prepare = getattr(work, "prepare", None)
    return work if prepare is None else prepare()  # type: ignore[return-value]


def attempt(do: Callable[[], Any]) -> bytes:
    """Execute a function and return a pickled `Done` with its result or its error."""
    try:
        return pickle.dumps(Done(do()))
    except KeyboardInterrupt:
        raise
    # Also catches SystemExit, which would end the worker or this process.
    except BaseException as one:
        error = one if isinstance(one, Exception) else RuntimeError(repr(one))
        if isinstance(error, InputError):
            return pickle.dumps(Done(error=error))
        where = "".join(traceback.format_exception(type(one), one, one.__traceback__))
    try:
        kept = pickle.dumps(Done(error=error, where=where))
        pickle.loads(kept)
    except Exception:  # the error cannot be pickled
        return pickle.dumps(Done(error=RemoteError(where)))
    return kept
