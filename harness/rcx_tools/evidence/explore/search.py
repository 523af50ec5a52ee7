"""Search through all reachable states of a model with blocks of the library."""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from random import Random
from struct import Struct
from typing import Any, NamedTuple

from rcx_harness.verify.explore.state_tables import TABLES
from rcx_tools.evidence.explore.abstraction import ModelAbstraction
from rcx_tools.evidence.explore.contract import Seen
from rcx_tools.evidence.explore.model import Choice, Model, Quiet, Wire
from rcx_tools.evidence.explore.oracle import Oracle
from rcx_tools.evidence.explore.stages import End, Stages
from rcx_tools.evidence.results import ROOT
from structured_text.engines.builtin import BuiltinProgram
from structured_text.explore.search import Broken, Paths, Result, Search, World
from structured_text.language.load import load
from structured_text.projects.needed import needed

__all__ = ["LIBRARY", "Explorer", "compiled", "longest", "quiet_choices"]

#: The unchanged library.
LIBRARY = tuple(sorted((ROOT / "plc/lib").rglob("*.st")))


def compiled(model: Model, library: Sequence[Path] = LIBRARY) -> BuiltinProgram:
    """Return the model's program on the built-in engine."""
    with tempfile.TemporaryDirectory() as folder:
        path = model.write(Path(folder))
        return BuiltinProgram.build(load([path, *needed([path], library)]))


class _Robot(NamedTuple):
    """The values of the robot (RCX_REF) that the search needs.

    Attributes:
        is_free: No block has a turn, and no command is out.
        queue: Number of tickets in the longer queue, including tickets of blocks that have given
            up.
    """

    is_free: bool
    queue: int


