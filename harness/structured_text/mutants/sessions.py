"""Runs of the user's tests: of his command in a process of its own, or in copies of one process.

A run of pytest takes longest to begin. Where a process can copy itself, one that has collected
the tests stays, and each mutant is tried in a copy of it.
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
from structured_text.mutants.judging import ENDLESS, Outcome, Task
from structured_text.mutants.order import VARIABLE, Order
from structured_text.output.paths import real
from structured_text.output.programs import Program
from structured_text.output.system import COPIES

__all__ = ["Judge", "Run"]

_PYTEST = ("pytest", "py.test")
#: What a run may take: so often the time of its tests, and so much besides [s]. Tests that wait do
#: so in virtual time, and the engine ends a loop without end: few come to this.
_SLOWER, _BESIDES_S = 10.0, 60.0
#: How often it is looked whether a process that is to answer has ended [s].
_LOOK_S = 0.2


@dataclass(frozen=True)
class Run:
    """Runs the user's command in his folder.

    Attributes:
        command: Words that end in a run of pytest.
        folder: His project.
    """

    command: tuple[str, ...]
    folder: Path

    @classmethod
    def of(cls, words: Sequence[str], folder: Path) -> Run:
        """The run of what he types; `pytest` is that of this Python."""
        first, *rest = words
        command = [sys.executable, "-m", "pytest"] if first in _PYTEST else [first]
        return cls((*command, *rest), real(folder))

    def started(self, order: Order) -> Program:
        """Start it with an order; what it prints goes to a file in the order's folder.

        Raises:
            InputError: there is no such command.
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
                    env={**os.environ, **place},
                    stdout=printed,
                    stderr=STDOUT,
                )
        except OSError as error:
            told = f"{self.command[0]} cannot be started: {error.strerror}"
            raise InputError(told, hint="write `-- pytest` and its options") from None

    def __call__(self, order: Order, seconds: float | None = None) -> int | None:
        """Run it to its end; the exit code, or None where it took longer than `seconds`."""
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
    """Runs mutants with their tests.

    Attributes:
        run: Runs the tests.
        base: A temporary folder, for those of the runs.
        sources: Files that all of them read.
    """

    run: Run
    base: Path
    sources: tuple[Path, ...] = ()

    @property
    def there(self) -> Path | None:
        """The folder, if this computer has it; else the usual one for what is temporary."""
        return self.base if self.base.is_dir() else None

    def prepare(self) -> Callable[[Task], Outcome]:
        """What runs one mutant."""
        return _Copies(self) if COPIES else self

    def __call__(self, task: Task) -> Outcome:
        """Run one in a process of its own."""
        started = time.monotonic()
        with TemporaryDirectory(dir=self.there, ignore_cleanup_errors=True) as name:
            order = self.order(task, Path(name))
            code = self.run(order, order.seconds)
            how = ENDLESS if code is None else f"the run ends with {code}"
            return outcome(task, order, how, time.monotonic() - started)

    def order(self, task: Task, folder: Path) -> Order:
        """The order for one mutant, with the copy that has the mistake."""
        original = real(self.run.folder / task.mutant.file)
        copy = folder / "sources" / original.name
        copy.parent.mkdir()
        copy.write_text(task.mutant.text, encoding="utf-8")
        limit = task.seconds * _SLOWER + _BESIDES_S
        return Order(folder, task.tests, {original: copy}, seconds=limit)


def outcome(task: Task, order: Order, how: str, seconds: float) -> Outcome:
    """What became of a mutant; `how` its run has ended counts where that has said nothing."""
    said = order.answered()
    by = how if said is None else said["failed"]
    return Outcome(task, by is not None, by or "", seconds)


class _Copies:
    """Runs mutants in copies of a process that has collected the tests.

    A copy that comes to no end, or ends by itself, decides nothing: a process of its own does.
    """

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._lines: socket.SocketIO | None = None
        self._process: Program | None = None
        self._given_up = False

    def __call__(self, task: Task) -> Outcome:
        """Run one."""
        started = time.monotonic()
        with TemporaryDirectory(dir=self._judge.there, ignore_cleanup_errors=True) as name:
            order = self._judge.order(task, Path(name))
            if self._done(order) and order.answered() is not None:
                return outcome(task, order, "", time.monotonic() - started)
        return self._judge(task)

    def _done(self, order: Order) -> bool:
        """Whether the process has done it."""
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
        self._given_up = True  # unless it answers
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
