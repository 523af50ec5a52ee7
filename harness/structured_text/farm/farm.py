"""The farm: it gives items to workers and yields the results in the order of the items.

`Farm` combines three parts. `_Known` takes results from the file of results and removes duplicate
items. `_Turns` decides which item is given next, and repeats an item if its worker has ended. A
crew executes the items: processes of this computer, a cluster, or this process itself.
"""

from __future__ import annotations

import pickle
from collections import deque
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence, Sized
from contextlib import contextmanager
from functools import partial
from itertools import chain, count
from typing import Any, Final, Protocol, TypeVar

from rich.console import Console
from rich.progress import Progress

from structured_text.errors import DISTRIBUTION, InputError
from structured_text.farm.cluster import Cluster
from structured_text.farm.local import LocalCrew
from structured_text.farm.result_file import ResultFile
from structured_text.farm.work import Died, Done, Ended, Lost, NotBegun, Work, attempt, doer
from structured_text.output.progress import progress_bar
from structured_text.output.system import MOST_PROCESSES, processors

__all__ = ["AHEAD", "NOT_YET", "Farm", "Item", "NotYet", "Result"]

#: Greatest number of items per worker that are started after an unfinished item. Their results wait
#: in memory until the unfinished item has ended.
AHEAD = 64


class NotYet:
    """The type of `NOT_YET`, which stands for items that depend on later results."""


NOT_YET: Final = NotYet()

Item = TypeVar("Item")
Result = TypeVar("Result")

#: The number of an item, the item, and its outcome.
_Ending = tuple[int, Any, Done]


class _Crew(Protocol):
    """The workers that `_Turns` uses, on this computer or on others."""

    @property
    def attempts(self) -> int:
        """Return how often an item is started if its workers end.

        In the last attempt no other item is in progress.
        """

    @property
    def size(self) -> int:
        """Return the number of workers."""

    def has_room(self) -> bool:
        """Return whether a new item would be started now or soon."""

    def give(self, number: int, item: Any) -> None:
        """Give an item, with its number, to the workers."""

    def ended(self) -> Iterable[tuple[int, Ended]]:
        """Wait until items end or there may be more room; yield their numbers and outcomes."""

    def close(self) -> None:
        """End all items in progress."""