class Explorer(World[Choice]):
    """A model in the form that the search can explore.

    Args:
        model: The model.
        library: Files of the library, possibly with a seeded bug.
        seed: Seed of the arbitrary values that check the abstraction.
    """

    def __init__(self, model: Model, library: Sequence[Path] = LIBRARY, seed: int = 1) -> None:
        self._model, self._seed = model, seed
        self.program = compiled(model, library)
        ticks = max(2, -(-model.longest_ms // model.tick_ms))
        self._state = ModelAbstraction(
            self.program, model.tick_ms * 1000, ticks, model.free(), TABLES
        )
        self._root: Any = self._state.root
        self._oracle = Oracle(model, self._root)
        looks = [partial(self._oracle.seen, k) for k in range(len(model.blocks))]
        notes: list[Callable[[], Any]] = [lambda: None, *looks, self._oracle.written]
        self._stages = Stages(model, self.program, self._state, self._look_at_robot, notes)
        self._packed = Struct(f"<{len(self._stages.first)}I")
        self._choices = model.choices()
        self._here: tuple[int, ...] = ()
        self._memory = b""
        self._entries: dict[int, tuple[tuple[int, ...], list[Seen]]] = {}
        self._after: End
        self._quiet = [quiet_choices(model, quiet) for quiet in model.quiet]
        self._nexts = [array("i") for _ in self._quiet]
        self._idle = [bytearray([1]), bytearray([1])]
        self._now_quiet: list[Choice] = []

    def run(self, limit: int = 0) -> Result:
        """Explore every state of the model (see `Search.run`)."""
        search = Search(self, self._choices, self._seed)
        return search.run(self._model.name, limit)

    def first(self) -> bytes:
        """Return the initial state of the model."""
        return self._packed.pack(*self._stages.first) + self._oracle.initial()

    def choices(self, state: bytes) -> Sequence[Choice]:
        """Return the possible choices of the environment in a state."""
        self._here = self._packed.unpack_from(state)
        self._memory = state[self._packed.size :]
        self._entries.clear()
        return self._choices

    def step(self, state: bytes, choice: Choice) -> tuple[bytes, list[str]]:
        """Run a scan with this choice.

        `choices` must have been called for this state before.
        """
        entered = self._entries.get(choice.ticks)
        if entered is None:
            entry = self._stages.entry(self._here, choice.ticks)
            entered = self._entries[choice.ticks] = entry, self._stages.notes(entry)[1:-1]
        end = self._stages.scan(entered[0], choice)
        self._after = end
        *now, written = end.notes[1:]
        after, broken = self._oracle.judge(self._memory, choice, entered[1], now, written)
        return self._packed.pack(*end.state) + after, broken

    def is_cut(self) -> bool:
        """Return whether a state is not explored, because its queue exceeds the limit."""
        return bool(self._after.shared.queue > self._model.queue)

    def added(self) -> None:
        """Record whether a new state is idle: no turn, and no command on the wire."""
        self._idle[0].append(self._after.shared.is_free)
        self._idle[1].append(not any(one.works for one in self._after.notes[1:-1]))

    def entered(self, state: bytes) -> None:
        """Record what each quiet environment selects in the state that is explored next."""
        wire = self._oracle.wire(state[self._packed.size :])
        self._now_quiet = [choice[wire] for choice in self._quiet]

    def followed(self, number: int, choice: Choice, following: int) -> None:
        """Record the states that follow in the quiet environments."""
        for k, one in enumerate(self._now_quiet):
            if one.number == choice.number:
                self._nexts[k].append(following)

    def look(self, result: Result, states: Paths) -> None:
        """Search for hangs, and for waits that exceed their limit."""
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
        """Repeat a scan with arbitrary values for everything that the state omits.

        The whole program runs, without cached calls. Raise AssertionError if the result differs.
        """
        here, memory = self._whole(state)
        key, remembered = self._whole(following)
        self._stages.reset()
        now_us = self._state.disturb(here, choice.ticks, random)
        self._root.INPUTAREA[34:] = random.randbytes(len(self._root.INPUTAREA) - 34)
        for name, value in choice.values:
            setattr(self._root, name, value)
        self._root.INPUTAREA[:34] = choice.image
        before = self._oracle.all_seen()
        self.program.scan(now_us)
        self._state.check_fixed()
        now, written = self._oracle.all_seen(), self._oracle.written()
        after, broken = self._oracle.judge(memory, choice, before, now, written)
        there = self._state.freeze()
        if there != key or after != remembered or broken:
            told = self._state.differences(there, key)
            told += [f"oracle {k}" for k, one in enumerate(after) if one != remembered[k]]
            raise AssertionError(
                f"model {self._model.name}: what the state leaves out has an effect on {told} "
                f"in the scan: {self._model.tell(choice)} {broken}"
            )

    def _whole(self, state: bytes) -> tuple[bytes, bytes]:
        """Return the abstract state of the whole program as bytes, and the memory of the oracle."""
        numbers = self._packed.unpack_from(state)
        return self._stages.bytes_of(numbers), state[self._packed.size :]

    def _look_at_robot(self) -> _Robot:
        """Return the present values of the robot (RCX_REF) that the search needs."""
        robot = self._root.ROBOT.INNER
        queues = [one.NEXTTICKET - one.SERVING & 0xFFFF for one in (robot.COMMAND, robot.SEQUENCE)]
        return _Robot(not any(queues) and robot.PHASE == 1, max(queues))


class _Pick(dict[Wire, Choice]):
    """The choices of a quiet environment by the values on the wire, computed on first use."""

    def __init__(self, quiet: Quiet, choices: dict[str, Choice]) -> None:
        super().__init__()
        self._quiet, self._choices = quiet, choices

    def __missing__(self, wire: Wire) -> Choice:
        found = self[wire] = self._choices[self._quiet.situation(wire)]
        return found


def quiet_choices(model: Model, quiet: Quiet) -> dict[Wire, Choice]:
    """Return the choices of a quiet environment, by the values on the wire."""
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
    """Return the most steps to an idle state, a state that never gets idle, and the slowest state.

    If every state leads to an idle state, the second value is -1. Otherwise the first and the third
    value are -1.

    Args:
        follow: The next state of each state. A state without a next state counts as idle.
        idle: Whether each state is idle.
    """
    unknown, walking = -1, -2
    steps = array("i", [0 if at else unknown for at in idle])
    for at in range(len(follow), len(idle)):
        steps[at] = 0
    # The states form a functional graph. Each walk ends in a state with known steps or returns to
    # itself. A walk that returns to itself is a cycle without an idle state: a hang. Every state is
    # visited once.
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
