"""Explore the models in several processes, print the figures and write them.

Each outcome is saved at once. A later run uses it again if none of its inputs has changed.
"""

from __future__ import annotations

import argparse
import gc
import json
import multiprocessing
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from queue import Queue
from tempfile import TemporaryDirectory
from threading import Thread
from typing import NamedTuple

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn
from rich.table import Table

from rcx_tools.evidence.explore import interlock
from rcx_tools.evidence.explore.interlock import InterlockModel
from rcx_tools.evidence.explore.known import AnyModel, Done, Found, Known
from rcx_tools.evidence.explore.models import MODELS
from rcx_tools.evidence.explore.models_small import SMALL
from rcx_tools.evidence.explore.replay import replay
from rcx_tools.evidence.explore.search import LIBRARY, Explorer
from rcx_tools.evidence.explore.seeded import SEEDED, Seeded
from rcx_tools.evidence.results import ROOT
from structured_text.explore.search import Broken, Result
from structured_text.farm import Farm
from structured_text.output.system import processors

__all__ = ["EVERY_BUG", "EVERY_MODEL", "OUT", "items_of", "main", "without_collector"]

#: The folder of the saved outcomes.
OUT = ROOT / "out/verification"
_SEEDS = "seeded bugs"
EVERY_MODEL: dict[str, AnyModel] = {
    model.name: model for model in (*MODELS, *SMALL, *interlock.MODELS)
}
EVERY_BUG = (*SEEDED, *interlock.SEEDED)


class _Task(NamedTuple):
    """The common settings of all explorations: see the arguments of the command."""

    library: tuple[Path, ...]
    limit: int
    seed: int


#: Progress of a model: its name, explored states, known states.
_Report = tuple[str, int, int]


@dataclass(frozen=True)
class _Exploring:
    """Worker that explores a model, or searches for a seeded bug, by its name."""

    task: _Task
    reports: Queue[_Report | None]

    def __call__(self, item: tuple[str, bool]) -> Done | Found:
        name, is_bug = item
        with without_collector():
            if is_bug:
                return _look_for(name, self.task.library)
            return _explore(name, self.task, self.reports)


