"""Judges mutants: by outcomes that still hold, and by a run of the rest with progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rcx_tools.evidence.mutants.pool import PATIENCE_S, Outcome, Task, run_tasks
from rcx_tools.evidence.mutants.report import Judged
from rcx_tools.evidence.mutants.select import Judges
from rcx_tools.evidence.store import Results

__all__ = ["Judging", "progress_bar"]

#: Between two lines of progress where there is no terminal [s].
_PATIENCE_S = 30.0


@dataclass
class Judging:
    """Judges mutants by what is known, and by running their tests.

    Attributes:
        results: The outcomes that are kept.
        jobs: How many run at a time.
        patience_s: Processor time of a mutant beyond that of its tests, until it counts as endless.
        until: Start none after this time of the monotonic clock [s]; None: run all.
    """

    console: Console
    results: Results
    jobs: int
    patience_s: float = PATIENCE_S
    until: float | None = None

    def of(
        self,
        title: str,
        tasks: Sequence[Task],
        judges: Judges,
        run: Callable[[Task], str | None],
        ended: Callable[[int], None] = lambda pid: None,
    ) -> list[Judged]:
        """What came of the mutants, in their order; those that were not run are left out."""
        judged: list[Judged] = []
        waiting: list[Task] = []
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
            for outcome in run_tasks(tasks_in_time, run, self.jobs, ended, self.patience_s):
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

    def _has_survived(self, task: Task) -> bool:
        """Whether it has survived before; such mutants take long and come last."""
        known = self.results.get(task.key)
        return known is not None and not known["killed"]

    def _in_time(self, tasks: Sequence[Task]) -> Iterator[Task]:
        for task in tasks:
            if self.until is not None and time.monotonic() > self.until:
                return
            yield task


def _tests(by: str, task: Task, judges: Judges) -> str:
    """The state of what has judged: of the test that has failed, or of all that have not."""
    return judges.states.of(by.partition("::")[0]) if "::" in by else judges.state(task.tests)


def _holds(known: Mapping[str, Any], task: Task, judges: Judges) -> bool:
    """Whether an outcome of an earlier run still holds with the tests as they are now."""
    by = known["by"]
    if "::" in by and by not in task.tests:
        return False
    return bool(known["tests"] == _tests(by, task, judges))


def progress_bar(console: Console) -> Progress:
    """A bar, or a line each half minute where there is no terminal."""
    # No thread of its own: this process makes copies of itself.
    return _Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
        TextColumn("{task.fields[told]}"),
        console=console,
        auto_refresh=False,
    )


class _Progress(Progress):
    _told = 0.0

    def refresh(self) -> None:
        """Show it."""
        if self.console.is_terminal:
            super().refresh()
        elif time.monotonic() - self._told > _PATIENCE_S and self.tasks:
            self._told = time.monotonic()
            task = self.tasks[-1]
            told = f"{task.description}: {task.completed:.0f} of {task.total or 0:.0f}"
            self.console.print(f"{told} {task.fields['told']}", highlight=False)
