"""A bench for one program: engine, virtual clock, stimulus and trace, without any device."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from structured_text.bench.bench import Bench, BenchTimeout

__all__ = ["Bench", "BenchTimeout"]


def __getattr__(name: str) -> Any:
    """Import `bench` on first use, so that readers of durations or stimuli need no engine."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from structured_text.bench import bench

    return getattr(bench, name)
