"""`rcx campaign`: runs of a user's cell with random faults, and the shortest runs that fail."""

from __future__ import annotations

import typer
from rich.console import Console

from rcx_harness.cli.campaign_options import CampaignOptions
from rcx_harness.cli.failure_classes import say_what_is_missing, tell_classes, tell_never
from rcx_harness.cli.junit_option import junit_file, seed_case
from rcx_harness.cli.options import counted, with_options
from rcx_harness.verify.storm.campaign import Seed, Storms, classes, storms
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.reached import Line, unreached_lines
from rcx_harness.verify.storm.written import check_folder
from structured_text.output.junit import JunitSuite

__all__ = ["campaign"]


@with_options(CampaignOptions)
def campaign(options: CampaignOptions) -> None:
    """Run a cell with random faults, and report which rules and properties break.

    Each seed draws faults of the network, the robots, the PLC and its operator. Failing seeds are
    grouped into classes. The shortest run of each class is written as a stimulus of rcx run, with
    its chart. Ctrl-C keeps the finished seeds; the same call continues.

    Exit code: 0 if no seed fails, 1 if a seed fails, 2 on bad input.
    """
    if options.guided:
        from rcx_harness.cli.guided_runs import run_guided

        run_guided(options)
        return
    check_folder(options.out)
    read = [*options.files, *(options.robot or ()), *(options.properties or ())]
    junit = junit_file(options.junit, None, [*read, *filter(None, [options.stimulus])])
    of = options.cells(options.stimulus)
    cells = of.make()
    cell = cells.cell(options.seed_from)
    Course(cell, cells.demands)  # raises InputError if a demanded variable is missing
    cell.close()
    if cells.notice:
        print(cells.notice)
    say_what_is_missing(cells)
    farm = options.farm(Console(stderr=True))
    kept = options.results(of, options.out)
    work, failing = Storms(of), dict[str, list[tuple[int, int]]]()
    ran = dict[int, Seed]()  # for the JUnit file only
    total, reached, goals = Seed({}, 0, 0, 0), set[Line](), set[str]()
    seeds = range(options.seed_from, options.seed_from + options.seeds)
    try:
        for seed, result in storms(farm, work, seeds, kept):
            total = Seed(
                {},
                total.virtual_us + result.virtual_us,
                total.scans + result.scans,
                total.acts + result.acts,
            )
            reached.update(result.lines)
            goals.update(result.reached)
            if junit.wanted:
                ran[seed] = result
            for kind, (t_us, _) in result.failures.items():
                failing.setdefault(kind, []).append((t_us, seed))
        found = classes(farm, work, failing, kept)
    except KeyboardInterrupt:
        print(f"finished results are in {options.out}; the same call continues")
        raise
    print(
        f"seeds {seeds[0]} to {seeds[-1]}: {total.acts} events, {total.virtual_us / 1e6:.0f} s of "
        f"virtual time, {counted(total.scans, 'scan')}"
    )
    for one in unreached_lines(cell, reached):
        print(one)
    never = tell_never(cells, goals)
    replays = tell_classes(options, cells, found)
    cases = [seed_case(seed, one.virtual_us, one.failures, replays) for seed, one in ran.items()]
    junit.write([JunitSuite("campaign", cases, total.virtual_us / 1e6)], total.virtual_us / 1e6)
    junit.say()
    if failing or never:
        raise typer.Exit(1)
