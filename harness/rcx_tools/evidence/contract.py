"""Command `python -m rcx_tools.evidence.contract`: tests of the PLCopen rules on every block.

The command runs tests/contract (every block on a bench without a robot) and tests/faults (every
kind of block on the virtual controller). It counts the test cases: block x Execute pattern x answer
x moment. Further arguments are passed to pytest. `--every-case` runs all cases.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from rich.console import Console
from rich.table import Table

from rcx_tools.evidence.results import FOLDER, write_result
from rcx_tools.evidence.running_tests import run_pytest

__all__ = ["DEMANDED", "figures", "main"]

#: The check requires more cases than this number.
DEMANDED = 10_000

_FOLDERS = ("tests/contract", "tests/faults")


def figures(report: Path) -> dict[str, Any]:
    """Return figures from the XML report of pytest: cases, scans, and broken blocks found."""
    tests = list(ElementTree.parse(report).getroot().iter("testcase"))
    failed = [one for one in tests if any(one.find(tag) is not None for tag in _BAD)]
    bench = [one for one in tests if "test_every_block" in one.get("classname", "")]
    broken = [one for one in tests if _is_broken(one)]
    cases = {one: sum(_property(test, "instances") for test in tests if one(test)) for one in _OF}
    return {
        "instances": sum(cases.values()),
        "instances_on_the_bench": cases[_on_the_bench],
        "instances_on_the_virtual_controller": cases[_on_the_controller],
        "blocks": sum(_property(one, "instances") > 0 for one in bench),
        "scans_on_the_bench": sum(_property(one, "scans") for one in tests),
        "broken_blocks": len(broken),
        "broken_blocks_found": sum(one not in failed for one in broken),
        "failed": [_name(one) for one in failed],
    }


_BAD = ("failure", "error")


def _on_the_bench(test: ElementTree.Element) -> bool:
    return "tests.contract" in test.get("classname", "")


def _on_the_controller(test: ElementTree.Element) -> bool:
    return "tests.faults" in test.get("classname", "")


_OF = (_on_the_bench, _on_the_controller)


def _is_broken(test: ElementTree.Element) -> bool:
    """Return whether a test checks that a deliberately broken block is detected."""
    return _name(test).startswith(("test_a_broken_block", "test_a_fault_in_the_library"))


def _name(test: ElementTree.Element) -> str:
    return test.get("name", "")


def _property(test: ElementTree.Element, name: str) -> int:
    found = (one for one in test.iter("property") if one.get("name") == name)
    return sum(int(one.get("value", "0")) for one in found)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the tests; return 0 if none failed and there are more cases than `DEMANDED`."""
    console = Console(highlight=False)
    FOLDER.mkdir(parents=True, exist_ok=True)
    report = FOLDER / "contract.xml"
    report.unlink(missing_ok=True)
    begin = time.monotonic()
    given = sys.argv[1:] if arguments is None else arguments
    _, lines = run_pytest("contract", [f"--junitxml={report}", *_FOLDERS, *given], console)
    if not report.is_file():
        console.print("\n".join(lines), markup=False)
        return 2
    found = figures(report)
    found["seconds"] = round(time.monotonic() - begin)
    if found["failed"]:
        console.print("\n".join(lines), markup=False)
    every = found["instances"] > DEMANDED and found["blocks"] > 0
    met = every and not found["failed"] and found["broken_blocks_found"] > 0
    write_result("contract", found, met=met)
    table = Table("figure", "value", title="Contract", box=None)
    for name, value in found.items():
        told = f"{value:,}" if isinstance(value, int) else ", ".join(value) or "none"
        table.add_row(name.replace("_", " "), told)
    console.print(table)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
