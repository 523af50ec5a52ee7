"""What the cells of a campaign hold: one of them at a time, however many there are."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Iterator
from pathlib import Path

import pytest

from feeder import feeder
from rcx_harness.verify.storm.cells import Cells, CellsOf


@pytest.fixture
def by_hand() -> Iterator[None]:
    """Python's collector does nothing by itself: a cell that is gone was asked for."""
    gc.disable()
    yield
    gc.enable()


def _cells(folder: Path) -> Cells:
    feeder(folder)
    return CellsOf.of([folder / "Feeder.st"], {"engine": "builtin"}).make()


@pytest.mark.usefixtures("by_hand")
def test_a_cell_is_gone_when_the_next_one_begins(tmp_path: Path) -> None:
    cells = _cells(tmp_path)
    first = weakref.ref(cells.cell(0))
    second = cells.cell(1)
    assert first() is None
    assert second.now_us == 0


@pytest.mark.usefixtures("by_hand")
def test_what_is_older_than_the_cells_is_looked_at_again_after_them(tmp_path: Path) -> None:
    """A collection for each cell is cheap only as long as the rest of the process is left out."""
    cells = _cells(tmp_path)
    assert gc.get_freeze_count() > 0
    del cells
    assert gc.get_freeze_count() == 0
