"""Generator of the table of matiec's faults in engines.md. The rest of the page is handwritten."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from structured_text.engines.matiec.detectors import DETECTORS
from structured_text.engines.matiec.faults import Fault, faults

__all__ = ["engines_page", "faults_table"]

_PAGE = Path(__file__).resolve().parents[3] / "docs" / "reference" / "engines.md"
_TABLE = re.compile(
    r"(<!-- generated from [^>]*faults\.toml [^>]*-->\n)\n.*?\n(?=\n<!-- end -->)", re.S
)
_VERSIONS = {"all": "all", "new": "since June 2024", "old": "before June 2024"}


def engines_page() -> str:
    """Return engines.md with the current table."""
    table = "\n".join(faults_table())
    return _TABLE.sub(lambda found: f"{found[1]}\n{table}\n", _PAGE.read_text(encoding="utf-8"))


def faults_table() -> Iterator[str]:
    """Yield the lines of the table of matiec's faults. Faults that `rcx` detects come first."""
    yield "| In your program | matiec | Versions | Write instead | Reported |"
    yield "|---|---|---|---|---|"
    for fault in sorted(faults().values(), key=lambda one: one.name not in DETECTORS):
        yield _row(fault)


def _row(fault: Fault) -> str:
    reported = "yes" if fault.name in DETECTORS else "no"
    cells = (fault.construct, fault.effect, _VERSIONS[fault.versions], fault.instead, reported)
    return f"| {' | '.join(cell.replace('|', '/') for cell in cells)} |"
