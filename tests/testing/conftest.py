"""Create the project of a user, for tests that run pytest inside pytest."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import rcx_harness.testing.cells  # noqa: F401 - stays loaded from one inner run to the next

#: `run(test, *options, ini={...})` runs that test file in a project with a program.
Run = Callable[..., pytest.RunResult]

#: Plugins that the inner run omits, because loading them takes longer than the run itself.
_WITHOUT = [f"-pno:{name}" for name in ("cacheprovider", "xdist", "hypothesispytest")]


@pytest.fixture
def run(pytester: pytest.Pytester, repository: Path) -> Run:
    """Return a function that tests a project with the program RawArea, which needs no library."""
    program = repository / "tests" / "cell" / "programs" / "RawArea.st"
    plc = pytester.mkdir("plc")
    (plc / "RawArea.st").write_text(program.read_text(encoding="utf-8"), encoding="utf-8")
    pytester.mkdir("no-library")

    def run(test: str, *options: str, **ini: str) -> pytest.RunResult:
        keys = {"sources": "plc/*.st", "lib": "no-library", "engine": "builtin"} | ini
        lines = [f"rcx_{name} = {value}" for name, value in keys.items() if value]
        pytester.makefile(".ini", pytest="\n".join(["[pytest]", *lines]))
        pytester.makepyfile(test_it=test)
        return pytester.runpytest_inprocess(*_WITHOUT, *options)

    return run
