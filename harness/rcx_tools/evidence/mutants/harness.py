"""Mutants of the parts that check the library: virtual controller, monitors, engine, tables.

Each mutant runs in a throw-away copy of the repository. A mutant is judged by tests that have
executed the changed function: some tests of each file, tests with words of the changed line in
their names, tests that execute few other functions, and the quickest tests. A mutant of a table is
judged by tests with the name of the table entry in their names, or with the name of something that
contains the entry. plc/lib is generated again from a changed table, so that the table and the
library agree.
"""

from __future__ import annotations

import json
from argparse import Namespace
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rcx_tools.evidence.mutants.baseline import Baseline
from rcx_tools.evidence.mutants.copies import Copies, Traced
from rcx_tools.evidence.mutants.pool import run_tasks
from rcx_tools.evidence.mutants.python import (
    concerned,
    file_key,
    functions,
    python_changes,
    python_meaning,
)
from rcx_tools.evidence.mutants.sample import sampled
from rcx_tools.evidence.mutants.seeded import Bug, bugs
from rcx_tools.evidence.mutants.select import (
    Judges,
    TestStates,
    alike,
    cheapest,
    folder_of,
    nearest,
)
from rcx_tools.evidence.mutants.suite import in_suite, spread
from rcx_tools.evidence.mutants.tables import (
    marks_of,
    table_changes,
    table_meaning,
)
from rcx_tools.evidence.mutants.tiers import quick_tier
from structured_text.errors import InputError
from structured_text.mutants.judging import Judging, MutantTask
from structured_text.mutants.mutant import Mutant
from structured_text.mutants.report import Judged, Reasons, figures
from structured_text.output.progress import progress_bar
from structured_text.output.results import digest

__all__ = ["KINDS", "HarnessRun", "Kind"]

_PACKAGE, _TOOLKIT = "harness/rcx_harness", "harness/structured_text"
#: Number of test files in one run without a mutant.
_SHARD = 6
#: Time limit of one run without a mutant [s].
_PATIENCE_S = 1000.0
#: Limits of the total time [s] of additional tests, which run the changed function or a user of the
#: changed value: tests that run the fewest other functions, and the quickest tests.
_NEAREST_S, _QUICKEST_S = 25.0, 6.0
#: Approximate factor by which tests are slower while their functions are recorded.
_TRACED = 2.0
#: A table that is not mutated, because it contains only sentences for people.
_PROSE = "rules.toml"
#: Number of tests for a table entry that no test names, or for a module in which no function was
#: executed.
_OTHERS = 12


@dataclass(frozen=True)
class Kind:
    """A kind of mutated sources, and the tests that judge their mutants.

    Attributes:
        name: Name for people.
        sources: Files and folders that are mutated.
        folders: Folders and files of tests.
        one_of: On average, one out of this number of changes becomes a mutant.
        pattern: Pattern of the mutated files in a folder. All files of a kind have the same suffix,
            because tests are selected differently for tables and for modules.
    """

    name: str
    sources: tuple[str, ...]
    folders: tuple[str, ...]
    one_of: int
    pattern: str = "*.py"

    def files(self, root: Path) -> list[Path]:
        """Return the files that are mutated, below the root of the repository."""
        starts = [root / source for source in self.sources]
        found = [
            file
            for start in starts
            for file in ([start] if start.is_file() else sorted(start.rglob(self.pattern)))
        ]
        return [file for file in found if file.name != _PROSE]


_MONITORS = tuple(f"{_PACKAGE}/watch/{name}.py" for name in ("wire", "contract", "steady"))
_ENGINE = (f"{_TOOLKIT}/engines/builtin", f"{_TOOLKIT}/language")
_OF_ENGINE = (
    *("tests/structured_text/engines", "tests/structured_text/language"),
    *("tests/verify/test_coverage.py", "tests/verify/test_coverage_language.py"),
    "tests/watch/test_calls.py",
)
_OF_TABLES = tuple(f"tests/{name}" for name in ("spec", "tools/library", "command", "diagnosis"))
KINDS = (
    Kind("controller", (f"{_PACKAGE}/robot",), ("tests/robot", "tests/cell", "tests/watch"), 20),
    Kind("monitors", _MONITORS, ("tests/cell", "tests/contract", "tests/watch"), 5),
    Kind("engine", _ENGINE, _OF_ENGINE, 40),
    Kind("tables", ("spec",), (*_OF_TABLES, "tests/robot"), 24, "*.toml"),
)


