"""How a process has ended, in words."""

from __future__ import annotations

import signal
import subprocess
from contextlib import suppress

__all__ = ["how_ended", "wait_for_code"]

_WAIT_S = 1.0


def how_ended(code: int | None) -> str:
    """An exit code as `subprocess` gives it: `killed by SIGKILL`, `exit code 1`."""
    if code is None:
        return "it does not answer any more"
    if code < 0:
        with suppress(ValueError):  # a number without a name
            return f"killed by {signal.Signals(-code).name}"
        return f"killed by signal {-code}"
    return f"exit code {code}"


def wait_for_code(process: subprocess.Popen[str]) -> int | None:
    """Exit code of a process whose pipes have closed, which takes a moment; None if it lives on."""
    with suppress(subprocess.TimeoutExpired):
        return process.wait(_WAIT_S)
    return None
