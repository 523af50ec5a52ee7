"""Runs each mutant in a child of its own: a copy of this process, with its tests and programs."""

from __future__ import annotations

import gc
import json
import os
import resource
import shutil
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import pytest

from rcx_harness.verify.mutants.engine import Workshop
from rcx_harness.verify.mutants.mutant import Mutant
from rcx_harness.verify.mutants.suite import Suite, private_folder

__all__ = ["Outcome", "Task", "remove_folders", "run_tasks"]

#: What a child may take: so often the time of its tests, and so much besides [s].
_SLOWER, _BESIDES = 4.0, 15.0
#: Real time after which a child counts as hanging [s]; the machine may have other work.
_HANGS = 600


@dataclass(frozen=True)
class Task:
    """A mutant and its tests; `seconds` is what they take with the original."""

    mutant: Mutant
    tests: tuple[str, ...]
    seconds: float
    key: str


@dataclass(frozen=True)
class Outcome:
    """What became of a mutant: killed, with what found it, or survived; processor time [s]."""

    task: Task
    killed: bool
    by: str
    seconds: float


class _Pool:
    def __init__(
        self, root: Path, suite: Suite, workshop: Workshop, order: Callable[[Task], Sequence[str]]
    ) -> None:
        self._root = root
        self._suite = suite
        self._workshop = workshop
        self._order = order
        self._running: dict[int, tuple[Task, int]] = {}

    def __len__(self) -> int:
        return len(self._running)

    def start(self, task: Task) -> None:
        reading, writing = os.pipe()
        pid = os.fork()
        if pid:
            os.close(writing)
            self._running[pid] = (task, reading)
            return
        try:
            os.close(reading)
            self._child(task, writing)
        finally:
            os._exit(1)

    def _child(self, task: Task, writing: int) -> None:
        nothing = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(nothing, stream)
        limit = int(task.seconds * _SLOWER + _BESIDES)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(_HANGS)
        config = next(iter(self._suite.items.values())).config
        private_folder(config, f"mutant{os.getpid()}")
        mutant = task.mutant
        self._workshop.put_in(
            self._root / mutant.file, mutant.text, mutant.pou.upper(), mutant.body
        )
        found = self._suite.run(self._order(task))
        os.write(writing, json.dumps({"by": found}).encode())
        os._exit(0)

    def ended(self) -> Outcome:
        """Wait for the next child to end."""
        pid, status, usage = os.wait4(-1, 0)
        task, reading = self._running.pop(pid)
        answer = os.read(reading, 65536)
        os.close(reading)
        seconds = usage.ru_utime + usage.ru_stime
        if answer:
            by = json.loads(answer)["by"]
            return Outcome(task, by is not None, by or "", seconds)
        if os.WIFSIGNALED(status):
            name = signal.Signals(os.WTERMSIG(status)).name
            slow = name in ("SIGXCPU", "SIGALRM", "SIGKILL")
            return Outcome(task, True, "a test does not end" if slow else name, seconds)
        raise RuntimeError(f"the tests could not be run with {task.mutant.after!r}")


def run_tasks(
    tasks: Iterable[Task],
    *,
    root: Path,
    suite: Suite,
    workshop: Workshop,
    order: Callable[[Task], Sequence[str]],
    jobs: int,
) -> Iterator[Outcome]:
    """Run mutants, so many at a time; yield what became of each, as it ends.

    Args:
        tasks: The mutants with their tests.
        root: The repository.
        suite: The collected tests.
        workshop: Where this process gets its programs from.
        order: The tests of a task in the order in which they run.
        jobs: How many run at a time.
    """
    pool = _Pool(root, suite, workshop, order)
    gc.collect()
    gc.freeze()
    waiting = iter(tasks)
    more = True
    while more or len(pool):
        while more and len(pool) < jobs:
            task = next(waiting, None)
            if task is None:
                more = False
            else:
                pool.start(task)
        if len(pool):
            yield pool.ended()


def remove_folders(config: pytest.Config) -> None:
    """Remove the temporary folders of all children."""
    factory = getattr(config, "_tmp_path_factory", None)
    if factory is not None and factory._basetemp is not None:
        for folder in factory._basetemp.glob("mutant*"):
            shutil.rmtree(folder, ignore_errors=True)
