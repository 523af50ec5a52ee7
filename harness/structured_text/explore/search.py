"""A breadth-first search of a world's reachable states, which finds a shortest trace first.

The steps from a state depend on nothing but the state and its number, so any process can take them
(`shared`). This module merges their results strictly in the order of the states. Therefore the
result does not depend on which process takes the steps.
"""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from array import array
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, field
from random import Random
from typing import Any, Generic, NamedTuple, Protocol, TypeVar

__all__ = [
    "Broken",
    "Choice",
    "Paths",
    "Ready",
    "Result",
    "Search",
    "Taken",
    "Transition",
    "World",
    "steps",
]

_OPEN = -1

#: From this number of states on, `World.look` checks all states whenever their number has doubled.
_FIRST_LOOK = 512


class _Numbered(Protocol):
    @property
    def number(self) -> int:
        """Return the index of the choice among all choices."""


Choice = TypeVar("Choice", bound=_Numbered)


@dataclass(frozen=True)
class Broken:
    """A broken rule, with a shortest path to it.

    Attributes:
        rules: The rules that are broken in the last scan, in words.
        path: The choices from the start on; the last one leads into the broken scan.
        quiet: For a hang: an identifier of the environment in which some action never ends.
    """

    rules: tuple[str, ...]
    path: tuple[Any, ...]
    quiet: Any = None


@dataclass
class Result:
    """The result of an exploration.

    Attributes:
        model: Name of the explored model.
        states: Number of different reachable states.
        transitions: Scans that were run and judged, one for each state and choice.
        depth: Scans from the start to the farthest state.
        complete: Whether every state is known. False if a rule was broken or a limit was reached.
        cut: Number of scans that lead to a state outside the search.
        checked: Number of scans that were repeated to check the abstraction.
        bounds: Highest number of scans until all actions have ended, by title of the environment.
        broken: The first rule that is broken.
    """

    model: str
    states: int = 0
    transitions: int = 0
    depth: int = 0
    complete: bool = False
    cut: int = 0
    checked: int = 0
    bounds: dict[str, int] = field(default_factory=dict)
    broken: Broken | None = None

    @property
    def met(self) -> bool:
        """Return whether the search is complete and no rule is broken."""
        return self.complete and self.broken is None


