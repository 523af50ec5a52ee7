"""The pytest plugin: fixtures `cell`, `robot` and `rcx_build` for tests of a PLC project.

pytest loads this module in every run of an environment that has the package. Therefore this module
imports the harness only when a test uses a fixture. docs/how-to/testing.md is the user's page.
"""

from __future__ import annotations

from argparse import ArgumentTypeError
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rcx_harness.testing import LISTS, OPTIONS, VALUES
from structured_text.testing import COVERAGE, LIBRARIES
from structured_text.testing import plugin as toolkit
from structured_text.testing.plugin import add_options, check_keys, is_set, order

__all__ = ["cell", "rcx_build", "rcx_machine", "robot"]

if TYPE_CHECKING:
    from rcx_harness.cell import Cell
    from rcx_harness.robot import Controller
    from rcx_harness.testing.cells import Build, Cells

_CELLS: pytest.StashKey[Cells] = pytest.StashKey()

_MARKERS = (
    "rcx(scan=, robot=, ...): build this test's cell otherwise; takes what Cell.build takes",
    "allow_violations(*rules): broken rules do not fail this test; without names: none of them",
)


def pytest_addoption(parser: pytest.Parser, pluginmanager: pytest.PytestPluginManager) -> None:
    """Add the options `--rcx-...` and the keys `rcx_...` of the ini file."""
    parser.getgroup("rcx", "virtual robot cell (rcx-harness)")
    types: dict[str, dict[str, Any]] = {"scan": {"type": _duration}}
    add_options(parser, {name: {**one, **types.get(name, {})} for name, one in OPTIONS.items()})
    LIBRARIES.add(_library)
    # pytest calls the hooks of plugins registered later first. The toolkit is registered here,
    # before the other hooks of this plugin, so that the hooks of this plugin are called first.
    if not pluginmanager.is_registered(toolkit):
        pluginmanager.register(toolkit, toolkit.__name__)
    for name, text in LISTS.items():
        parser.addini(f"rcx_{name}", text, type="linelist", default=[])
    for name, text in VALUES.items():
        parser.addini(f"rcx_{name}", text, default=None)


@pytest.hookimpl(tryfirst=True)
def pytest_configure(config: pytest.Config) -> None:
    """Register the markers, and check the plugin's settings if the user has set any."""
    for marker in _MARKERS:
        config.addinivalue_line("markers", marker)
    check_keys(config, [f"rcx_{name}" for name in (*OPTIONS, *COVERAGE, *LISTS, *VALUES)])
    if order() is None and _in_use(config):
        from rcx_harness.testing.settings import check_settings

        check_settings(config)


def pytest_report_header(config: pytest.Config) -> str | None:
    """Return the line for pytest's report header: version, engine, link, seed."""
    if not _in_use(config):
        return None
    from rcx_harness.testing.settings import header

    return header(config)


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Fail the test if a marker allows a rule that does not exist."""
    for marker in item.iter_markers("allow_violations"):
        from rcx_harness.testing.settings import wrong_marker

        wrong = wrong_marker(marker)
        if wrong:
            pytest.fail(f"rcx: {wrong}", pytrace=False)


@pytest.fixture
def rcx_build(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Build]:
    """Return a function that builds further cells. It takes the arguments of the marker `rcx`."""
    from rcx_harness.testing.cells import Cells

    cells = Cells(request.node, tmp_path_factory)
    request.node.stash[_CELLS] = cells
    yield cells.build
    broken = cells.finish()
    if broken:
        pytest.fail(broken, pytrace=False)


@pytest.fixture
def cell(rcx_build: Build) -> Cell:
    """Return this project's PLC program with a virtual robot, at time 0; new for every test."""
    from structured_text.errors import InputError

    try:
        return rcx_build()
    except InputError as error:
        reason = f"rcx: {error}"
    # outside of `except`, because pytest would otherwise print two tracebacks
    pytest.fail(reason, pytrace=False)


@pytest.fixture
def robot(cell: Cell) -> Controller:
    """Return the virtual robot of `cell`."""
    return cell.robot


@pytest.fixture
def rcx_machine(request: pytest.FixtureRequest, tmp_path: Path) -> Callable[..., None]:
    """Return a function that runs hypothesis's state machine on a cell.

    The arguments of the function are files of demands, `machine=`, and settings of hypothesis such
    as `max_examples` and `stateful_step_count`.
    """
    from structured_text.errors import InputError

    def run(*demands: str, machine: Any = None, **settings: Any) -> None:
        try:
            from rcx_harness.testing.machine import run_machine
        except ModuleNotFoundError as error:
            if error.name != "hypothesis":
                raise
            pytest.fail("rcx: rcx_machine needs hypothesis; pip install hypothesis", pytrace=False)
        try:
            run_machine(request.node, demands, machine, settings, tmp_path)
        except InputError as error:
            reason = f"rcx: {error}"
        else:
            return
        pytest.fail(reason, pytrace=False)

    return run


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, Any, Any]:
    """Fail a test that has passed if its cells have broken a rule of the manual."""
    cells = item.stash.get(_CELLS, None)
    try:
        result = yield
    finally:
        broken = "" if cells is None else cells.broken()
    if broken:
        pytest.fail(broken, pytrace=False)
    return result


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Attach chart and trace to the report of a test that failed."""
    cells = item.stash.get(_CELLS, None)
    if cells is not None and call.excinfo is not None:
        from rcx_harness.testing.cells import shorten

        shorten(call.excinfo)
    report = yield
    if cells is not None:
        if report.failed:
            cells.attach(report)
        if call.when == "teardown":
            del item.stash[_CELLS]
    return report


def _duration(text: str) -> str:
    from structured_text.errors import InputError
    from structured_text.output.units import parse_us

    try:
        parse_us(text)
    except InputError as error:
        raise ArgumentTypeError(str(error)) from None
    return text


def _library() -> Path:
    from rcx_harness.cell.sources import default_lib

    return default_lib()


def _in_use(config: pytest.Config) -> bool:
    """Return whether the ini file or the command line has any setting of this plugin."""
    if is_set(config, (*OPTIONS, *COVERAGE)):
        return True
    return any(config.getini(f"rcx_{name}") for name in (*LISTS, *VALUES))
