"""Execution of the tests on the built-in engine, which counts the covered code."""

from __future__ import annotations

import os
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from rcx_tools.evidence.running_tests import run_pytest
from structured_text.output.programs import environment

__all__ = ["FOLDERS", "Run", "run_tests"]

#: Folders of tests in which blocks of the library run.
FOLDERS = (
    *("area", "sequence", "command", "motion", "position", "points", "operator", "diagnosis"),
    *("chapters", "cell", "contract"),
    *("faults", "examples", "watch"),
)
#: Tests in real time. They are left out because they execute no additional code.
_LEFT_OUT = ("tests/cell/test_live.py",)

_COUNT = re.compile(r"(\d+) (passed|failed|errors?|skipped)")


@dataclass(frozen=True)
class Run:
    """The result of a test run; `output` is the last part of pytest's output."""

    passed: int
    failed: int
    skipped: int
    output: str

    @property
    def clean(self) -> bool:
        """Return whether tests were run and no test has failed."""
        return self.passed > 0 and self.failed == 0


def run_tests(root: Path, counts: Path, workers: str, console: Console) -> Run:
    """Run the tests that execute blocks, show progress, and write the counts to a file.

    Args:
        root: The repository.
        counts: The file for the counts.
        workers: Number of processes, in the form of pytest's option `-n`.
        console: For the progress.
    """
    shutil.rmtree(counts.parent, ignore_errors=True)
    counts.parent.mkdir(parents=True)
    counts.write_text("[]", encoding="utf-8")
    folders = [f"tests/{name}" for name in FOLDERS if (root / "tests" / name).is_dir()]
    arguments = ["-p", "no:cacheprovider", *folders]
    arguments += [f"--ignore={path}" for path in _LEFT_OUT]
    arguments += ["-p", "rcx_tools.evidence.coverage.counting", "--counts", str(counts)]
    arguments += ["--count-below", str(root / "plc" / "lib")]
    title, own = "tests with coverage", _environment()
    return _ended(*run_pytest(title, arguments, console, workers=workers, environment=own))


def _environment() -> dict[str, str]:
    """Return the environment without matiec, so that every program runs on the counting engine."""
    path = os.environ.get("PATH", "").split(os.pathsep)
    without_matiec = [entry for entry in path if not (Path(entry) / "iec2c").exists()]
    return environment(without=["RCX_MATIEC"], PATH=os.pathsep.join(without_matiec))


def _ended(code: int, lines: list[str]) -> Run:
    found = dict.fromkeys(("passed", "failed", "error", "skipped"), 0)
    for count, word in _COUNT.findall(lines[-1] if lines else ""):
        found[word.rstrip("s") if word.startswith("error") else word] = int(count)
    failed = found["failed"] + found["error"]
    return Run(found["passed"], failed or int(code != 0), found["skipped"], "\n".join(lines))
