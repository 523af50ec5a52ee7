"""A program without anything around it: an engine, a clock, a stimulus, a trace of variables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from structured_text.bench.bench import Bench, BenchTimeout

__all__ = ["Bench", "BenchTimeout"]


def __getattr__(name: str) -> Any:
    """Import on first use: who only reads durations or stimuli needs no engine."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from structured_text.bench import bench

    return getattr(bench, name)
