"""From counts to results: what of each file was covered."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.engine.builtin.coverage import Collector, Decision
from rcx_harness.engine.frontend.load import checked
from rcx_harness.verify.coverage.listing import Listing, listing, text_of

__all__ = [
    "Condition",
    "DecisionResult",
    "FileResult",
    "Item",
    "Judged",
    "Merged",
    "Share",
    "judge",
    "measure",
    "merge",
]


@dataclass(frozen=True)
class Share:
    """So many of so many; what is justified is in neither number."""

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
        """Covered of all, 100 where there is nothing to cover."""
        return 100.0 * self.covered / self.total if self.total else 100.0

    @property
    def complete(self) -> bool:
        """Whether nothing is left."""
        return self.covered == self.total


@dataclass(frozen=True)
class Item:
    """A statement or branch: how often it was executed, and why it need not be.

    `run` is its counter, `fork` the IF, CASE or WHILE of a branch by its number in the file.
    """

    line: int
    hits: int
    run: int
    text: str = ""
    fork: int = 0
    reason: str = ""


@dataclass(frozen=True)
class Condition:
    """A condition of a decision; `reason` says why it has no MC/DC."""

    text: str
    values: frozenset[bool]
    masking: bool
    unique: bool
    reason: str = ""


@dataclass(frozen=True)
class DecisionResult:
    """A decision, its conditions, and the vectors in which it was evaluated, with outcomes."""

    line: int
    text: str
    conditions: tuple[Condition, ...]
    vectors: Mapping[int, bool]


@dataclass
class FileResult:
    """The results of one file.

    Attributes:
        path: Below the library, as in `folder/Block.st`.
        source: Its lines.
        pous: Name, line and number of calls of each function or block in it.
        stale: Lines with a reason although everything on them was executed.
        changed: There are counts, but of another version of the file.
        demands_mcdc: MC/DC is demanded of it.
    """

    path: str
    source: list[str]
    pous: list[tuple[str, int, int]] = field(default_factory=list)
    statements: list[Item] = field(default_factory=list)
    branches: list[Item] = field(default_factory=list)
    decisions: list[DecisionResult] = field(default_factory=list)
    stale: list[int] = field(default_factory=list)
    changed: bool = False
    demands_mcdc: bool = False

    @property
    def folder(self) -> str:
        """Folder in the library."""
        return self.path.partition("/")[0]

    @property
    def statement_share(self) -> Share:
        """Statements executed."""
        return _share(self.statements)

    @property
    def branch_share(self) -> Share:
        """Branches taken."""
        return _share(self.branches)

    @property
    def condition_share(self) -> Share:
        """Conditions that were both TRUE and FALSE."""
        return self._conditions(lambda one: len(one.values) == 2)

    @property
    def mcdc_share(self) -> Share:
        """Conditions with MC/DC."""
        return self._conditions(lambda one: one.masking)

    @property
    def unique_share(self) -> Share:
        """Conditions with unique-cause MC/DC."""
        return self._conditions(lambda one: one.unique)

    def _conditions(self, holds: Callable[[Condition], bool]) -> Share:
        every = [one for decision in self.decisions for one in decision.conditions]
        justified = sum(1 for one in every if one.reason and not holds(one))
        return Share(sum(map(holds, every)), len(every) - justified, justified)


def _share(items: Iterable[Item]) -> Share:
    every = list(items)
    justified = sum(1 for item in every if item.reason and not item.hits)
    return Share(sum(1 for item in every if item.hits), len(every) - justified, justified)


@dataclass
class Merged:
    """The counts of all processes: those of one POU by (file, hash of its text, name)."""

    counters: dict[tuple[str, str, str], list[int]] = field(default_factory=dict)
    seen: dict[tuple[str, str, str], list[set[int]]] = field(default_factory=dict)

    def add(self, data: Iterable[Mapping[str, Any]]) -> None:
        """Add what one process has counted, as `Collector.data` gives it."""
        for entry in data:
            key = entry["file"], entry["hash"], entry["pou"]
            counters = self.counters.setdefault(key, [0] * len(entry["counters"]))
            counters[:] = map(sum, zip(counters, entry["counters"], strict=True))
            seen = self.seen.setdefault(key, [set() for _ in entry["seen"]])
            for every, vectors in zip(seen, entry["seen"], strict=True):
                every.update(vectors)


def merge(source: Path | Collector) -> Merged:
    """The counts of a collector, or those in the files of a folder."""
    merged = Merged()
    if isinstance(source, Collector):
        merged.add(source.data())
        return merged
    for file in sorted(source.glob("*.json")):
        merged.add(json.loads(file.read_text(encoding="utf-8")))
    return merged


def measure(
    library: Path,
    merged: Merged,
    reasons: Mapping[tuple[str, str, str], str] | None = None,
    demanded: tuple[str, ...] = (),
) -> list[FileResult]:
    """The results of each file of a library that has code, in the order of their paths.

    Args:
        library: Its folder; counts of another version of a file do not count.
        merged: The counts.
        reasons: Why a condition has no MC/DC, by (POU, decision, condition).
        demanded: Folders and files of which MC/DC is demanded, as their paths begin.
    """
    files = sorted(library.resolve().rglob("*.st"))
    counted = {file for file, _, _ in merged.counters}
    results = []
    for pou in checked(files).pous.values():
        found = listing(pou)
        path = found.file.relative_to(library.resolve()).as_posix()
        text = found.file.read_bytes()
        key = str(found.file), hashlib.sha256(text).hexdigest(), pou.name.upper()
        counters = merged.counters.get(key, [0] * found.plan.size)
        seen = merged.seen.get(key, [set() for _ in found.plan.decisions])
        result = FileResult(path, text.decode("utf-8").splitlines())
        result.demands_mcdc = path.startswith(demanded)
        result.changed = key not in merged.counters and key[0] in counted
        _fill(result, found, counters, seen, reasons or {})
        results.append(result)
    return sorted(results, key=lambda one: one.path)


def _fill(
    result: FileResult,
    found: Listing,
    counters: Sequence[int],
    seen: Sequence[set[int]],
    reasons: Mapping[tuple[str, str, str], str],
) -> None:
    calls = counters[found.statements[0].counter] if found.statements else 0
    result.pous.append((found.name, found.line, calls))
    why = found.reasons
    for point in found.statements:
        hits = counters[point.counter]
        result.statements.append(
            Item(point.line, hits, point.counter, reason=why.get(point.line, ""))
        )
    for way in found.branches:
        hits, reason = counters[way.counter], why.get(way.line, "")
        result.branches.append(Item(way.line, hits, way.counter, way.text, way.fork, reason))
    missed = {item.line for item in (*result.statements, *result.branches) if not item.hits}
    result.stale = sorted(set(why) - missed)
    for (line, decision), vectors in zip(found.decisions, seen, strict=True):
        text = text_of(decision.root)
        conditions = []
        judged = judge(decision, vectors)
        for condition, one in zip(decision.conditions, judged, strict=True):
            shown = text_of(condition)
            reason = reasons.get((found.name, text, shown), "")
            conditions.append(Condition(shown, one.values, one.masking, one.unique, reason))
        outcomes = {vector: decision.outcome(vector) for vector in sorted(vectors)}
        result.decisions.append(DecisionResult(line, text, tuple(conditions), outcomes))


@dataclass(frozen=True)
class Judged:
    """What is known about one condition of a decision.

    Attributes:
        values: The values it has had.
        masking: It has decided the outcome as TRUE and as FALSE.
        unique: So in two evaluations that differ in nothing else.
    """

    values: frozenset[bool]
    masking: bool
    unique: bool


def judge(decision: Decision, vectors: Collection[int]) -> list[Judged]:
    """Judge the conditions of a decision.

    Args:
        decision: The decision.
        vectors: All vectors in which it was evaluated; bit k is the condition k.
    """
    outcomes = {vector: decision.outcome(vector) for vector in vectors}
    return [_judge(decision, outcomes, 1 << k) for k in range(len(decision.conditions))]


def _judge(decision: Decision, outcomes: dict[int, bool], bit: int) -> Judged:
    decides: set[tuple[bool, bool]] = set()
    for vector, outcome in outcomes.items():
        if decision.outcome(vector ^ bit) != outcome:
            decides.add((bool(vector & bit), outcome))
    return Judged(
        values=frozenset(bool(vector & bit) for vector in outcomes),
        masking=any((not value, not outcome) in decides for value, outcome in decides),
        unique=any(
            vector ^ bit in outcomes and outcomes[vector ^ bit] != outcome
            for vector, outcome in outcomes.items()
        ),
    )
