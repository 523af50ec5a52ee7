"""Structured Text on a PC: reads, runs, measures, proves, debugs and exports any program.

What surrounds a program (a process image, a machine, a stimulus) is given by whoever uses this
package; it imports nothing of them.
"""

from __future__ import annotations

TYPE_CHECKING = False  # nothing is imported here that not every part needs
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
    """Import on first use: one part of the package does not load all others."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    home = "bench" if name.startswith("Bench") else "errors"
    return getattr(import_module(f"{__name__}.{home}"), name)
