"""What campaigns and sweeps print: missing demands, classes of failures and their replays."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path

from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.campaign_options import CampaignOptions, VerifyOptions
from rcx_harness.cli.options import counted
from rcx_harness.verify.storm.campaign import Explained
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.replay import Replay, replay
from rcx_harness.verify.storm.written import command, file_name, write

__all__ = ["say_what_is_missing", "tell_classes", "tell_never", "write_replay"]


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
