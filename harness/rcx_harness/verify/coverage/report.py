"""The results as text: a table per folder, the gaps, and a table of all files."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table

from rcx_harness.verify.coverage.measure import FileResult, Share

__all__ = [
    "MCDC_FILES",
    "REASONS",
    "Gap",
    "demands_mcdc",
    "folder_table",
    "full_text",
    "gaps",
    "totals",
]

#: Where MC/DC is demanded: folders and files.
MCDC_FILES = ("area/", "core/", "sequence/", "command/FB_RemoteCommand.st")

#: Why something need not be covered, below the repository.
REASONS = "tests/tools/evidence/conditions.toml"

_COLUMNS = ("statements", "branches", "conditions", "MC/DC", "unique-cause")


@dataclass(frozen=True)
class Gap:
    """Something that is not covered; `reason` says why it need not be."""

    path: str
    line: int
    text: str
    reason: str = ""

    def __str__(self) -> str:
        shown = f"{self.path}:{self.line}: {self.text}"
        return f"{shown}\n    because {self.reason}" if self.reason else shown


def demands_mcdc(result: FileResult) -> bool:
    """Whether MC/DC is demanded of a file."""
    return result.path.startswith(MCDC_FILES)


def totals(results: Sequence[FileResult]) -> dict[str, Share]:
    """Shares of some files together."""
    return {
        "statements": sum((one.statement_share for one in results), Share()),
        "branches": sum((one.branch_share for one in results), Share()),
        "conditions": sum((one.condition_share for one in results), Share()),
        "mcdc": sum((one.mcdc_share for one in results), Share()),
        "unique_cause": sum((one.unique_share for one in results), Share()),
    }


def gaps(results: Sequence[FileResult], *, justified: bool = False) -> list[Gap]:
    """What is not covered: that without a reason, or that with one.

    Statements in a branch that was not taken are named by the branch. A condition counts only
    where MC/DC is demanded.
    """
    found = []
    for result in results:
        if result.changed:
            if not justified:
                found.append(
                    Gap(result.path, 1, "changed while the tests ran, or since: run again")
                )
            continue
        every = sorted(_gaps(result), key=lambda gap: gap.line)
        found += [gap for gap in every if bool(gap.reason) is justified]
        if not justified:
            found += [
                Gap(result.path, line, "called unreachable, but it is reached")
                for line in result.stale
            ]
    return found


def _gaps(result: FileResult) -> Iterator[Gap]:
    ways = {item.run for item in result.branches if not item.hits}
    for item in result.statements:
        if not item.hits and item.run not in ways:
            text = result.source[item.line - 1].strip()
            yield Gap(result.path, item.line, f"not executed: {text}", item.reason)
    for item in result.branches:
        if not item.hits:
            yield Gap(result.path, item.line, f"not taken: {item.text}", item.reason)
    if demands_mcdc(result):
        for decision in result.decisions:
            for one in decision.conditions:
                if not one.masking:
                    text = f"no MC/DC of {one.text} in {decision.text}"
                    yield Gap(result.path, decision.line, text, one.reason)
                elif one.reason:
                    text = f"a reason for no MC/DC of {one.text}, but it has it"
                    yield Gap(result.path, decision.line, text)


def _not_demanded(results: Sequence[FileResult]) -> Iterator[Gap]:
    for result in results:
        if not demands_mcdc(result):
            for decision in result.decisions:
                for one in decision.conditions:
                    if not one.masking:
                        text = f"{one.text} in {decision.text}"
                        yield Gap(result.path, decision.line, text)


def _share(share: Share) -> str:
    justified = f" +{share.justified}" if share.justified else ""
    return f"{share.percent:.1f} % {share.covered}/{share.total}{justified}"


def _table(first: str, rows: Sequence[tuple[str, Sequence[FileResult]]]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    table.add_column(first)
    for name in _COLUMNS:
        table.add_column(name, justify="right")
    for name, results in rows:
        shares = totals(results)
        demanded = any(map(demands_mcdc, results))
        marks = ["" if share.complete else "red" for share in shares.values()]
        cells = [
            f"[{mark}]{_share(share)}[/]"
            if mark and (k < 2 or (k == 3 and demanded))
            else _share(share)
            for k, (share, mark) in enumerate(zip(shares.values(), marks, strict=True))
        ]
        table.add_row(name, *cells)
    return table


def folder_table(results: Sequence[FileResult]) -> Table:
    """One row per folder, one for the files of which MC/DC is demanded, one for all."""
    folders = sorted({result.folder for result in results})
    rows = [(one, [result for result in results if result.folder == one]) for one in folders]
    rows.append(("MC/DC demanded", [one for one in results if demands_mcdc(one)]))
    return _table("plc/lib", [*rows, ("all", list(results))])


def full_text(results: Sequence[FileResult]) -> str:
    """The whole report as plain text."""
    console = Console(file=io.StringIO(), width=160, color_system=None, emoji=False)
    console.print("Coverage of plc/lib by the tests, on the built-in engine\n")
    console.print(folder_table(results))
    console.print(f"\n(+n: justified in place, or with a reason in {REASONS})\n")
    console.print(_table("file", [(result.path, [result]) for result in results]))
    for title, justified in (("Gaps", False), ("Justified", True)):
        found = gaps(results, justified=justified)
        console.print(f"\n{title}: {len(found) or 'none'}")
        for gap in found:
            console.print(f"  {gap}", markup=False, highlight=False, soft_wrap=True)
    found = list(_not_demanded(results))
    console.print(f"\nConditions without MC/DC where it is not demanded: {len(found) or 'none'}")
    for gap in found:
        console.print(f"  {gap}", markup=False, highlight=False, soft_wrap=True)
    assert isinstance(console.file, io.StringIO)
    return "\n".join(line.rstrip() for line in console.file.getvalue().splitlines()) + "\n"
