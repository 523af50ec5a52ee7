"""One scan of both versions from states that are related, and the induction over it."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import z3

from structured_text.prove import values
from structured_text.prove.against.machine import Calls, PairedMachine, same
from structured_text.prove.against.versions import Pair, SharedInput
from structured_text.prove.assertions import Copies
from structured_text.prove.invariants import Candidate, candidates, kept
from structured_text.prove.logic import Bool, both, either, negated
from structured_text.prove.search import is_temporary
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import TIME_BITS

__all__ = ["STOPS_NOTHING", "Induction", "Inputs", "give", "machines", "stopped"]

#: Kinds of obligations that do not stop an engine.
STOPS_NOTHING = ("conversion", "time", "overflow")
_LOGIC = "QF_AUFBVFP"

Machines = tuple[PairedMachine, PairedMachine]


@dataclass(frozen=True)
class Inputs:
    """The terms of the inputs before a scan.

    Attributes:
        areas: Bytes and connection status of each device.
        values: The value of each input that a stimulus can set.
        when: The condition under which an input is set; True for most inputs.
    """

    areas: dict[int, tuple[list[Any], Any]]
    values: dict[str, Any]
    when: dict[str, Bool]


def machines(
    pair: Pair, unchanged: frozenset[str], milliseconds: str, *, exact: bool = False
) -> Machines:
    """Return a machine for each version."""
    calls = Calls()
    old, new = (
        PairedMachine(
            version.project,
            version.library,
            unchanged,
            calls,
            side,
            exact=exact,
            milliseconds=milliseconds,
        )
        for side, version in enumerate(pair.versions)
    )
    return old, new


def give(
    pair: Pair, inputs: list[SharedInput], both_: Machines, number: int, *, everything: bool
) -> Inputs:
    """Set the inputs of both versions to the same arbitrary values.

    With `everything`, inputs that a stimulus cannot set to every value are arbitrary, too.
    """
    areas: dict[int, tuple[list[Any], Any]] = {}
    for version, machine in zip(pair.versions, both_, strict=True):
        # Both versions have the same terms for the same device, since terms are equal by name.
        for device, found in version.around.give_areas(machine, number).items():
            if device not in areas or len(found[0]) > len(areas[device][0]):
                areas[device] = found
    terms, when = {}, {}
    for one in inputs:
        if not (one.any.searched or everything):
            continue
        here = True if one.steady else z3.Bool(f"set.{one.name}.{number}")
        if one.any.searched:
            terms[one.name], when[one.name] = _value(one, both_[0], number, everything), here
            for given, machine in zip(one.inputs, both_, strict=True):
                if given is not None:
                    machine.put(given.path, here, terms[one.name])
            continue
        _give_whole(one, both_, here)
    return Inputs(areas, terms, when)


def _value(one: SharedInput, machine: PairedMachine, number: int, everything: bool) -> Any:
    kind, name = one.any.type, f"{one.name}.{number}"
    if values.is_duration(kind) and not everything:
        return z3.ZeroExt(TIME_BITS - 32, z3.BitVec(name, 32)) * 1_000_000
    value = values.anything(kind, name)
    machine.assume(values.legal(kind, value))
    return value


def _give_whole(one: SharedInput, both_: Machines, when: Bool) -> None:
    """Set a REAL, STRING, array or structure to an arbitrary value."""
    made = both_[0]
    root = (f"#{made.fresh(one.name)}",)
    made.havoc(root, one.any.type)
    for given, machine in zip(one.inputs, both_, strict=True):
        if given is not None:
            for leaf in made.leaves(one.any.type):
                machine.put(given.path + leaf.suffix, when, made[root + leaf.suffix])


def stopped(machine: PairedMachine) -> Bool:
    """Return the condition that an operation of the last scan stops the PLC."""
    return either(*(one.when for one in machine.obligations if one.kind not in STOPS_NOTHING))


@dataclass
class _Step:
    """A scan of both versions, with the condition that each related variable stays equal."""

    both: Machines
    before: tuple[Mapping[Path, Any], Mapping[Path, Any]]
    equal: dict[Path, Bool]
    stops: tuple[Bool, Bool]


class Induction:
    """Induction over one scan of both versions.

    The first relation contains all variables with the same name, type and first value. Each
    variable that one scan can make different is removed, until the relation is inductive.

    Args:
        pair: The versions.
        unchanged: The blocks and functions of the library that are not run (see `PairedMachine`).
        milliseconds: See `ProgramMachine`.
        end: The time (`time.monotonic`) at which the induction ends.

    Attributes:
        relation: The paths of the new version that are equal after every scan.
        stops_alike: Whether both versions are proved to stop in the same scans.
        may_stop: Whether there is an operation that may stop a version.
    """

    def __init__(
        self, pair: Pair, unchanged: frozenset[str], milliseconds: str, end: float
    ) -> None:
        self._pair, self._unchanged, self._milliseconds = pair, unchanged, milliseconds
        self._end = end
        self._inputs = pair.inputs()
        self._held: tuple[list[Candidate], list[Candidate]] = ([], [])
        self.relation = self._first()
        self.stops_alike = False
        self.may_stop = True

    def prove(self, *, invariants: bool) -> set[Path]:
        """Return the paths of the outputs that are equal after every scan.

        With `invariants`, states that no run of a version reaches are excluded first.
        """
        if invariants:
            self._find_invariants()
        return self._run()

    def _machines(self) -> Machines:
        found = machines(self._pair, self._unchanged, self._milliseconds)
        for machine in found:
            machine.until = self._end
        return found

    def _first(self) -> set[Path]:
        """Return the related variables whose first values are equal."""
        found = self._machines()
        for version, machine in zip(self._pair.versions, found, strict=True):
            version.around.start(machine)
        old, new = found
        related = set()
        for path in new.snapshot():
            there = self._pair.old_path(path)
            kind = new.type_of(path)
            alike = there in old and old.type_of(there) == kind
            if alike and same(old[there], new[path], kind) is True:
                related.add(path)
        return related

    def _run(self) -> set[Path]:
        """Reduce the relation until it is inductive, and return the outputs that are equal."""
        while True:
            step = self._step()
            lost = self._lost(step, self.relation)
            if not lost:
                break
            self.relation -= lost
        outputs = self._output_leaves(step)
        more = {path for path in outputs if path not in self.relation}
        lost = self._lost(step, more) if more else set()
        old, new = step.stops
        differs = both(either(old, new), negated(both(old, new)))
        self.may_stop = old is not False or new is not False
        self.stops_alike = differs is False or self._never(step, differs, running=False)
        good = (outputs - more) | (more - lost)
        return {
            path
            for path in self._pair.outputs.values()
            if all(leaf in good for leaf in outputs if leaf[: len(path)] == path)
        }

    def _output_leaves(self, step: _Step) -> set[Path]:
        return {
            leaf
            for leaf in step.both[1].snapshot()
            if any(leaf[: len(path)] == path for path in self._pair.outputs.values())
        }

    def _begin(self) -> tuple[Machines, tuple[Mapping[Path, Any], Mapping[Path, Any]]]:
        found = self._machines()
        old, new = found
        now = z3.BitVec("now", TIME_BITS)
        for version, machine in zip(self._pair.versions, found, strict=True):
            machine.now = now
            version.around.anything(machine)
        old.assume(z3.And(now >= 0, now < 1 << 62))
        for path in self.relation:
            new[path] = old[self._pair.old_path(path)]
        return found, (old.snapshot(), new.snapshot())

    def _step(self) -> _Step:
        found, before = self._begin()
        give(self._pair, self._inputs, found, 0, everything=True)
        for version, machine in zip(self._pair.versions, found, strict=True):
            version.around.scan(machine, 0)
        old, new = found
        equal: dict[Path, Bool] = {}
        for path, value in new.snapshot().items():
            there = self._pair.old_path(path)
            kind = new.type_of(path)
            if not is_temporary(path) and there in old and old.type_of(there) == kind:
                equal[path] = same(old[there], value, kind)
        return _Step(found, before, equal, (stopped(old), stopped(new)))

    def _solver(self, step: _Step, *, running: bool) -> Any:
        solver = z3.SolverFor(_LOGIC)
        solver.add(*step.both[0].assumptions, *step.both[1].assumptions)
        if running:
            solver.add(*(z3.Not(one) for one in step.stops if one is not False))
        for machine, before, held in zip(step.both, step.before, self._held, strict=True):
            solver.add(*(one.of(partial(_term, machine, before)) for one in held))
        return solver

    def _never(self, step: _Step, condition: Bool, *, running: bool) -> bool:
        solver = self._solver(step, running=running)
        solver.set("timeout", self._left_ms())
        solver.add(condition)
        return bool(solver.check() == z3.unsat)

    def _left_ms(self, share: int = 1) -> int:
        return max(int((self._end - time.monotonic()) * 1000 / share), 1)

    def _lost(self, step: _Step, paths: set[Path]) -> set[Path]:
        """Return the paths that one scan can make different, or for which this is not decided."""
        open_ = {path: step.equal.get(path, False) for path in paths}
        lost = {path for path, equal in open_.items() if equal is False}
        open_ = {p: equal for p, equal in open_.items() if not isinstance(equal, bool)}
        while open_:
            solver = self._solver(step, running=True)
            solver.set("timeout", self._left_ms(2))
            solver.add(z3.Not(z3.And(*open_.values())))
            answer = solver.check()
            if answer == z3.unsat:
                break
            if answer == z3.unknown:
                lost |= self._alone(step, open_)
                break
            model = solver.model()
            now = {
                path
                for path, equal in open_.items()
                if not z3.is_true(model.eval(equal, model_completion=True))
            }
            lost |= now
            open_ = {path: equal for path, equal in open_.items() if path not in now}
        return lost

    def _alone(self, step: _Step, open_: dict[Path, Bool]) -> set[Path]:
        """Return the paths that are not proved when each is asked for alone."""
        found = set()
        for path, equal in open_.items():
            solver = self._solver(step, running=True)
            solver.set("timeout", self._left_ms(4))
            solver.add(z3.Not(equal))
            if solver.check() != z3.unsat:
                found.add(path)
        return found

    def _find_invariants(self) -> None:
        """Find invariants of each version alone, which exclude states that no run reaches."""
        step = self._step()
        found = []
        for version, machine, before in zip(
            self._pair.versions, step.both, step.before, strict=True
        ):
            own = {file: file for file in version.own}
            copies = Copies((), (), own)
            inputs = {one.path for one in version.around.inputs}
            tried = candidates(version.project, copies, inputs)
            start = machines(self._pair, self._unchanged, self._milliseconds)[machine.side]
            version.around.start(start)
            limit = max(self._end - time.monotonic(), 0) / 4
            scan = (machine, before, machine.snapshot())
            found.append(kept(tried, (start, start.snapshot()), scan, limit))
        self._held = (found[0], found[1])


def _term(machine: PairedMachine, memory: Mapping[Path, Any], path: Path) -> Any:
    return machine.term(path, memory)