class Farm:
    """The workers for items of work, on this computer or in a cluster.

    Args:
        workers: Number of processes on this computer; by default one per processor. 0 stands for
            this process itself.
        cluster: A cluster that is used instead of this computer.
        console: Console for the progress bar; None for no progress.
    """

    def __init__(
        self,
        workers: int | None = None,
        cluster: Cluster | None = None,
        *,
        console: Console | None = None,
    ) -> None:
        self.workers = min(processors() if workers is None else workers, MOST_PROCESSES)
        self.cluster = cluster
        self._console = Console(quiet=True) if console is None else console
        if cluster is not None:
            cluster.check()

    def run(
        self,
        work: Work[Item, Result],
        items: Iterable[Item | NotYet],
        *,
        lost: Callable[[Lost[Item]], Result] | None = None,
        kept: ResultFile[Item, Result] | None = None,
        title: str | None = "items",
    ) -> Generator[tuple[Item, Result], None, None]:
        """Yield each item with its result, in the order of the items, as early as possible.

        Closing the iterator ends the items in progress. If an item has raised an error, this error
        is raised in place of its result.

        Args:
            work: A function of one item, or an object whose `prepare()` returns that function.
                `prepare` is called once in each worker. The work, items and results must be
                picklable.
            items: The items. They are taken when a worker has room, at most `AHEAD` per worker
                beyond the first unfinished one. If the iterator yields `NOT_YET`, it is continued
                after the next result; `kept` cannot be used then.
            lost: Returns the result of an item whose workers all ended; it is not saved.
            kept: The file of results. Known results are taken from it, and new results are saved at
                once.
            title: Name of the items in the progress bar; None if the caller shows the progress.

        Raises:
            LostError: All workers of an item ended, and `lost` is None.
            InputError: There is no such cluster, or it is gone.
        """
        waiting: dict[int, tuple[Item, Done]] = {}
        following = 0
        for number, item, done in self._ended(work, items, lost, kept, title, ahead=AHEAD):
            waiting[number] = item, done
            while following in waiting:
                item, done = waiting.pop(following)
                yield item, done.get()
                following += 1

    def as_ready(
        self,
        work: Work[Item, Result],
        items: Iterable[Item],
        *,
        lost: Callable[[Lost[Item]], Result] | None = None,
    ) -> Generator[tuple[Item, Result], None, None]:
        """Yield each item with its result as `run` does, but in the order in which they end."""
        for _, item, done in self._ended(work, items, lost, None, "items"):
            yield item, done.get()

    def _ended(
        self,
        work: Work[Item, Result],
        items: Iterable[Item | NotYet],
        lost: Callable[[Lost[Item]], Result] | None,
        kept: ResultFile[Item, Result] | None,
        title: str | None,
        ahead: int | None = None,
    ) -> Iterator[_Ending]:
        known = _Known(kept)
        missing = known.missing(items)
        total = len(items) if isinstance(items, Sized) else None
        console = self._console if title is not None else Console(quiet=True)
        with progress_bar(console) as progress:
            bar = progress.add_task(title or "", total=total, told="")

            def shown(those: Sequence[_Ending]) -> Sequence[_Ending]:
                if those:
                    progress.update(bar, advance=len(those), refresh=True)
                return those

            first = next(missing, None)
            yield from shown(known.ready())
            if first is not None:
                with self._crew(work, progress) as crew:
                    turns = _Turns(crew, chain([first], missing), lost, ahead)
                    for ending in turns.ended():
                        yield from shown(known.ready(ending))
                yield from shown(known.ready())

    @contextmanager
    def _crew(self, work: Work[Any, Any], progress: Progress) -> Iterator[_Crew]:
        crew: _Crew
        if self.cluster is not None:
            where = f"connecting to {self.cluster.address} ..."
            progress.update(progress.task_ids[-1], told=where, refresh=True)
            crew = self._of_cluster(work, self.cluster)
            progress.update(progress.task_ids[-1], told="", refresh=True)
        else:
            crew = LocalCrew(work, self.workers) if self.workers else _Here(work)
        try:
            yield crew
        finally:
            crew.close()

    def _of_cluster(self, work: Work[Any, Any], cluster: Cluster) -> _Crew:
        try:
            from structured_text.farm.dask import ClusterCrew
        except ModuleNotFoundError as error:
            if error.name not in ("distributed", "dask"):
                raise
            hint = f"pip install '{DISTRIBUTION}[cluster]'"
            raise InputError("--cluster needs dask.distributed", hint=hint) from None
        return ClusterCrew(work, cluster, partial(self._console.print, highlight=False))


class _Known:
    """The results that need no worker.

    An item needs no worker if the file of results contains its result, or if an equal item is in
    progress. In the second case the item gets the result of the equal item.
    """

    def __init__(self, kept: ResultFile[Any, Any] | None) -> None:
        self._kept = kept
        self._ready: list[_Ending] = []
        self._same: dict[str, list[tuple[int, Any]]] = {}

    def missing(self, items: Iterable[Any]) -> Iterator[tuple[int, Any]]:
        """Yield the items that need a worker, with their numbers; -1 for `NOT_YET`."""
        numbers = count()
        for item in items:
            if item is NOT_YET:
                yield -1, item
                continue
            number = next(numbers)
            if self._kept is None:
                yield number, item
            elif self._kept.knows(item):
                self._ready.append((number, item, Done(self._kept.get(item))))
            elif (same := self._same.get(self._kept.key(item))) is not None:
                same.append((number, item))
            else:
                self._same[self._kept.key(item)] = []
                yield number, item

    def ready(self, *ended: _Ending) -> list[_Ending]:
        """Save the outcome of ended items; return all outcomes since the last call."""
        for number, item, done in ended:
            those = [(number, item)]
            if self._kept is not None:
                those += self._same.pop(self._kept.key(item))
                if done.error is None and not done.is_lost:
                    self._kept.add(item, done.result)
                    done = Done(self._kept.get(item))
            self._ready += [(*one, done) for one in those]
        ready, self._ready = self._ready, []
        return ready


