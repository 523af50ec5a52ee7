"""Run Structured Text programs with the RCX3 function blocks and a virtual robot controller."""

from __future__ import annotations

# Nothing is imported here, because Ctrl-C during an import would show a traceback.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

    from rcx_harness.cell import Cell, CellTimeout
    from rcx_harness.robot import RobotConfig
    from rcx_harness.verify.properties import always, eventually, sometimes
    from structured_text.errors import InputError

__all__ = ["Cell", "CellTimeout", "InputError", "RobotConfig", "always", "eventually"]
__all__ += ["sometimes"]

_HOME = dict.fromkeys(("Cell", "CellTimeout"), f"{__name__}.cell")
_HOME |= dict.fromkeys(("always", "eventually", "sometimes"), f"{__name__}.verify.properties")
_HOME |= {"InputError": "structured_text.errors", "RobotConfig": f"{__name__}.robot"}


def __getattr__(name: str) -> Any:
    """Import a name on first use, so that using a part of the package does not load all parts."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_HOME[name]), name)
