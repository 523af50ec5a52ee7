"""Inductive invariants of a user's variables: this module generates candidates and tests them.

The induction step starts from any state, also from states that no run reaches. Invariants exclude
such states. Candidates are simple relations between variables and constants of the program. The
Houdini method finds the largest subset that is inductive as a whole: it assumes all candidates,
runs one scan, and discards each candidate that the solver can break, until none is broken.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any

import z3

from structured_text.engines.builtin.storage import is_scalar
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, ElementaryType, EnumType, Type
from structured_text.language.walk import nodes
from structured_text.prove import values
from structured_text.prove.assertions import Copies
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path

__all__ = ["Candidate", "Look", "candidates", "constants", "kept"]

#: Highest number of BOOL variables for which pairs are tried.
_PAIRS = 40

#: A function that returns a scalar of some memory as a term, given its path.
Look = Callable[[Path], Any]


@dataclass(frozen=True)
class Candidate:
    """A relation that may hold after every scan; `of` returns it as a term of a memory."""

    says: str
    of: Callable[[Look], Any]


@dataclass(frozen=True)
class _Variable:
    """A variable of the user's own code: its path, its type and its initial value."""

    path: Path
    type: Type
    initial: Any


def candidates(project: Project, copies: Copies, inputs: set[Path]) -> list[Candidate]:
    """Return the candidates for the user's own variables that are not inputs."""
    own = [
        one
        for name, block in project.instances.items()
        for one in _own((name.upper(),), block, project, copies)
        if one.path not in inputs
    ]
    numbers = sorted(constants(project, copies.originals))
    return [*_ranges(own, numbers), *_pairs(own)]


def _own(path: Path, block: BlockType, project: Project, copies: Copies) -> Iterator[_Variable]:
    for symbol in project.pous[block.name.upper()].symbols.values():
        if symbol.section not in ("VAR", "VAR_OUTPUT", "VAR_INPUT") or symbol.address is not None:
            continue
        place = (*path, symbol.name.upper())
        if is_scalar(symbol.type):
            if not symbol.constant and values.is_number(symbol.type):
                yield _Variable(place, symbol.type, symbol.initial)
        elif isinstance(symbol.type, BlockType):
            pou = project.pous.get(symbol.type.name.upper())
            if pou is not None and pou.file in copies.originals:
                yield from _own(place, symbol.type, project, copies)


def _ranges(own: list[_Variable], numbers: list[int]) -> Iterator[Candidate]:
    for one in own:
        name, initial = ".".join(map(str, one.path)), one.initial
        yield Candidate(f"{name} = {initial}", _compared("=", one, initial))
        if one.type == ElementaryType("BOOL") or isinstance(one.type, EnumType):
            members = len(one.type.members) if isinstance(one.type, EnumType) else 0
            for member in range(members):
                yield Candidate(f"{name} <> {member}", _compared("<>", one, member))
            continue
        for number in numbers:
            if values.wrapped(one.type, number) != number:
                continue
            if number >= initial:
                yield Candidate(f"{name} <= {number}", _compared("<=", one, number))
            if number <= initial:
                yield Candidate(f"{name} >= {number}", _compared(">=", one, number))


def _compared(op: str, one: _Variable, number: Any) -> Callable[[Look], Any]:
    return lambda look: _term(values.compare(op, look(one.path), number, one.type))


def _pairs(own: list[_Variable]) -> Iterator[Candidate]:
    """Yield candidates about two variables: two BOOL, or a BOOL and an enumeration.

    Two BOOL may exclude or imply each other, or at least one of them may be TRUE. A BOOL may
    exclude a member of an enumeration, or be implied by it.
    """
    flags = [one for one in own if one.type == ElementaryType("BOOL")]
    stages = [one for one in own if isinstance(one.type, EnumType)]
    if len(flags) > _PAIRS:
        return
    both = (True, False)
    for (one, other), left, right in product(combinations(flags, 2), both, both):
        text = f"{one.path} {left} or {other.path} {right}"
        yield Candidate(text, _either(_flag(one, left), _flag(other, right)))
    for flag, stage in product(flags, stages):
        assert isinstance(stage.type, EnumType)
        for member, wanted in product(range(len(stage.type.members)), both):
            text = f"{flag.path} {wanted} or {stage.path} <> {member}"
            yield Candidate(text, _either(_flag(flag, wanted), _compared("<>", stage, member)))


def _flag(one: _Variable, wanted: bool) -> Callable[[Look], Any]:
    return lambda look: look(one.path) if wanted else z3.Not(look(one.path))


def _either(first: Callable[[Look], Any], second: Callable[[Look], Any]) -> Callable[[Look], Any]:
    return lambda look: z3.Or(first(look), second(look))


def _term(value: Any) -> Any:
    return z3.BoolVal(value) if isinstance(value, bool) else value


def kept(
    tried: list[Candidate],
    start: tuple[Machine, Mapping[Path, Any]],
    scan: tuple[Machine, Mapping[Path, Any], Mapping[Path, Any]],
    limit_s: float,
) -> list[Candidate]:
    """Return the candidates that hold at the start and that no scan breaks (Houdini).

    Each round assumes all remaining candidates before the scan and asks the solver for a scan after
    which at least one fails. Every candidate that fails in this model is discarded. The result is
    inductive as soon as the solver finds no such scan. `start` is a machine with the memory of the
    start. `scan` is a machine with the memory before a scan from any state, and after it. If the
    time limit is exceeded, the result is empty.
    """
    end = time.monotonic() + limit_s
    machine, first = start
    holds = [one for one in tried if z3.is_true(z3.simplify(one.of(_look(machine, first))))]
    machine, before, after = scan
    pairs = [(one, one.of(_look(machine, before)), one.of(_look(machine, after))) for one in holds]
    while pairs:
        left = end - time.monotonic()
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", max(int(left * 1000), 1))
        solver.add(*machine.assumptions, *(was for _, was, _ in pairs))
        solver.add(z3.Or(*(z3.Not(now) for _, _, now in pairs)))
        found = solver.check()
        if found == z3.unsat:
            break
        if found == z3.unknown or left <= 0:
            return []
        model = solver.model()
        pairs = [one for one in pairs if not z3.is_false(model.eval(one[2], model_completion=True))]
    return [one for one, _, _ in pairs]


def _look(machine: Machine, memory: Mapping[Path, Any]) -> Look:
    return lambda path: machine.term(path, memory)


def constants(project: Project, files: Container[str]) -> set[int]:
    """Return the integers in the code and array bounds of some files, and each integer minus 1."""
    found = {0, 1}
    for pou in project.pous.values():
        if pou.file not in files:
            continue
        for symbol in pou.symbols.values():
            if isinstance(symbol.type, ArrayType):
                found.update(bound for pair in symbol.type.bounds for bound in pair)
            elif isinstance(symbol.initial, int):
                found.add(int(symbol.initial))
        for one in nodes(pou.body):
            if isinstance(one, t.Constant) and isinstance(one.value, int):
                found.add(int(one.value))
            elif isinstance(one, t.Case):
                found.update(end for labels, _ in one.branches for pair in labels for end in pair)
    return found | {number - 1 for number in found}
