"""Command `python -m rcx_tools.evidence.prove`: prove the library; write out/prove.json.

If the user names properties, seeded bugs or another copy of the library, only these are checked.
Their outcome is written to out/prove/part.json.
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser, Namespace
from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.console import Console

from rcx_tools.evidence.prove import report, seeded
from rcx_tools.evidence.prove.agreement import jobs as agreeing
from rcx_tools.evidence.prove.jobs import died, jobs, run
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.running import HasKey, Run, outcomes
from rcx_tools.evidence.results import ROOT, write_result
from structured_text.errors import InputError
from structured_text.output.progress import progress_bar
from structured_text.output.results import Results
from structured_text.output.system import processors

__all__ = ["LIBRARY", "main"]

#: The folder of the library that is proved.
LIBRARY = ROOT / "plc" / "lib"
_OUT = ROOT / "out"


def _arguments(arguments: list[str] | None) -> Namespace:
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.prove", description=__doc__)
    parser.add_argument("properties", nargs="*", help="names of properties (default: all)")
    parser.add_argument(
        "--bug", action="append", default=[], help="name of a seeded bug to try; may be repeated"
    )
    parser.add_argument("--lib", help="another copy of plc/lib; without the seeded bugs")
    parser.add_argument("--limit", type=_positive, default=60.0, help="seconds for each goal")
    workers = "processes at a time; 0: none but this"
    parser.add_argument(
        "--jobs",
        type=int,
        choices=range(65),
        metavar="N",
        default=min(processors(), 64),
        help=workers,
    )
    parser.add_argument("--fresh", action="store_true", help="forget earlier outcomes")
    parser.add_argument("--out", type=Path, default=_OUT)
    return parser.parse_args(arguments)


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < 1e6:
        raise ValueError
    return value


class _Runner:
    """Runs all jobs without a saved outcome. Only good outcomes are saved."""

    def __init__(self, options: Namespace, console: Console) -> None:
        self._known = Results(options.out / "prove" / "known.jsonl", fresh=options.fresh)
        self._workers = options.jobs
        self._console = console

    def of(
        self,
        title: str,
        run: Run[Any],
        work: list[Any],
        died: Run[Any],
        prepare: Callable[[], None] = lambda: None,
    ) -> dict[str, Any]:
        """Return the outcomes of jobs by key, and reuse good outcomes of earlier runs.

        Args:
            title: The title of the progress bar.
            run: Function that runs a job.
            work: The jobs.
            died: Function that returns the outcome of a job whose process has died.
            prepare: Function that is called before the first job, if there is a job to run.
        """
        found = {job.key: known for job in work if (known := self._known.get(job.key))}
        missing: list[HasKey] = [job for job in work if job.key not in found]
        if missing:
            prepare()
        with progress_bar(self._console) as progress:
            bar = progress.add_task(title, total=len(work), completed=len(found), told="")
            for outcome in outcomes(run, missing, self._workers, died):
                progress.update(bar, advance=1, told=outcome["key"].rsplit(":", 1)[0], refresh=True)
                if outcome["good"]:
                    self._known.add(outcome)
                found[outcome["key"]] = outcome
        return found


def _prove(options: Namespace, console: Console) -> int:
    folder = Path(options.lib).resolve() if options.lib else LIBRARY
    library = Library(folder)
    library.complete(LIBRARY)
    whole = not options.properties and not options.bug
    work = [] if options.bug else list(jobs(library, options.properties, options.limit))
    own = whole and not options.lib
    if options.bug or own:
        seeded.chosen(library, options.bug, seeded.BUGS)
    runner = _Runner(options, console)
    entries = report.properties(work, runner.of("proving", run, work, died))
    bugs = []
    if options.bug or own:
        copies = (options.out / "prove" / "seeded").resolve()
        bugs = seeded.tasks(library, options.bug, options.limit, copies, seeded.BUGS)
    told: dict[str, Any] = {"library": str(folder)} if options.lib else {}
    told |= {"properties": entries, "assumptions": report.taken_for_granted(entries)}
    if own:
        compared = list(agreeing.comparisons(library))
        agreed = runner.of(
            *("agreement", agreeing.compare, compared, agreeing.died),
            lambda: agreeing.prepare(str(folder)),
        )
        told["agreement"] = agreeing.summary(agreed.values())
    if bugs:
        judged = runner.of("seeded bugs", seeded.judge, bugs, seeded.died)
        told["seeded"] = seeded.summary(bugs, judged, whole=whole)
    report.write(options.out / ("prove.json" if whole else "prove/part.json"), told)
    report.show(told, console)
    good = report.is_good(told)
    if own and options.out == _OUT:
        write_result("prove", told, met=good)
    if options.lib:
        console.print("Seeded bugs and agreement are only for the library of this project.")
    return 0 if good else 1


def main(arguments: list[str] | None = None) -> int:
    """Prove the library; return 0 if all is proved, 1 if not, 2 on bad input."""
    options = _arguments(arguments)
    console = Console(stderr=True, highlight=False)
    try:
        return _prove(options, console)
    except InputError as error:
        console.print(str(error), markup=False, soft_wrap=True)
        return 2


if __name__ == "__main__":
    sys.exit(main())
