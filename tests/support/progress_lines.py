"""Remove the progress lines that a command prints only on a slow machine."""

from __future__ import annotations

_PROGRESS = ("compiling", "running:")


def without_progress(stderr: str) -> str:
    """Return text from standard error without the lines that show the progress."""
    lines = stderr.splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith(_PROGRESS))
