"""Temporary copies of the repository, in which tests run with one changed file.

Each child process discards the imported packages, and imports them again from its copy, together
with their tables and tests.
"""

from __future__ import annotations

import importlib
import os
import resource
import shutil
import sys
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from rcx_tools.evidence.mutants.suite import exhaustive_of, pytest_options, settle_hypothesis
from structured_text.errors import InputError
from structured_text.testing.tracing import PerTest

__all__ = ["Copies", "Traced"]

#: Packages that a child process imports from its copy.
_PACKAGES = ("rcx_harness", "rcx_tools", "structured_text")
#: Files that are not copied because no test needs them.
_LEFT_OUT = (".*", "out", "*.egg-info")
#: Number of test files that are collected first. If one of their tests fails, no other file is
#: collected.
_FEW = 3
#: Memory limit of a child process [byte]. A mutant with an endless loop may fill a list.
_MEMORY = 6 << 30


class Traced(PerTest):
    """Plugin that records for each test the result, processor time [s], and executed functions.

    A function is `(file, line)`: a file in `folder`, and the line where the function begins.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._folder = str(folder)
        self._codes: set[Any] = set()
        self.exhaustive: set[str] = set()

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Record the tests that `make test` leaves out."""
        self.exhaustive = exhaustive_of(items)

    def take(self) -> set[Any]:
        """Return the code that has been executed since the last call of this method."""
        codes, self._codes = self._codes, set()
        return codes

    def begin(self) -> None:
        """Start to record the functions that are called."""
        sys.settrace(self._call)

    def end(self) -> None:
        """Stop tracing."""
        sys.settrace(None)

    def _call(self, frame: FrameType, event: str, arg: object) -> None:
        self._codes.add(frame.f_code)

    @property
    def ran(self) -> dict[str, set[tuple[str, int]]]:
        """Return the functions that each test has executed."""
        return {node: {*self._functions(seen)} for node, seen in self.seen.items()}

    def _functions(self, codes: Iterable[Any]) -> Iterator[tuple[str, int]]:
        for code in codes:
            if code.co_filename.startswith(self._folder):
                yield code.co_filename, code.co_firstlineno


class _First:
    """Plugin that selects the wanted tests in the wanted order, and records the first failure."""

    def __init__(self, wanted: Sequence[str]) -> None:
        self._places = {node: place for place, node in enumerate(wanted)}
        self.failed: str | None = None

    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        items[:] = sorted((item for item in items if self._place(item) >= 0), key=self._place)

    def _place(self, item: pytest.Item) -> int:
        """Return the position of a test (or of its file) among the wanted tests, or -1."""
        file = item.nodeid.partition("::")[0]
        return self._places.get(item.nodeid, self._places.get(file, -1))

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed and self.failed is None:
            self.failed = report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed and self.failed is None:
            self.failed = f"{report.nodeid} cannot be collected"


