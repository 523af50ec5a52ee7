"""A run of pytest for the command `mutants`, with the original program or with a mutant.

The command `mutants` puts the name of an order file into the environment. The order file says what
this run must do and where it writes the result. Output files of the user's options go to a
temporary folder.
"""

from __future__ import annotations

import gc
import socket
from collections.abc import Iterable
from contextlib import ExitStack
from functools import partial
from importlib import import_module
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest

from structured_text.coverage.listing import Text, listing
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.errors import COMMAND
from structured_text.language.parser import parse
from structured_text.mutants.order import Order
from structured_text.output.system import copied, copy_ended
from structured_text.projects.sources import INSTEAD
from structured_text.testing import LIBRARIES
from structured_text.testing.tracing import PerTest

__all__ = ["start"]

#: Options of other plugins for output files, which would overwrite those of the user's own runs.
_OUTPUTS = ("xmlpath", "htmlpath", "json_report_file", "allure_report_dir", "logfile")


def start(config: pytest.Config, order_file: Path) -> None:
    """Execute an order in this run of pytest."""
    order = Order.read(order_file)
    _place_outputs(config, order)
    # No worker processes of xdist: one process must see all tests.
    if hasattr(config.option, "numprocesses"):
        config.option.numprocesses, config.option.dist, config.option.tx = None, "no", []
    # Import by name, since the package has a function of the same name.
    chooser: Any = import_module("structured_text.engines.load")
    chooser.find_matiec = lambda *_: None
    _settle_hypothesis()
    if order.port:
        config.pluginmanager.register(_Server(order))
    elif order.tests is None:
        config.pluginmanager.register(_Original(config, order))
    else:
        INSTEAD.update(order.instead)
        config.option.maxfail = 1
        config.pluginmanager.register(_Mutant(order))


def _place_outputs(config: pytest.Config, order: Order) -> None:
    """Redirect or disable all output files, so that nothing is written into the user's folders."""
    for name in _OUTPUTS:
        if hasattr(config.option, name):
            setattr(config.option, name, None)
    setattr(config.option, f"{COMMAND}_artifacts", str(order.folder / "artifacts"))


def _settle_hypothesis() -> None:
    """Make hypothesis try the same examples in every run, and store none."""
    try:
        from hypothesis import Phase, settings
    except ImportError:
        return
    phases = (Phase.explicit, Phase.generate)
    steady: dict[str, Any] = {"database": None, "derandomize": True, "deadline": None}
    settings.register_profile(COMMAND, phases=phases, **steady)
    settings.load_profile(COMMAND)


class _Original(PerTest):
    """Notes which statements of the sources each test executes, and which tests fail."""

    def __init__(self, config: pytest.Config, order: Order) -> None:
        super().__init__()
        self._order, self._root = order, config.rootpath
        self._collector = Collector(library=False)
        for library in LIBRARIES:
            self._collector.leave_out(library())
        self._why: list[str] = []
        stack = ExitStack()
        stack.enter_context(counting(self._collector))
        config.add_cleanup(stack.close)

    def take(self) -> set[Any]:
        """Return the counters that have changed since the last call, each by its POU and index."""
        found: set[Any] = set()
        for number, one in enumerate(self._collector.counted):
            counters = one.counts.counters
            if any(counters):
                found |= {(number, place) for place, count in enumerate(counters) if count}
                counters[:] = [0] * len(counters)
        return found

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Record that a test has failed, with the reason."""
        super().pytest_runtest_logreport(report)
        if report.failed:
            crash = getattr(report.longrepr, "reprcrash", None)
            message = getattr(crash, "message", "") or str(report.longrepr or "")
            self._why.append(message.strip().partition("\n")[0])

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Record that a file of tests cannot be loaded."""
        if report.failed:
            self.passed[report.nodeid or "the tests"] = False
            self._why.append("it cannot be collected")

    def pytest_sessionfinish(self) -> None:
        """Write the executed statements and the failed tests to the result file."""
        lines: list[dict[int, set[int]]] = []
        listed: dict[str, set[int]] = {}
        for one in self._collector.counted:
            own: dict[int, set[int]] = {}
            text = Text(Path(one.file), one.sources)
            for point in listing(one.pou, one.plan, text).statements:
                own.setdefault(point.counter, set()).add(point.line)
            lines.append(own)
            listed.setdefault(one.file, set()).update(*own.values())
        ran: dict[str, dict[str, list[int]]] = {}
        for node, seen in self.seen.items():
            files: dict[str, set[int]] = {}
            for number, counter in seen:
                found = lines[number].get(counter, ())
                files.setdefault(self._collector.counted[number].file, set()).update(found)
            ran[node] = {file: sorted(found) for file, found in files.items()}
        content = {
            "root": str(self._root),
            "passed": self.passed,
            "why": self._why[:1],
            "seconds": self.seconds,
            "ran": ran,
            "listed": {file: sorted(found) for file, found in listed.items()},
            "elsewhere": sorted(self._collector.elsewhere),
        }
        self._order.answer(content)


class _Mutant:
    """Runs the tests of the order up to the first failure, and reports the result."""

    def __init__(self, order: Order) -> None:
        self._order = order
        self._failed: str | None = None

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Remove the tests that the order does not name."""
        items[:] = wanted(self._order, items)

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        """Report the first failure."""
        if report.failed:
            self._fail(report.nodeid)

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        """Report that a file of tests cannot be loaded."""
        if report.failed:
            self._fail(f"{report.nodeid} cannot be collected")

    def pytest_sessionfinish(self) -> None:
        """Report that no test failed."""
        if self._failed is None:
            self._order.answer({"failed": None})

    def _fail(self, node: str) -> None:
        if self._failed is None:
            self._failed = node
            self._order.answer({"failed": node})


def wanted(order: Order, items: Iterable[pytest.Item]) -> list[pytest.Item]:
    """Return the tests that the order names, in its order."""
    places = {node: place for place, node in enumerate(order.tests or ())}
    return sorted(
        (item for item in items if item.nodeid in places), key=lambda item: places[item.nodeid]
    )


class _Server:
    """Collects the tests once, and executes each incoming order in a copy of this process."""

    def __init__(self, order: Order) -> None:
        self._order = order

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        """Execute orders until the command `mutants` closes the connection."""
        for file in self._order.sources:
            parse(file)  # fill the parser's cache, which each copy of the process inherits
        gc.collect()
        gc.freeze()
        with socket.create_connection(("127.0.0.1", self._order.port)) as connection:
            lines = connection.makefile("rwb", buffering=0)
            while line := lines.readline():
                order = Order.read(Path(line.decode().strip()))
                pid = copied(partial(_in_copy, session, order), order.seconds)
                copy_ended(pid)
                lines.write(b"done\n")
        return True


def _in_copy(session: pytest.Session, order: Order) -> None:
    """Run the tests of a mutant in this copy of the process."""
    config = session.config
    _place_outputs(config, order)
    factory: Any = getattr(config, "_tmp_path_factory", None)
    if factory is not None:
        factory._basetemp = order.folder / "tests"  # noqa: SLF001 - pytest has no other way
        factory._basetemp.mkdir()  # noqa: SLF001
    INSTEAD.update(order.instead)
    mutant = _Mutant(order)
    config.pluginmanager.register(mutant)
    items = wanted(order, session.items)
    for item, following in zip_longest(items, items[1:]):
        config.hook.pytest_runtest_protocol(item=item, nextitem=following)
        if order.answered() is not None:
            return
    mutant.pytest_sessionfinish()
