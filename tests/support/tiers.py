"""The two tiers of the tests: `make test` omits tests that are marked `exhaustive`.

The mark belongs to a whole matrix of parameters, and names the ids that stay in the quick tier:
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
    """Remove the mark `exhaustive` from the tests that the mark names as its sample.

    Args:
        items: The collected tests.
        whole: Whether each function was collected with all its parameters.

    Raises:
        pytest.UsageError: a name in `but` is not the id of a parameter.
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
    """Return all rows as parameters, and mark those that the quick tier omits as exhaustive.

    Args:
        rows: The values; a tuple has the values of several parameters.
        every: The quick tier keeps the first row, and then every row at this distance.
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

    There are thousands of such tests, and reporting each as skipped would take too long.

    Args:
        items: The collected tests. The tests are removed from this list.

    Returns:
        For each removed test, the reason.
    """
    reasons = {item: reason for item in items if (reason := _missing_engine(item))}
    items[:] = [item for item in items if item not in reasons]
    return list(reasons.values())


def _missing_engine(item: pytest.Item) -> str:
    for mark in item.iter_markers("skipif"):
        if mark.args[0] is True and re.search(ENGINES, mark.kwargs["reason"]):
            return str(mark.kwargs["reason"])
    return ""
