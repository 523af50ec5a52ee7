"""Bounded search from the cold start for a run in which the outputs of two versions differ."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import z3

from structured_text.prove import values
from structured_text.prove.against.machine import PairedMachine, same
from structured_text.prove.against.step import Inputs, give, machines, stopped
from structured_text.prove.against.versions import Pair
from structured_text.prove.logic import Bool, both, either, negated
from structured_text.prove.search import ScanInput, SearchEndedError, is_temporary, value_of
from structured_text.prove.summaries import literals, one_of
from structured_text.prove.symbolic_memory import Path

__all__ = ["PairSearch", "Run"]


@dataclass(frozen=True)
class Run:
    """A run of both versions: its scan period, and the input before each scan.

    The inputs of a scan contain only the variables that are set before it.
    """

    scan_us: int
    steps: tuple[ScanInput, ...]


class PairSearch:
    """A bounded search that unrolls both versions scan by scan with the same inputs."""

    def __init__(self, pair: Pair, scan_us: int, milliseconds: str, until: float) -> None:
        self._pair, self.scan_us = pair, scan_us
        self._inputs = pair.inputs()
        self._both = machines(pair, frozenset(), milliseconds, exact=True)
        self._given: list[Inputs] = []
        self._facts: list[Any] = []
        for version, machine in zip(pair.versions, self._both, strict=True):
            machine.until = until
            version.around.start(machine)

    @property
    def scans(self) -> int:
        """Return the number of scans that have been unrolled."""
        return len(self._given)

    def scan(self) -> dict[str, Bool]:
        """Unroll one more scan; return the condition that each output differs after it.

        The name "" has the condition that only one version stops.
        """
        number = self.scans
        for machine in self._both:
            machine.now = number * self.scan_us * 1000
        self._given.append(give(self._pair, self._inputs, self._both, number, everything=False))
        for version, machine in zip(self._pair.versions, self._both, strict=True):
            version.around.scan(machine, number)
        stops = [stopped(machine) for machine in self._both]
        runs = both(*map(negated, stops))
        found = {"": both(either(*stops), negated(both(*stops)))}
        old, new = self._both
        for name, path in self._pair.outputs.items():
            leaves = [leaf for leaf in new.snapshot() if leaf[: len(path)] == path]
            equal = both(*(same(old[leaf], new[leaf], new.type_of(leaf)) for leaf in leaves))
            found[name] = both(runs, negated(equal))
        self._name(number)
        self._runs = runs
        return found

    def proceed(self) -> None:
        """Assume that both versions have run to the end of the last scan."""
        if not isinstance(self._runs, bool):
            self._facts.append(self._runs)

    def _name(self, number: int) -> None:
        """Give each value a name, so that the terms of the next scan do not grow.

        Equal terms of both versions get the same name, so that equal parts stay equal.
        """
        named: dict[int, Any] = {}
        for side, machine in enumerate(self._both):
            memory: dict[Path, Any] = {}
            for path, value in machine.snapshot().items():
                if is_temporary(path):
                    continue
                memory[path] = self._named(machine, path, value, f"{number}{'ab'[side]}", named)
            machine.restore(memory)

    def _named(
        self, machine: PairedMachine, path: Path, value: Any, suffix: str, named: dict[int, Any]
    ) -> Any:
        kind = machine.type_of(path)
        if not values.is_number(kind) or isinstance(value, (bool, int)) or not value.num_args():
            return value
        name = named.get(value.get_id())
        if name is None:
            name = z3.Const(f"{'.'.join(map(str, path))}@{suffix}", value.sort())
            named[value.get_id()] = name
            self._facts.append(name == value)
        durations = literals(value) if values.is_duration(kind) else None
        return one_of(name, durations) if durations else name

    def find(self, differs: Bool, limit_s: float) -> Run | None:
        """Return a run with a difference in the last scan, or None.

        Raises:
            SearchEndedError: The solver has not decided it within `limit_s` seconds.
        """
        if differs is False:
            return None
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", max(int(limit_s * 1000), 1))
        for machine in self._both:
            solver.add(*machine.assumptions)
        solver.add(*self._facts, differs)
        found = solver.check()
        if found == z3.unknown:
            raise SearchEndedError(solver.reason_unknown())
        return self._run(solver.model()) if found == z3.sat else None

    def _run(self, model: Any) -> Run:
        steps = []
        known = {one.name: one for one in self._inputs}
        last = {one.name: one.any.initial for one in self._inputs if one.steady}
        for number, given in enumerate(self._given):
            areas = {
                device: (bytes(_number(model, byte) for byte in content), _true(model, status))
                for device, (content, status) in given.areas.items()
            }
            inputs = {}
            for name, term in given.values.items():
                if not _true(model, given.when[name]):
                    continue
                value = value_of(model, term, known[name].any.type)
                if name not in last or last[name] != value:
                    inputs[name] = value
                if name in last:
                    last[name] = value
            steps.append(ScanInput(number * self.scan_us, areas, inputs))
        return Run(self.scan_us, tuple(steps))


def _number(model: Any, term: Any) -> int:
    return int(model.eval(term, model_completion=True).as_long())


def _true(model: Any, term: Any) -> bool:
    return term if isinstance(term, bool) else z3.is_true(model.eval(term, model_completion=True))
