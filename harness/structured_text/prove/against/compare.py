"""Proof that two versions of a program have the same outputs, or a run that shows a difference.

Induction comes first: with the library's blocks as functions of their state and arguments, then
with their code. A short search from the cold start, random runs and a longer search follow for the
outputs that are not proved. Both versions run on the built-in engine before a difference is
reported.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Protocol

from structured_text.errors import InputError
from structured_text.language.constructs import TRANSLATED, refuse
from structured_text.language.load import load, too_deep
from structured_text.language.project import Project
from structured_text.language.source import in_dialect
from structured_text.projects.sources import SourceFiles
from structured_text.prove.against.drawn import drawn_run
from structured_text.prove.against.search import PairSearch, Run
from structured_text.prove.against.step import Induction
from structured_text.prove.against.versions import Pair, Version, outputs_of, unchanged
from structured_text.prove.logic import PROVED, REFUTED, UnsupportedError
from structured_text.prove.properties import Library
from structured_text.prove.search import SearchEndedError
from structured_text.prove.surroundings import Surroundings, path_of
from structured_text.prove.user import Result

__all__ = ["Comparison", "PairBench", "Ran", "Wishes", "compare"]

#: A long scan period [us], with which a search of few scans reaches events that take seconds.
_LONG_US = 300_000
_FIRST, _SCANS = 8, 200
_STOPS = "stops"
_SHOWN = 8

_ASSUMES = (
    "Nothing but the inputs is set from outside of the programs.",
    "The clock never runs backwards and counts less than 2^62 ns; a TIME has 64 bits.",
)
_SAME_CALLS = "An unchanged block of the library stops no PLC, and depends only on its arguments."


@dataclass(frozen=True)
class Wishes:
    """The settings of a comparison.

    Attributes:
        outputs: Names of the outputs that count, with `*`; empty: the outputs of the programs.
        without: Names of outputs that do not count, with `*`.
        related: Names of variables of the new version, each with its name in the old version.
        scan_us: Scan period of the runs [us].
        limit_s: Time limit of each proof and each search [s].
        out: Folder for the stimulus file and the charts.
        runs: The number of random runs.
        scans: The number of scans of a random run.
        seed: The seed of the random runs.
        tell: A function that is called with progress messages.
    """

    outputs: Sequence[str] = ()
    without: Sequence[str] = ()
    related: Mapping[str, str] = field(default_factory=dict)
    scan_us: int = 10_000
    limit_s: float = 60.0
    out: Path = Path("out/prove")
    runs: int = 20
    scans: int = 200
    seed: int = 1
    tell: Callable[[str], None] = lambda _: None


@dataclass(frozen=True)
class Ran:
    """The result of a run on the built-in engine.

    `values` has the values of all parts of the outputs after each scan, by name. `error` stopped
    the program in the scan after the last one of `values`.
    """

    values: tuple[Mapping[str, Any], ...]
    error: InputError | None = None


@dataclass(frozen=True)
class Comparison:
    """The result for all outputs, the names of the inputs, and the number of random runs."""

    results: list[Result]
    inputs: list[str]
    drawn: int = 0


class PairBench(Protocol):
    """The interface to the surroundings of the programs, and to the engine."""

    @property
    def name(self) -> str:
        """Return the name of the command, for messages."""

    @property
    def library(self) -> Library:
        """Return the requirements of the library and the facts known about it."""

    def surroundings(self, project: Project) -> Surroundings:
        """Return the surroundings of a program, or raise InputError."""

    def blame(self, error: InputError) -> InputError:
        """Return an error in the sources, with a hint if the given library is incomplete."""

    def images(self, around: Surroundings) -> list[str]:
        """Return the names of the variables of the process image that a program writes."""

    def run(self, run: Run, side: int, around: Surroundings, names: Sequence[str]) -> Ran:
        """Run the old version (side 0) or the new one on the built-in engine."""

    def write(
        self, run: Run, around: Sequence[Surroundings], out: Path, about: str, watched: str
    ) -> tuple[str, tuple[str, str]]:
        """Write the stimulus file of a run; return its path, and the commands that replay it.

        The commands belong to the old and to the new version, and show the output `watched`.
        """


def compare(
    sources: tuple[SourceFiles, SourceFiles], wishes: Wishes, bench: PairBench
) -> Comparison:
    """Compare the old version of a program with the new one.

    Raises:
        InputError: The sources have an error, or a name of the wishes does not exist.
    """
    old, new = (
        _version(title, one, bench) for title, one in zip(("old", "new"), sources, strict=True)
    )
    images = [name for version in (old, new) for name in bench.images(version.around)]
    outputs = outputs_of(old, new, images, wishes.outputs, wishes.without)
    related = {
        path_of(new.project, name)[0]: path_of(old.project, before)[0]
        for name, before in wishes.related.items()
    }
    try:
        return _Comparing(Pair((old, new), outputs, related), wishes, bench).result()
    except RecursionError:
        raise too_deep(sources[1].all) from None


def _version(title: str, sources: SourceFiles, bench: PairBench) -> Version:
    own, library = sources.users
    try:
        files = [in_dialect(file, sources.dialect) for file in own]
        project = load([*files, *library])
        refuse(project.uses, bench.name, TRANSLATED)
    except InputError as error:
        raise bench.blame(error) from None
    except RecursionError:
        raise too_deep(sources.all) from None
    return Version(title, project, bench.surroundings(project), frozenset(map(str, own)))


class _Comparing:
    """A comparison with its open and decided outputs."""

    def __init__(self, pair: Pair, wishes: Wishes, bench: PairBench) -> None:
        self._pair, self._wishes, self._bench = pair, wishes, bench
        self._results = {name: Result(name, f"{name} is the same") for name in pair.outputs}
        self._results[_STOPS] = Result(_STOPS, "both versions stop in the same scans")
        self._open = dict.fromkeys(self._results)
        self._drawn = 0
        self._begin = time.monotonic()

    def result(self) -> Comparison:
        """Try all methods, and return the results."""
        runs = [run for one in self._pair.versions for run in one.project.schedule]
        several = any(run.every > 1 for run in runs)
        known = unchanged(*self._pair.versions)
        if several:
            self._note("no proof for several task intervals")
        else:
            self._try(lambda: self._induction(known, invariants=False))
        short, long = self._wishes.scan_us, max(self._wishes.scan_us, _LONG_US)
        self._try(lambda: self._search(short, _FIRST, 0.2))
        if not several:
            self._try(lambda: self._induction(known, invariants=True))
        self._random()
        if known and not several:
            self._try(lambda: self._induction(frozenset(), invariants=True))
        self._try(lambda: self._search(long, _SCANS, 0.5))
        self._try(lambda: self._search(short, _SCANS, 0.5))
        for name in self._open if self._drawn else ():
            one = self._results[name]
            text = f"{self._drawn} random runs of {self._wishes.scans} scans show no difference"
            self._results[name] = replace(one, note=f"{one.note}; {text}")
        results = list(self._results.values())
        inputs = [one.name for one in self._pair.inputs()]
        return Comparison(results, inputs, self._drawn)

    def _try(self, way: Callable[[], None]) -> None:
        """Run a method on the open outputs; note the reason if a construct is unsupported."""
        try:
            if self._open:
                way()
        except UnsupportedError as error:
            self._note(f"not decided: {error}")

    def _note(self, text: str) -> None:
        for name in self._open:
            one = self._results[name]
            self._results[name] = replace(one, note=one.note or text)

    def _induction(self, known: frozenset[str], *, invariants: bool) -> None:
        self._wishes.tell(
            "one scan from any related states"
            + (": the programs alone" if known else ": the programs with the library")
            + (", with invariants" if invariants else "")
        )
        end = time.monotonic() + self._wishes.limit_s
        way = Induction(self._pair, known, self._bench.library.milliseconds, end)
        proved = way.prove(invariants=invariants)
        assumes = (*_ASSUMES, _SAME_CALLS) if known else _ASSUMES
        for name, path in self._pair.outputs.items():
            if path in proved and name in self._open:
                self._close(name, status=PROVED, assumes=assumes)
        if way.stops_alike and _STOPS in self._open:
            self._close(_STOPS, status=PROVED, assumes=assumes)
        self._note("one scan from related states can make it different; no run is known")

    def _close(self, name: str, **given: Any) -> None:
        del self._open[name]
        seconds = time.monotonic() - self._begin
        self._results[name] = replace(self._results[name], **{"note": "", **given}, seconds=seconds)

    def _search(self, scan_us: int, scans: int, share: float) -> None:
        """Unroll scan after scan, and look for a run with another open output in the last scan."""
        end = time.monotonic() + self._wishes.limit_s * share
        going = PairSearch(self._pair, scan_us, self._bench.library.milliseconds, end)
        while going.scans < scans and time.monotonic() < end and self._open:
            self._wishes.tell(f"runs of {going.scans + 1} scans of {scan_us / 1000:g} ms")
            differs = going.scan()
            for name in list(self._open):
                condition = differs["" if name == _STOPS else name]
                if name not in self._open or condition is False:
                    continue
                try:
                    run = going.find(condition, max(end - time.monotonic(), 0.001))
                except SearchEndedError:
                    continue
                if run is not None and not self._shown(run):
                    note = "the solver has a run that differs, but the engine's runs are the same"
                    self._results[name] = replace(self._results[name], note=note)
            going.proceed()

    def _random(self) -> None:
        """Run both versions with random inputs until each open output has differed."""
        for number in range(self._wishes.runs):
            if not self._open:
                return
            self._wishes.tell(f"random run {number + 1} of {self._wishes.runs}")
            # Every second run has long scans, which reach events that take seconds.
            scan_us = max(self._wishes.scan_us, _LONG_US) if number % 2 else self._wishes.scan_us
            seed = f"{self._wishes.seed}.{number}"
            run = drawn_run(self._pair, scan_us, self._wishes.scans, seed)
            self._drawn += 1
            self._shown(run)

    def _shown(self, run: Run) -> bool:
        """Run both versions, and record each open output that differs; return whether one does."""
        names = list(self._pair.outputs)
        old, new = (
            self._bench.run(run, side, version.around, names)
            for side, version in enumerate(self._pair.versions)
        )
        found: dict[str, tuple[int, str]] = {}
        for number, (before, after) in enumerate(zip(old.values, new.values, strict=False)):
            for part, value in after.items():
                name = next(n for n in names if _is_part(part, n))
                if name in self._open and name not in found and repr(before[part]) != repr(value):
                    found[name] = (number, f"{part} is {value}, not {before[part]}")
        ends = [len(one.values) if one.error is not None else None for one in (old, new)]
        if ends[0] != ends[1] and _STOPS in self._open:
            end = min(one for one in ends if one is not None)
            side = ends.index(end)
            error, title = (old, new)[side].error, self._pair.versions[side].title
            found[_STOPS] = (end, f"only the {title} version stops: {error}")
        for name, (number, text) in found.items():
            self._refuted(name, replace(run, steps=run.steps[: number + 1]), number, text)
        return bool(found)

    def _refuted(self, name: str, run: Run, number: int, text: str) -> None:
        about = f"{name} differs in the last scan: {text}".replace("\n", " ")
        around = [one.around for one in self._pair.versions]
        watched = name if name != _STOPS else next(iter(self._pair.outputs))
        stimulus, commands = self._bench.write(run, around, self._wishes.out, about, watched)
        scans = "1 scan" if number == 0 else f"{number + 1} scans"
        note = f"after {scans} of {run.scan_us / 1000:g} ms: {text}"
        self._close(
            name,
            status=REFUTED,
            stimulus=stimulus,
            command=commands[1],
            note=f"{note}\n  old version: {commands[0]}",
        )


def _is_part(part: str, name: str) -> bool:
    return part == name or part.startswith((f"{name}.", f"{name}["))
