"""Results of coverage from counts, for each file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from structured_text.coverage.parts import CountedPou, Merged
from structured_text.engines.builtin.coverage import Postfix, outcome
from structured_text.output.paths import real

__all__ = [
    "Condition",
    "DecisionResult",
    "FileResult",
    "Item",
    "Judged",
    "Share",
    "judge",
    "measure",
]


@dataclass(frozen=True)
class Share:
    """A number of covered items out of a total; justified items are in neither number."""

    covered: int = 0
    total: int = 0
    justified: int = 0

    def __add__(self, other: Share) -> Share:
        return Share(
            self.covered + other.covered,
            self.total + other.total,
            self.justified + other.justified,
        )

    @property
    def percent(self) -> float:
        """Return the covered share in percent; 100 if there is nothing to cover."""
        return 100.0 * self.covered / self.total if self.total else 100.0

    @property
    def shown(self) -> str:
        """Return `84.6 %`, rounded down, so that 100 means that everything is covered."""
        tenths = 1000 * self.covered // self.total if self.total else 1000
        return f"{tenths // 10}.{tenths % 10} %"

    @property
    def complete(self) -> bool:
        """Return whether everything is covered."""
        return self.covered == self.total


@dataclass(frozen=True)
class Item:
    """A statement or branch: how often it was executed, and the reason if it cannot be executed.

    `text` describes a branch. For a statement of a rung or network it is the translation.
    `run` is the number of the counter. For a branch, `fork` is the number of its IF, CASE or loop
    in the file, and `at` is the first line of this statement.
    """

    line: int
    hits: int
    run: int
    text: str = ""
    at: int = 0
    fork: int = 0
    reason: str = ""


@dataclass(frozen=True)
class Judged:
    """The facts about one condition of a decision.

    Attributes:
        values: The values that the condition has had.
        deciding: The values with which the condition has decided the outcome: both if it has MC/DC,
            else at most one value.
        unique: Whether the condition has decided as TRUE and as FALSE in two evaluations that
            differ in no other condition. Conditions that one of the evaluations skipped do not
            count.
    """

    values: frozenset[bool]
    deciding: frozenset[bool]
    unique: bool

    @property
    def masking(self) -> bool:
        """Return whether the condition has decided the outcome as TRUE and as FALSE."""
        return len(self.deciding) == 2


@dataclass(frozen=True)
class Condition:
    """A condition of a decision; `reason` says why it has no MC/DC."""

    text: str
    judged: Judged
    reason: str = ""


@dataclass(frozen=True)
class DecisionResult:
    """A decision, its conditions, and each evaluated vector of condition values with its outcome.

    `at` is the first line of the statement with the decision. `judge` describes the vectors.
    """

    line: int
    at: int
    text: str
    conditions: tuple[Condition, ...]
    vectors: Mapping[int, bool]


@dataclass
class FileResult:
    """The results of one file.

    Attributes:
        path: The path as it is displayed, `folder/Block.st`.
        source: The lines of the file, by their numbers.
        networks: The rungs or networks that lines were translated from, such as `Main, rung 3`, by
            their numbers.
        pous: Name, line and number of calls of each function or block in the file.
        bodies: For each POU in `pous`, the sorted lines of its statements.
        stale: Numbers of lines that are marked as unreachable although everything on them was
            executed.
        changed: Whether the file has changed since the run, or counts of several versions exist.
        demands_mcdc: Whether MC/DC is required for the file.
        runs: The number of counters in the file.
    """

    path: str
    source: dict[int, str] = field(default_factory=dict)
    networks: dict[int, str] = field(default_factory=dict)
    pous: list[tuple[str, int, int]] = field(default_factory=list)
    bodies: list[list[int]] = field(default_factory=list)
    statements: list[Item] = field(default_factory=list)
    branches: list[Item] = field(default_factory=list)
    decisions: list[DecisionResult] = field(default_factory=list)
    stale: list[int] = field(default_factory=list)
    changed: bool = False
    demands_mcdc: bool = False
    runs: int = 0

    @property
    def folder(self) -> str:
        """Return the first folder in the displayed path of the file."""
        return self.path.partition("/")[0]

    @property
    def statement_share(self) -> Share:
        """Return the share of executed statements."""
        return _share(self.statements)

    @property
    def branch_share(self) -> Share:
        """Return the share of branches taken."""
        return _share(self.branches)

    @property
    def condition_share(self) -> Share:
        """Return the share of conditions that were both TRUE and FALSE."""
        return self._conditions(lambda one: len(one.judged.values) == 2)

    @property
    def mcdc_share(self) -> Share:
        """Return the share of conditions with MC/DC."""
        return self._conditions(lambda one: one.judged.masking)

    @property
    def unique_share(self) -> Share:
        """Return the share of conditions with unique-cause MC/DC."""
        return self._conditions(lambda one: one.judged.unique)

    def _conditions(self, holds: Callable[[Condition], bool]) -> Share:
        every = [one for decision in self.decisions for one in decision.conditions]
        justified = sum(1 for one in every if one.reason and not holds(one))
        return Share(sum(map(holds, every)), len(every) - justified, justified)


def _share(items: Iterable[Item]) -> Share:
    every = list(items)
    justified = sum(1 for item in every if item.reason and not item.hits)
    return Share(sum(1 for item in every if item.hits), len(every) - justified, justified)


def measure(
    merged: Merged,
    home: Path,
    reasons: Mapping[tuple[str, str, str], str] | None = None,
    demanded: tuple[str, ...] = (),
) -> list[FileResult]:
    """Return the results of each file that has code, in the order of their paths.

    Args:
        merged: The counts.
        home: The folder to which displayed paths are relative. Files outside it have absolute
            paths.
        reasons: The reasons why a condition has no MC/DC, by (POU, decision, condition).
        demanded: Beginnings of the paths for which MC/DC is required.
    """
    results = []
    for name in sorted({*merged.files, *merged.changed}):
        file = Path(name)
        below = file.is_relative_to(real(home))
        path = (file.relative_to(real(home)) if below else file).as_posix()
        versions = list(merged.files.get(name, {}).values())
        result = FileResult(path)
        result.demands_mcdc = path.startswith(demanded)
        result.changed = name in merged.changed or len(versions) > 1
        for source in versions[-1:]:
            result.source, result.networks = source.lines, source.networks
            for pou in source.pous.values():
                if result.changed:
                    pou = CountedPou(pou.listing, [0] * len(pou.counters), [set()] * len(pou.seen))
                _fill(result, pou, source.reasons, reasons or {})
            missed = {one.line for one in (*result.statements, *result.branches) if not one.hits}
            result.stale = sorted(set(source.reasons) - missed)
        if result.statements or result.changed:
            results.append(result)
    return sorted(results, key=lambda one: one.path)


def _fill(
    result: FileResult,
    pou: CountedPou,
    why: Mapping[int, str],
    reasons: Mapping[tuple[str, str, str], str],
) -> None:
    found, counters = pou.listing, pou.counters
    # The plan numbers counters and forks within a POU. Here they get numbers that are unique in the
    # file.
    runs, forks = result.runs, 1 + max((one.fork for one in result.branches), default=-1)
    result.runs += len(counters)
    if not found.statements:
        return
    result.pous.append((found.name, found.line, counters[found.statements[0].counter]))
    result.bodies.append(sorted({point.line for point in found.statements}))
    for point in found.statements:
        hits, run = counters[point.counter], runs + point.counter
        reason = why.get(point.line, "")
        item = Item(point.line, hits, run, point.text, point.line, reason=reason)
        result.statements.append(item)
    for way in found.branches:
        hits, run, fork = counters[way.counter], runs + way.counter, forks + way.fork
        reason = why.get(way.line, "")
        result.branches.append(Item(way.line, hits, run, way.text, way.at, fork, reason))
    for decision, vectors in zip(found.decisions, pou.seen, strict=True):
        conditions = []
        judged = judge(decision.code, len(decision.conditions), vectors)
        for shown, one in zip(decision.conditions, judged, strict=True):
            reason = reasons.get((found.name, decision.text, shown), "")
            conditions.append(Condition(shown, one, reason))
        size = len(decision.conditions)
        outcomes = {
            vector: bool(outcome(decision.code, vector, vector >> size))
            for vector in sorted(vectors)
        }
        result.decisions.append(
            DecisionResult(decision.line, decision.at, decision.text, tuple(conditions), outcomes)
        )


def judge(code: Postfix, size: int, vectors: Collection[int]) -> list[Judged]:
    """Judge the conditions of a decision.

    Bit k of a vector is the value of condition k; bit `size` + k says that condition k was skipped.
    """
    outcomes = {vector: bool(outcome(code, vector, vector >> size)) for vector in vectors}
    return [_judge(code, size, outcomes, k) for k in range(size)]


def _judge(code: Postfix, size: int, outcomes: dict[int, bool], number: int) -> Judged:
    """Judge one condition of a decision.

    The condition decides an evaluation if inverting it changes the outcome. It has masking MC/DC if
    it decides one evaluation as TRUE and another as FALSE, with opposite outcomes. It has
    unique-cause MC/DC if two such evaluations differ in no other condition. Evaluations that
    skipped the condition do not count.
    """
    bit, skips = 1 << number, 1 << number + size
    seen = {vector: result for vector, result in outcomes.items() if not vector & skips}
    decides: set[tuple[bool, bool]] = set()
    for vector, result in seen.items():
        # Skipped conditions may have any value, so the outcome of the inverted vector may be
        # unknown; an unknown outcome counts as a change.
        if outcome(code, vector ^ bit, vector >> size) is not result:
            decides.add((bool(vector & bit), result))
    masking = any((not value, not result) in decides for value, result in decides)
    deciding = frozenset(value for value, _ in decides)
    skips_any = any(vector >> size for vector in seen)
    return Judged(
        values=frozenset(bool(vector & bit) for vector in seen),
        deciding=deciding if masking else frozenset(sorted(deciding)[:1]),
        unique=any(
            _differs(vector, result, seen, bit, size)
            if skips_any
            else seen.get(vector ^ bit, result) != result
            for vector, result in seen.items()
        ),
    )


def _differs(vector: int, result: bool, seen: dict[int, bool], bit: int, size: int) -> bool:
    """Return whether another evaluation has another outcome and differs in one condition only."""
    every = (1 << size) - 1
    return any(
        other != result and (vector ^ one) & every & ~((vector | one) >> size) == bit
        for one, other in seen.items()
    )
