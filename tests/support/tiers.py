"""The two tiers of the tests: `make test` omits tests that are marked `exhaustive`.

A large matrix is marked as a whole and names the parameters that stay in the quick tier, by their
ids: `@pytest.mark.exhaustive(but=["FB_ServoOn", "FB_MovePtp"])`.
"""

from __future__ import annotations

from collections.abc import Iterable

import pytest


def keep_samples(items: Iterable[pytest.Item], *, whole: bool) -> None:
    """Take the mark `exhaustive` from the tests that it names as its sample.

    Args:
        items: The collected tests.
        whole: True if each function was collected with all its parameters.

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
