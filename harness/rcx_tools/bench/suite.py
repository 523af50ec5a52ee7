"""The tests: how long they take, on the wall and of the processors, and the ten slowest.

It runs them as `make test` does. Their results must depend neither on the number of processes nor
on the order: that is shown by running a part of them in one process, in four, in reverse and in an
order that is drawn (RCX_ORDER of tests/conftest.py).
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import NamedTuple

from rcx_tools.bench.figure import OUT_OF_REACH, Figure, Options, at_most, shown

__all__ = ["Tested", "measure", "read"]

_LIMIT_S = 180
_SLOWEST = 10
#: How a part is run once more: in how many processes, and in which order.
_OTHERWISE = (("in four", "4", ""), ("in reverse", "1", "reverse"), ("drawn", "1", "20261"))
#: That part: tests that share compiled programs, seeds and caches.
_PART = ("tests/area", "tests/sequence", "tests/contract/test_broken_blocks.py", "tests/robot")


class Tested(NamedTuple):
    """A test's name, its result (`passed`, `failed`, `skipped`) and its duration [s]."""

    name: str
    result: str
    seconds: float


def measure(options: Options) -> dict[str, Figure]:
    """Run the tests; with `quick` the part that is run several times only."""
    with tempfile.TemporaryDirectory() as folder:
        plain = _results(_run(Path(folder), *_PART))
        found = {}
        for how, processes, order in _OTHERWISE:
            other = _results(_run(Path(folder), *_PART, processes=processes, order=order))
            beside = f"{len(plain)} tests in 1 process, and {how}"
            name = f"tests_that_differ_{how.replace(' ', '_')}"
            found[name] = at_most(len(plain ^ other), "tests", 0, beside)
        if options.quick:
            return found
        before, start = _cpu(), time.monotonic()
        every = _run(Path(folder), processes="auto")
        wall, cpu = time.monotonic() - start, _cpu() - before
    failed = sum(test.result == "failed" for test in every)
    found["tests"] = shown(len(every), "tests")
    found["tests_failed"] = at_most(failed, "tests", 0)
    found["tests_wall"] = at_most(wall, "s", _LIMIT_S, "make test" + OUT_OF_REACH)
    found["tests_cpu"] = shown(cpu, "s", "all processes")
    slowest = sorted(every, key=lambda test: -test.seconds)[:_SLOWEST]
    for rank, test in enumerate(slowest, start=1):
        found[f"slowest_{rank}"] = shown(test.seconds, "s", test.name)
    return found


def read(file: Path) -> list[Tested]:
    """The tests of a file that `pytest --junitxml` has written."""
    tests = []
    for case in ET.parse(file).iter("testcase"):
        marks = {child.tag for child in case}
        result = "failed" if marks & {"failure", "error"} else "passed"
        result = "skipped" if "skipped" in marks else result
        name = f"{case.get('classname')}::{case.get('name')}"
        tests.append(Tested(name, result, float(case.get("time", "0"))))
    return tests


def _run(folder: Path, *parts: str, processes: str = "1", order: str = "") -> list[Tested]:
    file = folder / "tests.xml"
    options = ["-q", "-n", processes, "--dist", "worksteal", f"--junitxml={file}"]
    subprocess.run(
        [sys.executable, "-m", "pytest", *options, *parts],
        stdout=subprocess.DEVNULL, check=False, env={**os.environ, "RCX_ORDER": order},
    )  # fmt: skip
    return read(file)


def _results(tests: list[Tested]) -> set[tuple[str, str]]:
    return {(test.name, test.result) for test in tests}


def _cpu() -> float:
    """CPU time of all processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
