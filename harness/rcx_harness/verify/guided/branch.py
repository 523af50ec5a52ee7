"""The work of a guided campaign: a run that branches from a kept state, or begins anew."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.explore.cell_states import FrozenStates
from rcx_harness.verify.guided.novelty import Met, Observer
from rcx_harness.verify.storm.campaign import Straight
from rcx_harness.verify.storm.cells import CellsOf
from rcx_harness.verify.storm.course import RECOVERY, Course
from rcx_harness.verify.storm.draw import Drawn
from rcx_harness.verify.storm.moments import moments
from rcx_harness.verify.storm.reached import Line, Reached
from rcx_harness.verify.storm.storms import Failure
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.errors import InputError

__all__ = ["Branch", "Guided", "Kept", "Ran"]

#: Greatest number of states that a run adds to the corpus, and the shortest time between them [us].
_MOST_KEPT, _APART_US = 8, 250_000
#: Lengths of the storm of a branch, as shares of the demanded length.
_LENGTHS = (0.02, 0.05, 0.1, 0.2, 0.2, 0.3, 0.5, 0.7, 1.0)
#: Probability of a recovery after a storm: from a new state, and from a state from which a recovery
#: was tried before. A recovery takes as many scans as several short storms.
_NEW, _AGAIN = 0.6, 0.15


class Kept(NamedTuple):
    """A state of the corpus, with the whole run that leads there from a cold start.

    Attributes:
        acts: All actions that have begun.
        t_us: The time of the state [us].
        features: The features that were new when this state was reached.
        state: The state as bytes.
    """

    acts: tuple[Entry, ...]
    t_us: int
    features: tuple[int, ...]
    state: bytes


class Branch(NamedTuple):
    """Work item: the number of a run, the state where it begins, and all known features.

    If `kept` is None, the run begins with a cold start.
    """

    number: int
    kept: Kept | None
    known: frozenset[int]


class Ran(NamedTuple):
    """The result of a run.

    Attributes:
        failures: Maps a kind of failure to the run from a cold start that shows it.
        texts: Maps a kind of failure to its time [us] and its text.
        kept: States for the corpus.
        features: All features of the run.
        met: States of the user's blocks, with the faults that were present.
        scans: Number of scans of this run, without the scans before the branch.
        virtual_us: Virtual time of this run, without the time before the branch [us].
        acts: Number of actions of this run.
        lines: Reached lines of robot programs.
        reached: Names of the properties `sometimes` that held.
    """

    failures: dict[str, Straight]
    texts: dict[str, tuple[int, str]]
    kept: tuple[Kept, ...]
    features: tuple[int, ...]
    met: frozenset[Met]
    scans: int
    virtual_us: int
    acts: int
    lines: tuple[Line, ...]
    reached: tuple[str, ...]


@dataclass(frozen=True)
class Guided:
    """The work of a guided campaign for one worker; `seed` determines all runs."""

    cells: CellsOf
    seed: int

    def prepare(self) -> Callable[[Branch], Ran]:
        """Compile the program, and return the function that executes a branch."""
        return _Worker(self.cells, self.seed).run


class _Worker:
    """A cell that is brought into the state of each branch."""

    def __init__(self, of: CellsOf, seed: int) -> None:
        self._seed = seed
        collector = Collector()
        with counting(collector):
            self._cells = cells = of.make()
        demands = self._demands = cells.demands
        course = Course(cells.cell(seed), demands)
        self._moments = moments(course, demands.start, demands.length_us, cells.library)
        cell = cells.cell(seed, keep=0)
        if not isinstance(cell.program, BuiltinProgram):
            raise InputError("--guided needs the built-in engine", hint="add --engine builtin")
        self._course = Course(cell, demands)
        self._course.wanted = ""
        self._states = FrozenStates(cell, self._course.judge)
        self._begin = Kept((), 0, (), self._states.freeze())
        inputs = {*demands.buttons, *demands.switches, *demands.values}
        self._watch = Observer(self._course, cells.library, inputs, collector, self._mark)
        self._reached = Reached(cell)
        self._kept: list[Kept] = []
        self._known: frozenset[int] = frozenset()
        self._listed, self._planned = 0, False
        self._ends_us: int | None = None

    def run(self, item: Branch) -> Ran:
        """Execute a branch."""
        course, cell = self._course, self._course.cell
        begin = item.kept or self._begin
        random = Random(f"guided {self._seed} {item.number}")
        self._states.thaw(begin.state)
        course.begin_at(begin.acts)
        course.judge.forget_reached()
        self._reached.forget()
        self._known, self._kept = item.known, []
        self._listed, self._planned, self._ends_us = 0, False, None
        self._watch.begin(item.known)
        scans, begin_us = cell.scans, cell.now_us
        rest: tuple[int, ...] = ()
        try:
            for act in self._demands.start:
                if act.t_us > begin_us or item.kept is None:
                    course.plan(act)
            if item.kept is None:
                self._planned = True  # no state before the start has ended
                course.begin()
                self._keep()
            self._storm(random, is_first=item.kept is None)
            self._ends_us = cell.now_us
            course.come_to_rest()
            state = self._watch.rest()
            if random.random() < (_AGAIN if state in item.known else _NEW):
                course.recover()
                rest = (state,)
        except Failure as failure:
            course.failures.setdefault(failure.kind, failure)
        return Ran(
            {kind: self._straight(one) for kind, one in course.failures.items()},
            {kind: (one.t_us, one.text) for kind, one in course.failures.items()},
            tuple(self._kept),
            (*self._watch.found, *rest),
            frozenset(self._watch.met),
            cell.scans - scans,
            cell.now_us - begin_us,
            len(course.done) - len(begin.acts),
            self._reached.lines,
            course.judge.reached,
        )

    def _storm(self, random: Random, *, is_first: bool) -> None:
        """Draw and execute a short storm, many of whose actions are close to its beginning."""
        course, demands = self._course, self._demands
        now_us, scan_us = course.cell.now_us, course.cell.timing.scan_us
        drawn = Drawn(demands, random, len(course.cell.robots), scan_us)
        length_us = round(demands.length_us * random.choice(_LENGTHS) * random.uniform(0.5, 1.5))
        if is_first:
            storm = drawn.storm(length_us, self._moments[0])
        else:
            storm = drawn.storm(length_us, (), marks=(0,))
        left = [part.t_us for act in course.done for part in act.parts() if part.t_us > now_us]
        course.weather(storm)
        if left and (rest_us := max(left) + 1_000 - course.cell.now_us) > 0:
            course.let_pass(rest_us)

    def _mark(self) -> None:
        """Keep the state after the present scan, unless enough states of this run are kept."""
        now_us = self._course.cell.now_us
        last_us = self._kept[-1].t_us if self._kept else -_APART_US
        if not self._planned and len(self._kept) < _MOST_KEPT and now_us >= last_us + _APART_US:
            self._planned = True
            self._course.cell.at(now_us + 1, self._keep)

    def _keep(self) -> None:
        self._planned = False
        now_us = self._course.cell.now_us
        found = list(self._watch.found)
        new = tuple(one for one in found[self._listed :] if one not in self._known)
        self._listed = len(found)
        acts = tuple(self._course.begun_acts)
        self._kept.append(Kept(acts, now_us, new, self._states.freeze(stimuli=False)))

    def _straight(self, failure: Failure) -> Straight:
        """Return the run from a cold start that ends with a failure."""
        ends_us = self._ends_us if failure.kind == RECOVERY else failure.t_us
        if ends_us is None:  # the start itself has failed
            return Straight(failure.kind, self._seed, (), None)
        return Straight(failure.kind, self._seed, _before(self._course.done, ends_us), ends_us)


def _before(acts: Sequence[Entry], t_us: int) -> tuple[Entry, ...]:
    return tuple(sorted((one for one in acts if one.t_us <= t_us), key=lambda one: one.t_us))
