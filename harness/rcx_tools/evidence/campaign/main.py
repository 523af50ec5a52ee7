"""Command `python -m rcx_tools.evidence.campaign`: random long runs with every kind of fault."""

from __future__ import annotations

import hashlib
from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple, TypeGuard

from rich.console import Console
from rich.table import Table

from rcx_harness.cell.compiled import Compiled
from rcx_harness.cell.stimulus import entry_text
from rcx_harness.trace import Record
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.verify.storm.shrink import shrink
from rcx_harness.verify.storm.storms import Failure, Storm
from rcx_tools.evidence.broken import library_copy
from rcx_tools.evidence.campaign.commands import COMMANDS
from rcx_tools.evidence.campaign.judge import SEQUENCES
from rcx_tools.evidence.campaign.outcome import Outcome
from rcx_tools.evidence.campaign.run import compiled, run_storms
from rcx_tools.evidence.campaign.schedule import draw_run
from rcx_tools.evidence.campaign.seeded import SEEDED, find
from rcx_tools.evidence.results import FOLDER, write_result
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.farm import Farm

__all__ = ["main"]

#: Default number of runs, and default number of storms in each run.
RUNS, STORMS = 72, 10
#: Number of runs that are repeated on a second engine. Both engines must give the same trace.
TWICE = 8


class _Job(NamedTuple):
    seed: int
    storms: int
    engine: str
    lib: Path | None
    twice: bool
    seeded: int = -1
    """The index of the seeded bug to find. -1: the unchanged library is checked."""


class _Result(NamedTuple):
    seed: int
    outcome: Outcome
    failure: str
    job: _Job


@cache
def _compiled(engine: str, lib: Path | None) -> Compiled:
    return compiled(engine, lib)


def _run(job: _Job) -> _Result:
    if job.seeded >= 0:
        found = find(SEEDED[job.seeded], job.engine)
        right = found is not None and found.failure.kind in SEEDED[job.seeded].kinds
        text = "" if found is None else f"seed {found.seed}: {found.failure}"
        return _Result(job.seed, Outcome(), text if right else "", job)
    conditions, storms = draw_run(job.seed, job.storms)
    engines = ("matiec", "builtin") if job.twice else (job.engine,)
    outcome, digests = Outcome(), []
    for engine in engines:
        digest = hashlib.sha256()

        def take(record: Record, digest: hashlib._Hash = digest) -> None:
            digest.update(repr(record).encode())

        listener = take if job.twice else None
        try:
            program = _compiled(engine, job.lib)
            outcome = run_storms(program, conditions, storms, job.seed, listener=listener)
        except Failure as failure:
            return _Result(job.seed, outcome, str(failure), job)
        digests.append(digest.hexdigest())
    if len(set(digests)) > 1:
        return _Result(job.seed, outcome, "the engines give different traces", job)
    return _Result(job.seed, outcome, "", job)


def _explain(seed: int, options: Namespace, console: Console) -> None:
    """Run a failing seed again and shorten it. Write trace, chart and events."""
    program = _compiled(options.engine, options.lib)
    conditions, storms = draw_run(seed, options.storms)

    def again(candidate: Sequence[Storm]) -> None:
        run_storms(program, conditions, candidate, seed)

    try:
        again(storms)
    except Failure as failure:
        with console.status(f"seed {seed}: looking for a shorter run ..."):
            short, found = shrink(again, storms, failure)
    else:
        console.print(f"seed {seed}: no failure")
        return
    folder = FOLDER / "campaign"
    folder.mkdir(parents=True, exist_ok=True)
    trace, timeline = folder / f"seed_{seed}.jsonl", Timeline()
    begin_us = max(0, found.t_us - 4_000_000)

    def late(record: Record) -> None:
        if record.t_us >= begin_us:
            timeline.take(record)

    try:
        run_storms(program, conditions, short, seed, trace=trace, listener=late)
    except Failure as failure:
        chart = svg_chart(timeline, f"campaign, seed {seed}: {failure.kind}")
        (folder / f"seed_{seed}.svg").write_text(chart, encoding="utf-8")
    acts = [entry_text(act) for storm in short for act in storm.acts]
    lines = [str(found), f"{conditions.timing}", *acts]
    (folder / f"seed_{seed}.txt").write_text("\n".join(lines) + "\n", encoding="utf-8")
    console.print(f"seed {seed}: {found}")
    console.print(f"  {len(acts)} events remain: {trace}, also as .svg and .txt")


