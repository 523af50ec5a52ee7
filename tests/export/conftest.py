"""Exports for the tests of several targets: a part of the library in quick tests, or all."""

from __future__ import annotations

import pytest

from exported import sample
from structured_text.export.parts import Sources


@pytest.fixture(
    scope="session",
    params=[
        pytest.param(False, id="needed"),
        pytest.param(True, id="whole", marks=pytest.mark.exhaustive),
    ],
)
def whole(request: pytest.FixtureRequest) -> bool:
    """Return whether to export the whole library, or only the parts that the sample needs."""
    return bool(request.param)


@pytest.fixture(scope="session")
def sources(whole: bool) -> Sources:
    """Return the exported sources, read and checked."""
    return sample(whole=whole)
