"""The report on mutants on the console: tables, and the survivors without a reason."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import Any

from rich.console import Console
from rich.table import Table

__all__ = ["print_report"]


def print_report(
    console: Console, found: Mapping[str, Any], *, show: int, kind: str, table_of: str
) -> None:
    """Print the figures of one kind of mutants, and at most `show` survivors without a reason."""
    for title in ("score_by_folder", "score_by_operator"):
        table = Table(title=f"{kind}: {title.replace('_', ' ')}")
        for column in ("", "mutants", "killed", "score"):
            table.add_column(column, justify="left" if not column else "right")
        for name, row in found[title].items():
            score = f"{row['score']:.1f} %"
            table.add_row(name, str(row["mutants"]), str(row["killed"]), score)
        console.print(table)
    unexplained = [row for row in found["survivors"] if not row["reason"]]
    for row in unexplained[:show]:
        console.print(f"{row['file']}:{row['line']}: {row['operator']}", highlight=False)
        console.print(f"  - {row['before']}\n  + {row['after']}", highlight=False, markup=False)
    if len(unexplained) > show:
        console.print(f"... and {len(unexplained) - show} more survivors without a reason")
    blocks = Counter(row["block"] for row in unexplained)
    if blocks:
        most = ", ".join(f"{name} {count}" for name, count in blocks.most_common(12))
        console.print(f"without a reason by block: {most}", highlight=False)
    for row in found["rows_without_a_survivor"]:
        console.print(f"{table_of}: a test finds it now: {row}", markup=False)
    for row in found["rows_without_a_mutant"]:
        console.print(f"{table_of}: there is no such mutant now: {row}", markup=False)
    console.print(
        f"{kind}: {found['killed']} of {found['mutants']} mutants killed: {found['score']:.2f} %"
        f" ({found['survivors_with_a_reason']} survivors with a reason)"
    )
