"""External programs: compilers, capture tools, tests. Only this module starts them.

No program outlives this process, whether Ctrl-C, SIGTERM, SIGHUP or SIGKILL ends it. The process
`guard` between this process and the program detects the end. A Python child of this package ends
when its standard input closes, so it needs no guard.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from structured_text.output.system import APART, GUARDED, end_apart

__all__ = ["Program", "environment", "run"]

_GUARD = Path(__file__).with_name("guard.py")
_WORD = 16


def environment(*, without: Iterable[str] = (), **changes: str) -> dict[str, str]:
    """Return the environment of this process for a child process.

    The child does not get the variables in `without`; `changes` replace or add variables. All
    changed environments of child processes are made here.
    """
    left_out = set(without)
    inherited = {name: value for name, value in os.environ.items() if name not in left_out}
    return inherited | changes


class Program(subprocess.Popen[Any]):
    """A running program: a `subprocess.Popen` that ends with this process.

    Ctrl-C at a terminal does not reach the program; this process decides when the program ends.
    `kill` also ends the program's child processes. On Windows there is no guard, and the program
    survives if this process is killed.

    Raises:
        OSError: The program cannot be started.
    """

    _line: socket.socket | None = None

    def __init__(self, command: Sequence[str | os.PathLike[str]], **how: Any) -> None:
        how = {**APART, "stdin": subprocess.DEVNULL, **how}
        words = [os.fspath(word) for word in command]
        if not GUARDED:
            super().__init__(words, **how)
            return
        ours, theirs = socket.socketpair()
        number = theirs.fileno()
        guarded = [sys.executable, "-I", "-S", str(_GUARD), str(number), *words]
        try:
            with theirs:
                super().__init__(guarded, pass_fds=[number], **how)
            said = ours.recv(_WORD)
        except BaseException:
            ours.close()  # closing our end of the socket ends a guard that has started
            raise
        self._line = ours
        if said not in (b"0", b""):  # no answer means that the guard was killed
            with self:
                pass
            raise OSError(int(said), os.strerror(int(said)), words[0])

    def send_signal(self, sig: int) -> None:
        """Send a signal to the program and its child processes; SIGKILL also ends the guard."""
        if self._line is None:
            super().send_signal(sig)
        elif self.poll() is None:
            end_apart(self.pid, number=sig)

    def __exit__(self, *raised: Any) -> None:
        """Wait for the end of the program."""
        super().__exit__(*raised)
        if self._line is not None:
            self._line.close()


def run(
    command: Sequence[str | os.PathLike[str]], *, timeout: float | None = None, **how: Any
) -> subprocess.CompletedProcess[Any]:
    """Run a program to its end, and return what it has printed.

    After `timeout` seconds the program is ended.

    Raises:
        OSError: The program cannot be started.
        subprocess.TimeoutExpired: The program has not ended in time.
    """
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with Program(command, **{**pipes, **how}) as program:
        try:
            out, err = program.communicate(timeout=timeout)
        except BaseException:
            program.kill()
            raise
    return subprocess.CompletedProcess(command, program.returncode, out, err)
