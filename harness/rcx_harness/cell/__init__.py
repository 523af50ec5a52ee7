"""A virtual cell: program, robot and link, scanned on one clock."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rcx_harness.cell.cell import EVENTS, Cell, CellTimeout

__all__ = ["EVENTS", "Cell", "CellTimeout"]


def __getattr__(name: str) -> Any:
    """Import a public name on first use.

    A program that only collects sources does not need the robot. So the robot is not imported for
    such a program.
    """
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from rcx_harness.cell import cell

    return getattr(cell, name)
