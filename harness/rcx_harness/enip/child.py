"""A child process that does a part of the network's work, and the handle that its parent holds.

The only argument of the process contains the settings as JSON. The process writes JSON objects, one
per line, to standard output. The first object has the address at which the process listens, or the
reason why it cannot listen. The process ends when its standard input ends, at the latest with its
parent. If the system can fork, a child process starts its own children as copies of itself.
"""

from __future__ import annotations

import gc
import json
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from importlib import import_module
from typing import IO, Any, Literal

from rcx_harness.enip.errors import ProcessDiedError
from structured_text.output import system

__all__ = ["Child", "be_punctual", "how_ended", "run", "tell"]

_STOP_S, _WAIT_S = 5.0, 1.0
_is_child = False


class Child:
    """The handle of a child process in its parent.

    Args:
        module: The module that the process runs.
    """

    def __init__(self, module: str, settings: Mapping[str, Any], name: str) -> None:
        self.process = _started(module, json.dumps(settings))
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.orders: IO[str] = self.process.stdin
        self.reports: IO[str] = self.process.stdout
        try:
            line = self.reports.readline()
            if not line:
                how = how_ended(self.process.wait())
                raise ProcessDiedError(f"{name} ended at once, {how}")
            self.started: dict[str, Any] = json.loads(line)
        except BaseException:
            self.stop()
            raise

    def wait_for_code(self) -> int | None:
        """Wait until the process ends and return its exit code; None after a time-out."""
        with suppress(subprocess.TimeoutExpired):
            return self.process.wait(_WAIT_S)
        return None

    def stop(self) -> None:
        """Close the standard input of the process to end it; kill the process after a time-out."""
        with suppress(OSError):  # the process has ended and has not read all orders
            self.orders.close()
        try:
            self.process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()


def run(main: Callable[[str], None]) -> None:
    """Run the main function of this child process with the first argument of its command line."""
    global _is_child
    _is_child = True
    main(sys.argv[1])


def _started(module: str, argument: str) -> subprocess.Popen[str] | system.PipedCopy:
    # A copy (fork) has the locks of other threads, but not the threads. It could wait for such a
    # lock forever, so only a process with a single thread is copied.
    if system.COPIES and _is_child and threading.active_count() == 1:
        return system.PipedCopy(lambda: import_module(module).main(argument), module)
    return subprocess.Popen(
        [sys.executable, "-m", module, argument],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        encoding="utf-8",
        **system.APART,
    )


def how_ended(code: int | None) -> str:
    """Describe an exit code of `subprocess`, for example `killed by SIGKILL` or `exit code 1`."""
    if code is None:
        return "it does not answer any more"
    if code < 0:
        with suppress(ValueError):  # Python has no name for this signal
            return f"killed by {signal.Signals(-code).name}"
        return f"killed by signal {-code}"
    return f"exit code {code}"


def tell(message: Mapping[str, Any]) -> None:
    """Send a message from the child process to its parent."""
    with suppress(OSError):  # the parent has ended
        os.write(1, json.dumps(message).encode() + b"\n")


def be_punctual(policy: Literal["first", "in turn"]) -> None:
    """Request exact timing for this process; see `system.ask_for_priority`."""
    gc.freeze()
    system.fine_timers()
    system.ask_for_priority(policy)
