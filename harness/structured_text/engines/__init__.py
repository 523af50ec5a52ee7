"""The engines that run Structured Text: matiec if it is installed, else the built-in engine."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from structured_text.engines.base import Program, Value
    from structured_text.engines.load import ENGINES, Built, build

__all__ = ["ENGINES", "Built", "Program", "Value", "build"]


def __getattr__(name: str) -> Any:
    """Import an engine's names on first use: reading sources needs no engine."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from structured_text.engines import base, load

    return getattr(base if hasattr(base, name) else load, name)
