"""Mutants of plc/lib: their selection, the tests that judge them, and the figures."""

from __future__ import annotations

import os
from argparse import Namespace
from collections.abc import Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from random import Random
from typing import Any

from rcx_tools.evidence.mutants.baseline import Baseline
from rcx_tools.evidence.mutants.pool import run_tasks
from rcx_tools.evidence.mutants.select import (
    Judges,
    TestStates,
    folder_of,
    named_tests,
    naming_tests,
)
from rcx_tools.evidence.mutants.suite import (
    Suite,
    exhaustive_of,
    forget_benches,
    private_folder,
    remove_folders,
)
from rcx_tools.evidence.mutants.tiers import quick_tier
from rcx_tools.evidence.mutants.workshop import Workshop
from rcx_tools.library import files as generated_files
from rcx_tools.library.alarm_texts import text_files
from structured_text.mutants.judging import Judging, MutantTask
from structured_text.mutants.mutant import Mutant, Mutants, in_rounds
from structured_text.mutants.operators import Change
from structured_text.mutants.report import Reasons, figures
from structured_text.output.progress import progress_bar
from structured_text.output.results import digest
from structured_text.projects.needed import needed

__all__ = ["LibraryRun", "sample"]

#: Number of mutants that are run for each generated block.
SAMPLE = 16


