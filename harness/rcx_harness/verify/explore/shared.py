"""Steps taken by the workers of a farm: a few states at a time, all that may happen in each."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, NamedTuple

from rcx_harness.errors import InputError
from rcx_harness.verify.explore.search import Ready, Step, Taken, World, steps
from rcx_harness.verify.farm import NOT_YET, Farm, NotYet

__all__ = ["Stepping", "shared"]

#: States that go to a worker together: one of so many that wait, so that all workers get some, and
#: no more than are done in a moment.
_SHARE, _MOST = 128, 32

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
        world, seed = self.make(), self.seed

        def take(some: Some) -> list[_Came]:
            sent = {world.known_as(state) for state in some.states}
            places = enumerate(some.states, some.first)
            return [_taken(world, number, state, seed, sent) for number, state in places]

        return take


def _taken(world: World[Any], number: int, state: bytes, seed: int, sent: set[bytes]) -> _Came:
    """The steps from a state; a next state is sent once, and none of those that were given."""
    found = []
    try:
        for step in steps(world, number, state, seed):
            following = b"" if step.key in sent else step.following
            sent.add(step.key)
            found.append(tuple(step._replace(following=following)))
            if step.broken:
                break
    except InputError as error:
        return found, error
    return found, None


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
        number, states = ready.take(min(_MOST, 1 + len(ready) // _SHARE))
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
