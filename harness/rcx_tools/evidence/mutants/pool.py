"""Pool that runs each mutant in a forked child process, which has all data of this process."""

from __future__ import annotations

import gc
import json
import os
from collections.abc import Callable, Iterable, Iterator

from structured_text.errors import InputError
from structured_text.mutants.judging import ENDLESS, MutantTask, Outcome
from structured_text.output.system import copied, copy_ended

__all__ = ["PATIENCE_S", "run_tasks"]

#: Time limit of a child process: a factor for the processor time of its tests, plus a constant [s].
_SLOWER, PATIENCE_S = 4.0, 15.0


class _Pool:
    def __init__(
        self,
        run: Callable[[MutantTask], str | None],
        ended: Callable[[int], None],
        patience_s: float,
    ) -> None:
        self._run = run
        self._patience_s = patience_s
        self._told = ended
        self._running: dict[int, tuple[MutantTask, int]] = {}

    def __len__(self) -> int:
        return len(self._running)

    def start(self, task: MutantTask) -> None:
        reading, writing = os.pipe()

        def work() -> None:
            os.close(reading)
            os.write(writing, json.dumps({"by": self._run(task)}).encode())

        pid = copied(work, task.seconds * _SLOWER + self._patience_s)
        os.close(writing)
        self._running[pid] = (task, reading)

    def ended(self) -> Outcome:
        """Wait for the end of the next child process, and return its outcome."""
        pid, how, seconds = copy_ended()
        task, reading = self._running.pop(pid)
        self._told(pid)
        answer = os.read(reading, 65536)
        os.close(reading)
        if answer:
            by = json.loads(answer)["by"]
            return Outcome(task, by is not None, by or "", seconds)
        if isinstance(how, str):
            return Outcome(task, True, ENDLESS if how == "time" else how, seconds)
        text = f"the tests of {task.mutant.file} could not be run with {task.mutant.after!r}"
        raise InputError(text, hint="look for room on the disk, and run it again")


def run_tasks(
    tasks: Iterable[MutantTask],
    run: Callable[[MutantTask], str | None],
    jobs: int,
    ended: Callable[[int], None] = lambda pid: None,
    patience_s: float = PATIENCE_S,
) -> Iterator[Outcome]:
    """Run mutants in parallel. Yield each outcome as soon as the mutant ends.

    Args:
        tasks: Mutants with their tests.
        run: Function that is called in a child process. It runs the tests with the mutant and
            returns the test that found the mutant.
        jobs: Number of mutants that run in parallel.
        ended: Function that is called with the process number of each child process that has ended.
        patience_s: Time that a child process gets in addition to its tests. After this time the
            mutant counts as killed.
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
