"""Fixtures and hooks for tests of several folders."""

from __future__ import annotations

import atexit
import gc
import itertools
import os
import random
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from run_report import left_out_line, repeat_line, skip_lines
from shown import hexadecimal_comparison
from tiers import keep_samples, without_engine
from toolkit_alone import toolkit_alone

if TYPE_CHECKING:
    from rcx_harness import Cell
    from structured_text.engines.matiec.build import Matiec

REPOSITORY = Path(__file__).resolve().parents[1]

if "PYTEST_XDIST_WORKER" in os.environ:
    # When this runs, a worker has already sent its results.
    # Freeing its objects one by one would take up to ten seconds, during which xdist waits.
    atexit.register(os._exit, 0)


#: The configurations of this process, beginning with the outermost.
_sessions: list[pytest.Config] = []
_LEFT_OUT: pytest.StashKey[int] = pytest.StashKey()
#: The reason of each test that is not run because an engine is not installed.
_NO_ENGINE: pytest.StashKey[list[str]] = pytest.StashKey()


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add the options of this repository's tests."""
    group = parser.getgroup("suite", "tests of this repository")
    group.addoption("--order", default="", help="`reverse`, or the seed of a random order")
    group.addoption(
        "--every-case", action="store_true", help="leave no case of tests/faults out (hours)"
    )
    text = "rcx_harness cannot be imported: for tests/structured_text, with -p no:rcx"
    group.addoption("--toolkit-alone", action="store_true", help=text)


def pytest_configure(config: pytest.Config) -> None:
    """Start the count of tests that markers leave out, and reset ignored signals."""
    config.stash[_LEFT_OUT] = 0
    config.stash[_NO_ENGINE] = []
    if config.option.toolkit_alone:
        if "rcx_harness" in sys.modules:
            raise pytest.UsageError("--toolkit-alone: rcx_harness is loaded; add -p no:rcx")
        toolkit_alone()
    if not _sessions:
        gc.disable()  # modules and tests stay until the exit, so the collector would free nothing
    _sessions.append(config)
    _let_children_hear_signals(is_worker=hasattr(config, "workerinput"))


def _let_children_hear_signals(*, is_worker: bool) -> None:
    """Replace ignored signals by handlers, which children do not inherit.

    A shell starts background jobs with SIGINT ignored, and `nohup` ignores SIGHUP. Every child
    inherits that, but the tests of these signals need children that do not ignore them. The
    handler of SIGHUP does nothing, so that the tests themselves still continue after `nohup`.
    """
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    hang_up = getattr(signal, "SIGHUP", None)  # Windows does not have SIGHUP
    if hang_up and (is_worker or signal.getsignal(hang_up) is signal.SIG_IGN):
        signal.signal(hang_up, lambda number, frame: None)


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Order the tests by `--order`, select samples, and skip tests that need external programs."""
    named = any("::" in argument for argument in config.args)
    keep_samples(items, whole=not named)
    if not named:  # a test that the user names is reported as skipped
        config.stash[_NO_ENGINE] = without_engine(items)
    order = config.getoption("order")
    if order == "reverse":
        items.reverse()
    elif order:
        random.Random(int(order)).shuffle(items)
    if "external" not in config.getoption("markexpr"):
        for item in items:
            if mark := item.get_closest_marker("external"):
                item.add_marker(pytest.mark.skip(reason=mark.kwargs["reason"]))


_folders = itertools.count()


@pytest.fixture
def tmp_path(tmp_path_factory: pytest.TempPathFactory, request: pytest.FixtureRequest) -> Path:
    """Return a new folder for a test.

    The fixture of pytest also moves a symbolic link to the newest folder of each name. That takes
    longer than many a test.
    """
    name = re.sub(r"\W", "_", request.node.name)[:30]
    return tmp_path_factory.mktemp(f"{name}{next(_folders)}", numbered=False)


def pytest_collection_finish() -> None:
    """Exclude existing objects from garbage collection, and let the collector run less often.

    Both changes together save a tenth of the time of the run.
    """
    gc.freeze()
    gc.set_threshold(200_000, 50, 100)
    gc.enable()


def pytest_deselected(items: Sequence[pytest.Item]) -> None:
    """Count the exhaustive tests that a run leaves out."""
    for item in items:
        if item.get_closest_marker("exhaustive"):
            item.config.stash[_LEFT_OUT] += 1


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Pass the counts of a worker process to the process that reports."""
    output = getattr(session.config, "workeroutput", None)
    if output is not None:
        output["left_out"] = session.config.stash[_LEFT_OUT]
        output["no_engine"] = session.config.stash[_NO_ENGINE]
    if session.config is _sessions[0]:  # skip a session that a test has started in this process
        gc.disable()
        gc.freeze()  # each collection at the exit would take more than a second


@pytest.hookimpl(optionalhook=True)
def pytest_testnodedown(node: Any, error: object) -> None:
    """Copy the counts of a worker process. All workers collect the same tests."""
    output = getattr(node, "workeroutput", None) or {}
    stash = node.config.stash
    stash[_LEFT_OUT] = output.get("left_out", stash[_LEFT_OUT])
    stash[_NO_ENGINE] = output.get("no_engine", stash[_NO_ENGINE])


def pytest_terminal_summary(
    terminalreporter: pytest.TerminalReporter, config: pytest.Config
) -> None:
    """Print the numbers of skipped and omitted tests, and the command that repeats a failure."""
    stats = terminalreporter.stats
    skipped = [report.longrepr[2] for report in stats.get("skipped", [])]
    no_engine: list[str] = config.stash[_NO_ENGINE]
    skipped += no_engine
    if skipped:
        terminalreporter.write_line("skipped:")
    for line in skip_lines(skipped):
        terminalreporter.write_line(line)
    if count := config.stash[_LEFT_OUT]:
        terminalreporter.write_line(left_out_line(count))
    failed = [*stats.get("failed", []), *stats.get("error", [])]
    if failed:
        terminalreporter.write_line(repeat_line(failed[0].nodeid))


def pytest_assertrepr_compare(op: str, left: object, right: object) -> list[str] | None:
    """Show codes, ErrorIDs and words of telegrams in hexadecimal, as in 16#8001."""
    return hexadecimal_comparison(op, left, right)


@pytest.fixture
def repository() -> Path:
    """Return the folder of the repository."""
    return REPOSITORY


@pytest.fixture(scope="session")
def matiec() -> Matiec:
    """Return the installed matiec, or skip the test if it is missing."""
    from structured_text.engines.matiec.build import MISSING, find_matiec
    from structured_text.engines.native.toolchain import find_c_compiler

    found = find_matiec()
    if found is None:
        pytest.skip(MISSING)
    if find_c_compiler() is None:
        pytest.skip("no C compiler: set CC or PATH")
    return found


@pytest.fixture
def build_cell() -> Iterator[Callable[..., Cell]]:
    """Return a function that builds cells with `Cell.build`, and closes them after the test."""
    from rcx_harness import Cell

    cells: list[Cell] = []

    def build(*args: Any, **options: Any) -> Cell:
        cells.append(Cell.build(*args, **options))
        return cells[-1]

    yield build
    for cell in cells:
        cell.close()


@pytest.fixture
def raw_cell(build_cell: Callable[..., Cell], tmp_path: Path) -> Callable[..., Cell]:
    """Return a function that builds cells whose program writes the area without the library."""
    program = REPOSITORY / "tests" / "cell" / "programs" / "RawArea.st"
    empty = tmp_path / "no-library"
    empty.mkdir()

    def build(**options: Any) -> Cell:
        return build_cell(program, lib=empty, **options)

    return build
