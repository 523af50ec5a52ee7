"""Bounded search: find a run of a whole program, from its start, that breaks a property."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import z3

from structured_text.language.project import Project
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.prove import values
from structured_text.prove.logic import Bool
from structured_text.prove.program import ProgramMachine
from structured_text.prove.summaries import literals, one_of
from structured_text.prove.surroundings import Given, Surroundings
from structured_text.prove.symbolic_memory import Path

__all__ = [
    "Counterexample",
    "ScanInput",
    "Search",
    "SearchEndedError",
    "is_temporary",
    "value_of",
]


@dataclass(frozen=True)
class ScanInput:
    """The input before one scan: bytes and status of each device, and the variables set by path."""

    t_us: int
    areas: dict[int, tuple[bytes, bool]]
    inputs: dict[str, Any]


@dataclass(frozen=True)
class Counterexample:
    """A run from the start of the program.

    Attributes:
        scan_us: The period of its scans.
        steps: The input before each scan; the last scan is the one that breaks the property.
        states: The scalars of the program after each scan, by their path in the symbolic memory.
    """

    scan_us: int
    steps: tuple[ScanInput, ...]
    states: tuple[dict[Path, Any], ...]


class SearchEndedError(Exception):
    """The error for a search that has reached its time limit without a decision."""


@dataclass
class Search:
    """A bounded search that unrolls a program scan by scan, with all inputs from its surroundings.

    The first scan runs at time 0. `machine.own` holds the calls in all files outside the library;
    see `ProgramMachine`.

    Attributes:
        given: The input from the surroundings before each scan.
        states: The memory after each scan.
        names: Equations that define the names which stand for values of earlier scans.
    """

    project: Project
    scan_us: int
    around: Surroundings | None = None
    library: frozenset[str] = frozenset()
    milliseconds: str = ""
    given: list[Given] = field(default_factory=list)
    states: list[dict[Path, Any]] = field(default_factory=list)
    names: list[Any] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.around = self.around or Surroundings(self.project)
        self.machine = ProgramMachine(self.project, self.library, milliseconds=self.milliseconds)
        self.around.start(self.machine)

    @property
    def scans(self) -> int:
        """Return the number of scans that have been unrolled."""
        return len(self.given)

    def scan(self) -> None:
        """Unroll one more scan."""
        assert self.around is not None
        number = self.scans
        self.machine.now = number * self.scan_us * 1000
        self.given.append(self.around.give(self.machine, number))
        self.around.scan(self.machine, number)
        self._name(number)
        self.states.append(self.machine.snapshot())

    def _name(self, number: int) -> None:
        """Give each value a name, so that the terms of the next scan do not grow.

        Without names, each scan would contain the terms of all scans before it. A duration that is
        a choice among a few literals stays such a choice, because functions are run on each
        literal.
        """
        memory: dict[Path, Any] = {}
        for path, value in self.machine.snapshot().items():
            if is_temporary(path):
                continue
            kind = self.machine.type_of(path)
            if values.is_number(kind) and not isinstance(value, (bool, int)) and value.num_args():
                name = z3.Const(f"{'.'.join(map(str, path))}@{number}", value.sort())
                self.names.append(name == value)
                durations = literals(value) if values.is_duration(kind) else None
                value = one_of(name, durations) if durations else name
            memory[path] = value
        self.machine.restore(memory)

    def find(self, broken: Bool, limit_s: float) -> Counterexample | None:
        """Return a run in which `broken` holds in the scans unrolled so far, or None.

        Raises:
            SearchEndedError: The solver has not decided the condition within `limit_s` seconds.
        """
        if broken is False:
            return None
        # A new solver for each search is faster: its preprocessing saves more than learned clauses
        # would.
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", max(int(limit_s * 1000), 1))
        solver.add(*self.machine.assumptions, *self.names, broken)
        found = solver.check()
        if found == z3.unknown:
            raise SearchEndedError(solver.reason_unknown())
        return self._run(solver.model()) if found == z3.sat else None

    def _run(self, model: Any) -> Counterexample:
        """Return the run that a model of the solver describes."""
        assert self.around is not None
        kinds = {one.name: one.type for one in self.around.inputs}
        steps = []
        for number, given in enumerate(self.given):
            areas = {
                controller: (bytes(_number(model, byte) for byte in content), _true(model, status))
                for controller, (content, status) in given.areas.items()
            }
            inputs = {
                name: value_of(model, term, kinds[name]) for name, term in given.inputs.items()
            }
            steps.append(ScanInput(number * self.scan_us, areas, inputs))
        states = tuple(self._state(model, state) for state in self.states)
        return Counterexample(self.scan_us, tuple(steps), states)

    def _state(self, model: Any, state: dict[Path, Any]) -> dict[Path, Any]:
        """Return the numeric scalars of a state in a model.

        All values are evaluated as one concatenated term, because they share subterms. Temporary
        variables and values that are not numbers are omitted.
        """
        paths = [
            path
            for path in state
            if not is_temporary(path) and values.is_number(self.machine.type_of(path))
        ]
        known = {path: state[path] for path in paths if isinstance(state[path], (bool, int))}
        open_ = [path for path in paths if path not in known]
        if open_:
            bits = [_as_bits(self.machine.term(path, state)) for path in open_]
            whole = z3.Concat(*bits) if len(bits) > 1 else bits[0]
            number = model.eval(whole, model_completion=True).as_long()
            for path, part in zip(reversed(open_), reversed(bits), strict=True):
                raw = number & (1 << part.size()) - 1
                known[path] = signed(self.machine.type_of(path), raw)
                number >>= part.size()
        return known


def is_temporary(path: Path) -> bool:
    """Return whether a path is a variable of a function, or a VAR_TEMP, of a finished call."""
    return str(path[0]).startswith("#")


def _as_bits(term: Any) -> Any:
    if z3.is_bool(term):
        return z3.If(term, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))
    return term


def signed(kind: Type, raw: int) -> Any:
    """Return the number, truth value or member that the bits of a value represent."""
    if kind == ElementaryType("BOOL"):
        return bool(raw)
    width = values.bits(kind)
    if values.is_duration(kind):
        return raw - (1 << width) if raw >> width - 1 else raw
    return raw if isinstance(kind, EnumType) else values.wrapped(kind, raw)


def value_of(model: Any, term: Any, kind: Type) -> Any:
    """Return the value of a scalar in a model of the solver."""
    raw = model.eval(_as_bits(term), model_completion=True).as_long()
    return signed(kind, raw)


def _number(model: Any, term: Any) -> int:
    return int(model.eval(term, model_completion=True).as_long())


def _true(model: Any, term: Any) -> bool:
    return bool(z3.is_true(model.eval(term, model_completion=True)))
