"""Every reachable state of a model of the library's blocks."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any

from rcx_harness.engine.builtin import BuiltinProgram
from rcx_harness.engine.frontend.load import load
from rcx_harness.engine.needed import needed
from rcx_harness.verify.explore.abstraction import NOW_US, Abstraction
from rcx_harness.verify.explore.search import Broken, Paths, Result, Search, World
from rcx_tools.evidence.explore.model import Choice, Model, Quiet, Wire
from rcx_tools.evidence.explore.oracle import Oracle
from rcx_tools.evidence.results import ROOT

__all__ = ["LIBRARY", "Explorer", "compiled", "longest", "quiet_choices"]

#: The library as it stands.
LIBRARY = tuple(sorted((ROOT / "plc/lib").rglob("*.st")))


def compiled(model: Model, library: Sequence[Path] = LIBRARY) -> BuiltinProgram:
    """The model's program on the built-in engine."""
    with tempfile.TemporaryDirectory() as folder:
        path = model.write(Path(folder))
        return BuiltinProgram.build(load([path, *needed([path], library)]))


class Explorer(World[Choice]):
    """Explores one model.

    Args:
        model: What to explore.
        library: Files of the library; a broken block is put in here.
        seed: Of the arbitrary values that the abstraction is checked with.
    """

    def __init__(self, model: Model, library: Sequence[Path] = LIBRARY, seed: int = 1) -> None:
        self._model, self._seed = model, seed
        self.program = compiled(model, library)
        ticks = max(2, -(-model.longest_ms // model.tick_ms))
        self._state = Abstraction(self.program, model.tick_ms * 1000, ticks, model.free())
        self._root: Any = self._state.root
        self._oracle = Oracle(model, self._root)
        self._choices = model.choices()
        self._quiet = [quiet_choices(model, quiet) for quiet in model.quiet]
        self._nexts = [array("i") for _ in self._quiet]
        self._idle = [bytearray([1]), bytearray([1])]
        self._now_quiet: list[Choice] = []

    def run(self, limit: int = 0, report: Callable[[int, int], None] | None = None) -> Result:
        """Find every state; see `Search.run`."""
        search = Search(self, self._choices, self._seed)
        return search.run(self._model.name, limit, report=report)

    def first(self) -> bytes:
        """The state at the start."""
        return self._state.freeze() + self._oracle.initial()

    def choices(self, state: bytes) -> Sequence[Choice]:
        """What may happen next."""
        return self._choices

    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Let it happen."""
        self._state.thaw(state, choice.ticks)
        root = self._root
        for name, value in choice.values:
            setattr(root, name, value)
        root.INPUTAREA[:34] = choice.image
        before = self._oracle.pins()
        self.program.scan(NOW_US)
        after, broken = self._oracle.judge(state[self._state.size :], choice, before)
        return self._state.freeze() + after, broken

    def is_cut(self) -> bool:
        """Is the queue longer than the model looks at?"""
        return self._queue() > self._model.queue

    def added(self) -> None:
        """Note whether it is quiet."""
        self._idle[0].append(self._is_free())
        self._idle[1].append(self._is_idle())

    def entered(self, state: bytes) -> None:
        """Note what the quiet environments choose."""
        wire = self._oracle.wire(state[self._state.size :])
        self._now_quiet = [choice[wire] for choice in self._quiet]

    def followed(self, number: int, choice: Choice, following: int) -> None:
        """Note where the quiet environments lead to."""
        for k, one in enumerate(self._now_quiet):
            if one.number == choice.number:
                self._nexts[k].append(following)

    def look(self, result: Result, states: Paths) -> None:
        """Look for hangs, and for waits that are too long."""
        for quiet, follow in zip(self._model.quiet, self._nexts, strict=True):
            bound, stuck, slowest = longest(follow, self._idle[quiet.idle_blocks])
            result.bounds[quiet.title] = bound
            if 0 < quiet.most < bound and result.broken is None:
                text = (
                    f"wait: {bound} scans until the channel is free, not "
                    f"{quiet.most}: {quiet.title}"
                )
                result.broken = Broken((text,), states.path(slowest), quiet)
            if stuck >= 0 and result.broken is None:
                text = f"hang: never free again: {quiet.title}"
                result.broken = Broken((text,), states.path(stuck), quiet)

    def check(self, state: bytes, choice: Choice, following: bytes, random: Random) -> None:
        """Repeat a scan with arbitrary values in all that the state leaves out."""
        here, key = state, following
        memory = here[self._state.size :]
        now_us = self._state.disturb(here, choice.ticks, random)
        self._root.INPUTAREA[34:] = random.randbytes(len(self._root.INPUTAREA) - 34)
        for name, value in choice.values:
            setattr(self._root, name, value)
        self._root.INPUTAREA[:34] = choice.image
        before = self._oracle.pins()
        self.program.scan(now_us)
        after, broken = self._oracle.judge(memory, choice, before)
        there = self._state.freeze() + after
        if there != key or broken:
            told = self._state.differences(there, key)
            size = self._state.size
            told += [
                f"oracle {k}" for k in range(len(key) - size) if there[size + k] != key[size + k]
            ]
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


def longest(follow: Any, idle: bytearray) -> tuple[int, int, int]:
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
