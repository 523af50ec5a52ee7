"""Runs of the user's tests: the test command in a process, or in copies of a prepared process.

The start of pytest takes most of the time of a run. If a process can copy itself, one process
collects the tests once, and each mutant runs in a copy of it.
"""

from __future__ import annotations

import os
import shlex
import socket
import sys
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from subprocess import STDOUT, TimeoutExpired
from tempfile import TemporaryDirectory, mkdtemp

from structured_text.errors import InputError
from structured_text.mutants.judging import ENDLESS, MutantTask, Outcome
from structured_text.mutants.order import VARIABLE, Order
from structured_text.output.paths import real
from structured_text.output.programs import Program, environment
from structured_text.output.system import COPIES

__all__ = ["Judge", "PytestCommand", "outcome"]

_PYTEST = ("pytest", "py.test")
#: The time limit of a run is a multiple of the time of its tests, plus a number of seconds. Few
#: runs reach it, because tests wait in virtual time and the engine ends an endless loop.
_SLOWER, _BESIDES_S = 10.0, 60.0
#: Interval [s] of the check whether the process has ended before it has connected.
_LOOK_S = 0.2


@dataclass(frozen=True)
class PytestCommand:
    """The user's test command, executed in the folder of the project.

    Attributes:
        command: The words of the user's command, which ends in a run of pytest.
        folder: The user's project.
    """

    command: tuple[str, ...]
    folder: Path

    @classmethod
    def of(cls, words: Sequence[str], folder: Path) -> PytestCommand:
        """Return the command for the user's words; `pytest` means the pytest of this Python."""
        first, *rest = words
        command = [sys.executable, "-m", "pytest"] if first in _PYTEST else [first]
        return cls((*command, *rest), real(folder))

    def started(self, order: Order) -> Program:
        """Start the command with an order; its output is written to a file in the order's folder.

        Raise InputError if the command does not exist.
        """
        options = ["-o", f"cache_dir={order.folder / 'cache'}"]
        options += ["--basetemp", str(order.folder / "tests")]
        given = " ".join([os.environ.get("PYTEST_ADDOPTS", ""), *map(shlex.quote, options)])
        place = {VARIABLE: str(order.write()), "PYTEST_ADDOPTS": given.strip()}
        place |= {"COVERAGE_FILE": str(order.folder / "coverage")}
        try:
            with (order.folder / "printed").open("wb") as printed:
                return Program(
                    self.command,
                    cwd=self.folder,
                    env=environment(**place),
                    stdout=printed,
                    stderr=STDOUT,
                )
        except OSError as error:
            told = f"{self.command[0]} cannot be started: {error.strerror}"
            raise InputError(told, hint="write `-- pytest` and its options") from None

    def __call__(self, order: Order, seconds: float | None = None) -> int | None:
        """Run the command to its end; return the exit code, or None after `seconds`."""
        process = self.started(order)
        try:
            return process.wait(seconds)
        except TimeoutExpired:
            return None
        finally:
            process.kill()
            process.wait()


@dataclass(frozen=True)
class Judge:
    """Runs a mutant with its tests; each worker process of the farm gets a copy.

    Attributes:
        run: The user's tests.
        base: A temporary folder for the folders of the runs.
        sources: Files that all runs read.
    """

    run: PytestCommand
    base: Path
    sources: tuple[Path, ...] = ()

    @property
    def there(self) -> Path | None:
        """Return the temporary folder if it exists on this computer.

        None selects the system's temporary folder.
        """
        return self.base if self.base.is_dir() else None

    def prepare(self) -> Callable[[MutantTask], Outcome]:
        """Return a function that runs one mutant."""
        return _Copies(self) if COPIES else self

    def __call__(self, task: MutantTask) -> Outcome:
        """Run one mutant in its own process."""
        started = time.monotonic()
        with TemporaryDirectory(dir=self.there, ignore_cleanup_errors=True) as name:
            order = self.order(task, Path(name))
            code = self.run(order, order.seconds)
            how = ENDLESS if code is None else f"the run ends with {code}"
            return outcome(task, order, how, time.monotonic() - started)

    def order(self, task: MutantTask, folder: Path) -> Order:
        """Write the changed copy of the mutant's file, and return the order that runs the tests."""
        original = real(self.run.folder / task.mutant.file)
        copy = folder / "sources" / original.name
        copy.parent.mkdir()
        copy.write_text(task.mutant.text, encoding="utf-8")
        limit = task.seconds * _SLOWER + _BESIDES_S
        return Order(folder, task.tests, {original: copy}, seconds=limit)


def outcome(task: MutantTask, order: Order, how: str, seconds: float) -> Outcome:
    """Return the outcome of a mutant.

    If the run has not written a result, `how` says how the run ended.
    """
    said = order.answered()
    by = how if said is None else said["failed"]
    return Outcome(task, by is not None, by or "", seconds)


class _Copies:
    """Runs mutants in copies of a process that has collected the tests.

    If a copy does not end, or ends without a result, the mutant runs again in its own process. The
    process that collects the tests connects to a socket and reads lines with paths of orders. It
    answers with a line when the copy for an order has ended.
    """

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._lines: socket.SocketIO | None = None
        self._process: Program | None = None
        self._given_up = False

    def __call__(self, task: MutantTask) -> Outcome:
        """Run one mutant in a copy of the process; if that fails, run it in its own process."""
        started = time.monotonic()
        with TemporaryDirectory(dir=self._judge.there, ignore_cleanup_errors=True) as name:
            order = self._judge.order(task, Path(name))
            if self._done(order) and order.answered() is not None:
                return outcome(task, order, "", time.monotonic() - started)
        return self._judge(task)

    def _done(self, order: Order) -> bool:
        """Return whether the process has executed the order."""
        try:
            if self._lines is None and not self._given_up:
                self._start()
            if self._lines is not None:
                self._lines.write(f"{order.write()}\n".encode())
                if self._lines.readline():
                    return True
        except OSError:
            pass
        self._lines = None
        return False

    def _start(self) -> None:
        self._given_up = True  # reset as soon as the process connects
        with socket.create_server(("127.0.0.1", 0)) as server:
            server.settimeout(_LOOK_S)
            folder = Path(mkdtemp(dir=self._judge.there))
            order = Order(folder, (), port=server.getsockname()[1], sources=self._judge.sources)
            process = self._process = self._judge.run.started(order)
            while process.poll() is None:
                with suppress(TimeoutError):
                    connection, _ = server.accept()
                    connection.settimeout(None)
                    self._lines = socket.SocketIO(connection, "rw")
                    self._given_up = False
                    return
