"""Steps taken by the workers of a farm: a few states at a time, all that may happen in each."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.verify.explore.search import Ready, Step, Taken, World, steps
from rcx_harness.verify.farm import NOT_YET, Farm, NotYet

__all__ = ["Stepping", "shared"]

#: States that go to a worker together: one of so many that wait, so that all workers get some, and
#: no more than are done in a moment.
_SHARE, _MOST = 128, 32

#: The number of the first of some states, and them.
_Some = tuple[int, Sequence[bytes]]
#: The steps from a state, each as a tuple, and what was raised behind the last one.
_Came = tuple[Sequence[Any], InputError | None]


@dataclass(frozen=True)
class Stepping:
    """What a worker does.

    Attributes:
        make: Makes the world; can be pickled.
        seed: See `steps`.
    """

    make: Callable[[], World[Any]]
    seed: int

    def prepare(self) -> Callable[[_Some], list[_Came]]:
        """Make the world; what then takes the steps from some states."""
        world, seed = self.make(), self.seed

        def take(some: _Some) -> list[_Came]:
            first, states = some
            sent = {world.known_as(state) for state in states}
            came: list[_Came] = []
            for number, state in enumerate(states, first):
                came.append(_taken(world, number, state, seed, sent))
                if came[-1][1] is not None:
                    break
            return came

        return take


def _taken(
    world: World[Any], number: int, state: bytes, seed: int, sent: set[bytes]
) -> _Came:
    """The steps from a state; a next state is sent once, and none of those that were given."""
    found = []
    try:
        for step in steps(world, number, state, seed):
            following = b"" if step.told in sent else step.following
            sent.add(step.told)
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
            for (first, states), came in running:
                for place, (found, error) in enumerate(came):
                    yield first + place, states[place], _told(found, error)

    return taken


def _parcels(ready: Ready) -> Iterator[_Some | NotYet]:
    while True:
        number, states = ready.take(min(_MOST, 1 + len(ready) // _SHARE))
        if states:
            yield number, states
        elif ready.may_come():
            yield NOT_YET
        else:
            return


def _told(found: Iterable[Any], error: InputError | None) -> Iterator[Step]:
    yield from (Step(*one) for one in found)
    if error is not None:
        raise error
