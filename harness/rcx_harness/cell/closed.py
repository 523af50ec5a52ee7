"""What is left of a cell after `Cell.close`: its trace, and one clear message for the rest."""

from __future__ import annotations

from typing import NoReturn

from rcx_harness.errors import InputError

__all__ = ["ClosedProgram", "cell_is_closed"]


class ClosedProgram:
    """In place of a cell's program after `close`: on matiec its memory is gone."""

    def __getattr__(self, name: str) -> NoReturn:
        raise cell_is_closed()


def cell_is_closed() -> InputError:
    """The error of everything that a closed cell cannot do."""
    return InputError("the cell is closed", hint="read and scan before close(), inside the `with`")
