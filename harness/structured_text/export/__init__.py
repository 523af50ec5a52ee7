"""Export of the library and a user's program in the file formats of PLC tools."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from structured_text.export.targets import TARGETS, Target, export

__all__ = ["TARGETS", "Target", "export"]


def __getattr__(name: str) -> Any:
    """Import a name on first use, because `check --for` needs no exporter."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from structured_text.export import targets

    return getattr(targets, name)
