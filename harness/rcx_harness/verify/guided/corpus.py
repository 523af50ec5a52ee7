"""The corpus of a guided campaign: which states are kept, and where the next runs branch.

The runs are executed in rounds. The runs of a round depend only on the corpus at the beginning of
the round, and their results are merged in the order of their numbers. So the campaign does not
depend on the number of workers.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from random import Random

from rcx_harness.verify.guided.branch import Branch, Guided, Kept, Ran
from structured_text.farm import NOT_YET, Farm, NotYet

__all__ = ["Corpus", "guided"]

#: Number of runs in a round.
_ROUND = 8
#: Share of the runs that begin with a cold start.
_COLD = 0.04
#: Greatest number of kept states. States with the least energy are removed.
_MOST = 400


@dataclass
class _Place:
    """A kept state, how often a run began there, and how many new states these runs gave."""

    kept: Kept
    age: int
    used: int = 0
    gave: int = 0


class Corpus:
    """The kept states, and how often each feature was met."""

    def __init__(self, seed: int) -> None:
        self._seed = seed
        self._places: list[_Place] = []
        self._met: Counter[int] = Counter()

    @property
    def states(self) -> int:
        """Return the number of kept states."""
        return len(self._places)

    @property
    def features(self) -> int:
        """Return the number of known features."""
        return len(self._met)

    def choose(self, first: int, number: int) -> list[tuple[Branch, int]]:
        """Return the next runs, each with the index of its state; -1 for a cold start."""
        random = Random(f"corpus {self._seed} {first}")
        known = frozenset(self._met)
        energies = [self._energy(one) for one in self._places]
        chosen = []
        for k in range(first, first + number):
            if not self._places or random.random() < _COLD:
                chosen.append((Branch(k, None, known), -1))
                continue
            at = random.choices(range(len(energies)), energies)[0]
            energies[at] /= 2
            chosen.append((Branch(k, self._places[at].kept, known), at))
        return chosen

    def _energy(self, one: _Place) -> float:
        """Return the weight of a state: high if its features are rare and it was seldom used."""
        rare = sum(1 / self._met[feature] for feature in one.kept.features)
        return (0.2 + min(rare, 3.0)) * (2 + one.gave) / (2 + one.used)

    def add(self, results: list[tuple[int, Ran]]) -> None:
        """Merge the results of a round: the index of the state where each began, and the result."""
        before = set(self._met)
        places = list(self._places)
        for at, ran in results:
            self._met.update(ran.features)
            new = 0
            for kept in ran.kept:
                features = tuple(one for one in kept.features if one not in before)
                if features:
                    before.update(features)
                    self._places.append(_Place(kept._replace(features=features), 0))
                    new += 1
            if at >= 0:
                places[at].used += 1
                places[at].gave += new > 0
        if len(self._places) > _MOST:
            ranked = sorted(self._places, key=self._energy, reverse=True)
            left = {id(one) for one in ranked[:_MOST]}
            self._places = [one for one in self._places if id(one) in left]


def guided(farm: Farm, work: Guided, runs: int, corpus: Corpus) -> Iterator[tuple[int, Ran]]:
    """Execute a number of runs, and yield the number and the result of each, in order."""
    places: list[int] = []
    results: list[tuple[int, Ran]] = []

    def items() -> Iterator[Branch | NotYet]:
        first = 0
        while first < runs:
            # The first round has a single run: its states are the corpus of the second round.
            chosen = corpus.choose(first, min(_ROUND if first else 1, runs - first))
            first += len(chosen)
            places[:] = [at for _, at in chosen]
            results.clear()
            for item, _ in chosen:
                yield item
            while len(results) < len(chosen):
                yield NOT_YET
            corpus.add(results)

    for item, ran in farm.run(work, items(), title=None):
        results.append((places[len(results)], ran))
        yield item.number, ran
