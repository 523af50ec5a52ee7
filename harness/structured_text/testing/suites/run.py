"""The run of all suites of a program, in virtual time, with their results."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from typing import Any

from structured_text.bench import Bench
from structured_text.engines.builtin.objects import handed_back
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.output.paths import real
from structured_text.output.units import format_us, parse_us
from structured_text.projects.sources import SourceFiles
from structured_text.testing.suites.framework import Framework
from structured_text.testing.suites.mocks import Mocks
from structured_text.testing.suites.results import Case, Failure, Place, Results, Suite

__all__ = ["LONGEST", "run_suites"]

#: Default virtual time after which the run ends although some suites have not finished.
LONGEST = "10m"

#: Number of scans in which a program has to call its suites for the first time.
_FIRST_SCANS = 100
#: Name of the test for asserts that a suite makes before its first test.
_NO_TEST = "(before the first test)"
#: Name of the test for errors of a suite that occur outside its tests.
_OUTSIDE = "(outside of the tests)"
#: Number of failures of a test that are recorded. A test in a loop may fail without limit.
_MOST_FAILURES = 100
#: Number of messages of the program that are recorded.
_MOST_MESSAGES = 1000


def run_suites(
    files: SourceFiles,
    framework: Framework,
    *,
    scan: str | None = None,
    longest: str = LONGEST,
    only: Sequence[str] = (),
    progress: Callable[[float], None] = lambda share: None,
) -> Results:
    """Run all suites of a program until they have finished.

    Args:
        files: The sources of the program, without those of the framework.
        framework: The framework of its suites.
        scan: Period of the scan. By default it is the configuration's tick, or 10 ms.
        longest: Virtual time after which the run ends although some suites have not finished.
        only: Names of tests, suites, or `suite.test`, with `*`; only these tests run.
        progress: Called with the share of finished suites, from 0 to 1.

    Raises:
        InputError: The sources contain an error, there is no suite, no program runs the suites, or
            `only` selects no test.
    """
    limit_us = parse_us(longest)
    if not limit_us:
        raise InputError(
            "a run of 0 s finishes no test", hint=f"give at least a scan, as {LONGEST}"
        )
    sources, titles = framework.added_to(files)
    with Bench.build(sources, scan=scan, engine="builtin", keep=1) as bench:
        program = bench.program
        assert isinstance(program, BuiltinProgram)
        run = _Run(bench, program, framework, only, titles)
        mocks = Mocks(program, run.path)
        answers = mocks.answers(framework.words)
        answers |= {framework.note: run.note, framework.selected: run.selected}
        run.end_of_test = mocks.end
        with (
            program.answering(answers),
            program.guarding([framework.call], run.suite_called),
            program.guarding(_methods(program.project, framework), run.method_called),
        ):
            run.until(limit_us, progress)
    run.check_selection()
    return run.results


@dataclass
class _Seen:
    """How often a failure has occurred: in the last cycle, and in the cycle with most failures."""

    cycle: int = 0
    number: int = 0
    most: int = 0


@dataclass
class _Run:
    """The state of a run; the program calls `note` and `selected`."""

    bench: Bench
    program: BuiltinProgram
    framework: Framework
    only: Sequence[str]
    titles: Mapping[str, str]
    end_of_test: Callable[[], None] = lambda: None
    results: Results = field(init=False)
    _seen: dict[tuple[Any, ...], _Seen] = field(default_factory=dict)
    _matched: set[str] = field(default_factory=set)
    _begun_in_method: int = 0
    _ended: dict[tuple[int, str], int] = field(default_factory=dict)

    def __post_init__(self) -> None:
        names = self.framework
        if not self.program.project.global_symbols.get(names.count.upper()):
            raise self._no_suite()
        count = self.program.read(names.count)
        if not count:
            raise self._no_suite()
        self._paths = self.program.read(names.suites)[:count]
        suites: dict[str, Suite] = {}
        for path in self._paths:
            name = self._name(path)
            suites.setdefault(name, Suite(name))
        self.results = Results(list(suites.values()))
        self._suites = [suites[self._name(path)] for path in self._paths]
        self._current = self.program.reader([names.current])
        self._test = self.program.reader([names.test])
        self._flags = self.program.reader([names.done, names.aborted, names.started])

    def _name(self, path: str) -> str:
        """Return the shown path of a suite.

        Without a configuration, the path begins with the name of the program.
        """
        instances = self.program.instances()
        root, _, rest = path.partition(".")
        shown = self.titles.get(f"{instances[root].name}.{rest}" if root in instances else path)
        if shown is not None:
            return shown
        if len(instances) == 1 and not self.program.project.configured and rest:
            return f"{instances[root].name}.{rest}"
        return path

    def _no_suite(self) -> InputError:
        hint = "declare one in a program, as a variable"
        return InputError(
            f"there is no instance of a block that extends {self.framework.suite}", hint=hint
        )

    # --- the scans ---

    def until(self, limit_us: int, progress: Callable[[float], None]) -> None:
        """Run scans until all suites have finished, something ends the run, or the time is over."""
        bench, results = self.bench, self.results
        while True:
            try:
                bench.scan()
            except InputError as error:
                self._broken(error)
                break
            finally:
                results.scans = bench.scans
                results.duration_us = bench.now_us
            done, aborted, started = self._flags()
            if done:
                break
            if aborted:
                results.ended = "a wrong call has ended the run"
                break
            if not started and bench.scans >= _FIRST_SCANS:
                raise InputError(
                    f"no program has called {' or '.join(self.framework.run)} in "
                    f"{bench.scans} scans, so no suite runs",
                    hint="call it in a program that a task runs",
                )
            if bench.next_us >= limit_us:
                results.ended = (
                    f"given up after {bench.scans} scans ({format_us(limit_us)} of virtual time); "
                    "--for gives more"
                )
                break
            if bench.scans % 256 == 0:
                progress(bench.now_us / limit_us)

    def _broken(self, error: InputError) -> None:
        """End the run because of an error at run time outside the suites."""
        self.results.ended = f"the program has ended with an error: {error}"

    def check_selection(self) -> None:
        """Raise InputError if `only` has a name that no test or suite matches."""
        if missing := [name for name in self.only if name not in self._matched]:
            raise InputError(
                f"--only {missing[0]}: no test or suite of this name has begun",
                hint="write it as Suite, Test or Suite.Test, with * for any characters",
            )

    # --- calls of the program ---

    def selected(self, name: str) -> bool:
        """Return whether a test of the current suite is to run."""
        if not self.only:
            return True
        suite = self._suite().name
        short = suite.rpartition(".")[2]
        names = [name, suite, short, f"{suite}.{name}", f"{short}.{name}"]
        found = [one for one in self.only if _matches(names, one)]
        self._matched.update(found)
        return bool(found)

    def note(self, event: str, name: str, expected: str, actual: str, message: str) -> bool:
        """Record an event of the current suite."""
        if event == "log":
            if len(self.results.messages) < _MOST_MESSAGES:
                self.results.messages.append(message)
            return True
        suite = self._suite()
        key = self._key(name or _NO_TEST)
        test = suite.tests.get(key)
        if test is None:
            now = self.bench.now_us
            test = suite.tests[key] = Case(name or _NO_TEST, self._place(), now)
            test.ended_us = None if name else now
        if event == "skip":
            test.skipped = True
        elif event == "finish":
            test.ended_us = self.bench.now_us
            self.end_of_test()
        elif event == "assert":
            test.asserts += 1
        elif event == "fail":
            self._fail(test, expected, actual, message)
        elif event == "again":
            note = f"{suite.name}: there are several tests {name}; only the first one counts"
            if note not in self.results.notes:
                self.results.notes.append(note)
        elif event == "unknown":
            text = f"a test that the suite does not have has been finished: {message}"
            test.failures.append(Failure(self._place(), text, None, "", self.bench.now_us))
        return True

    # --- errors at run time ---

    def suite_called(self, name: str, first: Any, call: Callable[[], Any]) -> Any:
        """Run the call of a suite.

        An error ends this suite, and is recorded for the current test.
        """
        self._begun_in_method = 0
        try:
            return call()
        except InputError as error:
            suite = self._suite()
            test = self._erring()
            if test is None or test.ended_us is not None:
                test = suite.tests.setdefault(_OUTSIDE, Case(_OUTSIDE, None, self.bench.now_us))
            self._record(test, error)
            for other in suite.tests.values():
                if other.unfinished:
                    why = f"has not finished, because an error has ended the suite: {error.message}"
                    self._record(other, InputError(why))
            return False

    def method_called(self, name: str, instance: Any, call: Callable[[], Any]) -> Any:
        """Run a method of a suite; an error ends its test, and the method is not called again."""
        key = id(instance), name
        if (number := self._ended.get(key)) is not None:
            if number:  # asserts after the call also belong to the failed test
                self.program.write(self.framework.test, number)
                self.program.write(self.framework.failed, True)
            return False
        before = self._test()[0]
        try:
            return call()
        except InputError as error:
            number = self._test()[0]
            of_test = number != before or (number != 0 and number != self._begun_in_method)
            self._ended[key] = number if of_test else 0
            if of_test:
                if (test := self._erring()) is not None:
                    self._record(test, error)
                self.program.write(self.framework.failed, True)
            else:
                title = name.rpartition(".")[2]
                new = Case(title, None, self.bench.now_us)
                self._record(self._suite().tests.setdefault(f"method {title}", new), error)
            return False
        finally:
            if self._test()[0] != before:
                self._begun_in_method = self._test()[0]

    def _erring(self) -> Case | None:
        """Return the test that is being called; None without a test, or if it is not selected."""
        number: int = self._test()[0]
        if not number:
            return None
        found = self.program.read(f"{self.path()}.{self.framework.tests}[{number}]")
        return None if found["Skipped"] else self._suite().tests.get(self._key(found["Name"]))

    def _record(self, test: Case, error: InputError) -> None:
        """End a test with an error."""
        place = Place(error.file, error.line or 1) if error.file else None
        if place is None or str(real(place.file)) in self.framework.files:
            place = test.place
        test.failures.append(Failure(place, error.message, None, "", self.bench.now_us))
        test.place = test.place or place
        if test.ended_us is None:
            test.ended_us = self.bench.now_us
        self.end_of_test()

    def _fail(self, test: Case, expected: str, actual: str, message: str) -> None:
        """Record a failed assert, unless the same assert has failed in an earlier cycle."""
        failure = Failure(self._place(), message, expected, actual, self.bench.now_us)
        key = id(test), failure.place, expected, actual, message
        seen = self._seen.setdefault(key, _Seen())
        if seen.cycle != self.bench.scans:
            seen.cycle, seen.number = self.bench.scans, 0
        seen.number += 1
        if seen.number > seen.most:
            seen.most = seen.number
            if len(test.failures) < _MOST_FAILURES:
                test.failures.append(failure)

    def _key(self, name: str) -> str:
        """Return a key that identifies a test; tests of a TEST file may have the same name."""
        return f"{self.path()} {name}" if self.titles else name

    def _suite(self) -> Suite:
        number: int = self._current()[0]
        return self._suites[number - 1]

    def path(self) -> str:
        """Return the path of the suite that is being called."""
        number: int = self._current()[0]
        return str(self._paths[number - 1])

    def _place(self) -> Place | None:
        """Return the file and line of the innermost running statement outside the framework."""
        for file, line in self.program.running():
            if str(real(file)) not in self.framework.files:
                return Place(str(file), line)
        return None


def _matches(names: Sequence[str], pattern: str) -> bool:
    return any(fnmatchcase(name.lower(), pattern.lower()) for name in names)


def _methods(project: Project, framework: Framework) -> list[str]:
    """Return the methods of suites that the program declares, by `Block.Method`."""
    objects = project.objects
    suites = objects.derived(framework.suite.upper())
    return [
        method.name
        for suite in suites
        for method in objects.own[suite].values()
        if not handed_back(method)
    ]
