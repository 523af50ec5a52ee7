"""A virtual cell: program, robot and link, scanned on one clock."""

from rcx_harness.cell.cell import EVENTS, Cell, CellTimeout

__all__ = ["EVENTS", "Cell", "CellTimeout"]
