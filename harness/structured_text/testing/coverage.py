"""Coverage in a run of pytest.

Each process counts. With pytest-xdist the controller merges the counts of its workers.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from shutil import get_terminal_size
from typing import Any

import pytest

from structured_text.coverage.output import check_fail_under, check_folder, conclude
from structured_text.coverage.parts import Part, merge, part_of
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.errors import COMMAND, InputError
from structured_text.testing import COVERAGE, LIBRARIES
from structured_text.testing.settings import is_on, project

__all__ = ["Gathering", "start"]

_KEY = f"{COMMAND}_coverage"
_FOLDER = "out/coverage"


class Gathering(ABC):
    """Hooks of pytest that count in this process and collect the counts of xdist's workers.

    `collector` counts in this process until the run ends.
    """

    def __init__(self, config: pytest.Config, collector: Collector) -> None:
        self._collector = collector
        self._parts: list[Part] = []
        self._lost: list[str] = []
        stack = ExitStack()
        stack.enter_context(counting(collector))
        config.add_cleanup(stack.close)
        config.pluginmanager.register(self, f"{_KEY}-{type(self).__name__}")

    @pytest.hookimpl(optionalhook=True)
    def pytest_testnodedown(self, node: Any) -> None:
        """Collect the counts of an xdist worker that has ended; a crashed worker has none."""
        part = (getattr(node, "workeroutput", None) or {}).get(_KEY)
        if part is None:
            self._lost.append(f"worker {node.gateway.id}")
        else:
            self._parts.append(json.loads(part))

    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """In a worker, send the counts to the controller; in the controller, write the report."""
        part = part_of(self._collector)
        output = getattr(session.config, "workeroutput", None)
        if output is not None:
            output[_KEY] = json.dumps(part)
        elif not session.config.option.collectonly:
            self.report(session, [*self._parts, part], self._lost)

    @abstractmethod
    def report(self, session: pytest.Session, parts: list[Part], lost: list[str]) -> None:
        """Report the merged counts of all processes, and the workers that have died."""


@dataclass(frozen=True)
class _Settings:
    library: bool
    folder: Path
    fail_under: float | None


class _Coverage(Gathering):
    """The coverage of the user's sources."""

    def __init__(self, config: pytest.Config, settings: _Settings) -> None:
        collector = Collector(library=settings.library)
        for library in LIBRARIES:
            collector.leave_out(library())
        super().__init__(config, collector)
        self._settings = settings
        self._text = ""

    def report(self, session: pytest.Session, parts: list[Part], lost: list[str]) -> None:
        """Write the report; fail a run that has passed if the coverage is too low."""
        try:
            outcome = conclude(
                merge(parts),
                project(session.config),
                self._settings.folder,
                fail_under=self._settings.fail_under,
                lost=lost,
                width=get_terminal_size((100, 24)).columns,
            )
        except InputError as error:
            self._text, passed = f"{COMMAND}: {error}", False
        else:
            self._text, passed = outcome.text, outcome.passed
        if not passed and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print the table of coverage."""
        if self._text:
            terminalreporter.section(f"{COMMAND} coverage")
            terminalreporter.write_line(self._text)


def start(config: pytest.Config) -> None:
    """Start counting if the settings demand it; raise UsageError for a wrong setting."""
    try:
        settings = _settings(config)
    except InputError as error:
        raise pytest.UsageError(f"{COMMAND}: {error}") from None
    if settings is not None:
        _Coverage(config, settings)


def _settings(config: pytest.Config) -> _Settings | None:
    if not is_on(config, "coverage"):
        for name in COVERAGE:
            if config.getoption(f"{COMMAND}_{name}") is not None:
                option = f"--{COMMAND}-{name.replace('_', '-')}"
                raise InputError(
                    f"{option}: no coverage is counted", hint=f"add --{COMMAND}-coverage"
                )
        return None
    given, named = config.getoption(f"{_KEY}_out"), config.getini(f"{_KEY}_out")
    if given is not None:
        folder = config.invocation_params.dir / str(given)
    else:
        folder = project(config) / str(named or _FOLDER)
    check_folder(folder)
    option, key = f"--{COMMAND}-cover-fail-under", f"{COMMAND}_cover_fail_under"
    percent = config.getoption(key)
    if percent is None:
        percent, option = config.getini(key) or None, key
    return _Settings(
        is_on(config, "coverage_library"),
        folder,
        None if percent is None else check_fail_under(option, percent),
    )