class World(ABC, Generic[Choice]):
    """An explored system: states as bytes, and the choices in each state."""

    @abstractmethod
    def first(self) -> bytes:
        """Return the state at the start."""

    @abstractmethod
    def choices(self, state: bytes) -> Sequence[Choice]:
        """Return the possible choices, at least one."""

    @abstractmethod
    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Take the step of a choice; return the next state and the broken rules, in words."""

    @abstractmethod
    def check(self, state: bytes, choice: Choice, following: bytes, random: Random) -> None:
        """Repeat a step with values drawn by `random` in all variables outside the state.

        Raises:
            Exception: The step leads to another state than `following`.
        """

    def known_as(self, state: bytes) -> bytes:
        """Return the key that identifies the state."""
        return state

    def packed(self, state: bytes) -> bytes:
        """Return a state in a compact form for the queue."""
        return state

    def unpacked(self, packed: bytes) -> bytes:
        """Return a state from its compact form."""
        return packed

    def is_cut(self) -> bool:
        """Return whether the state after the last step is outside the search."""
        return False

    def added(self) -> None:
        """Handle the event that the last step has led to a new state.

        Only the process that took the step calls this method.
        """

    def followed(self, number: int, choice: Choice, following: int) -> None:
        """Handle the event that a choice leads from state `number` to state `following`."""

    def entered(self, state: bytes) -> None:
        """Handle the event that the following steps start from this state."""

    def look(self, result: Result, states: Paths) -> None:
        """Check all states together, and store a broken rule in the result."""


class Paths(Protocol):
    """The paths to all known states."""

    def path(self, number: int, last: Any = None) -> tuple[Any, ...]:
        """Return the choices from the start to a state, followed by `last`."""


class Transition(NamedTuple):
    """A step from a state.

    Attributes:
        choice: The number of the choice.
        key: The key of the next state.
        following: The next state, packed; empty if it is known.
        is_cut: Whether the next state is outside the search.
        is_checked: Whether the step is repeated, before the next step, to check the abstraction.
        broken: The rules that are broken, in words.
    """

    choice: int
    key: bytes
    following: bytes
    is_cut: bool
    is_checked: bool
    broken: Sequence[str]


def steps(
    world: World[Any], number: int, state: bytes, seed: int, is_known: Callable[[bytes], bool]
) -> Iterator[Transition]:
    """Yield all steps from a state; one of them is checked.

    `seed` and `number` determine the checked step. If `is_known` returns true for the key of a next
    state, this state is not sent.

    Raises:
        Exception: A checked step leads to another state, see `World.check`.
    """
    random = Random(f"{seed} {number}")
    choices = world.choices(state)
    check = random.randrange(len(choices))
    for place, choice in enumerate(choices):
        following, broken = world.step(state, choice)
        key, is_cut = world.known_as(following), world.is_cut()
        is_checked = place == check and not is_cut
        sent = b"" if is_known(key) else world.packed(following)
        yield Transition(choice.number, key, sent, is_cut, is_checked, broken)
        if is_checked:
            world.check(state, choice, following, random)


class Ready:
    """The queue of packed states whose steps are not yet explored, in order of their numbers.

    Args:
        first: The first state.
        depths: Distance of each state from the start, in scans.
        limit: Explore the steps of at most this number of states; 0 stands for all.
        depth: Explore only states at less than this distance from the start; 0 stands for all.
    """

    def __init__(self, first: bytes, depths: Sequence[int], limit: int, depth: int) -> None:
        self._waiting, self._taken = deque([first]), 0
        self._depths, self._limit, self._depth = depths, limit, depth
        self.done = 0
        """The number of states whose steps are all known."""

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, state: bytes) -> None:
        """Append a state."""
        self._waiting.append(state)

    def take(self, most: int) -> tuple[int, list[bytes]]:
        """Remove up to `most` states; return the number of the first state, and all these states.

        If no state is waiting, `may_come` returns whether more can follow.
        """
        number = self._taken
        states: list[bytes] = []
        while self._waiting and len(states) < most and not self._is_end():
            states.append(self._waiting.popleft())
            self._taken += 1
        return number, states

    def may_come(self) -> bool:
        """Return whether steps in progress may still add a state."""
        return self.done < self._taken and not self._is_end()

    def _is_end(self) -> bool:
        number = self._taken
        if self._limit and number >= self._limit:
            return True
        deep = self._depth and number < len(self._depths) and self._depths[number] >= self._depth
        return bool(deep)


#: The number of a state, the state (packed), and the steps from it.
Taken = tuple[int, bytes, Iterable[Transition]]


class Search(Generic[Choice]):
    """The search through a world.

    Args:
        world: The world.
        every: All choices. The index of a choice is its number.
        seed: Seed for the choice of checked steps.
        elsewhere: A function that takes the steps in other processes, and yields them in the order
            of the states. By default this process takes the steps.
        alone_s: Time at the start for which this process takes the steps in any case [s].
    """

    def __init__(
        self,
        world: World[Choice],
        every: Sequence[Choice],
        seed: int,
        elsewhere: Callable[[Ready], Generator[Taken, None, None]] | None = None,
        alone_s: float = 0.0,
    ) -> None:
        self._world, self._every, self._seed = world, every, seed
        self._elsewhere, self._alone_s = elsewhere, alone_s
        self._parents, self._by = array("i", [_OPEN]), array("i", [_OPEN])
        self._depths = array("i", [0])
        self._known: dict[bytes, int] = {}

    def run(
        self,
        name: str,
        limit: int = 0,
        depth: int = 0,
        report: Callable[[int, int], None] | None = None,
    ) -> Result:
        """Find every state.

        Args:
            name: Name of the world.
            limit: Stop after the steps from this number of states; 0 for no limit.
            depth: Explore only states at less than this distance from the start, in scans; 0 for no
                limit.
            report: Called at times with the number of explored and of known states.
        """
        result, world = Result(name), self._world
        first = world.first()
        known = self._known
        known[world.known_as(first)] = 0
        ready = Ready(world.packed(first), self._depths, limit, depth)
        with closing(self._taken(ready)) as taken:
            for number, here, found in taken:
                world.entered(world.unpacked(here))
                self._merge(number, found, ready, result)
                if result.broken is not None:
                    break
                ready.done = done = number + 1
                if report is not None and done % 100 == 0:
                    report(done, len(known))
                result.states, result.depth = len(known), self._depths[-1]
                result.complete = done == len(known)
                last = result.complete or done == limit
                if last or (done >= _FIRST_LOOK and done & (done - 1) == 0):
                    world.look(result, self)
                if last or result.broken is not None:
                    break
        return result

    def _merge(
        self, number: int, found: Iterable[Transition], ready: Ready, result: Result
    ) -> None:
        """Merge the steps from one state into the result, up to the first broken rule."""
        world, every, known = self._world, self._every, self._known
        depth = self._depths[number] + 1
        for by, key, following, is_cut, is_checked, broken in found:
            if broken:
                result.broken = Broken(tuple(broken), self.path(number, every[by]))
                result.states, result.depth = len(known), depth
                return
            result.transitions += 1
            there = known.get(key, _OPEN)
            if there == _OPEN and is_cut:
                result.cut += 1
                continue
            if there == _OPEN:
                there = known[key] = len(known)
                ready.add(following)
                self._parents.append(number)
                self._by.append(by)
                self._depths.append(depth)
                world.added()
            world.followed(number, every[by], there)
            result.checked += is_checked

    def _taken(self, ready: Ready) -> Generator[Taken, None, None]:
        world, is_known = self._world, self._known.__contains__
        until = time.monotonic() + self._alone_s
        while self._elsewhere is None or time.monotonic() < until:
            number, states = ready.take(1)
            if not states:
                return
            here = world.unpacked(states[0])
            yield number, states[0], steps(world, number, here, self._seed, is_known)
        yield from self._elsewhere(ready)

    def path(self, number: int, last: Choice | None = None) -> tuple[Choice, ...]:
        """Return the choices from the start to a state, followed by `last`."""
        return tuple(reversed([*([] if last is None else [last]), *self._back(number)]))

    def _back(self, number: int) -> Iterator[Choice]:
        while self._parents[number] != _OPEN:
            yield self._every[self._by[number]]
            number = self._parents[number]
