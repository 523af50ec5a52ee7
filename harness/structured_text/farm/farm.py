"""A farm: gives items to workers, and yields what comes of them in the order of the items."""

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
from structured_text.farm.kept import Kept
from structured_text.farm.local import LocalCrew
from structured_text.farm.work import Died, Done, Ended, Lost, NotBegun, Work, attempt, doer
from structured_text.output.progress import progress_bar
from structured_text.output.system import MOST_PROCESSES, processors

__all__ = ["AHEAD", "NOT_YET", "Farm", "NotYet"]

#: Where results come in order: so many items for each worker are begun while an earlier one is
#: under way. Their results wait in memory.
AHEAD = 64


class NotYet:
    """There is no item now; what comes of those that were taken may give some."""


NOT_YET: Final = NotYet()

Item = TypeVar("Item")
Result = TypeVar("Result")

#: Which item, the item, and what came of it.
_Ending = tuple[int, Any, Done]


class _Crew(Protocol):
    """Workers, wherever they are."""

    @property
    def attempts(self) -> int:
        """How often an item is begun whose worker ends; the last time nothing else is under way."""

    @property
    def size(self) -> int:
        """How many workers there are."""

    def has_room(self) -> bool:
        """Would an item be begun now, or soon?"""

    def give(self, number: int, item: Any) -> None:
        """Begin an item under a number of its own."""

    def ended(self) -> Iterable[tuple[int, Ended]]:
        """Wait until some have ended, or there may be more room; which, and how."""

    def close(self) -> None:
        """End what is under way."""


class Farm:
    """Where work is done.

    Args:
        workers: Processes of this computer (default: one for each processor); 0: in this process.
        cluster: The workers of this cluster instead.
        console: Where progress is shown; None: nowhere.
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
        kept: Kept[Item, Result] | None = None,
        title: str | None = "items",
    ) -> Generator[tuple[Item, Result], None, None]:
        """Each item with its result, in the order of the items, as soon as those before are there.

        Closing the iterator ends what is under way. An error of an item is raised in its turn.

        Args:
            work: A function of one item, or an object whose `prepare()` gives that function, once
                in each worker. Both, the items and the results can be pickled.
            items: What to do; taken as there is room, at most `AHEAD` for each worker before the
                first that is missing. `NOT_YET` among them, without `kept`, is none: they are asked
                again when the next result has been taken.
            lost: The result of an item that no worker gets through; it is not kept.
            kept: Where results are kept as soon as they are there, and which are known.
            title: What the items are, for the progress; None: it is shown by who asks.

        Raises:
            LostError: no worker gets through an item, and there is no `lost`.
            InputError: there is no such cluster, or it has gone.
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
        kept: Kept[Item, Result] | None = None,
        title: str = "items",
    ) -> Generator[tuple[Item, Result], None, None]:
        """The same in the order in which they end; none waits for another one."""
        for _, item, done in self._ended(work, items, lost, kept, title):
            yield item, done.get()

    def _ended(
        self,
        work: Work[Item, Result],
        items: Iterable[Item | NotYet],
        lost: Callable[[Lost[Item]], Result] | None,
        kept: Kept[Item, Result] | None,
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
    """Puts what is known from the file of results, or under way already, beside what ends."""

    def __init__(self, kept: Kept[Any, Any] | None) -> None:
        self._kept = kept
        self._ready: list[_Ending] = []
        self._same: dict[str, list[tuple[int, Any]]] = {}

    def missing(self, items: Iterable[Any]) -> Iterator[tuple[int, Any]]:
        """The items that are to be done, numbered; or that there is none yet."""
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
        """Keep what has ended; all that has not been asked for yet."""
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
    """Which item is given next; an item whose worker has ended is given again."""

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
        #: Of each that has not ended the place among those that were taken, and itself.
        self._items: dict[int, tuple[int, Any]] = {}
        self._died: dict[int, list[Died]] = {}
        self._under_way: set[int] = set()
        self._alone = False
        self._more = True

    def ended(self) -> Iterator[_Ending]:
        """Number, item and what came of it, as they end."""
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
        if self._last_time:  # alone, so that it is sure what ends the worker
            self._alone = not self._under_way
            return self._last_time.popleft() if self._alone else None
        if self._is_far_ahead():
            return None
        for number, item in self._new if self._more else ():
            if item is NOT_YET:
                assert self._under_way, "nothing is under way that could give an item"
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
    """No worker but this process."""

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
