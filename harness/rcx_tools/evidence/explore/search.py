"""Every reachable state of a model, breadth first: the first trace found is a shortest one."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from typing import Any

from rcx_harness.engine.builtin import BuiltinProgram
from rcx_harness.engine.frontend import load
from rcx_harness.engine.needed import needed
from rcx_tools.evidence.explore.abstraction import NOW_US, Abstraction
from rcx_tools.evidence.explore.model import Choice, Model, Quiet, Wire
from rcx_tools.evidence.explore.oracle import Oracle
from rcx_tools.evidence.results import ROOT

__all__ = ["LIBRARY", "Broken", "Explorer", "Result", "compiled", "quiet_choices"]

#: The library as it stands.
LIBRARY = tuple(sorted((ROOT / "plc/lib").rglob("*.st")))

_OPEN = -1

#: From so many states on, at each power of two, it is looked for hangs among those that are known.
_FIRST_LOOK = 512


@dataclass(frozen=True)
class Broken:
    """A rule that can be broken, and the shortest way there.

    Attributes:
        rules: What is broken in the last scan, in words.
        path: The choices from the start on; the last one leads into the broken scan.
        quiet: For a hang: the environment in which nothing comes to an end any more.
    """

    rules: tuple[str, ...]
    path: tuple[Choice, ...]
    quiet: Quiet | None = None


@dataclass
class Result:
    """What an exploration has found.

    Attributes:
        model: Name of the model.
        states: Reachable states that differ.
        transitions: Scans that were run and judged, one for each state and choice.
        depth: Scans from the start to the farthest state.
        complete: Every state is known; False where a rule was broken or a limit reached.
        cut: Those of them that lead to a longer queue than the model looks at.
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


def compiled(model: Model, library: Sequence[Path] = LIBRARY) -> BuiltinProgram:
    """The model's program on the built-in engine."""
    with tempfile.TemporaryDirectory() as folder:
        path = model.write(Path(folder))
        return BuiltinProgram.build(load([path, *needed([path], library)]))


