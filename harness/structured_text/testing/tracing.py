"""What each test of a run has executed, whatever it is that counts it."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from typing import Any

import pytest

__all__ = ["PerTest"]


class PerTest(ABC):
    """Notes per test whether it passes, its processor time [s], and what it has run.

    What a fixture runs that several tests share counts for each of them; what has run before the
    first test counts for all.
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
        """What has run since this was asked last."""

    def begin(self) -> None:  # noqa: B027 - not all need it
        """A test begins."""

    def end(self) -> None:  # noqa: B027 - not all need it
        """It has ended."""

    def pytest_collection_finish(self) -> None:
        """All tests are loaded."""
        self._always = self.take()

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Any:
        """Run a test."""
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
        """Make a fixture; where tests share it, the others run it, too."""
        outside, self._seen = self._seen | self.take(), set()
        try:
            return (yield)
        finally:
            inside = self._seen | self.take()
            if fixturedef.scope != "function":
                self._shared[id(fixturedef)] = inside
            self._seen = outside | inside

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Note what came of a part of it."""
        so_far = self.passed.get(report.nodeid, True)
        self.passed[report.nodeid] = so_far and not report.failed
