"""Local worker processes run each item once, and results come in the order of the items."""

from __future__ import annotations

import itertools
import math
import os
import select
import signal
import subprocess
import sys
from collections import deque
from collections.abc import Iterator
from pathlib import Path

import pytest

from farm_work import Counted, FirstWaits, Killed, Meeting, grandchild, process_number, refuse
from structured_text.errors import InputError
from structured_text.farm import NOT_YET, Farm, Lost, NotYet, ResultFile
from structured_text.farm.farm import AHEAD
from structured_text.farm.work import LostError, RemoteError


@pytest.mark.parametrize("workers", [0, 1, 3])
def test_results_come_in_the_order_of_the_items(workers: int) -> None:
    expected = [(4, 24), (0, 1), (3, 6), (5, 120), (2, 2)]
    assert list(Farm(workers).run(math.factorial, [4, 0, 3, 5, 2])) == expected


@pytest.mark.exhaustive
@pytest.mark.parametrize("workers", [0, 2])
def test_results_may_give_further_items(workers: int) -> None:
    """A result can add items.

    Each number n up to 7 adds 2 n and 2 n + 1, so the items are 1 to 15.
    """
    waiting, under_way = deque([1]), 0

    def items() -> Iterator[int | NotYet]:
        nonlocal under_way
        while waiting or under_way:
            if waiting:
                under_way += 1
                yield waiting.popleft()
            else:
                yield NOT_YET

    found = []
    for item, result in Farm(workers).run(math.factorial, items()):
        under_way -= 1
        found.append((item, result))
        if item <= 7:
            waiting.extend([2 * item, 2 * item + 1])
    assert found == [(number, math.factorial(number)) for number in range(1, 16)]


@pytest.mark.exhaustive
def test_two_workers_work_at_once(tmp_path: Path) -> None:
    for name in "01":
        os.mkfifo(tmp_path / name)
    assert [one for one, _ in Farm(2).run(Meeting(tmp_path), [0, 1])] == [0, 1]


@pytest.mark.exhaustive
@pytest.mark.parametrize("workers", [0, 1, 2])
def test_each_worker_sets_up_once(tmp_path: Path, workers: int) -> None:
    file = tmp_path / "set_up"
    did = {process for _, process in Farm(workers).run(Counted(file), range(20))}
    prepared = [int(line) for line in file.read_text().split()]
    assert len(prepared) == len(set(prepared))
    assert did <= set(prepared)
    assert len(prepared) <= max(1, workers)


@pytest.mark.exhaustive(but=["1-1"])
@pytest.mark.parametrize("deaths", [1, 2])
@pytest.mark.parametrize("workers", [1, 2])
def test_the_item_of_a_killed_worker_runs_again(tmp_path: Path, deaths: int, workers: int) -> None:
    for number in range(deaths):
        (tmp_path / str(number)).touch()
    found = list(Farm(workers).run(Killed(tmp_path), range(8)))
    assert found == [(item, item * 10) for item in range(8)]
    assert not list(tmp_path.iterdir())


@pytest.mark.exhaustive
def test_an_item_that_kills_three_workers_is_named(tmp_path: Path) -> None:
    for number in range(4):
        (tmp_path / str(number)).touch()
    running = Farm(2).run(Killed(tmp_path), range(8))
    assert [next(running) for _ in range(3)] == [(0, 0), (1, 10), (2, 20)]
    with pytest.raises(
        LostError, match="3 workers died while they worked on 3: ended by SIGKILL; check that"
    ):
        next(running)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.exhaustive
def test_a_lost_item_can_be_a_result(tmp_path: Path) -> None:
    for number in range(4):
        (tmp_path / str(number)).touch()

    def lost(one: Lost[int]) -> int:
        return -one.times

    found = list(Farm(2).run(Killed(tmp_path), range(5), lost=lost))
    assert found == [(0, 0), (1, 10), (2, 20), (3, -3), (4, 40)]


