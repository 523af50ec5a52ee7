"""Steps taken by the workers of a farm: a few states at a time, all that may happen in each."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

from structured_text.errors import InputError
from structured_text.explore.search import Ready, Step, Taken, World, steps
from structured_text.farm import NOT_YET, Farm, NotYet

__all__ = ["MOST", "SHARE", "Stepping", "shared"]

#: States that go to a worker together: one of so many that wait, so that all workers get some, and
#: no more than are done in a moment.
SHARE, MOST = 128, 32
#: A worker remembers so many states that need not be sent.
_REMEMBERED = 1 << 19

#: The steps from a state, each as a tuple, and what was raised behind the last one.
_Came = tuple[Sequence[Any], InputError | None]


class Some(NamedTuple):
    """States that go to a worker together: the number of the first, and them."""

    first: int
    states: Sequence[bytes]

    def __repr__(self) -> str:
        last = self.first + len(self.states) - 1
        return f"state {last}" if last == self.first else f"states {self.first} to {last}"


@dataclass(frozen=True)
class Stepping:
    """What a worker does.

    Attributes:
        make: Makes the world; can be pickled.
        seed: See `steps`.
    """

    make: Callable[[], World[Any]]
    seed: int

    def prepare(self) -> Callable[[Some], list[_Came]]:
        """Make the world; what then takes the steps from some states."""
        return partial(_take, self.make(), self.seed, {})


def _take(world: World[Any], seed: int, sent: dict[bytes, int], some: Some) -> list[_Came]:
    """The steps from some states.

    Args:
        world: The world.
        seed: See `steps`.
        sent: What tells those states apart that were given or sent, and with which item: they are
            known where the items before this one are. Changed in place.
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


def _came(found: Iterator[Step]) -> _Came:
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
    """Takes the steps from states on a farm, whose workers stay to the end of the exploration."""

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


def _steps(found: Iterable[Any], error: InputError | None) -> Iterator[Step]:
    yield from (Step(*one) for one in found)
    if error is not None:
        raise error
