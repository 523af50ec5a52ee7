"""`rcx campaign --guided`: runs that branch from rare states."""

from __future__ import annotations

from dataclasses import replace

import typer
from rich.console import Console

from rcx_harness.cli.campaign_options import CampaignOptions
from rcx_harness.cli.failure_classes import say_what_is_missing, tell_classes, tell_never
from rcx_harness.cli.junit_option import junit_file, seed_case
from rcx_harness.cli.options import counted
from rcx_harness.verify.guided.branch import Guided, Ran
from rcx_harness.verify.guided.corpus import Corpus, guided
from rcx_harness.verify.guided.novelty import Met
from rcx_harness.verify.guided.report import never_exercised
from rcx_harness.verify.storm.campaign import Explained, Storms, Straight
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.reached import Line, unreached_lines
from rcx_harness.verify.storm.written import check_folder, forget
from structured_text.errors import InputError
from structured_text.farm import Farm
from structured_text.output.junit import JunitSuite
from structured_text.output.progress import progress_bar

__all__ = ["run_guided"]


def run_guided(options: CampaignOptions) -> None:
    """Execute a guided campaign, and report failures and what was never exercised."""
    if options.engine not in ("auto", "builtin"):
        text = f"--guided needs the built-in engine, not {options.engine}"
        raise InputError(text, hint="leave out --engine")
    options = replace(options, engine="builtin")
    check_folder(options.out)
    read = [*options.files, *(options.robot or ()), *(options.properties or ())]
    junit = junit_file(options.junit, None, [*read, *filter(None, [options.stimulus])])
    of = options.cells(options.stimulus)
    cells = of.make()
    with cells.cell(options.seed_from) as cell:
        Course(cell, cells.demands)  # raises InputError if a demanded variable is missing
    if cells.notice:
        print(cells.notice)
    say_what_is_missing(cells)
    forget(options.out)
    console = Console(stderr=True)
    corpus, work = Corpus(options.seed_from), Guided(of, options.seed_from)
    failing: dict[str, list[tuple[int, Straight]]] = {}
    ran: dict[int, Ran] = {}
    met, lines, goals = set[Met](), set[Line](), set[str]()
    with progress_bar(console) as progress:
        bar = progress.add_task("runs", total=options.seeds, told="")
        for number, one in guided(options.farm(Console(quiet=True)), work, options.seeds, corpus):
            ran[number] = one._replace(kept=(), features=(), failures={}, met=frozenset())
            met |= one.met
            lines.update(one.lines)
            goals.update(one.reached)
            for kind, straight in one.failures.items():
                failing.setdefault(kind, []).append((number, straight))
            told = f"{corpus.states} states, {counted(len(failing), 'kind')} of failures"
            progress.update(bar, advance=1, told=told, refresh=True)
    found = _classes(options.farm(console), Storms(of), failing)
    acts, scans = sum(one.acts for one in ran.values()), sum(one.scans for one in ran.values())
    virtual_us = sum(one.virtual_us for one in ran.values())
    print(
        f"{counted(len(ran), 'run')} from seed {options.seed_from}: {acts} events, "
        f"{virtual_us / 1e6:.0f} s of virtual time, {counted(scans, 'scan')}; "
        f"{counted(corpus.states, 'state')} kept"
    )
    for line in never_exercised(cells, options.seed_from, met):
        print(line)
    with cells.cell(options.seed_from) as cell:
        for line in unreached_lines(cell, lines):
            print(line)
    never = tell_never(cells, goals)
    replays = tell_classes(options, cells, found)
    cases = [seed_case(k, one.virtual_us, one.texts, replays) for k, one in ran.items()]
    junit.write([JunitSuite("campaign", cases, virtual_us / 1e6)], virtual_us / 1e6)
    junit.say()
    if failing or never:
        raise typer.Exit(1)


def _classes(
    farm: Farm, work: Storms, failing: dict[str, list[tuple[int, Straight]]]
) -> list[tuple[str, Explained]]:
    """Return a class for each kind of failure; its run with the fewest actions is shortened."""
    runs = {
        kind: min(those, key=lambda one: (len(one[1].acts), one[0]))[1]
        for kind, those in failing.items()
    }
    items = list(runs.values())
    if not items:
        return []
    return [
        (item.kind, one._replace(seeds=tuple(number for number, _ in failing[item.kind])))
        for item, one in farm.run(work, items, title="classes")
    ]
