"""The code that each test of a run has executed; a subclass counts the code."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import Any

import pytest

__all__ = ["PerTest"]


class PerTest(ABC):
    """Notes for each test whether it passes, its processor time [s], and the code it has run.

    Code of a shared fixture counts for each test that uses it. Code before the first test counts
    for all tests.
    """

    def __init__(self) -> None:
        self._seen: set[Any] = set()
        self._always: set[Any] = set()
        self._shared: dict[int, set[Any]] = {}
        self.passed: dict[str, bool] = {}
        self.seconds: dict[str, float] = {}
        self.seen: dict[str, set[Any]] = {}

    @abstractmethod
    def take(self) -> set[Any]:
        """Return the code that has run since the last call."""

    def begin(self) -> None:  # noqa: B027 - not all need it
        """Prepare for the next test."""

    def end(self) -> None:  # noqa: B027 - not all need it
        """Finish the records of the current test."""

    def pytest_collection_finish(self) -> None:
        """Record the code that has run before the first test."""
        self._always = self.take()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        """Run a test, and record its processor time and the code that it has run."""
        self._seen = set()
        self.take()
        start = time.process_time()
        self.begin()
        try:
            done = yield
        finally:
            self.end()
        self.seconds[item.nodeid] = time.process_time() - start
        self._seen |= self.take() | self._always
        info = getattr(item, "_fixtureinfo", None)
        for definitions in info.name2fixturedefs.values() if info else ():
            for one in definitions:
                self._seen |= self._shared.get(id(one), set())
        self.seen[item.nodeid] = self._seen
        return done

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Any:
        """Set up a fixture; if tests share it, its code counts for all of them."""
        outside, self._seen = self._seen | self.take(), set()
        try:
            return (yield)
        finally:
            inside = self._seen | self.take()
            if fixturedef.scope != "function":
                self._shared[id(fixturedef)] = inside
            self._seen = outside | inside

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record whether a phase (set-up, call, tear-down) of a test has failed."""
        so_far = self.passed.get(report.nodeid, True)
        self.passed[report.nodeid] = so_far and not report.failed