class HarnessRun:
    """One run over everything outside of the library.

    Args:
        options: Options of the command line.
        judging: Object that runs the mutants.
    """

    def __init__(self, options: Namespace, judging: Judging) -> None:
        self._options = options
        self._judging = judging
        self._root: Path = options.root
        self._out = self._root / "out" / "verification"
        self._states = TestStates(self._root)
        self._names: dict[str, dict[int, str]] = {}
        packages = [self._root / name for name in (_PACKAGE, _TOOLKIT)]
        modules = sorted(file for package in packages for file in package.rglob("*.py"))
        keys = [file_key(one.relative_to(self._root).as_posix()) for one in modules]
        texts = [one.read_text(encoding="utf-8") for one in modules]
        self._texts = dict(zip(keys, texts, strict=True))

    def figures(self, wanted: Sequence[str]) -> dict[str, dict[str, Any]]:
        """Run the wanted kinds, and `seeded`; return the figures of each.

        Raises:
            InputError: a seeded bug cannot be inserted.
        """
        table = self._root / "tests/tools/evidence/seeded.toml"
        found_bugs = [bug for bug in bugs(table) if self._wants(bug.file)]
        found_bugs = found_bugs if "seeded" in wanted else []
        seeded = [bug.mutant(self._root) for bug in found_bugs]
        kinds = [one for one in KINDS if one.name in wanted and self._files(one)]
        if not kinds and not found_bugs:
            return {}
        copies = Copies(self._root)
        try:
            files = {file for kind in kinds for file in self._tests(kind.folders)}
            files.update(*(self._tests(bug.tests) for bug in found_bugs))
            baseline = self._baseline(copies, files)
            for node in baseline.failed:
                told = f"fails with the original, is not used: {node}"
                self._judging.console.print(told, markup=False)
            found = {one.name: self._kind(copies, one, baseline) for one in kinds}
            if found_bugs:
                rows = zip(found_bugs, seeded, strict=True)
                found["seeded"] = self._seeded(copies, list(rows), baseline)
            return found
        finally:
            copies.close()

    def _files(self, kind: Kind) -> list[Path]:
        """Return the files to mutate for a kind, limited to those named on the command line."""
        paths = {file: file.relative_to(self._root).as_posix() for file in kind.files(self._root)}
        return [file for file, path in paths.items() if self._wants(path)]

    def _wants(self, path: str) -> bool:
        parts = self._options.blocks
        return not parts or any(part in path for part in parts)

    # --- the run without a mutant ---

    def _tests(self, paths: Sequence[str]) -> set[str]:
        """Return the test files in files and folders."""
        starts = [self._root / path for path in paths]
        files = {one for start in starts for one in [start, *start.rglob("test_*.py")]}
        return {one.relative_to(self._root).as_posix() for one in files if one.is_file()}

    def _baseline(self, copies: Copies, files: Collection[str]) -> Baseline:
        """Return the functions that each test executes.

        Only tests that have changed since the last run are run again.
        """
        sources = [self._root / name for name in (_PACKAGE, "spec", "plc", "tests/support")]
        every = [one for folder in sources for one in folder.rglob("*") if self._matters(one)]
        state = digest(self._root, every)
        kept_in = self._out / "mutants-harness-baseline.json"
        kept = None if self._options.fresh else Baseline.read(kept_in, state)
        if kept is None:
            kept = Baseline({}, {}, (), (), {})
        here = {*files, *(file for file in kept.states if (self._root / file).is_file())}
        states = {file: self._states.of(file) for file in here}
        new = sorted(file for file in files if kept.states.get(file) != states[file])
        exhaustive = {node for node in kept.exhaustive if _file(node) not in new}
        seconds = {
            node: took
            for node, took in kept.seconds.items()
            if kept.holds(node, states.get(_file(node), ""))
        }
        ran = {node: kept.ran[node] for node in seconds if node in kept.ran}
        for one in self._traced(copies, new):
            seconds |= one["seconds"]
            exhaustive |= {*one["exhaustive"]}
            ran |= {node: self._named(one["ran"][node]) for node in one["passed"]}
        failed = tuple(sorted(node for node in seconds if node not in ran))
        baseline = Baseline(ran, seconds, failed, (), states, frozenset(exhaustive))
        baseline.write(kept_in, state)
        judging = in_suite(sorted(node for node in ran if _file(node) in files))
        return replace(baseline, ran={node: ran[node] for node in judging})

    def _matters(self, path: Path) -> bool:
        """Return whether a path is a source file that tests execute.

        The result is False for files of rcx_tools, because tests do not execute them.
        """
        parts = path.relative_to(self._root).parts
        return path.is_file() and not {"__pycache__", "verify", "evidence"} & set(parts)

    def _traced(self, copies: Copies, files: Sequence[str]) -> Iterator[dict[str, Any]]:
        """Run test files, several of them in each child process.

        Yield the records of each child process.
        """
        shards = [tuple(files[k :: _shards(files)]) for k in range(_shards(files))]
        folder = copies.original / "out"
        folder.mkdir(exist_ok=True)

        def run(task: MutantTask) -> None:
            copies.traced(task.tests, lambda traced: _write(folder / f"{task.key}.json", traced))

        nothing = Mutant("", "the original", "", 0, "", "", "", None)
        tasks = [MutantTask(nothing, shard, _PATIENCE_S, str(k)) for k, shard in enumerate(shards)]
        with progress_bar(self._judging.console) as progress:
            bar = progress.add_task("the harness as it is", total=len(files), told="")
            for outcome in run_tasks(tasks, run, self._options.jobs):
                left = folder / f"{outcome.task.key}.json"
                tests = outcome.task.tests
                progress.update(bar, advance=len(tests), told=tests[-1], refresh=True)
                if not left.is_file():
                    hint = f"run `python -m pytest {' '.join(tests)}`"
                    raise InputError("tests of the harness cannot be run as it is", hint=hint)
                yield json.loads(left.read_text(encoding="utf-8"))

    def _named(self, ran: Sequence[tuple[str, int]]) -> frozenset[str]:
        """Return the functions that a test has executed, and their modules, in upper case."""
        found = set()
        for file, line in ran:
            if file not in self._names:
                self._names[file] = functions((self._root / file).read_text(encoding="utf-8"))
            key = file_key(file)
            if line in self._names[file]:
                found |= {key.upper(), f"{key}:{self._names[file][line]}".upper()}
        return frozenset(found)

    # --- the mutants ---

    def _kind(self, copies: Copies, kind: Kind, baseline: Baseline) -> dict[str, Any]:
        mutants = [one for file in self._files(kind) for one in self._mutants(kind, file)]
        ran = self._about(mutants, kind.folders, baseline)
        judges = Judges(self._states, ran, baseline.seconds, exhaustive=baseline.exhaustive)
        tasks = []
        for mutant in mutants:
            own = _own(mutant.file, ran)
            module = mutant.pou.partition(":")[0]  # code outside of functions runs only at import
            tests = judges.of(mutant.pou, own) or judges.of(module, own)
            if tests and not _is_table(mutant.file):
                about = concerned(mutant.pou, mutant.line, self._texts)
                ran_it = [node for node in ran if ran[node] & about]
                near = alike(f"{mutant.pou.partition(':')[2]} {mutant.before}", ran_it)
                near += nearest(ran_it, ran, baseline.seconds, _NEAREST_S)
                near += cheapest(ran_it, baseline.seconds, _QUICKEST_S)
                tests = tuple(dict.fromkeys((*tests, *near)))
            tasks.append(self._task(mutant, tests or self._others(mutant, ran), baseline))
        return self._judged(copies, kind.name, tasks, judges)

    def _seeded(
        self, copies: Copies, rows: Sequence[tuple[Bug, Mutant]], baseline: Baseline
    ) -> dict[str, Any]:
        tasks = []
        for bug, mutant in rows:
            ran = self._about([mutant], bug.tests, baseline)
            name = mutant.pou.upper()
            tests = [node for node, about in ran.items() if bug.of_library or name in about]
            tasks.append(self._task(mutant, tests, baseline))
        judges = Judges(
            self._states, baseline.ran, baseline.seconds, exhaustive=baseline.exhaustive
        )
        return self._judged(copies, "seeded", tasks, judges)

    def _about(
        self, mutants: Sequence[Mutant], paths: Sequence[str], baseline: Baseline
    ) -> dict[str, frozenset[str]]:
        """Return the subjects of the tests: the functions that they execute, or table entries."""
        files = self._tests(paths)
        ran = {node: about for node, about in baseline.ran.items() if _file(node) in files}
        entries = {one.pou for one in mutants if _is_table(one.file)}
        if not entries:
            return ran
        tables = sorted((self._root / "spec").glob("*.toml"))
        marks = {entry: marks_of(entry, tables) for entry in entries}
        return {node: _marked(node, marks) for node in ran}

    def _task(self, mutant: Mutant, tests: Sequence[str], baseline: Baseline) -> MutantTask:
        """Return a task. For a table, the key of the task includes the generator of the library."""
        around = ""
        if _is_table(mutant.file):
            around = digest(self._root, (self._root / "harness/rcx_tools/library").glob("*.py"))
        seconds = sum(baseline.seconds[node] for node in tests) / _TRACED
        return MutantTask(mutant, tuple(tests), seconds, f"{mutant.identity}{around}")

    def _mutants(self, kind: Kind, file: Path) -> list[Mutant]:
        text = file.read_text(encoding="utf-8")
        path = file.relative_to(self._root).as_posix()
        is_table = _is_table(path)
        changes = table_changes(text) if is_table else python_changes(text, path)
        one_of = 1 if self._options.all else kind.one_of
        if self._options.sample:
            one_of = max(1, len(changes) // self._options.sample)
        meaning = table_meaning if is_table else python_meaning
        seed = self._options.seed
        return sampled(self._root, file, changes, meaning, one_of=one_of, seed=seed)

    def _others(self, mutant: Mutant, ran: dict[str, frozenset[str]]) -> list[str]:
        """Return tests for a module in which no test has executed a function.

        The tests are in files that contain the name of the module.
        """
        name = Path(mutant.file).stem
        files = sorted({_file(node) for node in ran})
        naming = {file for file in files if name in (self._root / file).read_text("utf-8")}
        return spread([node for node in ran if _file(node) in naming], _OTHERS)

    def _judged(
        self, copies: Copies, title: str, tasks: list[MutantTask], judges: Judges
    ) -> dict[str, Any]:
        def run(task: MutantTask) -> str | None:
            mutant = task.mutant
            nodes = judges.ordered(mutant.pou, task.tests, _own(mutant.file, judges.ran))
            changed = {mutant.file: mutant.text}
            return copies.first_failure(
                changed,
                nodes,
                exhaustive=judges.exhaustive,
                regenerate=_is_table(mutant.file),
            )

        jobs, patience_s = self._options.jobs, self._options.patience
        judged = self._judging.of(
            title,
            tasks,
            judges,
            lambda todo: run_tasks(todo, run, jobs, copies.discard, patience_s),
        )
        return self._told(judged, len(tasks), judges.exhaustive)

    def _told(
        self, judged: Sequence[Judged], of: int, exhaustive: Collection[str]
    ) -> dict[str, Any]:
        reasons = Reasons(self._root / "tests/tools/evidence/survivors_harness.toml")
        tier = {"quick": quick_tier(judged, exhaustive)}
        return figures(judged, reasons, folder_of) | tier | {"not_run": of - len(judged)}


def _is_table(file: str) -> bool:
    return file.endswith(".toml")


def _file(node: str) -> str:
    return node.partition("::")[0]


def _shards(files: Sequence[str]) -> int:
    return -(-len(files) // _SHARD)


def _own(file: str, nodes: Mapping[str, frozenset[str]]) -> tuple[str, ...]:
    """Return the test files with the module's name in their path; for tables tests/spec."""
    stem = Path(file).stem
    files = sorted({_file(node) for node in nodes})
    if _is_table(file):
        return tuple(one for one in files if one.startswith("tests/spec/"))
    return tuple(one for one in files if stem in one)


def _marked(node: str, marks: dict[str, tuple[str, ...]]) -> frozenset[str]:
    """Return the table entries that the name of a test mentions.

    A test in tests/spec, or a test without parameters, is about all entries.
    """
    if "[" not in node or node.startswith("tests/spec/"):
        return frozenset(entry.upper() for entry in marks)
    return frozenset(
        entry.upper() for entry, names in marks.items() if any(name in node for name in names)
    )


def _write(file: Path, traced: Traced) -> None:
    """Write the records of a child process; paths are relative to the folder of the package."""
    base = file.parents[1]
    content = {
        "exhaustive": sorted(traced.exhaustive),
        "passed": [node for node, passed in traced.passed.items() if passed],
        "failed": [node for node, passed in traced.passed.items() if not passed],
        "seconds": {node: round(seconds, 4) for node, seconds in traced.seconds.items()},
        "ran": {
            node: [(Path(file_).relative_to(base).as_posix(), line) for file_, line in ran]
            for node, ran in traced.ran.items()
        },
    }
    file.write_text(json.dumps(content), encoding="utf-8")
