"""Command `python -m rcx_tools.evidence.mutants`: run the tests for one mutant after the other.

Mutants are made of plc/lib (`library`), of the virtual controller, the monitors and the engine, and
of the tables in spec/. A mutant is one small change of one file that still compiles. It is killed
if a test of the suite fails with it. Mutants of the library are inserted into programs in the
memory of this process, all other mutants into temporary copies of the repository. Each mutant runs
in its own child process. The argument `seeded` runs the bugs of seeded.toml. The tests in the row
of a bug must find the bug.

Outcomes are saved in out/verification/mutants.jsonl. A saved outcome is valid while its inputs are
unchanged: the mutated file, the files compiled with it, and the test that has failed (or all tests,
if no test has failed). A run therefore continues where the last run ended. The same folder gets the
survivors without a reason as rows for the tables in tests/tools/evidence:
mutants-without-reason.toml for survivors.toml, and mutants-without-reason-harness.toml for
survivors_harness.toml.

The generated command blocks are similar to each other. Only a sample of their mutants, and of the
mutants outside the library, is run. A seed determines the sample, and each operator is included.
`--all` or MUTANTS=all runs all mutants.

The tests that `make test` leaves out run last. Each run therefore also gives the score of the quick
tests alone.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from rcx_tools.evidence.mutants.harness import KINDS, HarnessRun
from rcx_tools.evidence.mutants.library import LibraryRun
from rcx_tools.evidence.mutants.pool import PATIENCE_S
from rcx_tools.evidence.mutants.printing import print_report
from rcx_tools.evidence.mutants.tiers import QUICK_GOAL, print_quick_tier
from structured_text.errors import InputError
from structured_text.mutants.judging import Judging
from structured_text.mutants.report import write_rows
from structured_text.output.results import Results

__all__ = ["main"]

ROOT = Path(__file__).resolve().parents[4]
#: Required score [%] of all mutants that do not compile to the same code as the original.
GOAL = 95.0
_LIBRARY, _SEEDED = "library", "seeded"
_ALL = (*(kind.name for kind in KINDS), _SEEDED, _LIBRARY)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the mutants; return 0 if the score is reached, with reasons for all survivors.

    Every seeded bug must also be found. The exit code is 1 otherwise, 2 on bad input, 130 after
    Ctrl-C.
    """
    options = _options(arguments)
    console = Console()
    out = options.root / "out" / "verification"
    started = time.monotonic()
    judging = Judging(
        console,
        Results(out / "mutants.jsonl", fresh=options.fresh),
        started + 60 * options.minutes if options.minutes is not None else None,
    )
    try:
        found = HarnessRun(options, judging).figures(options.kinds)
        if _LIBRARY in options.kinds:
            library = LibraryRun(options, judging).figures()
            if library is None:
                print("the tests could not be collected", file=sys.stderr)
                return 2
            found[_LIBRARY] = library
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("stopped; the next run goes on from here", file=sys.stderr)
        return 130
    _report(console, found, out, options.show)
    met = all(_is_met(kind, one) for kind, one in found.items())
    whole = not (options.blocks or options.named or options.sample)
    if whole and _LIBRARY in found:
        more = {name: one for name, one in found.items() if name != _LIBRARY}
        figures = found[_LIBRARY] | {
            "kinds": more,
            "seed": options.seed,
            "run_time_s": round(time.monotonic() - started, 1),
        }
        report = {"command": "make mutants", "figures": figures, "met": met}
        (out / "mutants.json").write_text(json.dumps(report, indent=1) + "\n", "utf-8")
    return 0 if met else 1


def _report(console: Console, found: dict[str, dict[str, Any]], out: Path, show: int) -> None:
    unexplained: list[Any] = []
    for kind, one in found.items():
        table = "survivors.toml" if kind == _LIBRARY else "survivors_harness.toml"
        print_report(console, one, show=show, kind=kind, table_of=table)
        print_quick_tier(console, kind, one)
        if kind == _LIBRARY:
            write_rows(out / "mutants-without-reason.toml", one["survivors"])
        elif kind != _SEEDED:
            unexplained += one["survivors"]
    write_rows(out / "mutants-without-reason-harness.toml", unexplained)


def _is_met(kind: str, figures: dict[str, Any]) -> bool:
    if figures["not_run"] or figures["quick"]["share"] < QUICK_GOAL:
        return False
    if kind == _SEEDED:
        return bool(figures["killed"] == figures["mutants"])
    explained = figures["survivors_with_a_reason"] == len(figures["survivors"])
    return bool(figures["score"] >= GOAL and explained)


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m rcx_tools.evidence.mutants")
    parser.add_argument(
        "blocks", nargs="*", help="names of blocks, or parts of paths (default: all)"
    )
    parser.add_argument("--root", type=Path, default=ROOT, help="the repository")
    parser.add_argument("--kinds", help=f"some of {','.join(_ALL)} (default: all)")
    parser.add_argument("--all", action="store_true", help="every mutant, no sample")
    parser.add_argument(
        "--named", action="store_true", help="a quick look: only the tests that a file names"
    )
    parser.add_argument("--sample", type=int, help="a quick look: so many mutants of each file")
    parser.add_argument("--seed", type=int, default=1, help="of the sample")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument(
        "--patience", type=float, default=PATIENCE_S, help="seconds until a mutant is endless"
    )
    parser.add_argument("--minutes", type=float, help="start no mutant after so long")
    parser.add_argument("--fresh", action="store_true", help="forget earlier outcomes")
    parser.add_argument("--show", type=int, default=20, help="survivors that are printed")
    options = parser.parse_args(arguments)
    options.root = options.root.resolve()
    options.kinds = options.kinds.split(",") if options.kinds else list(_ALL)
    unknown = [kind for kind in options.kinds if kind not in _ALL]
    if unknown:
        parser.error(f"there is no kind {unknown[0]!r}; kinds are {', '.join(_ALL)}")
    options.all = options.all or os.environ.get("MUTANTS") == "all"
    return options


if __name__ == "__main__":
    sys.exit(main())
