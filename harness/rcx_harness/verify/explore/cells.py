"""The exploration of a cell: all orders of changes of inputs and of faults.

The virtual controller runs with its robot programs and its own times. A state is the state of the
whole cell after a scan: PLC, network, controllers, monitors and properties.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cell.link import PacketNetwork
from rcx_harness.cell.stimulus import Entry, Stimulus
from rcx_harness.verify.explore.cell_states import CellStates
from rcx_harness.verify.explore.inputs import values_of
from rcx_harness.verify.explore.user import refuse
from rcx_harness.verify.properties import Judge
from rcx_harness.verify.replay import replayed
from rcx_harness.verify.storm.cells import Cells, CellsOf
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.explore.search import Paths, Result, Search, World
from structured_text.explore.shared import Stepping, shared
from structured_text.farm import Farm

__all__ = ["FAULTS", "CellChoice", "CellExplored", "CellSettings", "explore_cell", "replay_cell"]

#: Faults that may occur, by the names of `rcx explore --faults`, each with its description.
FAULTS = {
    "link": "the link is lost and comes back",
    "alarm": "the controller has an alarm",
}
#: The events that `FAULTS` inject, each with its description.
_EVENTS = {
    "link_down": "link lost",
    "link_up": "link up",
    "alarm": "SO(03) ON: alarm",
}
_PLACE = re.compile(r"^(controller \d+: )?(plc, scan \d+|robot, cycle \d+): ")
#: The keys are checked with pairs of states that have the same key. The constants are: number of
#: pairs that are checked at first, interval of later checked pairs, number of compared scans, and
#: number of keys with stored states.
_FIRST_TWINS, _FURTHER_TWINS, _COMPARED, _EARLIER = 20, 16, 3, 2_000


class CellChoice(NamedTuple):
    """An event before a scan: a fault, a new value of an input, or nothing."""

    number: int
    event: str
    controller: int
    path: str
    text: str
    """The new value of the input, as the user wrote it."""
    value: Any

    def tell(self) -> str:
        """Return a description of the choice in words."""
        if self.event:
            return _EVENTS[self.event] + (f" ({self.controller})" if self.controller > 1 else "")
        return f"{self.path} := {self.text}" if self.path else "nothing"

    def entry(self, t_us: int) -> Entry:
        """Return the choice as an entry of a stimulus."""
        values = {self.path: self.value} if self.path else {}
        events: tuple[tuple[str, Mapping[str, Any]], ...] = ()
        if self.event:
            events = ((self.event, {}),)
        return Entry(t_us, values=values, events=events, controller=self.controller)


@dataclass(frozen=True)
class CellSettings:
    """The settings of the exploration of a cell.

    Attributes:
        cells: The cell, its properties, and the run with which each path begins.
        inputs: Values of each input in Structured Text; see `user.Settings`.
        faults: Names from `FAULTS`.
        begin_us: The exploration begins with the first scan at or after this time.
        states: Greatest number of states to expand; 0 means no limit.
        depth: Greatest number of scans from the beginning; 0 means no limit.
        seed: The seed of the random checks of the keys.
        report: Called with the number of expanded states and of known states.
    """

    cells: CellsOf
    inputs: Mapping[str, Sequence[str]] = field(default_factory=dict)
    faults: frozenset[str] = frozenset()
    begin_us: int = 0
    states: int = 0
    depth: int = 0
    seed: int = 1
    report: Any = None


class CellExplored(NamedTuple):
    """The result of an exploration: figures, input values, and the time of the first scan [us]."""

    result: Result
    inputs: Mapping[str, Sequence[str]]
    first_us: int
    scan_us: int


def explore_cell(settings: CellSettings, farm: Farm | None = None) -> CellExplored:
    """Explore a cell; the result does not depend on the `farm` of worker processes."""
    world = _CellWorld(settings)
    taken, alone_s = None, 0.0
    if farm is not None and (farm.workers > 1 or farm.cluster is not None):
        make = partial(_CellWorld, replace(settings, report=None))
        taken = shared(farm, Stepping(make, settings.seed))
        alone_s = 1.0 if farm.cluster is None else 0.0
    search = Search(world, world.every, settings.seed, taken, alone_s)
    result = search.run("cell", settings.states, settings.depth, settings.report)
    inputs = {path: [text for text, _ in found] for path, found in world.inputs.items()}
    return CellExplored(result, inputs, world.first_us, world.cell.timing.scan_us)


class _CellWorld(World[CellChoice]):
    """A cell in which the inputs and the faults are chosen before each scan."""

    def __init__(self, settings: CellSettings) -> None:
        cells: Cells = settings.cells.make()
        self.cell: Cell = cells.cell(0, keep=0)
        program = self.cell.program
        if not isinstance(program, BuiltinProgram):
            raise InputError("a cell can be explored only on the built-in engine")
        refuse(program.module.project)
        _refuse_clocks(self.cell)
        self._broken: list[str] = []
        self.inputs = {
            path: list(values_of(program, path, texts)) for path, texts in settings.inputs.items()
        }
        judge = Judge(self.cell, cells.demands.properties, self._found)
        self._states = CellStates(self.cell, judge)
        self._faults = settings.faults
        self.every = list(_choices(self.inputs, settings.faults, len(self.cell.robots)))
        self.first_us = self._begin(cells.demands.start, settings.begin_us)
        self._known = self._states.freeze_with_key()
        self._first = self._known[0]
        self._twins: list[tuple[bytes, bytes]] = []
        self._earlier = {self._known[1]: self._first}
        self._noticed = 0

    def _begin(self, start: Sequence[Entry], begin_us: int) -> int:
        """Run until the exploration begins; return the time of the next scan [us]."""
        Stimulus(Path(), list(start)).schedule(self.cell)
        while self.cell.next_us < begin_us:
            self.cell.scan(1)
        # A later entry would stay in the agenda, and so become a part of each state.
        if late := [entry for entry in start if entry.t_us >= self.cell.next_us]:
            text = (
                f"the run has an entry at {late[0].t_us // 1000} ms, after the exploration begins"
            )
            raise InputError(text, hint="name a later --begin")
        if self._broken or self.cell.violations:
            told = [*self._broken, *(one.text for one in self.cell.violations)]
            hint = "begin the exploration with a run in which nothing fails"
            raise InputError(f"before the exploration: {told[0]}", hint=hint)
        return self.cell.next_us

    def first(self) -> bytes:
        """Return the state in which the exploration begins."""
        return self._first

    def known_as(self, state: bytes) -> bytes:
        """Return a digest of 128 bits that identifies a state."""
        if self._known[0] != state:
            self._states.thaw(state)
            self._known = (state, self._states.key())
        return self._known[1]

    def choices(self, state: bytes) -> Sequence[CellChoice]:
        """Return all choices: nothing happens, each possible fault, and each change of an input."""
        self._states.thaw(state)
        now = {path: self.cell.program.read(path) for path in self.inputs}
        return [
            one
            for one in self.every
            if (not one.path or now[one.path] != one.value) and self._may_happen(one)
        ]

    def _may_happen(self, choice: CellChoice) -> bool:
        if choice.event == "alarm":
            return not self.cell.robots[choice.controller - 1].alarms.serious
        if choice.event:
            network = self.cell.network_of(choice.controller)
            assert isinstance(network, PacketNetwork)
            return network.has_cable == (choice.event == "link_down")
        return True

    def step(self, state: bytes, choice: CellChoice) -> tuple[bytes, list[str]]:
        """Run one scan, and return the following state and the broken rules."""
        self._states.thaw(state)
        broken = self._scan(choice)
        if broken:
            return state, broken
        self._known = self._states.freeze_with_key()
        self._note_twin(self._known[0])
        return self._known[0], broken

    def _scan(self, choice: CellChoice) -> list[str]:
        cell, self._broken = self.cell, []
        before = len(cell.violations)
        entry = choice.entry(cell.next_us)
        if choice.path or choice.event:
            cell.at(entry.t_us, partial(entry.apply, cell))
        try:
            cell.scan(1)
        except InputError as error:
            return [f"stops: {error}"]
        rules = [_PLACE.sub(r"\1", one.text) for one in cell.violations[before:]]
        return rules + self._broken

    def _found(self, kind: str, text: str) -> None:
        self._broken.append(f"property: {kind}: {text}")

    def _note_twin(self, state: bytes) -> None:
        """Store a state together with an earlier state that has the same key."""
        earlier = self._earlier.setdefault(self._known[1], state)
        if len(self._earlier) > _EARLIER:
            self._earlier.pop(next(iter(self._earlier)))
        if earlier == state:
            return
        self._noticed += 1
        if self._noticed <= _FIRST_TWINS or self._noticed % _FURTHER_TWINS == 0:
            self._twins.append((earlier, state))

    def check(self, state: bytes, choice: CellChoice, following: bytes, random: Random) -> None:
        """If there is a pair of states with the same key, check that both behave alike."""
        del state, choice, following
        if self._twins:
            self._compare(*self._twins.pop(), random)

    def look(self, result: Result, states: Paths) -> None:
        """Check all pairs of states with the same key that have not been checked yet."""
        del result, states
        while self._twins:
            self._compare(*self._twins.pop(), Random(len(self._twins)))

    def _compare(self, one: bytes, other: bytes, random: Random) -> None:
        """Check that two states behave alike over some scans, after a random choice."""
        choice = random.choice(self.choices(one))
        ways = [list(self._way(state, choice)) for state in (one, other)]
        if ways[0] != ways[1]:
            raise InputError(
                "the states of this cell cannot be distinguished",
                hint="please report it with the cell; nothing is said about its rules",
            )

    def _way(self, state: bytes, choice: CellChoice) -> Iterator[object]:
        """Yield the key of each state after `state`, or the rules that the scan broke."""
        self._states.thaw(state)
        for one in (choice, *[self.every[0]] * (_COMPARED - 1)):
            if broken := self._scan(one):
                yield broken
                return
            yield self._states.key()


def _refuse_clocks(cell: Cell) -> None:
    """Raise InputError if a robot program reads the time, because its states then never recur."""
    for robot in cell.robots:
        for task in robot.program.tasks:
            for one in task.code.code:
                if any("TCOUNTER" in node.args for node in one.nodes()):
                    name = task.program.name
                    raise InputError(
                        f"robot program {name} reads the time in line {one.line}, which never "
                        "comes back to where it was",
                        hint="measure with DELAY, or with the time limit of WAIT",
                    )


def _choices(
    inputs: Mapping[str, Sequence[tuple[str, Any]]], faults: Iterable[str], controllers: int
) -> Iterator[CellChoice]:
    """Yield all choices. The first choice is that nothing happens."""
    number = 0
    yield CellChoice(number, "", 1, "", "", None)
    for path, values in inputs.items():
        for text, value in values:
            number += 1
            yield CellChoice(number, "", 1, path, text, value)
    events = {"link": ("link_down", "link_up"), "alarm": ("alarm",)}
    for controller in range(1, controllers + 1):
        for fault in FAULTS:
            for event in events[fault] if fault in faults else ():
                number += 1
                yield CellChoice(number, event, controller, "", "", None)


def replay_cell(settings: CellSettings, explored: CellExplored, folder: Path) -> tuple[Path, bool]:
    """Write the stimulus of a broken rule and its chart, and run it in a cell.

    Returns:
        The stimulus file, and whether the run shows the same broken rules.
    """
    broken = explored.result.broken
    assert broken is not None
    stimulus, chart = folder / "broken.toml", folder / "broken.svg"
    cells = settings.cells.make()
    times = [explored.first_us + k * explored.scan_us for k in range(len(broken.path))]
    entries = [one.entry(t_us) for one, t_us in zip(broken.path, times, strict=True)]
    entries = [*cells.demands.start, *(one for one in entries if one.values or one.events)]
    told = [
        f"{t_us // 1000} ms: {one.tell()}" for one, t_us in zip(broken.path, times, strict=True)
    ]
    with replayed(
        lambda: cells.cell(0),
        entries,
        "\n".join([*broken.rules, "broken in the last scan of:", *told]),
        stimulus,
        chart,
        properties=cells.demands.properties,
    ) as cell:
        stopped = ""
        try:
            while cell.next_us <= times[-1]:
                cell.scan(1)
        except InputError as error:
            stopped = f"stops: {error}"
        shown = [stopped, *(_PLACE.sub(r"\1", one.text) for one in cell.violations)]
    return stimulus, all(rule in shown for rule in broken.rules)
