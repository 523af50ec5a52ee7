"""Engines: compile Structured Text and scan it; matiec where it is found, else the built-in one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from structured_text.engines.base import Program, Value
    from structured_text.engines.load import ENGINES, Built, build

__all__ = ["ENGINES", "Built", "Program", "Value", "build"]


def __getattr__(name: str) -> Any:
    """Import on first use: who only reads sources needs no engine."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from structured_text.engines import base, load

    return getattr(base if name in base.__all__ else load, name)
