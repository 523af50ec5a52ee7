"""Steps of a search that the workers of a farm take, for a few states at a time."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from structured_text.errors import InputError
from structured_text.explore.search import Ready, Taken, Transition, World, steps
from structured_text.farm import NOT_YET, Farm, NotYet

__all__ = ["Some", "Stepping", "shared"]

#: A parcel contains the waiting states divided by `SHARE`, so that all workers get some, and at
#: most `MOST` states, so that it takes only a moment.
SHARE, MOST = 128, 32
#: Number of keys that a worker remembers because their states need not be sent again.
_REMEMBERED = 1 << 19

#: The steps from a state, each as a tuple, and the error after the last step, if any.
_Came = tuple[Sequence[Any], InputError | None]


class Some(NamedTuple):
    """A parcel of states for a worker: the number of its first state, and the states."""

    first: int
    states: Sequence[bytes]

    def __repr__(self) -> str:
        last = self.first + len(self.states) - 1
        return f"state {last}" if last == self.first else f"states {self.first} to {last}"


@dataclass(frozen=True)
class Stepping:
    """The task of a worker.

    Attributes:
        make: Creates the world; can be pickled.
        seed: See `steps`.
    """

    make: Callable[[], World[Any]]
    seed: int

    def prepare(self) -> Callable[[Some], list[_Came]]:
        """Create the world; return the function that takes the steps from some states."""
        return partial(_take, self.make(), self.seed, {})


def _take(world: World[Any], seed: int, sent: dict[bytes, int], some: Some) -> list[_Came]:
    """Take the steps from some states.

    Args:
        world: The world.
        seed: See `steps`.
        sent: Keys of the states that this worker has received or sent, each with the number of its
            parcel. New keys are added. A key of an earlier parcel counts as known, because the
            search merges that parcel first.
        some: The states.
    """
    here = some.first

    def is_known(key: bytes) -> bool:
        if sent.get(key, here + 1) <= here:
            return True
        sent[key] = here
        return False

    if len(sent) > _REMEMBERED:
        sent.clear()
    states = [world.unpacked(one) for one in some.states]
    sent.update((world.known_as(state), 0) for state in states)
    found = enumerate(states, here)
    return [_came(steps(world, number, state, seed, is_known)) for number, state in found]


def _came(found: Iterator[Transition]) -> _Came:
    taken = []
    try:
        for step in found:
            taken.append(tuple(step))
            if step.broken:
                break
    except InputError as error:
        return taken, error
    return taken, None


def shared(farm: Farm, work: Stepping) -> Callable[[Ready], Generator[Taken, None, None]]:
    """Return a function that takes the steps on a farm; its workers live until the search ends."""

    def taken(ready: Ready) -> Generator[Taken, None, None]:
        with closing(farm.run(work, _parcels(ready), title=None)) as running:
            for some, came in running:
                for place, (found, error) in enumerate(came):
                    yield some.first + place, some.states[place], _steps(found, error)

    return taken


def _parcels(ready: Ready) -> Iterator[Some | NotYet]:
    while True:
        number, states = ready.take(min(MOST, 1 + len(ready) // SHARE))
        if states:
            yield Some(number, states)
        elif ready.may_come():
            yield NOT_YET
        else:
            return


def _steps(found: Iterable[Any], error: InputError | None) -> Iterator[Transition]:
    yield from (Transition(*one) for one in found)
    if error is not None:
        raise error
