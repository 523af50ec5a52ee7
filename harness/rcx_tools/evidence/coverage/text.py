"""The results as text: a table of the folders, the gaps, and a table of all files."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence

from rich.console import Console
from rich.table import Table

from structured_text.coverage.measure import FileResult, Share
from structured_text.coverage.report import Gap, gaps, totals

__all__ = ["folder_table", "full_text"]

_COLUMNS = ("statements", "branches", "conditions", "MC/DC", "unique-cause")


def _not_demanded(results: Sequence[FileResult]) -> Iterator[Gap]:
    for result in results:
        if not result.demands_mcdc:
            for decision in result.decisions:
                for one in decision.conditions:
                    if not one.judged.masking:
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
        demanded = any(one.demands_mcdc for one in results)
        marks = ["" if share.complete else "red" for share in shares.values()]
        cells = [
            f"[{mark}]{_share(share)}[/]"
            if mark and (k < 2 or (k == 3 and demanded))
            else _share(share)
            for k, (share, mark) in enumerate(zip(shares.values(), marks, strict=True))
        ]
        table.add_row(name, *cells)
    return table


def folder_table(results: Sequence[FileResult], library: str) -> Table:
    """Return a table: one row per folder of `library`, one for required MC/DC, one for all."""
    folders = sorted({result.folder for result in results})
    rows = [(one, [result for result in results if result.folder == one]) for one in folders]
    rows.append(("MC/DC demanded", [one for one in results if one.demands_mcdc]))
    return _table(library, [*rows, ("all", list(results))])


def full_text(results: Sequence[FileResult], library: str, reasons: str) -> str:
    """Return the whole report as plain text.

    Args:
        results: All files.
        library: The name of their folder.
        reasons: The name of the file with the reasons.
    """
    console = Console(file=io.StringIO(), width=160, color_system=None, emoji=False)
    console.print(f"Coverage of {library} by the tests, on the built-in engine\n")
    console.print(folder_table(results, library))
    console.print(f"\n(+n: justified in place, or with a reason in {reasons})\n")
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
