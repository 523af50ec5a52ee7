"""What the tests of the engines share."""

from __future__ import annotations

import pytest

from structured_text.engines.load import MISSING, Matiec, find_c_compiler, find_matiec


@pytest.fixture(scope="session")
def matiec() -> Matiec:
    """The installed matiec; tests that need it are skipped where there is none."""
    found = find_matiec()
    if found is None:
        pytest.skip(MISSING)
    if find_c_compiler() is None:
        pytest.skip("no C compiler: set CC or PATH")
    return found
