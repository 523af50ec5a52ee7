"""Run pytest in several processes and show the progress."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import deque
from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from rcx_tools.evidence.results import ROOT

__all__ = ["run_pytest"]

_PERCENT = re.compile(r"\[ *(\d+)%\]")
_LAST_LINES = 60
#: Step of the progress messages if the output is not a terminal [%].
_STEP = 20


def run_pytest(
    title: str,
    arguments: Sequence[str],
    console: Console,
    *,
    workers: str = "auto",
    environment: Mapping[str, str] | None = None,
) -> tuple[int, list[str]]:
    """Run tests. Return the exit code and the last lines of pytest's output."""
    command = [sys.executable, "-m", "pytest", "-q", "--color=no", "-n", workers]
    command += ["--dist", "worksteal", *arguments]
    last: deque[str] = deque(maxlen=_LAST_LINES)
    columns = (TextColumn("{task.description}"), BarColumn())
    columns_after = (TextColumn("{task.percentage:.0f} %"), TimeElapsedColumn())
    with (
        Progress(*columns, *columns_after, console=console, transient=True) as progress,
        subprocess.Popen(
            command,
            cwd=ROOT,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        ) as process,
    ):
        task = progress.add_task(title, total=100)
        shown = 0
        assert process.stdout is not None
        for line in process.stdout:
            last.append(line.rstrip())
            if found := _PERCENT.search(line):
                progress.update(task, completed=int(found[1]))
                if not console.is_terminal and int(found[1]) >= shown + _STEP:
                    shown = int(found[1])
                    console.print(f"{title}: {shown} %")
    return process.returncode, list(last)
