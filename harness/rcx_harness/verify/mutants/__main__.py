"""`python -m rcx_harness.verify.mutants`: one mistake after the other in plc/lib, and its tests.

A mutant is one small change of one file that is still correct ST. It is killed where a test of the
suite fails with it. Tests, programs and mutants are kept in one process; each mutant runs in a
child of its own. Outcomes are kept in out/verification/mutants.jsonl; one holds as long as the
mutated file, the library files that it needs, and the test that has failed (or all that have not)
are as they were, so that a run goes on where the last one ended. Survivors without a reason are
written beside them as rows for tests/verify/survivors.toml: mutants-without-reason.toml.

Of the generated command blocks, which are alike, a sample is taken: of each block so many mutants,
drawn by the seed, one of each operator first. `--all` or MUTANTS=all takes them all.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from rcx_harness.engine.needed import needed
from rcx_harness.library import files as generated_files
from rcx_harness.library.alarm_texts import text_files
from rcx_harness.verify.mutants.baseline import Baseline
from rcx_harness.verify.mutants.engine import Workshop
from rcx_harness.verify.mutants.mutant import Mutant, Mutants
from rcx_harness.verify.mutants.pool import Task, remove_folders, run_tasks
from rcx_harness.verify.mutants.report import (
    GOAL,
    Judged,
    Reasons,
    figures,
    print_report,
    write_rows,
)
from rcx_harness.verify.mutants.select import Judges, TestStates, named_tests
from rcx_harness.verify.mutants.suite import Suite, forget_benches
from rcx_harness.verify.store import Results, digest

__all__ = ["main"]

ROOT = Path(__file__).resolve().parents[4]
#: So many mutants of each generated block are taken.
SAMPLE = 16
#: Between two lines of progress where there is no terminal [s].
_PATIENCE_S = 30.0


def main(arguments: Sequence[str] | None = None) -> int:
    """Run; 0 where the score is reached and every survivor has its reason."""
    options = _options(arguments)
    session = _Session(options)
    code = session.suite.collected(session.run)
    if session.answer is None:
        print("the tests could not be collected", file=sys.stderr)
        return code or 2
    return session.answer


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m rcx_harness.verify.mutants")
    parser.add_argument(
        "blocks", nargs="*", help="names of blocks, or parts of paths (default: all)"
    )
    parser.add_argument("--root", type=Path, default=ROOT, help="the repository")
    parser.add_argument("--all", action="store_true", help="every mutant of the generated blocks")
    parser.add_argument(
        "--named", action="store_true", help="a quick look: only the tests that a file names"
    )
    parser.add_argument("--sample", type=int, help="a quick look: so many mutants of every block")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--minutes", type=float, help="start no mutant after so long")
    parser.add_argument("--fresh", action="store_true", help="forget earlier outcomes")
    parser.add_argument("--show", type=int, default=20, help="survivors that are printed")
    options = parser.parse_args(arguments)
    options.all = options.all or os.environ.get("MUTANTS") == "all"
    return options


class _Session:
    """One run of the command."""

    def __init__(self, options: argparse.Namespace) -> None:
        self._options = options
        self._console = Console()
        self._root = root = options.root.resolve()
        self._out = root / "out" / "verification"
        self._library = sorted((root / "plc/lib").rglob("*.st"))
        self._generated = {*generated_files(), *text_files()}
        self._states = TestStates(root)
        self._results = Results(self._out / "mutants.jsonl", fresh=options.fresh)
        self._started = time.monotonic()
        self.workshop = Workshop()
        self.workshop.install()
        self.suite = Suite(root)
        self.answer: int | None = None

    def run(self) -> None:
        """Everything that needs the collected tests."""
        baseline = self._baseline()
        for node in baseline.failed:
            self._console.print(f"fails with the original, judges nothing: {node}", markup=False)
        named = {one: named_tests(one) for one in self._library}
        judges = Judges(self._states, baseline.ran, baseline.seconds, self._options.named)
        mutants = Mutants(self._root, self._library)
        tasks = self._tasks(mutants, judges, named)
        judged = self._judge(tasks, judges, named)
        config = next(iter(self.suite.items.values())).config
        remove_folders(config)
        found = figures(judged, Reasons(self._root / "tests" / "verify" / "survivors.toml"))
        found |= {
            "no_mutants": {"refused": mutants.counted.refused, "equal": mutants.counted.equal},
            "not_run": len(tasks) - len(judged),
            "tests": len(baseline.ran),
            "tests_that_fail": list(baseline.failed),
            "seed": self._options.seed,
            "of_each_generated_block": "all" if self._options.all else SAMPLE,
            "library": digest(self._root, self._library),
            "run_time_s": round(time.monotonic() - self._started, 1),
        }
        print_report(self._console, found, show=self._options.show)
        write_rows(self._out / "mutants-without-reason.toml", found)
        self.answer = self._finish(found)

    def _finish(self, found: dict[str, Any]) -> int:
        explained = found["survivors_with_a_reason"] == len(found["survivors"])
        met = found["score"] >= GOAL and explained and not found["not_run"]
        if not (self._options.blocks or self._options.named or self._options.sample):
            report = {"command": "make mutants", "figures": found, "met": met}
            (self._out / "mutants.json").write_text(json.dumps(report, indent=1) + "\n", "utf-8")
        return 0 if met else 1

    # --- the original ---

    def _baseline(self) -> Baseline:
        """Which tests run which POUs; only tests that have changed are run for it."""
        tests, examples = self._root / "tests", self._root / "plc" / "examples"
        around = [*tests.rglob("*.st"), *tests.rglob("conftest.py"), *examples.rglob("*.st")]
        library = digest(self._root, [*self._library, *around])
        file = self._out / "mutants-baseline.json"
        kept = None if self._options.fresh else Baseline.read(file, library)
        if kept is None:
            kept = Baseline({}, {}, (), (), {})
        items = self.suite.items
        states = {
            name: self._states.of(name) for name in {node.partition("::")[0] for node in items}
        }
        known = {node for node in items if kept.holds(node, states[node.partition("::")[0]])}
        ran = {node: kept.ran[node] for node in known if node in kept.ran}
        seconds = {node: kept.seconds[node] for node in known}
        builders = [node for node in kept.builders if node in known]
        self.workshop.watch()
        for node in self._shown("compile", builders):
            self.suite.timed(node)
        for node in self._shown("the original", [node for node in items if node not in known]):
            before = self.workshop.programs
            self.workshop.watch()
            passed, seconds[node] = self.suite.timed(node)
            if passed:
                ran[node] = frozenset(self.workshop.seen)
            if self.workshop.programs > before:
                builders.append(node)
        self.workshop.unwatch()
        forget_benches(self._root / "tests")
        ran = {node: ran[node] for node in items if node in ran}
        failed = tuple(node for node in items if node not in ran)
        baseline = Baseline(ran, seconds, failed, tuple(builders), states)
        baseline.write(file, library)
        return baseline

    def _shown(self, description: str, nodes: Sequence[str]) -> Iterator[str]:
        with self._progress() as progress:
            bar = progress.add_task(description, total=len(nodes), told="")
            for node in nodes:
                yield node
                progress.update(bar, advance=1, told=node.partition("::")[0], refresh=True)

    # --- the mutants ---

    def _tasks(
        self, mutants: Mutants, judges: Judges, named: dict[Path, tuple[str, ...]]
    ) -> list[Task]:
        tasks = []
        for file in self._library:
            path = file.relative_to(self._root).as_posix()
            if self._options.blocks and not any(
                name in path or name == file.stem for name in self._options.blocks
            ):
                continue
            others = [one for one in needed([file], self._library) if one != file]
            around = digest(self._root, others)
            for mutant in self._mutants_of(mutants, file):
                tests = judges.of(mutant.pou, named[file])
                seconds = sum(judges.seconds[node] for node in tests)
                key = f"{mutant.identity}-{around[:8]}"
                tasks.append(Task(mutant, tests, seconds, key))
        return tasks

    def _mutants_of(self, mutants: Mutants, file: Path) -> Iterator[Mutant]:
        generated = file.relative_to(self._root).as_posix() in self._generated
        if self._options.sample:
            yield from mutants.sample(file, self._options.sample, self._options.seed)
        elif generated and not self._options.all:
            yield from mutants.sample(file, SAMPLE, self._options.seed)
        else:
            yield from mutants.of(file)

    def _judge(
        self, tasks: Sequence[Task], judges: Judges, named: dict[Path, tuple[str, ...]]
    ) -> list[Judged]:
        judged: list[Judged] = []
        waiting: list[Task] = []
        for task in tasks:
            known = self._results.get(task.key)
            if known is None or not _holds(known, task, judges):
                waiting.append(task)
            else:
                judged.append(Judged(task.mutant, known["killed"], known["by"]))
                if known["killed"] and "::" in known["by"]:
                    judges.killed(task.mutant.pou, known["by"])
        waiting.sort(key=self._has_survived)
        outcomes = run_tasks(
            self._in_time(waiting),
            root=self._root,
            suite=self.suite,
            workshop=self.workshop,
            order=lambda task: judges.ordered(
                task.mutant.pou, task.tests, named[self._root / task.mutant.file]
            ),
            jobs=self._options.jobs,
        )
        survived = sum(not one.killed for one in judged)
        with self._progress() as progress:
            bar = progress.add_task("mutants", total=len(waiting), told="")
            for outcome in outcomes:
                mutant = outcome.task.mutant
                judged.append(Judged(mutant, outcome.killed, outcome.by))
                survived += not outcome.killed
                if "::" in outcome.by:
                    judges.killed(mutant.pou, outcome.by)
                self._results.add(
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
                told = f"{mutant.pou}, {survived} survive"
                progress.update(bar, advance=1, told=told, refresh=True)
        places = {id(task.mutant): place for place, task in enumerate(tasks)}
        return sorted(judged, key=lambda one: places[id(one.mutant)])

    def _has_survived(self, task: Task) -> bool:
        """Whether it has survived before; such mutants take long and come last."""
        known = self._results.get(task.key)
        return known is not None and not known["killed"]

    def _in_time(self, tasks: Sequence[Task]) -> Iterator[Task]:
        minutes = self._options.minutes
        for task in tasks:
            if minutes is not None and time.monotonic() - self._started > 60 * minutes:
                return
            yield task

    def _progress(self) -> Progress:
        # No thread of its own: this process makes copies of itself.
        return _Progress(
            TextColumn("{task.description}"),
            BarColumn(),
            MofNCompleteColumn(),
            TimeRemainingColumn(),
            TextColumn("{task.fields[told]}"),
            console=self._console,
            auto_refresh=False,
        )


def _tests(by: str, task: Task, judges: Judges) -> str:
    """The state of what has judged: of the test that has failed, or of all that have not."""
    return judges.states.of(by.partition("::")[0]) if "::" in by else judges.state(task.tests)


def _holds(known: Mapping[str, Any], task: Task, judges: Judges) -> bool:
    """Whether an outcome of an earlier run still holds with the tests as they are now."""
    by = known["by"]
    if "::" in by and by not in task.tests:
        return False
    return bool(known["tests"] == _tests(by, task, judges))


class _Progress(Progress):
    """A bar, or a line each half minute where there is no terminal."""

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


if __name__ == "__main__":
    sys.exit(main())
