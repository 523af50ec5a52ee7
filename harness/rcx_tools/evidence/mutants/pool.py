"""Runs each mutant in a child of its own: a copy of this process, with all that it holds."""

from __future__ import annotations

import gc
import json
import os
import resource
import signal
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from rcx_harness.errors import InputError
from rcx_harness.verify.mutants.mutant import Mutant

__all__ = ["PATIENCE_S", "Outcome", "Task", "run_tasks"]

#: What a child may take: so often the processor time of its tests, and so much besides [s].
_SLOWER, PATIENCE_S = 4.0, 15.0
#: Real time after which a child counts as hanging: so much [s], and so often its processor time,
#: since the machine may have other work.
_HANGS, _BUSY = 600, 8


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
        self,
        run: Callable[[Task], str | None],
        ended: Callable[[int], None],
        patience_s: float,
    ) -> None:
        self._run = run
        self._patience_s = patience_s
        self._told = ended
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
        limit = int(task.seconds * _SLOWER + self._patience_s)
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(_HANGS + _BUSY * limit)
        os.write(writing, json.dumps({"by": self._run(task)}).encode())
        os._exit(0)

    def ended(self) -> Outcome:
        """Wait for the next child to end."""
        pid, status, usage = os.wait4(-1, 0)
        task, reading = self._running.pop(pid)
        self._told(pid)
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
        text = f"the tests of {task.mutant.file} could not be run with {task.mutant.after!r}"
        raise InputError(text, hint="look for room on the disk, and run it again")


def run_tasks(
    tasks: Iterable[Task],
    run: Callable[[Task], str | None],
    jobs: int,
    ended: Callable[[int], None] = lambda pid: None,
    patience_s: float = PATIENCE_S,
) -> Iterator[Outcome]:
    """Run mutants, so many at a time; yield what became of each, as it ends.

    Args:
        tasks: The mutants with their tests.
        run: What a child does: run the tests with the mutant, and say what has found it.
        jobs: How many run at a time.
        ended: Is told the process number of each child that has ended.
        patience_s: How long a child may take beyond its tests; then it counts as killed.
    """
    pool = _Pool(run, ended, patience_s)
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
