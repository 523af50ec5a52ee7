"""What tests of several targets export: a part in the quick tests, all of it in the others."""

from __future__ import annotations

from pathlib import Path

import pytest

from example_runs import EXAMPLES
from plc_bench import ROOT
from structured_text.projects.needed import needed as needed_files


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(True, id="needed"),
        pytest.param(False, id="whole", marks=pytest.mark.exhaustive),
    ],
)
def needed(request: pytest.FixtureRequest) -> bool:
    """Export only what the first example needs of the library, or all of it."""
    return bool(request.param)


@pytest.fixture(scope="module")
def original(needed: bool) -> list[Path]:
    """Return the files that are exported."""
    library = sorted((ROOT / "plc/lib").rglob("*.st"))
    cell = sorted(EXAMPLES[0].folder.glob("*.st"))
    return [*(needed_files(cell, library) if needed else library), *cell]
