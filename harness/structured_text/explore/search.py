"""Every reachable state of a world, breadth first: the first trace found is a shortest one.

The steps from a state depend on nothing but the state and its number, so they can be taken anywhere
(`shared`). What follows from them is put together here, strictly in the order of the states: who
takes the steps changes nothing of what comes out.
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

__all__ = ["Broken", "Ready", "Result", "Search", "Step", "Taken", "World", "steps"]

_OPEN = -1

#: From so many states on, at each power of two, all that are known are looked at together.
_FIRST_LOOK = 512


class _Numbered(Protocol):
    @property
    def number(self) -> int:
        """Its place among all choices that there are."""


Choice = TypeVar("Choice", bound=_Numbered)


@dataclass(frozen=True)
class Broken:
    """A rule that can be broken, and the shortest way there.

    Attributes:
        rules: What is broken in the last scan, in words.
        path: The choices from the start on; the last one leads into the broken scan.
        quiet: For a hang: the environment in which nothing comes to an end any more.
    """

    rules: tuple[str, ...]
    path: tuple[Any, ...]
    quiet: Any = None


@dataclass
class Result:
    """What an exploration has found.

    Attributes:
        model: What was explored.
        states: Reachable states that differ.
        transitions: Scans that were run and judged, one for each state and choice.
        depth: Scans from the start to the farthest state.
        complete: Every state is known; False where a rule was broken or a limit reached.
        cut: Scans that lead to a state that is not looked at.
        checked: Scans that were repeated to check the abstraction.
        bounds: Most scans until all is quiet, for each quiet environment.
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
        """Is all of it known, and no rule broken?"""
        return self.complete and self.broken is None


class World(ABC, Generic[Choice]):
    """What is explored: states as bytes, and what may happen in each."""

    @abstractmethod
    def first(self) -> bytes:
        """The state at the start."""

    @abstractmethod
    def choices(self, state: bytes) -> Sequence[Choice]:
        """What may happen next, at least one."""

    @abstractmethod
    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Let it happen: the next state, and the rules that are broken, in words."""

    @abstractmethod
    def check(self, state: bytes, choice: Choice, following: bytes, random: Random) -> None:
        """Let it happen again with anything in what a state leaves out, as it is drawn.

        Raises:
            Exception: another state follows.
        """

    def known_as(self, state: bytes) -> bytes:
        """What tells it apart."""
        return state

    def packed(self, state: bytes) -> bytes:
        """The same in fewer bytes, for as long as it waits."""
        return state

    def unpacked(self, packed: bytes) -> bytes:
        """The state again."""
        return packed

    def is_cut(self) -> bool:
        """Is the state that the last step has led to none to look at?"""
        return False

    def added(self) -> None:
        """The state that the last step has led to is new; asked only where the steps are taken."""

    def followed(self, number: int, choice: Choice, following: int) -> None:
        """A step from one state, by its number, to another."""

    def entered(self, state: bytes) -> None:
        """The steps from here are next."""

    def look(self, result: Result, states: Paths) -> None:
        """Look at all states together; what is broken is put into the result."""


class Paths(Protocol):
    """The ways to all states that are known."""

    def path(self, number: int, last: Any = None) -> tuple[Any, ...]:
        """The choices from the start to a state, and one more."""


class Step(NamedTuple):
    """A step from a state.

    Attributes:
        choice: The number of the choice.
        key: What tells the next state apart.
        following: The next state, packed; empty where it is known.
        is_cut: It is none to look at.
        is_checked: It is repeated to check the abstraction, before the next step.
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
) -> Iterator[Step]:
    """All steps from a state; one of them is checked, as the seed and the state's number draw it.

    Args:
        world: The world.
        number: Of the state.
        state: Itself.
        seed: Draws what is checked.
        is_known: Is there no need for the state that is told apart by this?

    Raises:
        Exception: see `World.check`.
    """
    random = Random(f"{seed} {number}")
    choices = world.choices(state)
    check = random.randrange(len(choices))
    for place, choice in enumerate(choices):
        following, broken = world.step(state, choice)
        key, is_cut = world.known_as(following), world.is_cut()
        is_checked = place == check and not is_cut
        sent = b"" if is_known(key) else world.packed(following)
        yield Step(choice.number, key, sent, is_cut, is_checked, broken)
        if is_checked:
            world.check(state, choice, following, random)


class Ready:
    """The states that are known and not gone on from yet, packed, in their order.

    Args:
        first: The first one.
        depths: Of each state, the scans from the start.
        limit: Only so many are gone on from; 0: all.
        depth: None is that is so many scans from the start; 0: any number.
    """

    def __init__(self, first: bytes, depths: Sequence[int], limit: int, depth: int) -> None:
        self._waiting, self._taken = deque([first]), 0
        self._depths, self._limit, self._depth = depths, limit, depth
        self.done = 0
        """So many have been gone on from, and what follows is known."""

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, state: bytes) -> None:
        """One more."""
        self._waiting.append(state)

    def take(self, most: int) -> tuple[int, list[bytes]]:
        """The number of the first of the next few, and them; none: see `may_come`."""
        number = self._taken
        states: list[bytes] = []
        while self._waiting and len(states) < most and not self._is_end():
            states.append(self._waiting.popleft())
            self._taken += 1
        return number, states

    def may_come(self) -> bool:
        """May one come yet of the steps from those that were taken?"""
        return self.done < self._taken and not self._is_end()

    def _is_end(self) -> bool:
        number = self._taken
        if self._limit and number >= self._limit:
            return True
        deep = self._depth and number < len(self._depths) and self._depths[number] >= self._depth
        return bool(deep)


#: A state by its number, itself (packed), and the steps from it.
Taken = tuple[int, bytes, Iterable[Step]]


class Search(Generic[Choice]):
    """Explores a world.

    Args:
        world: The world.
        every: All choices that there are, by their numbers.
        seed: Draws what is checked.
        elsewhere: Takes the steps, and gives them in the order of the states. Default: taken here.
        alone_s: So long they are taken here all the same [s].
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
            name: Of the world.
            limit: Give up after the steps from so many states; 0 = never.
            depth: Look no further than so many scans from the start; 0 = any number.
            report: Called now and then with the states that are done and that are known.
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

    def _merge(self, number: int, found: Iterable[Step], ready: Ready, result: Result) -> None:
        """Take over the steps from one state, up to one that breaks a rule."""
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
        """The choices from the start to a state, and one more."""
        return tuple(reversed([*([] if last is None else [last]), *self._back(number)]))

    def _back(self, number: int) -> Iterator[Choice]:
        while self._parents[number] != _OPEN:
            yield self._every[self._by[number]]
            number = self._parents[number]
