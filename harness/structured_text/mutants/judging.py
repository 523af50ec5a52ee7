"""The verdicts on mutants: a test has killed the mutant, or the mutant has survived.

A saved outcome of an earlier run is used if it is still valid. All other mutants are run.

The caller decides how and on which computer a mutant runs with its tests.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

from rich.console import Console

from structured_text.mutants.mutant import Mutant
from structured_text.mutants.report import Judged
from structured_text.output.progress import progress_bar
from structured_text.output.results import Results

__all__ = ["ENDLESS", "Judges", "Judging", "MutantTask", "Outcome", "is_outcome"]

#: The value of `Outcome.by` if a test with the mutant exceeds its time limit.
ENDLESS = "a test does not end"


@dataclass(frozen=True)
class MutantTask:
    """A mutant and its tests.

    `seconds` is the time that the tests take with the original program.
    """

    mutant: Mutant
    tests: tuple[str, ...]
    seconds: float
    key: str


@dataclass(frozen=True)
class Outcome:
    """The outcome of a mutant.

    `by` is the test that killed the mutant, or the reason in words. It is empty for a survivor.
    `seconds` is the time of the run.
    """

    task: MutantTask
    killed: bool
    by: str
    seconds: float


def is_outcome(entry: Mapping[str, Any]) -> bool:
    """Return whether an entry in the file of saved results has all required fields."""
    types = {"killed": bool, "by": str, "tests": str}
    return all(isinstance(entry.get(name), one) for name, one in types.items())


class Judges(Protocol):
    """The tests of a project: their hashes, and a record of the tests that killed a mutant."""

    def state_of(self, file: str) -> str:
        """Return a hash of a test file with all files that it uses."""

    def state(self, nodes: Iterable[str]) -> str:
        """Return a hash of tests: their identifiers, and all files that they use."""

    def killed(self, pou: str, node: str) -> None:
        """Record that a test has found a mutant of a POU."""


@dataclass
class Judging:
    """Decides which mutants survive, from saved outcomes and by running the tests.

    Attributes:
        until: Start no mutant after this time of the monotonic clock [s]; None for no limit.
    """

    console: Console
    results: Results
    until: float | None = None

    def of(
        self,
        title: str,
        tasks: Sequence[MutantTask],
        judges: Judges,
        run: Callable[[Iterable[MutantTask]], Iterator[Outcome]],
    ) -> list[Judged]:
        """Return the verdicts on the mutants in the order of `tasks`.

        Mutants that were not run, because the time was over, are missing.

        A saved outcome is used if the tests have not changed since. All other mutants are run.
        `run` yields each outcome as soon as it is known.
        """
        judged: list[Judged] = []
        waiting: list[MutantTask] = []
        for task in tasks:
            known = self.results.get(task.key)
            if known is None or not _holds(known, task, judges):
                waiting.append(task)
            else:
                judged.append(Judged(task.mutant, known["killed"], known["by"]))
                if known["killed"] and "::" in known["by"]:
                    judges.killed(task.mutant.pou, known["by"])
        waiting.sort(key=self._has_survived)
        survived = sum(not one.killed for one in judged)
        with progress_bar(self.console) as progress:
            bar = progress.add_task(title, total=len(waiting), told="")
            tasks_in_time = self._in_time(waiting)
            for outcome in run(tasks_in_time):
                judged.append(Judged(outcome.task.mutant, outcome.killed, outcome.by))
                survived += not outcome.killed
                self._keep(outcome, judges)
                told = f"{outcome.task.mutant.pou}, {survived} survive"
                progress.update(bar, advance=1, told=told, refresh=True)
        places = {id(task.mutant): place for place, task in enumerate(tasks)}
        return sorted(judged, key=lambda one: places[id(one.mutant)])

    def _keep(self, outcome: Outcome, judges: Judges) -> None:
        mutant = outcome.task.mutant
        if "::" in outcome.by:
            judges.killed(mutant.pou, outcome.by)
        self.results.add(
            {
                "key": outcome.task.key,
                "tests": _tests(outcome.by, outcome.task, judges),
                "killed": outcome.killed,
                "by": outcome.by,
                "seconds": round(outcome.seconds, 3),
                "block": mutant.pou,
                "operator": mutant.operator,
                "line": mutant.line,
                "after": mutant.after,
            }
        )

    def _has_survived(self, task: MutantTask) -> bool:
        """Return whether a mutant survived an earlier run.

        Such a mutant takes long, because all its tests run. It is therefore run last.
        """
        known = self.results.get(task.key)
        return known is not None and not known["killed"]

    def _in_time(self, tasks: Sequence[MutantTask]) -> Iterator[MutantTask]:
        for task in tasks:
            if self.until is not None and time.monotonic() > self.until:
                return
            yield task


def _tests(by: str, task: MutantTask, judges: Judges) -> str:
    """Return the hash of the failed test's file, or of all tests of the mutant if none failed."""
    return judges.state_of(by.partition("::")[0]) if "::" in by else judges.state(task.tests)


def _holds(known: Mapping[str, Any], task: MutantTask, judges: Judges) -> bool:
    """Return whether the outcome of an earlier run is still valid with the present tests."""
    by = known["by"]
    if "::" in by and by not in task.tests:
        return False
    return bool(known["tests"] == _tests(by, task, judges))
