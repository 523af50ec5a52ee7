"""Fixtures with exports: in quick tests of a part of the library, otherwise of all parts."""

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
    """Return TRUE to export the whole library, FALSE to export only a small part."""
    return bool(request.param)


@pytest.fixture(scope="session")
def sources(whole: bool) -> Sources:
    """Return the sources of the export, read and checked."""
    return sample(whole=whole)
