"""The two tiers of the tests: `make test` omits tests that are marked `exhaustive`.

A large matrix is marked as a whole. Its mark names the parameter ids that stay in the quick tier:
`@pytest.mark.exhaustive(but=["FB_ServoOn", "FB_MovePtp"])`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

import pytest

#: Texts in the reason of a skipped test that mean a missing engine.
ENGINES = r"matiec|STruC\+\+|strucpp"


def keep_samples(items: Iterable[pytest.Item], *, whole: bool) -> None:
    """Remove the mark `exhaustive` from those tests that it names as its sample.

    Args:
        items: The collected tests.
        whole: Whether each function was collected with all its parameters.

    Raises:
        pytest.UsageError: a name in `but` is not the id of a parameter: the sample has shrunk.
    """
    wanted, found = set(), set()
    for item in items:
        mark = item.get_closest_marker("exhaustive")
        if mark is not None and "but" in mark.kwargs:
            function, _, rest = item.nodeid.partition("[")
            wanted |= {f"{function}[{name}]" for name in mark.kwargs["but"]}
            if rest.removesuffix("]") in mark.kwargs["but"]:
                found.add(item.nodeid)
                item.own_markers.remove(mark)
    if whole and wanted != found:
        gone = ", ".join(sorted(wanted - found))
        raise pytest.UsageError(f"no such tests, though exhaustive(but=...) names them: {gone}")


def sampled(rows: Iterable[Any], every: int) -> list[Any]:
    """Return parameters of which the quick tier runs only some.

    Args:
        rows: The values; a tuple has the values of several parameters.
        every: Distance of the rows that the quick tier keeps, beginning with the first.
    """
    return [
        pytest.param(
            *(row if isinstance(row, tuple) else (row,)),
            marks=pytest.mark.exhaustive if number % every else (),
        )
        for number, row in enumerate(rows)
    ]


def without_engine(items: list[pytest.Item]) -> list[str]:
    """Remove the tests of engines that are not installed from the list.

    There are thousands of them, and reporting each as skipped would take longer than many tests.

    Args:
        items: The collected tests; those that remain.

    Returns:
        The reason of each test that was taken out.
    """
    reasons = {item: reason for item in items if (reason := _missing_engine(item))}
    items[:] = [item for item in items if item not in reasons]
    return list(reasons.values())


def _missing_engine(item: pytest.Item) -> str:
    for mark in item.iter_markers("skipif"):
        if mark.args[0] is True and re.search(ENGINES, mark.kwargs["reason"]):
            return str(mark.kwargs["reason"])
    return ""
