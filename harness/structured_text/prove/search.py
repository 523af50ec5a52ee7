"""Bounded search: a run of a whole program from its start that breaks a claim."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import z3

from structured_text.language.project import Project
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.prove import values
from structured_text.prove.logic import Bool
from structured_text.prove.machine import Path
from structured_text.prove.program import ProgramMachine
from structured_text.prove.summaries import literals, one_of
from structured_text.prove.surroundings import Given, Surroundings

__all__ = ["Run", "Search", "SearchEndedError", "Step", "value_of"]


@dataclass(frozen=True)
class Step:
    """What happens before a scan: bytes and status of each device, and the inputs by path."""

    t_us: int
    areas: dict[int, tuple[bytes, bool]]
    inputs: dict[str, Any]


@dataclass(frozen=True)
class Run:
    """A run from the start.

    Attributes:
        scan_us: The period of its scans.
        steps: What happens before each of them; the last is the scan that breaks the claim.
        states: After each scan the scalars of the program, by their place in a machine.
    """

    scan_us: int
    steps: tuple[Step, ...]
    states: tuple[dict[Path, Any], ...]


class SearchEndedError(Exception):
    """The limit was reached before the search was through."""


@dataclass
class Search:
    """Unrolls a program scan by scan, with all that its surroundings may do.

    Args:
        project: The sources, with the programs that run.
        scan_us: The period of the scans; the first is at 0.
        around: Its surroundings, where they are known already.
        library: The files of the library: then `machine.own` are the calls in all others.
        milliseconds: See `ProgramMachine`.

    Attributes:
        given: What the surroundings do before each scan.
        states: The memory after each scan.
        names: What the names stand for that values of earlier scans got.
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
        """How many scans have been unrolled."""
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
        """Give each value a name, so that the next scan's terms are no larger than this one's.

        A duration that is one of a few literals stays so: functions are run on each of them.
        """
        memory: dict[Path, Any] = {}
        for path, value in self.machine.snapshot().items():
            if is_temporary(path):
                continue
            kind = self.machine.type_of(path)
            if _is_number(kind) and not isinstance(value, (bool, int)) and value.num_args():
                name = z3.Const(f"{'.'.join(map(str, path))}@{number}", value.sort())
                self.names.append(name == value)
                durations = literals(value) if values.is_duration(kind) else None
                value = one_of(name, durations) if durations else name
            memory[path] = value
        self.machine.restore(memory)

    def find(self, broken: Bool, limit_s: float) -> Run | None:
        """A run in which something is so by now; None if there is none.

        Raises:
            SearchEndedError: not decided in so many seconds.
        """
        if broken is False:
            return None
        # A new solver each time: what it does before it searches is worth more than what it knows.
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", max(int(limit_s * 1000), 1))
        solver.add(*self.machine.assumptions, *self.names, broken)
        found = solver.check()
        if found == z3.unknown:
            raise SearchEndedError(solver.reason_unknown())
        return self._run(solver.model()) if found == z3.sat else None

    def _run(self, model: Any) -> Run:
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
            steps.append(Step(number * self.scan_us, areas, inputs))
        states = tuple(self._state(model, state) for state in self.states)
        return Run(self.scan_us, tuple(steps), states)

    def _state(self, model: Any, state: dict[Path, Any]) -> dict[Path, Any]:
        """The scalars of a state; all in one question, whose parts share what they have in common.

        Temporary variables and those that are no number are left out.
        """
        paths = [
            path
            for path in state
            if not is_temporary(path) and _is_number(self.machine.type_of(path))
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
    """Whether it is a variable of a function, or a VAR_TEMP, of a call that is over."""
    return str(path[0]).startswith("#")


def _is_number(kind: Type) -> bool:
    return values.bits(kind) > 0 or kind == ElementaryType("BOOL")


def _as_bits(term: Any) -> Any:
    if z3.is_bool(term):
        return z3.If(term, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1))
    return term


def signed(kind: Type, raw: int) -> Any:
    """The bits of a value as the number that they mean."""
    if kind == ElementaryType("BOOL"):
        return bool(raw)
    width = values.bits(kind)
    if values.is_duration(kind):
        return raw - (1 << width) if raw >> width - 1 else raw
    return raw if isinstance(kind, EnumType) else values.wrapped(kind, raw)


def value_of(model: Any, term: Any, kind: Type) -> Any:
    """A scalar's value in a case that the solver found."""
    raw = model.eval(_as_bits(term), model_completion=True).as_long()
    return signed(kind, raw)


def _number(model: Any, term: Any) -> int:
    return int(model.eval(term, model_completion=True).as_long())


def _true(model: Any, term: Any) -> bool:
    return bool(z3.is_true(model.eval(term, model_completion=True)))