@pytest.mark.parametrize("workers", [0, 1, 3])
def test_a_users_error_arrives_as_it_was_raised_and_the_first_one_first(workers: int) -> None:
    running = Farm(workers).run(refuse, range(8))
    assert [next(running) for _ in range(2)] == [(0, 0), (1, 1)]
    with pytest.raises(InputError) as caught:
        next(running)
    assert str(caught.value) == "a.st:2: no such pin; name another"
    assert (caught.value.file, caught.value.line) == ("a.st", 2)


@pytest.mark.parametrize("workers", [0, 1])
def test_any_other_error_comes_with_its_traceback(workers: int) -> None:
    with pytest.raises(KeyError) as caught:
        list(Farm(workers).run(refuse, [9]))
    assert isinstance(caught.value.__cause__, RemoteError)
    assert "raise KeyError(item)" in str(caught.value.__cause__)


@pytest.mark.exhaustive
def test_the_next_item_is_taken_when_a_worker_is_free() -> None:
    taken = []

    def items() -> Iterator[int]:
        for item in range(1000):
            taken.append(item)
            yield item

    running = Farm(2).run(process_number, items())
    assert next(running)[0] == 0
    running.close()
    assert len(taken) <= 2 * AHEAD


class _Releasing(ResultFile[int, int]):
    """A result file that lets item 0 continue when `others` other items have ended."""

    def __init__(self, file: Path, fifo: Path, others: int) -> None:
        super().__init__(file, {})
        self.ended: list[int] = []
        self._fifo, self._others = fifo, others

    def add(self, item: int, result: int) -> None:
        super().add(item, result)
        self.ended.append(item)
        if len(self.ended) == self._others:
            with self._fifo.open("w"):
                pass


@pytest.mark.exhaustive
def test_while_an_item_takes_long_the_others_do_not_run_far_ahead(tmp_path: Path) -> None:
    """While a worker runs a long item, the other workers run only a limited number of items ahead.

    One item may wait for the worker of the long item.
    """
    os.mkfifo(tmp_path / "fifo")
    kept = _Releasing(tmp_path / "kept", tmp_path / "fifo", 2 * AHEAD - 2)
    taken_before_the_first_ended = []

    def items() -> Iterator[int]:
        for item in itertools.count():
            if 0 not in kept.ended:
                taken_before_the_first_ended.append(item)
            yield item

    running = Farm(2).run(FirstWaits(tmp_path / "fifo"), items(), kept=kept)
    assert [next(running) for _ in range(2 * AHEAD)] == [(k, k) for k in range(2 * AHEAD)]
    running.close()
    assert len(taken_before_the_first_ended) <= 2 * AHEAD


def test_no_worker_is_left_behind() -> None:
    running = Farm(1).run(process_number, range(3))
    _, worker = next(running)
    running.close()
    with pytest.raises(ProcessLookupError):
        os.kill(worker, 0)


def test_a_process_started_by_a_worker_ends_with_it() -> None:
    running = Farm(1).run(grandchild, range(2))
    _, started = next(running)
    handle = os.pidfd_open(started)
    running.close()
    assert select.select([handle], [], [], 60)[0]
    os.close(handle)


_PARENT = """
import sys
from farm_work import waits_with_a_folder
from structured_text.farm import Farm
list(Farm(1).run(waits_with_a_folder, [sys.argv[1]]))
"""


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_worker_ends_with_its_parent(tmp_path: Path, number: signal.Signals) -> None:
    """If the parent process ends, its worker ends in the middle of an item.

    The test's pipe closes when both have ended.
    """
    found = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-c", _PARENT, str(tmp_path)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, env=found, stdout=pipe, stderr=pipe) as parent:
        assert parent.stdout is not None
        assert parent.stdout.readline() == b"begun\n"
        parent.send_signal(number)
        assert select.select([parent.stdout], [], [], 60)[0], (
            "the worker continues without its parent"
        )
        assert parent.stdout.read() == b""
    assert list(tmp_path.iterdir()) == []