class LibraryRun:
    """One run over the library. Tests, programs and mutants stay in memory.

    Args:
        options: Options of the command line.
        judging: Object that runs the mutants.
    """

    def __init__(self, options: Namespace, judging: Judging) -> None:
        self._options = options
        self._judging = judging
        self._console = judging.console
        self._root = root = options.root
        self._out = root / "out" / "verification"
        self._library = sorted((root / "plc/lib").rglob("*.st"))
        self._generated = {*generated_files(), *text_files()}
        self._states = TestStates(root)
        self._suite = Suite(root)
        self._workshop = Workshop()
        self._found: dict[str, Any] | None = None

    def figures(self) -> dict[str, Any] | None:
        """Run the mutants; return the figures, or None if the tests could not be collected."""
        self._workshop.install()
        self._suite.collected(self._run)
        return self._found

    def _run(self) -> None:
        """Do the work that needs the collected tests."""
        baseline = self._baseline()
        for node in baseline.failed:
            self._console.print(f"fails with the original, is not used: {node}", markup=False)
        naming = naming_tests(self._root)
        named = {one: (*named_tests(one), *naming.get(one.stem, ())) for one in self._library}
        judges = Judges(
            self._states,
            baseline.ran,
            baseline.seconds,
            self._options.named,
            baseline.exhaustive,
        )
        mutants = Mutants(self._root, self._library)
        tasks = self._tasks(mutants, judges, named)

        def run(task: MutantTask) -> str | None:
            mutant = task.mutant
            file = self._root / mutant.file
            private_folder(config, f"mutant{os.getpid()}")
            self._workshop.put_in(file, mutant.text, mutant.pou.upper(), mutant.body)
            return self._suite.run(judges.ordered(mutant.pou, task.tests, named[file]))

        config = next(iter(self._suite.items.values())).config
        jobs, patience_s = self._options.jobs, self._options.patience
        judged = self._judging.of(
            "library", tasks, judges, lambda todo: run_tasks(todo, run, jobs, patience_s=patience_s)
        )
        remove_folders(config)
        reasons = Reasons(self._root / "tests/tools/evidence/survivors.toml")
        whole = {file.stem for file in self._wanted() if not self._is_sampled(file)}
        complete = () if len(judged) < len(tasks) else whole
        self._found = figures(judged, reasons, folder_of, complete) | {
            "no_mutants": {"refused": mutants.counted.refused, "equal": mutants.counted.equal},
            "not_run": len(tasks) - len(judged),
            "quick": quick_tier(judged, baseline.exhaustive),
            "tests": len(baseline.ran),
            "tests_that_fail": list(baseline.failed),
            "of_each_generated_block": "all" if self._options.all else SAMPLE,
            "library": digest(self._root, self._library),
        }

    # --- the run without a mutant ---

    def _baseline(self) -> Baseline:
        """Return the POUs that each test runs.

        Only tests that have changed since the last run are run again.
        """
        tests, examples = self._root / "tests", self._root / "plc" / "examples"
        around = [*tests.rglob("*.st"), *tests.rglob("conftest.py"), *examples.rglob("*.st")]
        library = digest(self._root, [*self._library, *around])
        file = self._out / "mutants-baseline.json"
        kept = None if self._options.fresh else Baseline.read(file, library)
        if kept is None:
            kept = Baseline({}, {}, (), (), {})
        items = self._suite.items
        states = {
            name: self._states.of(name) for name in {node.partition("::")[0] for node in items}
        }
        known = {node for node in items if kept.holds(node, states[node.partition("::")[0]])}
        ran = {node: kept.ran[node] for node in known if node in kept.ran}
        seconds = {node: kept.seconds[node] for node in known}
        builders = [node for node in kept.builders if node in known]
        self._workshop.watch()
        for node in self._shown("compile", builders):
            self._suite.timed(node)
        for node in self._shown("the original", [node for node in items if node not in known]):
            before = self._workshop.programs
            self._workshop.watch()
            passed, seconds[node] = self._suite.timed(node)
            if passed:
                ran[node] = frozenset(self._workshop.seen)
            if self._workshop.programs > before:
                builders.append(node)
        self._workshop.unwatch()
        forget_benches(self._root / "tests")
        ran = {node: ran[node] for node in items if node in ran}
        failed = tuple(node for node in items if node not in ran)
        exhaustive = frozenset(exhaustive_of(items.values()))
        baseline = Baseline(ran, seconds, failed, tuple(builders), states, exhaustive)
        baseline.write(file, library)
        return baseline

    def _shown(self, description: str, nodes: Sequence[str]) -> Iterator[str]:
        with progress_bar(self._console) as progress:
            bar = progress.add_task(description, total=len(nodes), told="")
            for node in nodes:
                yield node
                progress.update(bar, advance=1, told=node.partition("::")[0], refresh=True)

    # --- the mutants ---

    def _tasks(
        self, mutants: Mutants, judges: Judges, named: dict[Path, tuple[str, ...]]
    ) -> list[MutantTask]:
        tasks = []
        for file in self._wanted():
            others = [one for one in needed([file], self._library) if one != file]
            around = digest(self._root, others)
            for mutant in self._mutants_of(mutants, file):
                tests = judges.of(mutant.pou, named[file])
                seconds = sum(judges.seconds[node] for node in tests)
                key = f"{mutant.identity}-{around[:8]}"
                tasks.append(MutantTask(mutant, tests, seconds, key))
        return tasks

    def _wanted(self) -> list[Path]:
        """Return the files of the library that the command line names."""
        names = self._options.blocks
        return [
            file
            for file in self._library
            if not names or any(name in self._path(file) or name == file.stem for name in names)
        ]

    def _path(self, file: Path) -> str:
        return file.relative_to(self._root).as_posix()

    def _is_sampled(self, file: Path) -> bool:
        generated = self._path(file) in self._generated
        return bool(self._options.sample) or (generated and not self._options.all)

    def _mutants_of(self, mutants: Mutants, file: Path) -> Iterator[Mutant]:
        if self._is_sampled(file):
            yield from sample(mutants, file, self._options.sample or SAMPLE, self._options.seed)
        else:
            yield from mutants.of(file)


def sample(mutants: Mutants, file: Path, most: int, seed: int) -> list[Mutant]:
    """Return at most `most` mutants of one file, drawn in rounds with one mutant per operator."""
    chance = Random(f"{seed}:{file.name}")

    def drawn(found: Iterable[Change]) -> list[Change]:
        return in_rounds(found, lambda change: change.operator, chance)

    return sorted(islice(mutants.of(file, drawn), most), key=lambda mutant: mutant.line)