class Copies:
    """Copies of a repository, under a folder that `close` removes.

    Args:
        root: The repository. It is not changed.

    Raises:
        InputError: the repository cannot be copied.
    """

    def __init__(self, root: Path) -> None:
        self._root = root.resolve()
        self._base = Path(tempfile.mkdtemp(prefix="mutants-"))
        self.original = self._base / "original"
        left_out = shutil.ignore_patterns(*_LEFT_OUT)
        try:
            shutil.copytree(root, self.original, ignore=left_out, symlinks=True)
        except OSError as error:  # shutil.Error is an OSError
            self.close()
            told = f"the repository cannot be copied to {self._base.parent}: {error}"
            raise InputError(told, hint="make room there, or set TMPDIR") from error
        import hypothesis  # noqa: F401  # once for all children

    def close(self) -> None:
        """Remove all copies of the repository."""
        shutil.rmtree(self._base, ignore_errors=True)

    def discard(self, pid: int) -> None:
        """Remove the copy of a child process that has ended."""
        shutil.rmtree(self._base / str(pid), ignore_errors=True)

    # --- in a child process ---

    def first_failure(
        self,
        changed: Mapping[str, str],
        nodes: Sequence[str],
        *,
        exhaustive: Collection[str] = (),
        regenerate: bool = False,
    ) -> str | None:
        """Run tests in a copy up to the first failure. Return the failed test, or another reason.

        Args:
            changed: Texts of changed files, by path in the repository.
            nodes: Tests or whole test files in the order in which they run. A test that does not
                exist any more counts as passed.
            exhaustive: Tests that run after all others.
            regenerate: Whether to regenerate the generated files of plc/lib.
        """
        # Quick tests run before exhaustive ones, and a few files before the rest. If a test in
        # these files fails, all other files are not collected. Each child process has its own copy:
        # files are hard links, and only changed files are written.
        quick = [node for node in nodes if node not in exhaustive]
        own = self._base / str(os.getpid())
        with suppress(OSError, ValueError):  # some systems have no memory limit
            resource.setrlimit(resource.RLIMIT_AS, (_MEMORY, _MEMORY))
        shutil.copytree(self.original, own, copy_function=_linked, symlinks=True)
        for path, text in changed.items():
            _write(own / path, text)
        self._enter(own)
        try:
            if regenerate:
                _regenerate(own)
            for tier in (quick, [node for node in nodes if node not in quick]):
                files = list(dict.fromkeys(node.partition("::")[0] for node in tier))
                for part in (files[:_FEW], files[_FEW:]):
                    wanted = [node for node in tier if node.partition("::")[0] in part]
                    if wanted:
                        first = _First(wanted)
                        code = _pytest(own, part, first, ["-x"])
                        if first.failed or code not in (pytest.ExitCode.OK, _NO_TESTS):
                            return first.failed or "the tests cannot be started"
        except Exception as error:
            return f"nothing runs: {type(error).__name__}"
        return None

    def traced(self, files: Collection[str], read: Callable[[Traced], None]) -> None:
        """Run test files in an unchanged copy, and call `read` with the records."""
        self._enter(self.original)
        sys.dont_write_bytecode = False
        traced = Traced(self.original / "harness")
        _pytest(self.original, sorted(files), traced, [])
        read(traced)

    def _enter(self, copy: Path) -> None:
        """Switch this process to a copy.

        Later imports come from the copy, including the modules that tests use.
        """
        sys.dont_write_bytecode = True
        os.chdir(copy)
        helping = str(self._root / "tests") + os.sep
        for name, module in list(sys.modules.items()):
            file = getattr(module, "__file__", None) or ""
            if name.partition(".")[0] in _PACKAGES or file.startswith(helping):
                del sys.modules[name]
        sys.path.insert(0, str(copy / "harness"))
        os.environ["PYTHONPATH"] = str(copy / "harness")
        os.environ["PYTHONDONTWRITEBYTECODE"] = "1"
        os.environ.pop("RCX_MATIEC", None)
        os.environ["XDG_CACHE_HOME"] = str(copy / "out")
        importlib.invalidate_caches()


_NO_TESTS = pytest.ExitCode.NO_TESTS_COLLECTED


def _pytest(copy: Path, files: Sequence[str], plugin: object, more: Sequence[str]) -> int:
    there = [file for file in files if (copy / file).is_file()]
    if not there:
        return _NO_TESTS
    own = copy / "out" / str(os.getpid())
    own.mkdir(parents=True, exist_ok=True)
    options = [*pytest_options(copy), "--basetemp", str(own / "tests")]
    return int(pytest.main([*options, *more, *there], plugins=[plugin, _Settled()]))


class _Settled:
    """Plugin that makes hypothesis try the same examples in every run."""

    def pytest_configure(self) -> None:
        settle_hypothesis()


def _regenerate(copy: Path) -> None:
    """Write the files that are generated from the tables of this copy."""
    files: Any = importlib.import_module("rcx_tools.library").files()
    texts: Any = importlib.import_module("rcx_tools.library.alarm_texts").text_files()
    for path, write in {**files, **texts}.items():
        _write(copy / path, write())
    bits: Any = importlib.import_module("rcx_tools.library.signals").signal_files()
    for path, write in bits.items():
        if (copy / path).is_file():  # handwritten files; some of them may be missing in the copy
            _write(copy / path, write())


def _linked(source: str, target: str) -> None:
    """Create a hard link to a file. If that is not possible, copy the file."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def _write(file: Path, text: str) -> None:
    """Replace a file. Other hard links to the old file keep the old content."""
    file.parent.mkdir(parents=True, exist_ok=True)
    file.unlink(missing_ok=True)
    file.write_text(text, encoding="utf-8")
