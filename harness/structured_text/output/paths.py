"""Resolution of links in paths."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["real"]


def real(path: str | Path) -> Path:
    """Return a path without links, as far as its parts exist.

    `Path.resolve` does the same, but raises a RuntimeError for links in a loop until Python 3.12.
    Here such a link stays as it is. The system then refuses to open it, and that error is reported.
    """
    return Path(os.path.realpath(path))
