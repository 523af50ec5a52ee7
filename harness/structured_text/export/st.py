"""Export as a single file of Structured Text, each declaration after those it needs."""

from __future__ import annotations

from structured_text.export.output import Output
from structured_text.export.parts import Sources, comment

__all__ = ["to_st"]


def to_st(sources: Sources) -> Output:
    """Join the sources in dependency order."""
    return Output(
        {"": "\n".join([f"{comment(sources.notice)}\n", *(part.text for part in sources.parts)])}
    )