def _options(arguments: list[str] | None) -> Namespace:
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.campaign", description=__doc__)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--runs", type=int, default=RUNS, help="number of seeds")
    parser.add_argument("--storms", type=int, default=STORMS, help="storms in each run")
    parser.add_argument("--seed", type=int, help="run only this seed; explain a failure")
    parser.add_argument("--only-runs", action="store_true", help="do not try the seeded bugs")
    parser.add_argument("--engine", default="auto", help="auto, matiec or builtin")
    parser.add_argument("--lib", type=Path, help="folder of the library")
    parser.add_argument("--jobs", type=int, default=2, help="processes")
    return parser.parse_args(arguments)


def _figures(total: Outcome, options: Namespace, engine: str, twice: int) -> dict[str, object]:
    return {
        "virtual hours": round(total.virtual_us / 3_600_000_000, 2),
        "seeds": f"{options.first} to {options.first + options.runs - 1}",
        "storms": total.storms,
        "scans": total.scans,
        "requests of command blocks": total.requests,
        "executions in the controller": total.executions,
        "ends of command blocks": dict(sorted(total.ends.items())),
        "faults": dict(sorted((k, v) for k, v in total.acts.items() if k != "set")),
        "packets": dict(sorted(total.packets.items())),
        "work done by each block": dict(sorted(total.done.items())),
        "longest until the cell is at rest [s]": round(total.longest_quiet_us / 1e6, 2),
        "longest recovery with work [s]": round(total.longest_recovery_us / 1e6, 2),
        "engine": engine,
        "runs with the same trace on both engines": twice,
    }


def _expected() -> set[str]:
    """Return what every long campaign must contain: work of each block, and each kind of fault."""
    faults = {"alarm", "emergency_stop", "link_down", "power_off", "pendant_on", "manual_mode"}
    faults |= {"lost", "late", "doubled", "plc_overrun", "packet_interval", "plc_power_off"}
    faults |= {"main_power_off"}
    return faults | {"safety_on"} | set(COMMANDS) | set(SEQUENCES)


def _is_count(value: object) -> TypeGuard[dict[str, int]]:
    return isinstance(value, dict) and all(isinstance(one, int) for one in value.values())


def main(arguments: list[str] | None = None) -> int:
    """Run the campaign; return 0 if nothing was found, else 1."""
    options = _options(arguments)
    with library_copy() as lib:
        options.lib = options.lib or lib
        return _main(options, Console())


def _main(options: Namespace, console: Console) -> int:
    if options.seed is not None:
        _explain(options.seed, options, console)
        return 0
    both = find_matiec() is not None and find_c_compiler() is not None
    engine = options.engine
    if engine == "auto":
        engine = "matiec" if both else "builtin"
    seeds = range(options.first, options.first + options.runs)
    last_twice = options.first + (TWICE if both else 0)
    jobs = [_Job(k, options.storms, engine, options.lib, k < last_twice) for k in seeds]
    if not options.only_runs:
        jobs += [_Job(0, 0, engine, None, False, k) for k in range(len(SEEDED))]
    console.print(f"seeds {seeds[0]} to {seeds[-1]}, {options.storms} storms each, on {engine}")
    total, failures, twice, found = Outcome(), {}, 0, {}
    for job, result in Farm(options.jobs, console=console).run(_run, jobs, title="campaign"):
        if job.seeded >= 0:
            found[SEEDED[job.seeded].name] = result.failure or "NOT FOUND"
            continue
        total.add(result.outcome)
        twice += job.twice and not result.failure
        if result.failure:
            failures[result.seed] = result.failure
            console.print(f"seed {result.seed}: {result.failure}")
    figures = _figures(total, options, engine, twice)
    unseen = sorted(_expected() - {*total.acts, *total.done, *total.packets})
    missed = [name for name, text in found.items() if text == "NOT FOUND"]
    figures["never seen"] = unseen
    figures["failing seeds"] = {str(k): failures[k] for k in sorted(failures)}
    figures["broken blocks found"] = f"{len(found) - len(missed)} of {len(found)}"
    figures["broken blocks"] = dict(sorted(found.items()))
    table = Table("figure", "value", title="Fault campaign")
    for name, value in figures.items():
        shown = sum(value.values()) if _is_count(value) else value
        if not isinstance(shown, dict):
            table.add_row(name, str(shown))
    console.print(table)
    met = not (failures or unseen or missed)
    write_result("campaign", figures, met=met)
    for seed in sorted(failures)[:3]:
        _explain(seed, options, console)
    return 0 if met else 1
