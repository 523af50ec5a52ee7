"""The actions of the operator for the tests."""

from __future__ import annotations

from rcx_harness import Cell

__all__ = ["press"]


def press(cell: Cell, button: str) -> None:
    """Press a button for 50 ms."""
    cell[button] = True
    cell.run("50ms")
    cell[button] = False
