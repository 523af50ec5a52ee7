"""`python -m rcx_tools.evidence.prove`: prove every property of the library; out/prove.json."""

from __future__ import annotations

import json
import os
import sys
from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import Any

from rich.console import Console

from rcx_harness.errors import InputError
from rcx_tools.evidence.mutants.judging import progress_bar
from rcx_tools.evidence.prove.jobs import PROPERTIES, Job, jobs, run
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.results import ROOT
from rcx_tools.evidence.store import Results
from rcx_tools.evidence.workers import results

__all__ = ["main"]


def _arguments(arguments: list[str] | None) -> Namespace:
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.prove", description=__doc__)
    parser.add_argument("properties", nargs="*", help="names of properties (default: all)")
    parser.add_argument("--lib", default=str(ROOT / "plc/lib"), help="another copy of plc/lib")
    parser.add_argument("--limit", type=float, default=60.0, help="seconds for each goal")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--fresh", action="store_true", help="forget earlier outcomes")
    parser.add_argument("--out", default=str(ROOT / "out"))
    return parser.parse_args(arguments)


def _outcomes(
    work: list[Job], known: Results, console: Console, workers: int
) -> list[dict[str, Any]]:
    found = [outcome for job in work if (outcome := known.get(job.key)) is not None]
    have = {outcome["key"] for outcome in found}
    missing = [job for job in work if job.key not in have]
    with progress_bar(console) as progress:
        bar = progress.add_task("proving", total=len(work), completed=len(found), told="")
        for outcome in results(run, missing, workers) if missing else ():
            told = f"{outcome['property']} {outcome['part']}: {outcome['status']}"
            progress.update(bar, advance=1, told=told, refresh=True)
            if outcome["status"] == "proved":
                known.add(outcome)
            found.append(outcome)
    return found


def _report(found: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """One entry a property, in their order."""
    order = ("refuted", "unknown", "proved")
    report = []
    for item in PROPERTIES:
        parts = [outcome for outcome in found if outcome["property"] == item.name]
        if parts:
            goals = [goal | {"part": part["part"]} for part in parts for goal in part["goals"]]
            report.append(
                {
                    "name": item.name,
                    "says": item.says,
                    "section": item.section,
                    "status": min((part["status"] for part in parts), key=order.index),
                    "seconds": round(sum(part["seconds"] for part in parts), 1),
                    "assumes": list(item.assumes),
                    "goals": len(goals),
                    "not_proved": [goal for goal in goals if goal["status"] != "proved"],
                }
            )
    return report


def main(arguments: list[str] | None = None) -> int:
    """Run it; 0 where all is proved, 1 where something is not, 2 on bad input."""
    options = _arguments(arguments)
    console = Console(stderr=True)
    folder = Path(options.lib).resolve()
    out = Path(options.out)
    try:
        if not folder.is_dir():
            raise InputError(f"there is no folder {options.lib}", hint="name a copy of plc/lib")
        work = list(jobs(Library(folder), options.properties, options.limit))
    except InputError as error:
        console.print(str(error), markup=False, highlight=False)
        return 2
    known = Results(out / "prove" / "known.jsonl", fresh=options.fresh)
    found = _outcomes(work, known, console, options.jobs)
    report = _report(found)
    text = json.dumps({"properties": report}, indent=1) + "\n"
    (out / "prove.json").write_text(text, encoding="utf-8")
    for item in report:
        console.print(
            f"{item['status']:8} {item['name']}: {item['goals']} goals, {item['seconds']} s"
        )
        for goal in item["not_proved"]:
            console.print(
                f"    {goal['status']}: {goal['part']} {goal['goal']}",
                goal.get("values") or goal.get("reason"),
                markup=False,
            )
    return 0 if all(item["status"] == "proved" for item in report) else 1


if __name__ == "__main__":
    sys.exit(main())
