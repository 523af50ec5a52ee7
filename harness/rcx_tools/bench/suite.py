"""Measure `make test`: its duration, its CPU time, its slowest files, and the time per folder.

The results of the tests must not depend on the order or on the number of processes. To check this,
a part of the tests runs several times: in one process, in four processes, in reverse order, and in
a random order (`--order` of tests/conftest.py).
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rcx_tools.bench.figure import Figure, Options, at_most, shown

__all__ = ["Tested", "measure", "read"]

#: Time limits for `make test` on two idle cores without matiec: real time, and CPU time of both
#: cores.
_LIMIT_S, _LIMIT_CPU_S = 150, 300
_EXPENSIVE = 10
_QUICK = ("-m", "not exhaustive")
#: The repetitions of a part of the tests: name, number of processes, and order.
_OTHERWISE = (("in four", "4", ""), ("in reverse", "1", "reverse"), ("drawn", "1", "20261"))
#: The tests that are repeated. They share compiled programs, seeds and caches.
_PART = ("tests/area", "tests/sequence", "tests/contract/test_broken_blocks.py", "tests/robot")


class Tested(NamedTuple):
    """A test's name, its result (`passed`, `failed`, `skipped`) and its duration [s]."""

    name: str
    result: str
    seconds: float


def measure(options: Options) -> dict[str, Figure]:
    """Run the repetitions and then all tests. With `quick`, run only the repetitions."""
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
        every = _run(Path(folder), *_QUICK, processes="auto")
        wall, cpu = time.monotonic() - start, _cpu() - before
    failed = sum(test.result == "failed" for test in every)
    found["tests"] = shown(len(every), "tests")
    found["tests_failed"] = at_most(failed, "tests", 0)
    found["tests_wall"] = at_most(wall, "s", _LIMIT_S, "make test")
    found["tests_cpu"] = at_most(cpu, "s", _LIMIT_CPU_S, "all processes, collection included")
    for rank, (file, seconds) in enumerate(_sums(every, _file)[:_EXPENSIVE], start=1):
        found[f"file_{rank}"] = shown(seconds, "s", file)
    for room, seconds in _sums(every, _room):
        found[f"room_{room}"] = shown(seconds, "s", f"tests/{room}")
    return found


def _sums(tests: list[Tested], of: Callable[[Tested], str]) -> list[tuple[str, float]]:
    """Return the sum of the seconds for each group of tests, the most expensive group first."""
    sums: dict[str, float] = {}
    for test in tests:
        sums[of(test)] = sums.get(of(test), 0.0) + test.seconds
    return sorted(sums.items(), key=lambda item: -item[1])


def _file(test: Tested) -> str:
    """Return the file of a test, for example `tests.area.test_read_area`."""
    return test.name.partition("::")[0]


def _room(test: Tested) -> str:
    """Return the folder of a test below tests/."""
    return [*_file(test).split("."), "tests"][1]


def read(file: Path) -> list[Tested]:
    """Return the tests in a report of `pytest --junitxml`."""
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
    command = [sys.executable, "-m", "pytest", *options, f"--order={order}", *parts]
    subprocess.run(command, stdout=subprocess.DEVNULL, check=False)
    return read(file)


def _results(tests: list[Tested]) -> set[tuple[str, str]]:
    return {(test.name, test.result) for test in tests}


def _cpu() -> float:
    """Return the CPU time of all processes that have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
