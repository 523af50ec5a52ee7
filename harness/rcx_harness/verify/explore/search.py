"""Every reachable state of a world, breadth first: the first trace found is a shortest one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from array import array
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import Any, Generic, Protocol, TypeVar

__all__ = ["Broken", "Result", "Search", "World"]

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
    def check(self, state: bytes, choice: Choice, following: bytes) -> None:
        """Let it happen again with anything in what a state leaves out.

        Raises:
            Exception: another state follows.
        """

    def known_as(self, state: bytes) -> bytes:
        """What tells it apart."""
        return state

    def is_cut(self) -> bool:
        """Is the new state that the last step has led to none to look at?"""
        return False

    def added(self) -> None:
        """The state that the last step has led to is new."""

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


class Search(Generic[Choice]):
    """Explores a world.

    Args:
        world: The world.
        every: All choices that there are, by their numbers.
        random: Draws what is checked.
    """

    def __init__(self, world: World[Choice], every: Sequence[Choice], random: Random) -> None:
        self._world, self._every, self._random = world, every, random
        self._parents, self._by = array("i", [_OPEN]), array("i", [_OPEN])
        self._depths = array("i", [0])

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
        known_as, step, followed = world.known_as, world.step, world.followed
        first = world.first()
        known: dict[bytes, int] = {known_as(first): 0}
        states = [first]
        depths, number, too_deep = self._depths, 0, False
        while number < len(states):
            here = states[number]
            states[number] = b""
            if depth and depths[number] >= depth:
                too_deep = True
                break
            choices = world.choices(here)
            world.entered(here)
            check = self._random.randrange(len(choices))
            for place, choice in enumerate(choices):
                key, broken = step(here, choice)
                if broken:
                    result.broken = Broken(tuple(broken), self.path(number, choice))
                    result.states, result.depth = len(states), depths[number] + 1
                    return result
                result.transitions += 1
                told = known_as(key)
                there = known.get(told, _OPEN)
                if there == _OPEN and world.is_cut():
                    result.cut += 1
                    continue
                if there == _OPEN:
                    there = known[told] = len(states)
                    states.append(key)
                    self._parents.append(number)
                    self._by.append(choice.number)
                    depths.append(depths[number] + 1)
                    world.added()
                followed(number, choice, there)
                if place == check:
                    world.check(here, choice, key)
                    result.checked += 1
            number += 1
            if report is not None and number % 100 == 0:
                report(number, len(states))
            result.states, result.depth = len(states), depths[-1]
            result.complete = number == len(states)
            last = result.complete or number == limit
            if last or (number >= _FIRST_LOOK and number & (number - 1) == 0):
                world.look(result, self)
            if last or result.broken is not None:
                break
        result.complete = result.complete and not too_deep
        return result

    def path(self, number: int, last: Choice | None = None) -> tuple[Choice, ...]:
        """The choices from the start to a state, and one more."""
        return tuple(reversed([*([] if last is None else [last]), *self._back(number)]))

    def _back(self, number: int) -> Iterator[Choice]:
        while self._parents[number] != _OPEN:
            yield self._every[self._by[number]]
            number = self._parents[number]
