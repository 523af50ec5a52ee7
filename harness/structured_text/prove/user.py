"""Proof of a user's program, and search for runs that break the properties that are not proved.

A property is tried in several ways. The first way is induction: one scan from an arbitrary state,
with arbitrary results of library calls (outline). Short searches from the start, induction with the
library's code, and longer searches follow. Invariants found automatically exclude unreachable
states before an induction. A run that is found is replayed on the built-in engine before it is
reported.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Protocol

import z3

from structured_text.errors import InputError, located
from structured_text.language.constructs import TRANSLATED, refuse
from structured_text.language.load import load, too_deep
from structured_text.language.project import Project
from structured_text.language.source import in_dialect
from structured_text.projects.sources import SourceFiles
from structured_text.prove.assertions import Copies, with_assertions
from structured_text.prove.invariants import Candidate, candidates, kept
from structured_text.prove.logic import PROVED, REFUTED, UNKNOWN, Bool, UnsupportedError
from structured_text.prove.naming import Names
from structured_text.prove.program import ProgramMachine
from structured_text.prove.properties import Key, Library, Watch, inner_written, title
from structured_text.prove.search import Counterexample, Search, SearchEndedError
from structured_text.prove.surroundings import Surroundings
from structured_text.prove.symbolic_memory import Path as Place
from structured_text.prove.values import TIME_BITS

__all__ = ["NOTED", "Bench", "Replayed", "Result", "Settings", "prove"]

#: Status of arithmetic that may leave its type, if the user does not treat an overflow as a fault.
NOTED = "noted"

#: A long scan period [us], with which a search of few scans reaches events that take seconds.
_LONG_US = 300_000
#: Highest number of scans of a search.
_SCANS = 400
#: Scans of the first search, which finds early violations with the user's own scan period.
_FIRST = 6
_SHOWN = 8
#: Kinds of obligations that do not stop an engine. No run can show that they are broken, so they
#: are proved or unknown.
_STOPS_NOTHING = ("conversion", "time", "overflow")

_INPUTS = "Nothing but the inputs is set from outside of the program."
_CLOCK = "The clock never runs backwards and counts less than 2^62 ns; a TIME has 64 bits."


@dataclass(frozen=True)
class Settings:
    """The settings of a proof.

    Attributes:
        scan_us: Scan period of the runs in a search [us].
        limit_s: Time limit for each property [s].
        out: Folder for stimulus files and charts.
        overflow: Whether arithmetic that may leave its type counts as a property like the others.
        tell: A function that is called with progress messages.
    """

    scan_us: int = 10_000
    limit_s: float = 60.0
    out: Path = Path("out/prove")
    overflow: bool = False
    tell: Callable[[str], None] = lambda _: None


@dataclass(frozen=True)
class Result:
    """The result for a property.

    Attributes:
        name: Kind and position of the property.
        says: The claim of the property, as a sentence.
        at: File and line, if the property has a position.
        status: `proved`, `refuted` or `unknown`; `noted` for arithmetic that may leave its type,
            unless `Settings.overflow` is set.
        seconds: Time spent on the property.
        assumes: The assumptions of the proof.
        stimulus: The stimulus file of a run that breaks the property.
        command: The command that replays that run.
        note: The reason why the property is unknown, with the state before the failing step; or a
            description of what is broken.
    """

    name: str
    says: str
    at: str = ""
    status: str = UNKNOWN
    seconds: float = 0.0
    assumes: tuple[str, ...] = ()
    stimulus: str = ""
    command: str = ""
    note: str = ""


@dataclass(frozen=True)
class Replayed:
    """The result of a run on the built-in engine.

    Attributes:
        scans: The number of scans that ran to their end.
        error: The error that stopped the program, or None.
        differences: Variables with other values than in the run that was found; empty if all agree.
        findings: The broken rules, as text.
    """

    scans: int
    error: InputError | None
    differences: tuple[str, ...]
    findings: tuple[str, ...]


class Bench(Protocol):
    """The interface to the surroundings of the programs, and to the engine for replays."""

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

    def replay(
        self,
        run: Counterexample,
        around: Surroundings,
        files: Sequence[Path],
        stimulus: Path,
        *,
        about: str,
        chart: Path,
    ) -> Replayed:
        """Write the stimulus file of a run, and run it on the built-in engine.

        `about` is the comment at the beginning of the file; `chart` is the path of the timing chart
        (SVG). Raise InputError if a file cannot be written, or exists already and was not written
        by a search.
        """

    def command(self, run: Counterexample, around: Surroundings, stimulus: Path) -> str:
        """Return the command with which a user can replay the run."""


def prove(sources: SourceFiles, settings: Settings, bench: Bench) -> tuple[list[Result], list[str]]:
    """Prove a program's properties; return the results and the names of its inputs.

    Raises:
        InputError: The sources have an error, or the program cannot be run.
    """
    own, library = sources.users
    with TemporaryDirectory() as folder:
        copies = with_assertions(own, Path(folder))
        try:
            copies = replace(
                copies, files=tuple(in_dialect(file, sources.dialect) for file in copies.files)
            )
            project = load([*copies.files, *library])
            refuse(project.uses, bench.name, TRANSLATED)
        except InputError as error:
            raise _told_of_original(bench.blame(error), copies) from None
        try:
            work = _Work(bench, copies, project, settings)
            return work.results(), [one.name for one in work.around.inputs]
        except RecursionError:
            raise too_deep(sources.all) from None


def _told_of_original(error: InputError, copies: Copies) -> InputError:
    asserted = any((one.file, one.line) == (error.file, error.line) for one in copies.assertions)
    return InputError(
        f"in the assertion: {error.message}" if asserted else error.message,
        file=copies.original(error.file) or None,
        line=error.line,
        column=None if asserted else error.column,
        hint=error.hint,
    )


@dataclass
class _Step:
    """A scan from an arbitrary state: the states around it, and when a property is broken."""

    machine: ProgramMachine
    before: Mapping[Place, Any]
    after: Mapping[Place, Any]
    broken: dict[Key, Bool]


@dataclass
class _Work:
    """The proof of one program, with its open and decided properties."""

    bench: Bench
    copies: Copies
    project: Project
    settings: Settings
    open: dict[Key, Result] = field(default_factory=dict)
    done: dict[Key, Result] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.around = self.bench.surroundings(self.project)
        self.watch = Watch(self.project, self.copies, self.bench.library)
        own = set(self.copies.originals)
        self.library = frozenset(
            pou.file for pou in self.project.pous.values() if pou.file not in own
        )
        self._spent: dict[Key, float] = {}
        self._operations: dict[Key, str] = {}
        self._searches: dict[int, Search] = {}

    def results(self) -> list[Result]:
        """Return the results of all properties, after all methods have been tried.

        A program with several task intervals is only searched, because induction needs scans that
        are all alike.
        """
        inner = [self._inner(self.bench.library.reference)] if self.bench.library.reference else []
        for key in self.watch.always:
            self.open[key] = self._named(key)
        several = any(run.every > 1 for run in self.project.schedule)
        if several:
            self._try(self._list_operations, finds=True)
            self._note(
                "no proof for several task intervals: only a search for runs that break a property"
            )
        else:
            self._try(lambda: self._induction(outline=True), finds=True)
        if not self.settings.overflow:
            self._only_note()
        short, long = self.settings.scan_us, max(self.settings.scan_us, _LONG_US)
        self._try(lambda: self._search(short, _FIRST, 0.3))
        if not several:
            self._try(lambda: self._induction(outline=False))
        self._try(lambda: self._search(long, _SCANS, 0.7))
        self._try(lambda: self._search(short, _SCANS, 1))
        every = {**self.done, **self.open}
        return [*inner, *(every[key] for key in sorted(every))]

    def _only_note(self) -> None:
        """Set the status of the remaining arithmetic properties to `noted`, and close them."""
        for key in [key for key in self.open if key[0] == "overflow"]:
            seconds = self._spent.get(key, 0.0)
            self.done[key] = replace(self.open.pop(key), status=NOTED, seconds=seconds)

    def _try(self, way: Callable[[], None], *, finds: bool = False) -> None:
        """Run one method on the open properties; note the reason if a construct is unsupported.

        A method that also `finds` properties runs even if no property is open yet. If it fails,
        operations may be missing from the results, so they have an unknown result of their own.
        """
        try:
            if self.open or finds:
                way()
        except UnsupportedError as error:
            note = f"not decided: {error}"
            if not self.open:
                every = Result("operations", "no statement stops the PLC", note=note)
                self.open["operations", "", 0] = every
            self._note(note)

    # --- properties of the source text ---

    def _inner(self, reference: str) -> Result:
        found = sorted(set(inner_written(self.project, self.copies, reference)))
        result = Result("inner", f"nothing is written into an {reference}", status=PROVED)
        if not found:
            return result
        places = [f"{located(self.copies.original(f), line)}: {name}" for f, line, name in found]
        note = "written: " + "; ".join(places[:_SHOWN])
        return replace(result, status=REFUTED, at=places[0].rpartition(":")[0], note=note)

    # --- induction ---

    def _induction(self, *, outline: bool) -> None:
        """Try to prove the open properties by induction over one scan.

        The scan starts from an arbitrary state in which the invariants hold. If no such scan breaks
        a property, no run does. With `outline`, calls of the library have arbitrary results, which
        keeps the terms small. If a scan breaks the property, its state may still be unreachable, so
        the property stays open.
        """
        how = "the program alone" if outline else "the program with the library"
        self.settings.tell(f"one scan from any state: {how}")
        step = self._any_scan(outline=outline)
        for key in step.broken:
            if key not in self.done and key not in self.open:
                self.open[key] = self._named(key)
        start = self._machine(outline=outline)
        self.around.start(start)
        tried = candidates(self.project, self.copies, {one.path for one in self.around.inputs})
        needed = any(
            self.open[key] and step.broken.get(key, False) is not False for key in self.open
        )
        limit = self.settings.limit_s / 4
        held: list[Candidate] = []
        if needed:
            memories = (step.machine, step.before, step.after)
            held = kept(tried, (start, start.snapshot()), memories, limit)
        for key in list(self.open):
            self._decide(key, step, held, outline=outline)

    def _list_operations(self) -> None:
        """Open a property for each operation that may stop the PLC, without a proof."""
        for key in self._any_scan(outline=True).broken:
            if key not in self.done and (key[0] != "overflow" or self.settings.overflow):
                self.open.setdefault(key, self._named(key))

    def _machine(self, *, outline: bool) -> ProgramMachine:
        milliseconds = self.bench.library.milliseconds
        return ProgramMachine(
            self.project, self.library, exact=False, outline=outline, milliseconds=milliseconds
        )

    def _any_scan(self, *, outline: bool) -> _Step:
        machine = self._machine(outline=outline)
        machine.until = time.monotonic() + self.settings.limit_s / 2
        machine.now = z3.BitVec("now", TIME_BITS)
        machine.assume(z3.And(machine.now >= 0, machine.now < 1 << 62))
        self.around.anything(machine)
        before = machine.snapshot()
        self.around.give(machine, 0, everything=True)
        # Scan 0 also runs the programs with a longer interval.
        self.around.scan(machine, 0)
        wraps = self.watch.wraps(machine)
        self._operations |= {key: text for key, (text, _) in wraps.items()}
        broken = self.watch.broken(machine, before)
        broken |= {key: when for key, (_, when) in wraps.items()}
        return _Step(machine, before, machine.snapshot(), broken)

    def _decide(self, key: Key, step: _Step, held: list[Candidate], *, outline: bool) -> None:
        broken, begin = step.broken.get(key, False), time.monotonic()
        of_library = self.bench.library.calls if outline else self.bench.library.counts
        assumes = (_INPUTS, _CLOCK, of_library) if of_library else (_INPUTS, _CLOCK)
        result = replace(self.open[key], assumes=assumes)
        if broken is False:
            self._proved(key, result)
            return
        solver = z3.SolverFor("QF_AUFBVFP")
        solver.set("timeout", max(int((self.settings.limit_s - self._spent.get(key, 0)) * 1000), 1))
        solver.add(*step.machine.assumptions)
        solver.add(*(one.of(lambda p: step.machine.term(p, step.before)) for one in held))
        solver.add(broken)
        found = solver.check()
        self._spent[key] = self._spent.get(key, 0.0) + time.monotonic() - begin
        if found == z3.unsat:
            self._proved(key, result)
        elif found == z3.sat:
            state = _state(solver.model(), broken, Names(step.machine, self.around))
            note = f"one scan breaks it from a state that may be unreachable: {state}"
            self.open[key] = replace(self.open[key], note=note)
        elif not self.open[key].note:
            self.open[key] = replace(self.open[key], note="not decided within the limit")

    def _proved(self, key: Key, result: Result) -> None:
        del self.open[key]
        self.done[key] = replace(result, status=PROVED, seconds=self._spent.get(key, 0.0), note="")

    def _named(self, key: Key) -> Result:
        kind, file, line = key
        at = located(self.copies.original(file), line) if file else ""
        says = title(key, self.copies)
        if key in self._operations:
            says += f": {self._operations[key]}"
        name = Path(self.copies.original(file)).name if file else ""
        return Result(f"{kind} {name}:{line}" if file else kind, says, at)

    def _note(self, text: str) -> None:
        for key, one in self.open.items():
            self.open[key] = replace(one, note=one.note or text)

    # --- search ---

    def _search(self, scan_us: int, scans: int, share: float) -> None:
        """Search for runs of up to `scans` scans that break a property, in a share of the time."""
        end = time.monotonic() + share * max(map(self._left, self.open))
        going = self._searches.pop(scan_us, None)
        milliseconds = self.bench.library.milliseconds
        going = going or Search(self.project, scan_us, self.around, self.library, milliseconds)
        going.machine.until = end
        self._deeper(going, scans, end)
        self._searches[scan_us] = going

    def _left(self, key: Key) -> float:
        return self.settings.limit_s - self._spent.get(key, 0.0)

    def _sought(self) -> list[Key]:
        """Return the open properties for which a search can find a run."""
        return [key for key in self.open if key[0] not in _STOPS_NOTHING]

    def _deeper(self, going: Search, scans: int, end: float) -> None:
        """Unroll scan after scan, and look for a run that breaks an open property in the last scan.

        The run must break only this property, because an engine would stop at another broken
        obligation first. After each scan its obligations are assumed to hold, because a run must
        reach the next scan.
        """
        while going.scans < scans and time.monotonic() < end and self._sought():
            begin = time.monotonic()
            before = going.machine.snapshot()
            number = going.scans
            names = ", ".join(self.open[key].name for key in self._sought()[:3])
            self.settings.tell(
                f"runs of {number + 1} scans of {going.scan_us / 1000:g} ms: {names}"
            )
            going.scan()
            found = self.watch.broken(going.machine, before)
            for key in self._sought():
                broken = found.get(key, False)
                if broken is False or time.monotonic() > end:
                    continue
                first = self.watch.alone(key, broken, going.machine)
                try:
                    run = going.find(first, min(self._left(key), end - time.monotonic()))
                except SearchEndedError:
                    continue
                if run is not None:
                    self._found(key, run)
            going.names += [z3.Not(one) for one in self.watch.stops(going.machine)]
            for key in self.open:
                self._spent[key] = self._spent.get(key, 0.0) + time.monotonic() - begin

    def _found(self, key: Key, run: Counterexample) -> None:
        """Replay a run that the solver found, and record the result.

        The property counts as refuted only if the run on the built-in engine also breaks it.
        Otherwise the translation is wrong; the result asks the user to report it.
        """
        result = self.open[key]
        name = result.name.replace(" ", "-").replace(":", "-")
        stimulus, chart = self.settings.out / f"{name}.toml", self.settings.out / f"{name}.svg"
        about = f"{result.says}: broken in the last scan" + (f" ({result.at})" if result.at else "")
        files = self.copies.files
        came = self.bench.replay(run, self.around, files, stimulus, about=about, chart=chart)
        del self.open[key]
        if not self._shows(key, came, len(run.steps)):
            why = "; ".join(came.differences[:_SHOWN]) or "the run shows no violation"
            note = f"THE TRANSLATION IS WRONG, please report it: {stimulus} breaks nothing: {why}"
            self.done[key] = replace(result, note=note, stimulus=str(stimulus))
        else:
            self.done[key] = replace(
                result,
                status=REFUTED,
                seconds=self._spent.get(key, 0.0),
                stimulus=str(stimulus),
                command=self.bench.command(run, self.around, stimulus),
                note=f"after {len(run.steps)} scans of {run.scan_us / 1000:g} ms",
            )

    def _shows(self, key: Key, came: Replayed, scans: int) -> bool:
        kind, file, line = key
        if kind in ("once", "steady"):
            said = "times in one scan" if kind == "once" else "though it is busy"
            return any(said in one for one in came.findings)
        return came.error is not None and (came.error.file, came.error.line) == (file, line)


def _state(model: Any, broken: Bool, names: Names) -> str:
    """Return the values of the variables that occur in the broken condition, as text."""
    found: dict[str, None] = {}
    waiting, seen = [] if isinstance(broken, bool) else [broken], set()
    while waiting and len(found) < _SHOWN:
        one = waiting.pop(0)
        if one.get_id() in seen:
            continue
        seen.add(one.get_id())
        if one.num_args():
            waiting += one.children()
        elif _is_value(one) and (text := names.told(model, one)):
            found[text] = None
    return ", ".join(found) or "any"


def _is_value(term: Any) -> bool:
    """Return whether a term is a variable of the solver and not an array."""
    named = z3.is_const(term) and term.decl().kind() == z3.Z3_OP_UNINTERPRETED
    return named and not z3.is_array(term)
