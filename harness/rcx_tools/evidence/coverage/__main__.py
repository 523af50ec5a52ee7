"""Command `python -m rcx_tools.evidence.coverage`: run the tests and report the coverage.

The exit code is 1 if something is not covered.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from rcx_tools.evidence.coverage.run import Run, run_tests
from rcx_tools.evidence.results import ROOT
from structured_text.coverage.measure import FileResult, Share, measure
from structured_text.coverage.output import write_report
from structured_text.coverage.parts import Part, merge, part_of
from structured_text.coverage.report import gaps, summary, totals
from structured_text.engines.builtin.collector import Collector
from structured_text.engines.builtin.coverage import Plan
from structured_text.language.load import checked
from structured_text.output.toml_files import load_toml

__all__ = ["figures", "main", "reasons", "uncounted"]

#: Folders and files for which MC/DC is required.
MCDC_FILES = ("area/", "core/", "sequence/", "command/FB_RemoteCommand.st")

#: File with the reasons for parts that need no coverage. The path is relative to the repository.
REASONS = "tests/tools/evidence/conditions.toml"

#: The name of the library in the reports.
_LIBRARY = "plc/lib"

#: Width of the table [characters].
_WIDTH = 120

#: Number of gaps to print; the report contains all gaps.
_MOST_GAPS = 30


def reasons(file: Path) -> dict[tuple[str, str, str], str]:
    """Return the reasons for missing MC/DC, by (POU, decision, condition), from a TOML file."""
    table = load_toml(file)
    return {
        (one["pou"], one["decision"], condition): one["reason"]
        for one in table.get("gap", [])
        for condition in one["conditions"]
    }


def uncounted(library: Path) -> Part:
    """Return a part of the report with every file of a library and without executed code."""
    collector = Collector(library)
    project = checked(sorted(library.resolve().rglob("*.st")))
    for pou in project.pous.values():
        collector.counts(pou, Plan.of(pou), project)
    return part_of(collector)


def figures(results: Sequence[FileResult], run: Run) -> dict[str, Any]:
    """Return the figures for out/verification/coverage.json."""
    folders = sorted({result.folder for result in results})
    return {
        "tests": run.passed,
        "failed": run.failed,
        "files": len(results),
        "all": _shares(results),
        "folders": {
            one: _shares([result for result in results if result.folder == one]) for one in folders
        },
        "mcdc_demanded": _shares([result for result in results if result.demands_mcdc]),
        "gaps": len(gaps(results)),
        "justified": len(gaps(results, justified=True)),
    }


def _shares(results: Sequence[FileResult]) -> dict[str, Any]:
    return {name: _numbers(share) for name, share in totals(results).items()}


def _numbers(share: Share) -> dict[str, float]:
    return {
        "covered": share.covered,
        "total": share.total,
        "justified": share.justified,
        "percent": round(share.percent, 2),
    }


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the coverage. Return 0 if all is covered or justified and MC/DC is sufficient."""
    parser = argparse.ArgumentParser(prog="python -m rcx_tools.evidence.coverage")
    parser.add_argument("--report-only", action="store_true", help="use the counts of the last run")
    parser.add_argument("--workers", default="auto", help="processes (pytest's -n)")
    parser.add_argument("--out", type=Path, default=ROOT / "out", help="folder of the results")
    options = parser.parse_args(arguments)
    console = Console(highlight=False, emoji=False)
    console.width = max(console.width, _WIDTH)
    folder = options.out / "coverage"
    counts = folder / "counts" / "counts.json"
    if options.report_only:
        run = _last_run(folder)
    else:
        run = run_tests(ROOT, counts, options.workers, console)
        last = {"passed": run.passed, "failed": run.failed, "skipped": run.skipped}
        (folder / "run.json").write_text(json.dumps(last) + "\n", encoding="utf-8")
    library = ROOT / _LIBRARY
    parts = [*json.loads(counts.read_text(encoding="utf-8")), uncounted(library)]
    results = measure(merge(parts), library, reasons(ROOT / REASONS), MCDC_FILES)
    write_report(results, folder, _LIBRARY, library, absolute=True)
    lines = [summary(results, 160)]
    for title, justified in (("Gaps", False), ("Justified", True)):
        lines += [f"\n{title}:", *(f"  {gap}" for gap in gaps(results, justified=justified))]
    (folder / "coverage.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    met = run.clean and not gaps(results)
    data = {"command": "make coverage", "figures": figures(results, run), "met": met}
    verification = options.out / "verification"
    verification.mkdir(parents=True, exist_ok=True)
    (verification / "coverage.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    _print(console, results, run, folder)
    return 0 if met else 1


def _last_run(folder: Path) -> Run:
    file = folder / "run.json"
    if not file.is_file():
        raise SystemExit(f"there is no earlier run in {folder}")
    last = json.loads(file.read_text(encoding="utf-8"))
    return Run(last["passed"], last["failed"], last["skipped"], "")


def _print(console: Console, results: Sequence[FileResult], run: Run, folder: Path) -> None:
    if not run.clean:
        console.print(run.output, markup=False)
    console.print(f"{run.passed} tests passed, {run.failed} failed, {run.skipped} skipped\n")
    for name, share in totals(results).items():
        console.print(f"{name}: {share.percent:.2f} % ({share.covered} of {share.total})")
    found = gaps(results)
    console.print(f"\ngaps: {len(found) or 'none'}; with a reason: ", end="")
    console.print(len(gaps(results, justified=True)))
    for gap in found[:_MOST_GAPS]:
        console.print(f"  {gap}", markup=False, soft_wrap=True)
    if len(found) > _MOST_GAPS:
        console.print(f"  and {len(found) - _MOST_GAPS} more")
    shown = folder.relative_to(ROOT) if folder.is_relative_to(ROOT) else folder
    console.print(
        f"\n{shown}/index.html, coverage.txt, coverage.lcov, coverage.xml", soft_wrap=True
    )


if __name__ == "__main__":
    sys.exit(main())
