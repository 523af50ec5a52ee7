"""What is to be done, and what became of it, whoever does it."""

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
        """Set up (say, compile the program); what then does one item."""


Work = Callable[[ItemIn], ResultOut] | Prepared[ItemIn, ResultOut]
"""A function of the top level of a module, or an object to be prepared; either can be pickled."""


class LostError(InputError):
    """Something that none of the workers gets through: their processes end with it."""

    exit_code = 1


class RemoteError(Exception):
    """The cause of an error that came from a worker: its traceback there."""

    def __str__(self) -> str:
        return f"in a worker:\n{self.args[0]}"


@dataclass(frozen=True)
class Lost(Generic[Item]):
    """An item whose workers have ended by themselves, each time."""

    item: Item
    times: int
    """How many workers have ended with it."""
    why: str
    """How the last one ended, for people."""

    def error(self) -> LostError:
        """The same as an error."""
        return LostError(
            f"{self.times} workers have ended with {self.item!r}, {self.why}",
            hint="is there memory enough for all of them",
        )


@dataclass(frozen=True)
class Done:
    """A result, or the error that came instead."""

    result: Any = None
    error: Exception | None = None
    where: str = ""
    """The traceback of an error that is nobody's input."""
    is_lost: bool = False
    """It says that there is none: another time there may be one."""

    def get(self) -> Any:
        """The result.

        Raises:
            Exception: the error, as it was raised.
        """
        if self.error is None:
            return self.result
        raise self.error from (RemoteError(self.where) if self.where else None)


@dataclass(frozen=True)
class Died:
    """No answer: the worker has ended.

    Attributes:
        why: How it has ended, for people.
        workers: So many have, one after the other.
    """

    why: str
    workers: int = 1


@dataclass(frozen=True)
class NotBegun:
    """No answer, and not by this item: the worker has ended with another one."""


Ended = Done | Died | NotBegun


def doer(work: Work[Any, Any]) -> Callable[[Any], Any]:
    """Set up in this process; what does one item."""
    prepare = getattr(work, "prepare", None)
    return work if prepare is None else prepare()  # type: ignore[return-value]


def attempt(do: Callable[[], Any]) -> bytes:
    """Do something; a pickled `Done`, whatever comes of it."""
    try:
        return pickle.dumps(Done(do()))
    except KeyboardInterrupt:
        raise
    except BaseException as one:  # also SystemExit, which would end the worker, or this process
        error = one if isinstance(one, Exception) else RuntimeError(repr(one))
        if isinstance(error, InputError):
            return pickle.dumps(Done(error=error))
        where = "".join(traceback.format_exception(type(one), one, one.__traceback__))
    try:
        kept = pickle.dumps(Done(error=error, where=where))
        pickle.loads(kept)
    except Exception:  # an error that cannot travel
        return pickle.dumps(Done(error=RemoteError(where)))
    return kept
