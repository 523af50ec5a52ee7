"""The mutants of a user's program, and the verdicts of the user's tests on them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

from structured_text.errors import COMMAND, DISTRIBUTION, InputError
from structured_text.farm import Farm
from structured_text.language.cache import sources_key
from structured_text.mutants.judging import ENDLESS, Judging, MutantTask, Outcome
from structured_text.mutants.mutant import Mutant, Mutants, in_rounds
from structured_text.mutants.order import Order
from structured_text.mutants.report import Judged, Reasons, figures
from structured_text.mutants.sessions import Judge, PytestCommand
from structured_text.mutants.tests import Tests
from structured_text.output.paths import real
from structured_text.projects.sources import SourceFiles

__all__ = ["UNREACHED", "UserMutants", "Verdicts"]

#: The value of `by` for a mutant in code that no test executes.
UNREACHED = "no test runs it"


class Verdicts(NamedTuple):
    """The verdicts on the mutants of a program.

    Attributes:
        figures: The figures of the report, and further figures about the run.
        judged: The mutants with their verdicts; survivors are in the order of the figures.
        not_run: Mutants that were not run, because the time was over.
    """

    figures: dict[str, Any]
    judged: list[Judged]
    not_run: list[Mutant]


class UserMutants:
    """The mutants of a program, and its tests.

    Raises:
        InputError: The sources do not compile or are not ST files.
    """

    def __init__(
        self, sources: SourceFiles, run: PytestCommand, written: Iterable[Path] = ()
    ) -> None:
        self._run = run
        self._written = {real(file) for file in written}
        self.files, library = sources.users
        for file in self.files:
            if getattr(file, "lines", None) is not None:
                hint = f"write its .st files with `{COMMAND} import`"
                raise InputError("is a project", file=file, hint=hint)
        self._all = [*self.files, *library]
        self._mutants = Mutants(run.folder, self._all, portable=False)

    def baseline(self) -> Tests:
        """Run the original program, and record the lines that each test executes.

        Raise InputError if a test fails, or none runs the program.
        """
        with TemporaryDirectory(prefix=f"{COMMAND}-mutants-", ignore_cleanup_errors=True) as name:
            order = Order(real(name))
            code = self._run(order)
            printed = (order.folder / "printed").read_text("utf-8", "replace")
            said = order.answered()
        command = " ".join(self._run.command)
        if said is None:
            last = next((line for line in reversed(printed.splitlines()) if line.strip()), "")
            told = f"`{command}` ends with {code} and runs no tests: {last.strip()}"
            raise InputError(
                told, hint=f"run pytest in an environment with {DISTRIBUTION} installed"
            )
        failed = [node for node, passed in said["passed"].items() if not passed]
        if failed:
            more = f" and {len(failed) - 1} more" if len(failed) > 1 else ""
            why = f" ({said['why'][0]})" if said["why"] else ""
            told = f"{failed[0]}{more} fails with the program as it is{why}"
            raise InputError(told, hint="make all tests pass first")
        mutated = {real(file) for file in self.files}
        ran = {
            node: {file: set(lines) for file, lines in files.items() if Path(file) in mutated}
            for node, files in said["ran"].items()
        }
        if not any(lines for files in ran.values() for lines in files.values()):
            told = f"none of {len(ran)} tests executes a statement of {self.files[0]}"
            raise InputError(told, hint="name the program files that the tests load")
        root = Path(said["root"])
        own = mutated | self._written
        return Tests(self._run.folder, root, ran, said["seconds"], said["listed"], own)

    def tasks(self, tests: Tests) -> tuple[list[MutantTask], list[Mutant]]:
        """Return the mutants in the order in which they are run, and mutants that no test executes.

        The order is the same in each run. If the time limit ends a run early, all files and all
        kinds of mistakes have had their share.
        """
        by_file: list[list[MutantTask]] = []
        unreached: list[Mutant] = []
        for file in self.files:
            others = [one for one in self._all if one != file]
            around = sources_key(others)[:8]
            found = in_rounds(self._mutants.of(file), lambda one: one.operator, Random(file.name))
            by_file.append([])
            for mutant in found:
                if not (nodes := tests.of(mutant)):
                    unreached.append(mutant)
                    continue
                seconds = sum(tests.seconds.get(node, 0.0) for node in nodes)
                in_order = tuple(tests.ordered(mutant, nodes))
                by_file[-1].append(
                    MutantTask(mutant, in_order, seconds, f"{mutant.identity}-{around}")
                )
        return [one for each in zip_longest(*by_file) for one in each if one is not None], unreached

    def judged(self, tests: Tests, judging: Judging, farm: Farm, reasons: Reasons) -> Verdicts:
        """Run the mutants; return their verdicts, and the figures of the report."""
        tasks, unreached = self.tasks(tests)

        def run(todo: Iterable[MutantTask]) -> Iterator[Outcome]:
            with TemporaryDirectory(
                prefix=f"{COMMAND}-mutants-", ignore_cleanup_errors=True
            ) as name:
                judge = Judge(self._run, real(name), tuple(self._all))
                for task, outcome in farm.as_ready(judge, todo):
                    # The worker process returns a copy of the task; `Judging` needs the original
                    # object.
                    yield replace(outcome, task=task)

        judged = judging.of("mutants", tasks, tests, run)
        judged += [Judged(mutant, False, UNREACHED) for mutant in unreached]
        judged.sort(key=lambda one: (one.mutant.file, one.mutant.line, one.mutant.after))
        found = figures(judged, reasons, lambda file: file, self._whole(judged, tasks, unreached))
        counted = self._mutants.counted
        open_ones = found["mutants"] - found["survivors_with_a_reason"]
        score = round(100.0 * found["killed"] / open_ones, 2) if open_ones else 100.0
        # Two mutants of a place can be equal, so the object itself counts.
        ran = {id(one.mutant) for one in judged}
        not_run = [task.mutant for task in tasks if id(task.mutant) not in ran]
        found |= {
            "score_without_reasons": score,
            "tests": len(tests.ran),
            "timed_out": sum(one.by == ENDLESS for one in judged),
            "unreached": [_place(mutant) for mutant in unreached],
            "not_run": len(not_run),
            "not_compiling": counted.refused,
            "changing_nothing": counted.equal,
        }
        return Verdicts(found, judged, not_run)

    @staticmethod
    def _whole(
        judged: Sequence[Judged], tasks: Sequence[MutantTask], unreached: Sequence[Mutant]
    ) -> set[str]:
        """Return the names of the POUs if all mutants were run, else an empty set."""
        if len(judged) < len(tasks) + len(unreached):
            return set()
        return {one.mutant.pou for one in judged}


def _place(mutant: Mutant) -> dict[str, Any]:
    return {"file": mutant.file, "line": mutant.line, "after": mutant.after}
