"""The results of the unit tests of a run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

__all__ = ["Case", "Failure", "Place", "Results", "Suite"]


@dataclass(frozen=True)
class Place:
    """A line of a source file, from 1."""

    file: str
    line: int

    def __str__(self) -> str:
        """Return `file:line`."""
        return f"{self.file}:{self.line}"


@dataclass(frozen=True)
class Failure:
    """An assert that has failed, or an error that has ended the test.

    Attributes:
        place: The statement; None if it is unknown.
        text: The message of the assert, or the error.
        expected: The expected value; None for an error.
        actual: The actual value.
        t_us: Virtual time of the scan [us].
    """

    place: Place | None
    text: str
    expected: str | None
    actual: str
    t_us: int

    @property
    def message(self) -> str:
        """Return expected and actual value with the message, or the error."""
        if self.expected is None:
            return self.text
        values = f"expected {self.expected}, actual {self.actual}"
        return f"{values}: {self.text}" if self.text else values


@dataclass
class Case:
    """A test of a suite.

    Attributes:
        name: Name of the test.
        place: The statement that began the test; None if it is unknown.
        began_us: Virtual time at which the test began [us].
        ended_us: Virtual time at which the test finished [us]; None if it has not finished.
        asserts: Number of asserts that counted.
        failures: The failed asserts, and an error that ended the test.
        skipped: Whether the test is disabled.
    """

    name: str
    place: Place | None
    began_us: int
    ended_us: int | None = None
    asserts: int = 0
    failures: list[Failure] = field(default_factory=list)
    skipped: bool = False

    @property
    def unfinished(self) -> bool:
        """Return whether the test has begun but not finished."""
        return self.ended_us is None and not self.skipped

    @property
    def passed(self) -> bool:
        """Return whether the test has finished without a failure."""
        return not (self.failures or self.unfinished or self.skipped)

    @property
    def duration_us(self) -> int:
        """Return the virtual time from the beginning to the end of the test [us]."""
        return (self.began_us if self.ended_us is None else self.ended_us) - self.began_us


@dataclass
class Suite:
    """A suite: the path of its instance, and its tests in the order in which they began."""

    name: str
    tests: dict[str, Case] = field(default_factory=dict)


@dataclass
class Results:
    """The results of a run.

    Attributes:
        suites: All suites, in the order of their declaration.
        notes: One line for each fact that deserves attention but is not a failure.
        messages: What the program has logged, in order.
        scans: Number of scans.
        duration_us: Virtual time of the run [us].
        ended: The reason why the run ended before all suites had finished; empty if they had.
    """

    suites: list[Suite]
    notes: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    scans: int = 0
    duration_us: int = 0
    ended: str = ""

    def tests(self) -> Iterator[tuple[Suite, Case]]:
        """Yield all tests with their suites."""
        for suite in self.suites:
            for test in suite.tests.values():
                yield suite, test

    def count(self, what: str) -> int:
        """Return the number of tests for which the property `what` of `Case` is true."""
        return sum(bool(getattr(test, what)) for _, test in self.tests())

    @property
    def passed(self) -> bool:
        """Return whether all suites have finished, and no test has failed."""
        return not self.ended and all(test.passed or test.skipped for _, test in self.tests())
