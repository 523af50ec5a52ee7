"""`rcx campaign`: runs of a user's cell with random faults, and the shortest runs that fail."""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console

from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.cell_options import CellOptions
from rcx_harness.cli.farm import FarmOptions, WorkersOrNone
from rcx_harness.cli.junit_option import Junit, junit_file, seed_case
from rcx_harness.cli.options import counted, with_options
from rcx_harness.verify.fingerprint import fingerprint
from rcx_harness.verify.storm.campaign import Explained, Seed, Storms, classes, storms
from rcx_harness.verify.storm.cells import Cells, CellsOf
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.reached import Line, unreached_lines
from rcx_harness.verify.storm.replay import Replay, replay
from rcx_harness.verify.storm.saved_results import saved_results
from rcx_harness.verify.storm.written import check_folder, command, file_name, forget, write
from structured_text.errors import InputError
from structured_text.farm import ResultFile
from structured_text.output.junit import JunitSuite

__all__ = ["CampaignOptions", "VerifyOptions", "campaign", "write_replay"]


@dataclass(frozen=True)
class VerifyOptions(FarmOptions, CellOptions):
    """The options that campaign and sweep have in addition to the options of a cell."""

    properties: Annotated[
        list[Path] | None,
        typer.Option(help="Operator actions and required properties: .toml, .py; repeatable."),
    ] = None
    workers: WorkersOrNone = None

    def cells(self, stimulus: Path | None) -> CellsOf:
        """Return the description of the cell, from which each worker process builds its cells."""
        if self.link != "direct":
            raise InputError(f"--link {self.link} is for rcx run", hint="leave it out")
        return CellsOf.of(self.files, self.of_cell(), self.properties or (), stimulus)

    def results(self, cells: CellsOf, out: Path, further: str = "") -> ResultFile[Any, Any]:
        """Return valid results of earlier calls; print a notice about invalid results."""
        kept, notice = saved_results(out / "results.jsonl", self._about(cells, further))
        if kept.notice:
            print(kept.notice, file=sys.stderr)
        if notice:
            print(notice)
            forget(out)
        return kept

    def _about(self, cells: CellsOf, further: str) -> dict[str, str]:
        """Return the files, options and version that the results depend on."""
        options = " ".join([*self.words()[len(self.files) :], further]).strip()
        ours = hashlib.sha256(repr(fingerprint()).encode()).hexdigest()[:16]
        return {"files": cells.parcel.digest(), "options": options or "none", "rcx": ours}


@dataclass(frozen=True)
class CampaignOptions(VerifyOptions):
    """The options of `rcx campaign`."""

    seeds: Annotated[int, typer.Option(help="Number of random runs (seeds).", min=1, max=10**9)] = (
        100
    )
    seed_from: Annotated[int, typer.Option(help="The first seed.", min=0, max=2**63 - 1)] = 0
    stimulus: Annotated[
        Path | None, typer.Option(help="Stimulus of a good run (TOML), to which faults are added.")
    ] = None
    out: Annotated[Path, typer.Option(help="Folder for results and replays.")] = Path(
        "out/campaign"
    )
    junit: Junit = None
    guided: Annotated[
        bool,
        typer.Option(
            "--guided",
            help="Keep rare states, and branch from them; --seeds is the number of runs.",
        ),
    ] = False


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


def say_what_is_missing(cells: Cells) -> None:
    """Print what the file about the cell does not declare."""
    demands = cells.demands
    missing = []
    if demands.recovery is None:
        missing.append("[recover]: it is not checked whether the cell works again")
    if not (demands.buttons or demands.switches or demands.values):
        missing.append("[operator]: no button is pressed")
    if not demands.properties:
        missing.append("[[always]]: only the rules of the wire and of the blocks are checked")
    for one in missing:
        print(f"no {one}")


def tell_never(cells: Cells, reached: Collection[str]) -> list[str]:
    """Print the properties `sometimes` that no run has reached, and return their names."""
    goals = [one for one in cells.demands.properties if one.sometimes]
    never = [one for one in goals if one.name not in reached]
    for one in never:
        what = one.that if isinstance(one.that, str) else "the function"
        print(f"{one.kind}: never reached: {what}")
    return [one.name for one in never]


def tell_classes(
    options: CampaignOptions, cells: Cells, found: Sequence[tuple[str, Explained]]
) -> dict[tuple[str, int], str]:
    """Print the classes of failures, and write a replay of each.

    Return the command of the replay by kind of failure and seed.
    """
    commands: dict[tuple[str, int], str] = {}
    if not found:
        print("nothing failed")
        return commands
    names: list[str] = []
    print(f"{len(found)} class{'es' if len(found) > 1 else ''} of failures")
    for kind, one in found:
        number = counted(len(one.seeds), "seed")
        print(f"\n{kind}: {number}, the first is {one.seeds[0]}")
        if one.replay is None:
            print("  it did not fail again")
            continue
        print(f"  {one.replay.told}")
        print(f"  needs: {', '.join(one.causes) or 'nothing but the start'}")
        names.append(file_name(kind, names))
        again = write_replay(options, cells, one.replay, options.out, names[-1])
        commands |= {(kind, seed): again for seed in one.seeds}
    return commands


def write_replay(options: VerifyOptions, cells: Cells, one: Replay, folder: Path, name: str) -> str:
    """Write the shortest run of a class as a stimulus, and replay it.

    Print the command that replays it, and return the command.
    """
    file = folder / f"{name}.toml"
    write(folder, {file.name: one.text})
    came = replay(cells, one, Stimulus.load(file))
    write(folder, {f"{name}.svg": came.chart})
    words = options.words()
    if "expect" not in came.found and any(
        callable(p.that) or (not p.that and p.kind == one.kind) for p in cells.demands.properties
    ):
        words += [f"--properties {file}" for file in options.properties or ()]
    again = {one.kind, "expect"}.intersection(came.found)
    told = command(one, words, file)
    print(f"  {told}")
    shown = f"{file} ({counted(one.lines, 'line')}), {file.with_suffix('.svg')}"
    print(f"  {shown}" if again else f"  {shown}; the replay did NOT fail")
    return told
