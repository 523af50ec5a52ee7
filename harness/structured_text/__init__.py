"""Structured Text on a PC: read, run, measure, prove, debug and export any program.

The user of this package supplies the surroundings of a program (a process image, a machine, a
stimulus). The package imports nothing from them.
"""

from __future__ import annotations

TYPE_CHECKING = False  # a constant, so that `typing` need not be imported at run time
if TYPE_CHECKING:
    from typing import Any

    from structured_text.bench import Bench, BenchTimeout
    from structured_text.errors import BLOCKS, COMMAND, DISTRIBUTION, VARIABLES, InputError

__all__ = [
    "BLOCKS",
    "COMMAND",
    "DISTRIBUTION",
    "VARIABLES",
    "Bench",
    "BenchTimeout",
    "InputError",
]


def __getattr__(name: str) -> Any:
    """Import a public name on first use.

    Importing the package therefore does not load all its modules.
    """
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    home = "bench" if name.startswith("Bench") else "errors"
    return getattr(import_module(f"{__name__}.{home}"), name)
