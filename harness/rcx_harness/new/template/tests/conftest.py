"""The fixtures that the tests of this cell share. `cell` and `robot` come from rcx-harness."""

from __future__ import annotations

import pytest
from panel import press

from rcx_harness import Cell


@pytest.fixture
def moving(cell: Cell) -> Cell:
    """Return the safe and started cell while its robot moves to the first part."""
    cell["Main.CellSafe"] = True
    cell.run_until(lambda: cell["Main.Robot.SO.SO01_CpuOk"], within="1s")
    press(cell, "Main.Start")
    cell.run_until(lambda: cell["Main.Robot.Status"] == 0x0100, within="5s")
    assert cell["Main.Stage"] == "CELL_TO_PICK"
    return cell
