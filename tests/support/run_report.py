"""The last lines of a test run: reasons of skipped tests, omitted tests, tests to repeat."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable

from tiers import ENGINES

#: Parts of reasons for skipped tests, each with the text to print for it. The first match counts.
_SAME = (
    (ENGINES, "need matiec or STruC++: docs/reference/engines.md"),
    (r"C compiler|no cc", "need a C compiler"),
    (r"npm|site", "need the built site: make site-test"),
    (r"package index", "need a package index: make test-all with pytest -m external"),
    (r"tshark|openssl|lcov|node ", "need tshark, openssl, lcov or node"),
)


def skip_lines(reasons: Iterable[str]) -> list[str]:
    """Return a line for each kind of reason, beginning with the most frequent.

    Args:
        reasons: The reason of each skipped test, as pytest reports it.
    """
    counts = Counter(map(_kind, reasons))
    return [f"  {count:>6,} {kind}" for kind, count in counts.most_common()]


def _kind(reason: str) -> str:
    text = reason.removeprefix("Skipped: ")
    return next((kind for pattern, kind in _SAME if re.search(pattern, text)), text)


def left_out_line(count: int) -> str:
    """Return the line with the number of tests that only `make test-all` runs."""
    return f"{count:,} exhaustive tests were left out: make test-all runs them, too"


def repeat_line(node: str) -> str:
    """Return the command that repeats a single test."""
    return f"repeat one: .venv/bin/python -m pytest -n 0 '{node}'"
