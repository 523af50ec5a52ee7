"""Results of unit tests as text, for the terminal."""

from __future__ import annotations

import os
from pathlib import Path

from structured_text.output.units import format_us
from structured_text.testing.suites.results import Place, Results

__all__ = ["results_text"]

#: Number of failures of a test that are shown.
_MOST_SHOWN = 10


def results_text(results: Results) -> str:
    """Return a text with the failed, unfinished and disabled tests, and a line with the totals."""
    lines = [f"log: {message}" for message in results.messages]
    lines += [f"note: {note}" for note in results.notes]
    for suite, test in results.tests():
        name = f"{suite.name}.{test.name}"
        if test.skipped:
            lines.append(f"SKIPPED {name}")
        elif test.failures:
            lines.append(f"FAILED {name}")
            for failure in test.failures[:_MOST_SHOWN]:
                lines.append(f"  {_where(failure.place)}: {failure.message}")
            if (rest := len(test.failures) - _MOST_SHOWN) > 0:
                lines.append(f"  ... and {rest} more")
        elif test.unfinished:
            lines.append(f"UNFINISHED {name}")
            lines.append(f"  {_where(test.place)}: has begun here and not finished")
    lines += [f"note: {suite.name} has no test" for suite in results.suites if not suite.tests]
    if results.ended:
        lines.append(results.ended)
    total = sum(1 for _ in results.tests())
    failed = sum(bool(test.failures) for _, test in results.tests())
    unfinished = sum(test.unfinished and not test.failures for _, test in results.tests())
    figures = [f"{results.count('passed')} passed", f"{failed} failed"]
    if unfinished:
        figures.append(f"{unfinished} unfinished")
    figures.append(f"{results.count('skipped')} skipped")
    lines.append(
        f"{_counted(len(results.suites), 'suite')}, {_counted(total, 'test')}: "
        f"{', '.join(figures)}; {_counted(results.scans, 'scan')} in "
        f"{format_us(results.duration_us)} of virtual time"
    )
    return "\n".join(lines)


def _counted(number: int, what: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'}"


def _where(place: Place | None) -> str:
    """Return file and line of a place.

    The path is relative if the file is below the working directory.
    """
    if place is None:
        return "?"
    file = Path(place.file)
    shown = (
        os.path.relpath(file) if file.is_absolute() and file.is_relative_to(Path.cwd()) else file
    )
    return f"{shown}:{place.line}"