class Explorer:
    """Explores one model.

    Args:
        model: What to explore.
        library: Files of the library; a broken block is put in here.
        seed: Of the arbitrary values that the abstraction is checked with.
    """

    def __init__(self, model: Model, library: Sequence[Path] = LIBRARY, seed: int = 1) -> None:
        self._model, self._random = model, Random(seed)
        self.program = compiled(model, library)
        ticks = max(2, -(-model.longest_ms // model.tick_ms))
        self._state = Abstraction(self.program, model.tick_ms * 1000, ticks, model.free())
        self._root: Any = self._state.root
        self._oracle = Oracle(model, self._root)
        self._choices = model.choices()
        self._quiet = [quiet_choices(model, quiet) for quiet in model.quiet]

    def run(self, limit: int = 0, report: Callable[[int, int], None] | None = None) -> Result:
        """Find every state.

        Args:
            limit: Give up after so many states; 0 = never.
            report: Called now and then with the states that are done and that are known.
        """
        result = Result(self._model.name)
        freeze, thaw, size = self._state.freeze, self._state.thaw, self._state.size
        scan, judge, pins = self.program.scan, self._oracle.judge, self._oracle.pins
        image, root, choices = self._root.INPUTAREA, self._root, self._choices
        first = freeze() + self._oracle.initial()
        known: dict[bytes, int] = {first: 0}
        states = [first]
        parents, by = array("i", [_OPEN]), array("i", [_OPEN])
        depths = array("i", [0])
        nexts = [array("i") for _ in self._quiet]
        idle: list[bytearray] = [bytearray([1]), bytearray([1])]
        number = 0
        while number < len(states):
            here = states[number]
            memory, states[number] = here[size:], b""
            quiet = [choice[self._oracle.wire(memory)] for choice in self._quiet]
            quiets = {choice.number for choice in quiet}
            check = self._random.randrange(len(choices))
            for choice in choices:
                thaw(here, choice.ticks)
                for name, value in choice.values:
                    setattr(root, name, value)
                image[:34] = choice.image
                before = pins()
                scan(NOW_US)
                after, broken = judge(memory, choice, before)
                key = freeze() + after
                if broken:
                    result.broken = Broken(tuple(broken), self._path(parents, by, number, choice))
                    result.states, result.depth = len(states), depths[number] + 1
                    return result
                result.transitions += 1
                there = known.get(key, _OPEN)
                if there == _OPEN and self._queue() > self._model.queue:
                    result.cut += 1
                    continue
                if there == _OPEN:
                    there = known[key] = len(states)
                    states.append(key)
                    parents.append(number)
                    by.append(choice.number)
                    depths.append(depths[number] + 1)
                    idle[0].append(self._is_free())
                    idle[1].append(self._is_idle())
                if choice.number in quiets:
                    for k, one in enumerate(quiet):
                        if one.number == choice.number:
                            nexts[k].append(there)
                if choice.number == check:
                    self._check(here, choice, key)
                    result.checked += 1
            number += 1
            if report is not None and number % 100 == 0:
                report(number, len(states))
            result.states, result.depth = len(states), depths[-1]
            result.complete = number == len(states)
            last = result.complete or number == limit
            if last or (number >= _FIRST_LOOK and number & (number - 1) == 0):
                for quiet_one, follow in zip(self._model.quiet, nexts, strict=True):
                    bound, stuck, slowest = _longest(follow, idle[quiet_one.idle_blocks])
                    result.bounds[quiet_one.title] = bound
                    if 0 < quiet_one.most < bound and result.broken is None:
                        text = (
                            f"wait: {bound} scans until the channel is free, not "
                            f"{quiet_one.most}: {quiet_one.title}"
                        )
                        path = self._path(parents, by, slowest, None)
                        result.broken = Broken((text,), path, quiet_one)
                    if stuck >= 0 and result.broken is None:
                        text = f"hang: never free again: {quiet_one.title}"
                        path = self._path(parents, by, stuck, None)
                        result.broken = Broken((text,), path, quiet_one)
            if last or result.broken is not None:
                break
        return result

    def _path(self, parents: Any, by: Any, number: int, last: Choice | None) -> tuple[Choice, ...]:
        path = [] if last is None else [last]
        while parents[number] != _OPEN:
            path.append(self._choices[by[number]])
            number = parents[number]
        return tuple(reversed(path))

    def _check(self, here: bytes, choice: Choice, key: bytes) -> None:
        """Repeat a scan with arbitrary values in all that the state leaves out."""
        memory = here[self._state.size :]
        now_us = self._state.disturb(here, choice.ticks, self._random)
        self._root.INPUTAREA[34:] = self._random.randbytes(len(self._root.INPUTAREA) - 34)
        for name, value in choice.values:
            setattr(self._root, name, value)
        self._root.INPUTAREA[:34] = choice.image
        before = self._oracle.pins()
        self.program.scan(now_us)
        after, broken = self._oracle.judge(memory, choice, before)
        there = self._state.freeze() + after
        if there != key or broken:
            names = self._state.names()
            where = [k for k, (a, b) in enumerate(zip(there, key, strict=True)) if a != b]
            told = [names[k] if k < len(names) else f"oracle {k - len(names)}" for k in where]
            raise AssertionError(
                f"model {self._model.name}: what the state leaves out has an effect on {told} "
                f"in the scan: {self._model.tell(choice)} {broken}"
            )

    def _queue(self) -> int:
        """Tickets on the longer queue, also those whose blocks have given up."""
        robot = self._root.ROBOT.INNER
        command = robot.COMMAND.NEXTTICKET - robot.COMMAND.SERVING & 0xFFFF
        return int(max(command, robot.SEQUENCE.NEXTTICKET - robot.SEQUENCE.SERVING & 0xFFFF))

    def _is_free(self) -> bool:
        """No turn is taken, nothing is out, and no block that is called is busy."""
        robot = self._root.ROBOT.INNER
        return bool(
            robot.COMMAND.SERVING == robot.COMMAND.NEXTTICKET
            and robot.SEQUENCE.SERVING == robot.SEQUENCE.NEXTTICKET
            and robot.PHASE == 1
        )

    def _is_idle(self) -> bool:
        """No block is busy."""
        held = (getattr(self._root, block.name.upper()) for block in self._model.blocks)
        return not any(one.BUSY or getattr(one, "STOPPING", False) for one in held)


class _Pick(dict[Wire, Choice]):
    """The choice of a quiet environment, by what is on the wire."""

    def __init__(self, quiet: Quiet, choices: dict[str, Choice]) -> None:
        super().__init__()
        self._quiet, self._choices = quiet, choices

    def __missing__(self, wire: Wire) -> Choice:
        found = self[wire] = self._choices[self._quiet.situation(wire)]
        return found


def quiet_choices(model: Model, quiet: Quiet) -> dict[Wire, Choice]:
    """What a quiet environment chooses, by what is on the wire; it is made as it is asked for."""
    does = tuple(
        quiet.does if quiet.does in block.does else block.does[0] for block in model.blocks
    )
    emergency_ok, stop_ok = max(model.pins)
    found: dict[str, Choice] = {}
    for choice in model.choices():
        alike = (choice.does, choice.ticks) == (does, model.gaps[0])
        if alike and (choice.emergency_ok, choice.stop_ok) == (emergency_ok, stop_ok):
            found.setdefault(choice.situation.label, choice)
    return _Pick(quiet, found)


def _longest(follow: Any, idle: bytearray) -> tuple[int, int, int]:
    """The most steps to an idle state, and where: (most, first without any or -1, first with most).

    Args:
        follow: The next state of each; a state without one is taken as idle.
        idle: Which states are.
    """
    unknown, walking = -1, -2
    steps = array("i", [0 if at else unknown for at in idle])
    for at in range(len(follow), len(idle)):
        steps[at] = 0
    for start in range(len(follow)):
        path, at = [], start
        while steps[at] == unknown:
            steps[at] = walking
            path.append(at)
            at = follow[at]
        if steps[at] == walking:
            return -1, start, -1
        for one in reversed(path):
            steps[one] = steps[at] + 1
            at = one
    most = max(steps)
    return most, -1, steps.index(most)
