"""The gaps in the coverage, and the results as a table."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from rich.console import Console
from rich.table import Table

from structured_text.coverage.measure import FileResult, Item, Share

__all__ = ["Gap", "conditions", "gaps", "missing", "summary", "total", "totals"]


@dataclass(frozen=True)
class Gap:
    """An item that is not covered.

    Attributes:
        reason: Why the item need not be covered.
        network: The rung or network of the line, such as `Main, rung 3`; empty for a line of text.
    """

    path: str
    line: int
    text: str
    reason: str = ""
    network: str = ""

    def __str__(self) -> str:
        network = f"{self.network}: " if self.network else ""
        shown = f"{self.path}:{self.line}: {network}{self.text}"
        return f"{shown}\n    because {self.reason}" if self.reason else shown


def totals(results: Sequence[FileResult]) -> dict[str, Share]:
    """Return the covered shares over all files."""
    return {
        "statements": sum((one.statement_share for one in results), Share()),
        "branches": sum((one.branch_share for one in results), Share()),
        "conditions": sum((one.condition_share for one in results), Share()),
        "mcdc": sum((one.mcdc_share for one in results), Share()),
        "unique_cause": sum((one.unique_share for one in results), Share()),
    }


def gaps(results: Sequence[FileResult], *, justified: bool = False) -> list[Gap]:
    """Return uncovered items.

    With `justified`, return only items that have a reason in the source, else only items without a
    reason.

    A statement in a branch that was not taken is represented by the branch. A condition counts only
    if MC/DC is required for its file.
    """
    found = []
    for result in results:
        if result.changed:
            if not justified:
                found.append(
                    Gap(result.path, 1, "changed while the tests ran, or since: run again")
                )
            continue
        every = [
            replace(gap, network=result.networks.get(gap.line, ""))
            for gap in sorted(_gaps(result), key=lambda gap: gap.line)
        ]
        found += [gap for gap in every if bool(gap.reason) is justified]
        if not justified:
            found += [
                Gap(result.path, line, "marked as unreachable, but it was executed")
                for line in result.stale
            ]
    return found


def _gaps(result: FileResult) -> Iterator[Gap]:
    ways = {item.run for item in result.branches if not item.hits}
    for item in result.statements:
        if not item.hits and item.run not in ways:
            text = item.text or result.source.get(item.line, "").strip()
            yield Gap(result.path, item.line, f"not executed: {text}", item.reason)
    for item in result.branches:
        if not item.hits:
            yield Gap(result.path, item.line, f"not taken: {item.text}", item.reason)
    if result.demands_mcdc:
        yield from conditions(result)


def conditions(result: FileResult) -> Iterator[Gap]:
    """Yield the conditions without MC/DC, and superfluous reasons for conditions with MC/DC."""
    for decision in result.decisions:
        network = result.networks.get(decision.line, "")
        for one in decision.conditions:
            if not one.judged.masking:
                of = "" if one.text == decision.text else f" in {decision.text}"
                text = f"no MC/DC for {one.text}{of}"
                yield Gap(result.path, decision.line, text, one.reason, network)
            elif one.reason:
                text = f"there is a reason for missing MC/DC of {one.text}, but MC/DC is complete"
                yield Gap(result.path, decision.line, text, network=network)


def missing(result: FileResult) -> str:
    """Return the lines of statements that were not executed, and of branches not taken.

    The form is `12-14, 20; branches 17, 19`. For a drawing, its rungs or networks are named in
    place of lines: `Main, rung 2; Main, rung 4`.
    """
    if result.changed:
        return "changed since"
    drawn = [
        result.networks[item.line]
        for item in sorted((*result.statements, *result.branches), key=lambda item: item.line)
        if not _counts(item) and item.line in result.networks
    ]
    return "; ".join(filter(None, (*dict.fromkeys(drawn), _missing_lines(result))))


def _missing_lines(result: FileResult) -> str:
    """Return the lines of text that were not executed."""
    executed: dict[int, bool] = {}
    for item in result.statements:
        executed[item.line] = executed.get(item.line, True) and _counts(item)
    runs = [
        [*run]
        for body in result.bodies
        for hit, run in groupby(body, lambda line: executed[line] or line in result.networks)
        if not hit
    ]
    shown = [f"{run[0]}-{run[-1]}" if len(run) > 1 else str(run[0]) for run in sorted(runs)]
    dead = {item.run for item in result.statements if not _counts(item)}
    ways = sorted(
        {
            one.line
            for one in result.branches
            if not _counts(one) and one.run not in dead and one.line not in result.networks
        }
    )
    branches = f"branches {', '.join(map(str, ways))}" if ways else ""
    return "; ".join(filter(None, (", ".join(shown), branches)))


def _counts(item: Item) -> bool:
    return bool(item.hits or item.reason)


def total(results: Sequence[FileResult]) -> Share:
    """Return the covered share of all statements and branches together."""
    shares = totals(results)
    return shares["statements"] + shares["branches"]


def summary(results: Sequence[FileResult], width: int) -> str:
    """Return a table of all files with the missing lines of each, as plain text."""
    table = Table(box=None, pad_edge=False)
    table.add_column("file", overflow="fold")
    for name in ("statements", "branches", "MC/DC"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("missing lines", overflow="fold")
    for result in results:
        table.add_row(result.path, *_cells([result]), missing(result))
    if len(results) > 1:
        table.add_section()
        table.add_row("all", *_cells(results), "")
    console = Console(file=io.StringIO(), width=width, color_system=None, emoji=False, markup=False)
    console.print(table, highlight=False)
    assert isinstance(console.file, io.StringIO)
    return "\n".join(line.rstrip() for line in console.file.getvalue().splitlines())


def _cells(results: Sequence[FileResult]) -> list[str]:
    shares = totals(results)
    return [_cell(shares[name]) for name in ("statements", "branches", "mcdc")]


def _cell(share: Share) -> str:
    return f"{share.shown} {share.covered}/{share.total}" if share.total else "-"
