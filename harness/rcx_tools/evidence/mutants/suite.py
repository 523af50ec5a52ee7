"""The tests that judge mutants. They are collected once and stay in memory."""

from __future__ import annotations

import os
import shutil
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import _lru_cache_wrapper
from gc import get_objects
from itertools import zip_longest
from pathlib import Path
from typing import Any, cast

import pytest
from _pytest.runner import runtestprotocol

__all__ = [
    "FOLDERS",
    "Suite",
    "exhaustive_of",
    "forget_benches",
    "in_suite",
    "private_folder",
    "pytest_options",
    "remove_folders",
    "settle_hypothesis",
    "spread",
]

#: Folders with tests that run blocks of the library.
FOLDERS = (
    *("area", "sequence", "command", "motion", "position", "points", "operator", "diagnosis"),
    *("faults", "chapters", "examples"),
    "tools/library",
)
#: Tests with these parts in their names are left out. They are about the network, other engines, or
#: test tools.
_OTHERS = (
    *("[enip", "-enip", "over_ethernet_ip", "matiec", "strucpp"),
    *("test_fault_runner", "test_files.py"),
)
#: Number of fault runs for each block. It is small, because fault runs are long.
_FAULT_RUNS = 3


def spread(items: Sequence[str], most: int) -> list[str]:
    """Return at most `most` of the items, evenly spread, including the first."""
    if len(items) <= most:
        return list(items)
    return [items[k * len(items) // most] for k in range(most)]


def exhaustive_of(items: Iterable[pytest.Item]) -> set[str]:
    """Return the identifiers of the tests that `make test` leaves out."""
    return {item.nodeid for item in items if item.get_closest_marker("exhaustive")}


def in_suite(nodes: Sequence[str]) -> list[str]:
    """Return the node identifiers of the collected tests that judge mutants."""
    plain = [node for node in nodes if not any(word in node for word in _OTHERS)]
    faults: dict[str, list[str]] = {}
    for node in plain:
        if "/faults/" in node and "[" in node:
            faults.setdefault(node.partition("[")[2].partition("-")[0], []).append(node)
    left_out = {
        node
        for nodes in faults.values()
        for node in nodes
        if node not in spread(nodes, _FAULT_RUNS)
    }
    return [node for node in plain if node not in left_out]


def forget_benches(tests: Path) -> None:
    """Clear the caches of the tests, so that each child process makes new benches."""
    folder = str(tests)
    for found in [item for item in get_objects() if isinstance(item, _lru_cache_wrapper)]:
        code = getattr(getattr(found, "__wrapped__", None), "__code__", None)
        if code is not None and code.co_filename.startswith(folder):
            found.cache_clear()


@dataclass
class Suite:
    """The collected tests.

    Attributes:
        items: Tests by node identifier, in the order of collection.
    """

    root: Path
    items: dict[str, pytest.Item] = field(default_factory=dict)
    body: Callable[[], None] | None = None

    def collected(self, body: Callable[[], None]) -> int:
        """Collect the tests, then run `body` within the session; return pytest's exit code."""
        self.body = body
        tests = [str(self.root / "tests" / folder) for folder in FOLDERS]
        there = [folder for folder in tests if Path(folder).is_dir()]
        return int(pytest.main([*pytest_options(self.root), *there], plugins=[_Plugin(self)]))

    def run(self, nodes: Iterable[str]) -> str | None:
        """Run tests one after the other until a test fails. Return the failed test, or None."""
        items = [self.items[node] for node in nodes]
        for item, following in zip_longest(items, items[1:]):
            if not self.passes(item, following):
                return item.nodeid
        return None

    @staticmethod
    def passes(item: pytest.Item, following: pytest.Item | None) -> bool:
        """Run one test, and return whether it passes. A skipped test counts as passed."""
        reports = runtestprotocol(item, log=False, nextitem=following)
        return not any(report.failed for report in reports)

    def timed(self, node: str) -> tuple[bool, float]:
        """Run one test alone. Return whether it passes, and its processor time [s]."""
        start = time.process_time()
        passed = self.passes(self.items[node], None)
        return passed, time.process_time() - start


def pytest_options(root: Path) -> list[str]:
    """Return options of pytest for a repository: quiet, and without a cache."""
    return [
        *("-s", "-p", "no:cacheprovider", "-p", "no:terminal", "-p", "no:xdist"),
        *("--rootdir", str(root), "-c", str(root / "pyproject.toml")),
        *("-o", "addopts=--strict-markers --import-mode=importlib"),
    ]


def settle_hypothesis() -> None:
    """Make hypothesis use the same examples in every run, without a database."""
    from hypothesis import Phase, settings  # hypothesis is installed only together with the tests

    phases = (Phase.explicit, Phase.generate)
    settings.register_profile(
        "mutants", database=None, derandomize=True, deadline=None, phases=phases
    )
    settings.load_profile("mutants")


class _Plugin:
    """Plugin that passes the collected tests to the suite and suppresses the text of reports."""

    def __init__(self, suite: Suite) -> None:
        self._suite = suite

    def pytest_configure(self, config: pytest.Config) -> None:
        del config
        settle_hypothesis()

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        wanted = set(in_suite([item.nodeid for item in session.items]))
        self._suite.items = {item.nodeid: item for item in session.items if item.nodeid in wanted}
        assert self._suite.body is not None
        self._suite.body()
        return True

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> pytest.TestReport:
        outcome: Any = "passed"
        longrepr: Any = None
        if call.excinfo is not None:
            skipped = call.excinfo.errisinstance(pytest.skip.Exception)
            outcome = "skipped" if skipped else "failed"
            if skipped:
                longrepr = (str(item.path), 0, "skipped")
        return pytest.TestReport(
            item.nodeid, item.location, {}, outcome, longrepr, cast(Any, call.when)
        )


def private_folder(config: pytest.Config, name: str) -> None:
    """Give this process its own base folder for the temporary folders of its tests."""
    factory = getattr(config, "_tmp_path_factory", None)
    base = getattr(factory, "_basetemp", None)
    if factory is not None and base is not None:
        os.makedirs(base / name, exist_ok=True)
        factory._basetemp = base / name  # noqa: SLF001 - pytest has no public way


def remove_folders(config: pytest.Config) -> None:
    """Remove the temporary folders of all child processes."""
    base = getattr(getattr(config, "_tmp_path_factory", None), "_basetemp", None)
    if base is not None:
        for folder in base.glob("mutant*"):
            shutil.rmtree(folder, ignore_errors=True)
