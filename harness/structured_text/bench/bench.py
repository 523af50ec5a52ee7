"""A bench: one program on an engine, with one virtual clock."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Any, ClassVar, NamedTuple, NoReturn, TypeVar, cast

from structured_text.bench.agenda import SCAN, STIMULUS, Agenda, Duration, scan_us
from structured_text.bench.compiled import Compiled
from structured_text.bench.events import EVENTS, checked
from structured_text.bench.outputs import check_outputs
from structured_text.bench.plc import Plc
from structured_text.bench.samples import KEPT, Sample, Trace
from structured_text.bench.watched import Watched
from structured_text.engines.base import Program, Value
from structured_text.errors import InputError, Violation
from structured_text.output.units import format_us, parse_us, whole
from structured_text.projects.sources import Files, SourceFiles, source_files

__all__ = ["Bench", "BenchTimeout"]

#: A time, or a number of scans, that is greater than in any run.
_NEVER = sys.maxsize
#: Upper limits for a number of scans, and for a delay of a scan in microseconds.
_MOST_SCANS, _LONGEST_US = 10**10, 365 * 86_400_000_000

_Self = TypeVar("_Self", bound="Bench")


class BenchTimeout(AssertionError):  # noqa: N818 - a failed assertion, not a fault of the bench
    """The condition that a test waited for did not become true in time."""


class _ClosedProgram:
    """The stand-in for the program of a closed bench, after its memory has been freed."""

    def __init__(self, error: Callable[[], InputError]) -> None:
        self._error = error

    def __getattr__(self, name: str) -> NoReturn:
        raise self._error()


class _Snapshot(NamedTuple):
    program: object
    agenda: Any
    plc: Any
    trace: Any
    counts: tuple[int, int, int]


class Bench:
    """A PLC program in virtual time, without any device around it.

    Build it with `Bench.build`. Everything before `now_us` has happened. Subclasses add the devices
    around the program.
    """

    place: ClassVar[str] = "bench"
    """The name of this kind of bench in messages."""
    late: ClassVar[type[BenchTimeout]] = BenchTimeout
    """The error that `run_until` raises."""

    def __init__(
        self,
        program: Program,
        scan_us: int,
        *,
        watched: Watched,
        trace: Trace[Any],
        plc: Plc,
        first_us: int = 0,
        notice: str = "",
        mistakes: Sequence[str] = (),
        agenda: Agenda | None = None,
        leave: Callable[[], None] | None = None,
    ) -> None:
        self.program = program
        self.closed = False
        """Whether `close` has been called."""
        self._notice, self._leave = notice, leave or program.close
        self.mistakes = mistakes
        """The warnings about the source of the program, one line each.

        `notice` contains them as well.
        """
        self.now_us = 0
        self.scans = 0
        self.violations: list[Violation] = []
        """All broken rules so far, in order of time."""
        self._watch, self.trace = watched, trace
        self._agenda = Agenda() if agenda is None else agenda
        self._agenda.repeat(first_us, SCAN, scan_us, self._scan)
        self._scan_us, self._first_us = scan_us, first_us
        self.plc = plc
        """The state of the PLC: STOP or RUN, its power, and the variables that survive a start."""
        self._wanted = False

    @classmethod
    def build(
        cls,
        program: Files | SourceFiles,
        *,
        lib: str | Path | None = None,
        scan: Duration | None = None,
        engine: str = "auto",
        trace: str | Path | None = None,
        watch: str | Sequence[str] = (),
        replace: Mapping[str, str | Path] | None = None,
        dialect: str | None = None,
        device: str = "",
        keep: int = KEPT,
    ) -> Bench:
        """Compile a program and put it onto a bench.

        Args:
            program: One ST file or project file, or several, or a folder.
            lib: Folder of a library; the bench adds the library files that the program needs.
            scan: Period of the scan. By default it is the configuration's tick, or 10 ms without
                tasks.
            engine: `"auto"`, `"matiec"`, `"builtin"` or `"strucpp"`.
            trace: File for the trace; it replaces the trace of an earlier run.
            watch: Variables that the trace shows in every scan: paths, or patterns with `*`.
            replace: ST files for POUs of a project, by the POU's name.
            dialect: The PLC tool whose behaviour the program gets. By default it is the dialect of
                the project's format, or plain Structured Text.
            device: The device to read of a project with several devices.
            keep: Number of trace records in memory; each snapshot contains them.

        Raises:
            InputError: The sources or the arguments have an error.
        """
        whole("keep", keep, 0, sys.maxsize)
        files = program
        if not isinstance(files, SourceFiles):
            library = None if lib is None else Path(lib)
            files = source_files(files, library, replace, dialect, device)
        check_outputs({"trace": trace}, files)
        compiled = Compiled.take(files, engine)
        try:
            made = compiled.program
            period_us = scan_us(scan if scan is not None else made.tick_us or "10ms")
            made.pace(period_us)
            watched = Watched(made, watch)
            header = {"scan_us": period_us, "engine": made.engine}
            return cls(
                made,
                period_us,
                watched=watched,
                trace=Trace(header, trace, keep=keep, watched=watched.types),
                plc=Plc(made, compiled.retained),
                notice=compiled.notice,
                mistakes=compiled.mistakes,
                leave=compiled.leave,
            )
        except BaseException:
            compiled.leave()
            raise

    # --- variables ---------------------------------------------------------------------------

    def __getitem__(self, path: str) -> Value:
        """Return the value of a variable, as in `bench["Main.Motor.Done"]`."""
        return self.program.read(path)

    def __setitem__(self, path: str, value: Value) -> None:
        """Set a variable between two scans."""
        self.program.write(path, value)
        self.plc.note(path)

    def watched(self) -> dict[str, str]:
        """Return the watched variables by path, each as Structured Text writes it.

        Structures and arrays appear as their members and elements. After `close` the method returns
        the values at the end of the run.
        """
        return self._watch.texts()

    # --- time --------------------------------------------------------------------------------

    def scan(self, n: int = 1) -> None:
        """Run `n` more scans.

        Raise InputError if `n` is not a number of scans, or no scan can run because the PLC is in
        STOP or has no power.
        """
        goal = self.scans + whole("the number of scans", n, 0, _MOST_SCANS)
        self._wanted = True
        try:
            self._pass(_NEVER, goal)
        finally:
            self._wanted = False

    def run(self, duration: Duration) -> None:
        """Advance time by `duration`: everything before `now + duration` happens."""
        end = self.now_us + parse_us(duration)
        self._pass(end)
        self.now_us = end

    def run_until(self, predicate: Callable[[], bool], within: Duration) -> int:
        """Scan until `predicate()` is true; evaluate it now and after every scan.

        Returns:
            The time that passed, in microseconds.

        Raises:
            BenchTimeout: The predicate did not become true within this time.
            InputError: `predicate` is not a function.
        """
        if not callable(predicate):
            hint = f'write run_until(lambda: {self.place}["Main.Done"], within="1s")'
            raise InputError(f"run_until needs a function, not {predicate!r:.40}", hint=hint)
        start = self.now_us
        end = start + parse_us(within)
        while not predicate():
            goal = self.scans + 1
            self._pass(end + 1, goal)
            if self.scans < goal:
                self.now_us = end
                raise self.late(self._timeout_text(end - start))
        return self.now_us - start

    @contextmanager
    def takes(self, *, scans: int) -> Iterator[None]:
        """Assert that the body of the `with` takes exactly `scans` scans."""
        whole("scans", scans, 0, _MOST_SCANS)
        before = self.scans
        yield
        took = self.scans - before
        assert took == scans, (
            f"took {took} scans, expected {scans} (until scan {self.scans}, "
            f"{format_us(self.now_us)})"
        )

    # --- surroundings ------------------------------------------------------------------------

    def inject(self, event: str, **args: Any) -> None:
        """Trigger one of `events.EVENTS` now.

        Raises:
            InputError: There is no such event, or it does not take these arguments.
        """
        if event not in EVENTS:
            raise InputError(f"unknown event {event!r}", hint=f"use {', '.join(EVENTS)}")
        checked(EVENTS, event, args)(self, 1)

    def stop_plc(self, *, power: bool = False) -> None:
        """Put the PLC into STOP, or switch its power off. No scan runs until `start_plc`."""
        self.plc.stop(power=power)

    def start_plc(self, start: str = "warm") -> None:
        """Put the PLC into RUN; restart it if it runs already.

        `start` is `"warm"` to reset all variables except retained ones, `"cold"` to reset all
        variables, or `"continue"` to reset none.
        """
        checked(EVENTS, "plc_run", {"start": start})
        self.plc.start(start)

    def overrun(self, late_us: int) -> None:
        """Delay the next scan and all later ones by `late_us` microseconds."""
        self._agenda.delay(SCAN, whole("late_us", late_us, 0, _LONGEST_US))

    def at(self, t_us: int, action: Callable[[], None]) -> None:
        """Call `action` at `t_us`, before all other events of this time."""
        whole("t_us", t_us, 0, _NEVER)
        if t_us < self.now_us:
            raise InputError(
                f"{format_us(t_us)} is in the past: the time is {format_us(self.now_us)}"
            )
        self._agenda.add(t_us, STIMULUS, lambda _: action())

    @property
    def notice(self) -> str:
        """Return the notices about the chosen engine and the network; empty if there are none."""
        return "\n".join(filter(None, (self._notice, self._agenda.notice)))

    @contextmanager
    def trying(self) -> Iterator[None]:
        """Undo all changes of variables at the end of the `with`; no time passes inside."""
        before = self.program.snapshot()
        try:
            yield
        finally:
            self.program.restore(before)

    def ends_scan(self, record: object) -> bool:
        """Return whether a trace record is the first record of a scan."""
        return isinstance(record, Sample)

    @property
    def next_us(self) -> int:
        """Return the planned time of the next scan, without a delay by `overrun`."""
        return self._first_us + self.scans * self._scan_us

    # --- state -------------------------------------------------------------------------------

    def snapshot(self) -> Any:
        """Return the state of everything: program, time, and the devices around the program."""
        return _Snapshot(
            self.program.snapshot(),
            self._agenda.snapshot(),
            self.plc.snapshot(),
            self.trace.snapshot(),
            (self.now_us, self.scans, len(self.violations)),
        )

    def restore(self, snapshot: Any) -> None:
        """Restore the state from a `snapshot` of this bench."""
        assert isinstance(snapshot, _Snapshot), f"not a snapshot of a {self.place}"
        self.program.restore(snapshot.program)
        self._agenda.restore(snapshot.agenda)
        self.plc.restore(snapshot.plc)
        self.trace.restore(snapshot.trace)
        self.now_us, self.scans, found = snapshot.counts
        del self.violations[found:]

    def close(self) -> None:
        """Write out the trace, then free the program and the devices around it.

        Afterwards the trace and `violations` can still be read; time, variables and snapshots raise
        `InputError`.
        """
        if self.closed:
            return
        self._watch.keep()
        self.trace.close()
        self._part()
        self._leave()
        self.closed = True
        self.program = cast(Program, _ClosedProgram(self._closed))

    def _part(self) -> None:
        """Shut down the devices around the program.

        Subclasses with devices override this method.
        """

    def _closed(self) -> InputError:
        """Return the error for an operation on a closed bench."""
        hint = "read and scan before close(), inside the `with`"
        return InputError(f"the {self.place} is closed", hint=hint)

    def __enter__(self: _Self) -> _Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    # --- what happens ------------------------------------------------------------------------

    def _pass(self, end: int, scans: int = _NEVER) -> None:
        """Process all events before `end`, or until `scans` scans have run."""
        agenda = self._agenda
        while self.scans < scans:
            if self.closed:
                raise self._closed()
            if agenda.first()[0] >= end:
                return
            self.now_us, action = agenda.pop()
            action(self.now_us)

    def _scan(self, now: int) -> None:
        if not self.plc.runs:
            if self._wanted:
                hint = f"use {self.place}.run(), or schedule plc_run or plc_power_on"
                raise InputError("the PLC is not in RUN, so no scan can run", hint=hint)
            return
        self._before_scan(now)
        self.program.scan(now)
        number, self.scans = self.scans, self.scans + 1
        self._after_scan(now, number, self._watch.values() if self._watch.types else None)
        if found := self.plc.judge(now, number):
            self.report(found)

    def _before_scan(self, now: int) -> None:
        """Pass the inputs from the devices to the program.

        Subclasses with devices override this method.
        """

    def _after_scan(self, now: int, number: int, watched: dict[str, Any] | None) -> None:
        """Add the scan to the trace. Subclasses also pass the program's outputs to the devices."""
        self.trace.add(Sample(now, number, watched))

    def report(self, found: Iterable[Violation]) -> None:
        """Add broken rules to `violations` and to the trace."""
        for violation in found:
            self.violations.append(violation)
            self.trace.add(violation)

    def _timeout_text(self, waited_us: int) -> str:
        text = f"not within {format_us(waited_us)} (scan {self.scans}, {format_us(self.now_us)})"
        for path, value in self._watch.values().items():
            text += f"; {path} = {value}"
        if self.violations:
            text += f"; last violation: {self.violations[-1].text}"
        return "\n".join((text, *self.mistakes))