@contextmanager
def without_collector() -> Iterator[None]:
    """Disable the garbage collector meanwhile.

    Millions of small objects exist, none of them in a cycle. Searching them for cycles takes a
    sixth of the time.
    """
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 0 if every model is complete and no rule is broken."""
    parser = argparse.ArgumentParser(
        prog="python -m rcx_tools.evidence.explore", description=__doc__
    )
    names = list(EVERY_MODEL)
    parser.add_argument("models", nargs="*", metavar="MODEL", help=f"of {', '.join(names)}; all")
    parser.add_argument("--jobs", type=int, default=min(2, processors()))
    parser.add_argument("--limit", type=int, default=0, help="most states of a model; 0 = all")
    parser.add_argument("--lib", type=Path, help="another copy of plc/lib")
    parser.add_argument("--fresh", action="store_true", help="forget the outcomes of earlier runs")
    parser.add_argument("--seed", type=int, default=1, help="of the checks of the abstraction")
    chosen = parser.parse_args(arguments)
    unknown = set(chosen.models) - set(names)
    if unknown:
        parser.error(f"no model {', '.join(sorted(unknown))}; there are {', '.join(names)}")
    models = [one for one in EVERY_MODEL.values() if not chosen.models or one.name in chosen.models]
    seeded = [bug for bug in EVERY_BUG if bug.model in {model.name for model in models}]
    console = Console()
    started = time.monotonic()
    library = LIBRARY if chosen.lib is None else tuple(sorted(chosen.lib.rglob("*.st")))
    task = _Task(library, chosen.limit, chosen.seed)
    known = Known(OUT / "explore.jsonl", chosen.seed, library, fresh=chosen.fresh)
    done, found = _run(models, seeded, chosen.jobs, task, known, console)
    seconds = time.monotonic() - started
    _print(console, done, found, seconds)
    met = all(one.result.met for one in done) and all(one.scans for one in found)
    if not chosen.models and not chosen.limit:
        _write(done, found, met)
    return 0 if met else 1


def _run(
    models: Sequence[AnyModel],
    seeded: Sequence[Seeded],
    jobs: int,
    task: _Task,
    known: Known,
    console: Console,
) -> tuple[list[Done], list[Found]]:
    """Explore all models and search for all seeded bugs, in several processes."""
    columns = (
        TextColumn("{task.description:<12}"),
        BarColumn(24),
        TextColumn("{task.completed:>7,.0f} of {task.total:>7,.0f} {task.fields[what]}"),
        TimeElapsedColumn(),
    )
    outcomes: dict[str, Done | Found] = {}
    for model in models:
        if (done := known.model(model)) is not None:
            outcomes[model.name] = done
    for bug in seeded:
        if (found := known.bug(bug, EVERY_MODEL[bug.model])) is not None:
            outcomes[bug.name] = found
    for name, outcome in outcomes.items():
        console.print(f"{name}: known from an earlier run ({_line(outcome)})")
    missing = [one for one in items_of(models, seeded) if one[0] not in outcomes]
    with (
        multiprocessing.get_context("spawn").Manager() as manager,
        Progress(*columns, console=console, transient=True) as progress,
    ):
        reports: Queue[_Report | None] = manager.Queue()
        showing = Thread(target=_show, args=(progress, reports))
        showing.start()
        if seeded:
            bar = progress.add_task(_SEEDS, what="looked for", total=len(seeded))
        try:
            for (name, _), outcome in Farm(jobs).as_ready(_Exploring(task, reports), missing):
                outcomes[name] = outcome
                known.keep(outcome, _model_of(outcome))
                progress.console.print(_line(outcome))
                if seeded:
                    progress.update(bar, completed=sum(bug.name in outcomes for bug in seeded))
        finally:
            reports.put(None)
            showing.join()
    names = [*(model.name for model in models), *(bug.name for bug in seeded)]
    every = [outcomes[name] for name in names]
    return (
        [one for one in every if isinstance(one, Done)],
        [one for one in every if isinstance(one, Found)],
    )


def items_of(models: Sequence[AnyModel], seeded: Sequence[Seeded]) -> list[tuple[str, bool]]:
    """Return all items, each with "is it a seeded bug", so that no long one comes last.

    Models on one robot come first, beginning with the most choices.
    """

    def size(model: AnyModel) -> int:
        return 0 if isinstance(model, InterlockModel) else len(model.choices())

    longest = sorted(models, key=size, reverse=True)
    return [*((one.name, False) for one in longest), *((one.name, True) for one in seeded)]


def _show(progress: Progress, reports: Queue[_Report | None]) -> None:
    """Show the progress of each model until the queue ends with None."""
    bars: dict[str, TaskID] = {}
    for name, number, states in iter(reports.get, None):
        if name not in bars:
            bars[name] = progress.add_task(name, what="known states", total=1)
        progress.update(bars[name], completed=number, total=states)


def _model_of(outcome: Done | Found) -> AnyModel:
    """Return the model that was explored."""
    return EVERY_MODEL[outcome.result.model if isinstance(outcome, Done) else outcome.bug.model]


def _line(done: Done | Found) -> str:
    """Return the line that is printed as soon as an outcome is known."""
    if isinstance(done, Found):
        return f"seeded: {done.bug.name}: {f'{done.scans} scans' if done.scans else 'NOT FOUND'}"
    one = done.result
    text = f"{one.model}: {one.states:,} states, {one.transitions:,} transitions"
    return f"{text}, {f'BROKEN: {one.broken.rules[0]}' if one.broken else 'no rule broken'}"


def _explore(name: str, task: _Task, reports: Queue[_Report | None]) -> Done:
    """Explore one model; a broken rule is replayed and written as trace and chart."""
    model, started = EVERY_MODEL[name], time.process_time()
    result = _search(
        model,
        task.library,
        task.limit,
        task.seed,
        lambda at, known: reports.put((name, at, known)),
    )
    if result.broken is not None:
        _draw(model, result.broken, task.library, name)
        result.broken = replace(result.broken, quiet=None)
    return Done(result, time.process_time() - started)


def _search(
    model: AnyModel,
    library: Sequence[Path],
    limit: int = 0,
    seed: int = 1,
    report: Callable[[int, int], None] | None = None,
) -> Result:
    """Explore a model, to its end or to this number of states."""
    if isinstance(model, InterlockModel):
        return interlock.explored(model, library, limit, seed, report)
    return Explorer(model, library, seed).run(limit, report)


def _look_for(name: str, library: Sequence[Path]) -> Found:
    """Explore the model that should find a seeded bug, and replay the trace it finds."""
    bug = next(bug for bug in EVERY_BUG if bug.name == name)
    model = EVERY_MODEL[bug.model]
    with TemporaryDirectory() as folder:
        changed = bug.library(Path(folder), library)
        result = _search(model, changed)
        if result.broken is None:
            return Found(bug, 0, result.states, ())
        rules = _draw(model, result.broken, changed, f"seeded_{EVERY_BUG.index(bug) + 1:02}")
    known = any(rule.startswith(bug.rule) for rule in rules)
    return Found(bug, len(result.broken.path) if known else 0, result.states, rules)


def _draw(model: AnyModel, broken: Broken, library: Sequence[Path], name: str) -> tuple[str, ...]:
    """Replay a trace and write it with its chart; return the rules that the replay breaks.

    A trace of robots at one area is written in words.
    """
    folder = OUT / "explore"
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(model, InterlockModel):
        rules = interlock.replay(model, broken, library)
        text = "\n".join([*interlock.told(broken.path), *rules])
        (folder / f"{name}.txt").write_text(text + "\n", encoding="utf-8")
        return rules
    shown = replay(model, broken, library, folder / f"{name}.jsonl")
    title = f"{model.name}: {broken.rules[0].partition(':')[0]}"
    (folder / f"{name}.svg").write_text(shown.chart(title), encoding="utf-8")
    return tuple(shown.rules)


def _print(console: Console, done: Sequence[Done], found: Sequence[Found], seconds: float) -> None:
    table = Table("model", "states", "transitions", "depth", "quiet after", "processor", "result")
    for column in table.columns[1:6]:
        column.justify = "right"
    for one in done:
        result, took, model = one.result, one.seconds, _model_of(one)
        bound = max(result.bounds.values(), default=0)
        told = f"{bound} scans, {bound * model.tick_ms} ms" if result.complete else "-"
        verdict = "all states, no rule broken" if result.met else "not complete"
        if result.broken is not None:
            verdict = f"BROKEN after {len(result.broken.path)} scans: {result.broken.rules[0]}"
        numbers = (f"{result.states:,}", f"{result.transitions:,}", str(result.depth))
        table.add_row(model.name, *numbers, told, f"{took:.0f} s", verdict)
    console.print(table)
    if found:
        table = Table("seeded bug", "block", "scans", "found as")
        for bug, scans, _, rules in found:
            told = rules[0] if scans else f"NOT FOUND {' '.join(rules)}"
            table.add_row(bug.name, bug.block, str(scans), told)
        console.print(table)
    console.print(f"{seconds:.0f} s; traces and charts of broken rules: out/verification/explore")


def _end(model: AnyModel) -> str:
    """Return the end of waiting: a free channel, or a robot that is granted the area."""
    return "granted" if isinstance(model, InterlockModel) else "free"


def _longest(done: Sequence[Done], end: str) -> int:
    mine = (one.result.bounds.values() for one in done if _end(_model_of(one)) == end)
    return max((bound for bounds in mine for bound in bounds), default=0)


def _write(done: Sequence[Done], found: Sequence[Found], met: bool) -> None:
    figures = {
        "states": sum(one.result.states for one in done),
        "transitions": sum(one.result.transitions for one in done),
        "checked_abstractions": sum(one.result.checked for one in done),
        **{f"longest_until_{end}_scans": _longest(done, end) for end in ("free", "granted")},
        "broken_rules": sum(one.result.broken is not None for one in done),
        "seeded_bugs": len(found),
        "seeded_bugs_found": sum(bool(one.scans) for one in found),
        "processor_seconds": round(sum(one.seconds for one in done)),
        "models": {
            _model_of(one).name: {
                "title": _model_of(one).title,
                "states": one.result.states,
                "transitions": one.result.transitions,
                "cut": one.result.cut,
                "depth_scans": one.result.depth,
                "complete": one.result.complete,
                "tick_ms": _model_of(one).tick_ms,
                "bounds_scans": one.result.bounds,
                "until": _end(_model_of(one)),
                "broken": list(one.result.broken.rules) if one.result.broken else [],
                "processor_seconds": round(one.seconds),
            }
            for one in done
        },
        "seeded": {one.bug.name: {"scans": one.scans, "rules": one.rules} for one in found},
    }
    OUT.mkdir(parents=True, exist_ok=True)
    text = json.dumps({"command": "make explore", "figures": figures, "met": met}, indent=1)
    (OUT / "explore.json").write_text(text + "\n", encoding="utf-8")