class _Turns:
    """The order in which items are given to the crew.

    If a worker ends, its item is given again. After `crew.attempts - 1` such ends, the item waits
    until nothing else is in progress and runs alone, so that it is certain which item ends the
    worker. If the worker ends again, the item is lost. Items that a worker had not begun when it
    ended do not count as attempts. After an error, no new items are taken.
    """

    def __init__(
        self,
        crew: _Crew,
        items: Iterator[tuple[int, Any]],
        lost: Callable[[Lost[Any]], Any] | None,
        ahead: int | None,
    ) -> None:
        self._crew = crew
        self._new = items
        self._lost = lost
        self._ahead = ahead
        self._taken = 0
        self._again: deque[int] = deque()
        self._last_time: deque[int] = deque()
        #: For each unfinished item: its position in the order in which items were taken, and the
        #: item.
        self._items: dict[int, tuple[int, Any]] = {}
        self._died: dict[int, list[Died]] = {}
        self._under_way: set[int] = set()
        self._alone = False
        self._more = True

    def ended(self) -> Iterator[_Ending]:
        """Yield number, item and outcome of each item as it ends."""
        while True:
            while self._crew.has_room() and (number := self._next()) is not None:
                self._under_way.add(number)
                self._crew.give(number, self._items[number][1])
            if not (self._under_way or self._more or self._again or self._last_time):
                return
            for number, how in self._crew.ended():
                self._under_way.discard(number)
                self._alone = self._alone and bool(self._under_way)
                if isinstance(how, NotBegun):
                    self._again.append(number)
                    continue
                done = self._again_or_lost(number, how) if isinstance(how, Died) else how
                if done is not None:
                    self._more = self._more and done.error is None
                    yield number, self._items.pop(number)[1], done

    def _next(self) -> int | None:
        if self._alone:
            return None
        if self._again:
            return self._again.popleft()
        if self._last_time:  # the item runs alone, so that it is certain which item ends the worker
            self._alone = not self._under_way
            return self._last_time.popleft() if self._alone else None
        if self._is_far_ahead():
            return None
        for number, item in self._new if self._more else ():
            if item is NOT_YET:
                assert self._under_way, "NOT_YET without an item in progress"
                return None
            self._items[number] = self._taken, item
            self._taken += 1
            return number
        self._more = False
        return None

    def _is_far_ahead(self) -> bool:
        if self._ahead is None or not self._items:
            return False
        oldest, _ = next(iter(self._items.values()))
        return self._taken - oldest >= self._ahead * self._crew.size

    def _again_or_lost(self, number: int, how: Died) -> Done | None:
        died = self._died.setdefault(number, [])
        died.append(how)
        if len(died) < self._crew.attempts:
            last = len(died) == self._crew.attempts - 1
            (self._last_time if last else self._again).append(number)
            return None
        found = Lost(self._items[number][1], sum(one.workers for one in died), how.why)
        if self._lost is None:
            return Done(error=found.error())
        return Done(self._lost(found), is_lost=True)


class _Here:
    """The crew without worker processes: items are executed in this process."""

    attempts = 1
    size = 1

    def __init__(self, work: Work[Any, Any]) -> None:
        self._work = work
        self._do: Callable[[Any], Any] | None = None
        self._given: list[tuple[int, Any]] = []

    def has_room(self) -> bool:
        return not self._given

    def give(self, number: int, item: Any) -> None:
        self._given.append((number, item))

    def ended(self) -> Iterator[tuple[int, Ended]]:
        number, item = self._given.pop()
        yield number, pickle.loads(attempt(partial(self._one, item)))

    def _one(self, item: Any) -> Any:
        self._do = self._do or doer(self._work)
        return self._do(item)

    def close(self) -> None:
        pass
