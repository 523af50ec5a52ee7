"""Processes that a benchmark starts, and their CPU time."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from structured_text.errors import InputError

__all__ = ["begin", "cpu_of_children", "first_line", "in_ordinary_time", "running"]

#: Folder with the process information of Linux. Without this folder CPU time cannot be measured.
_PROC = Path("/proc")


def cpu_of_children(module: str) -> float:
    """Return the CPU time of the descendants of this process that run a Python module [s].

    Raises:
        InputError: this system does not report CPU time.
    """
    return sum(_ticks_of_children(module).values()) / os.sysconf("SC_CLK_TCK")


def in_ordinary_time(module: str) -> None:
    """Remove real-time priority from the descendants of this process that run a Python module.

    Raises:
        InputError: this system does not list processes.
    """
    for number in _ticks_of_children(module):
        with suppress(ProcessLookupError):  # the process has ended in the meantime
            os.sched_setscheduler(number, os.SCHED_OTHER, os.sched_param(0))


def _ticks_of_children(module: str) -> dict[int, int]:
    """Return the CPU time of descendants that run a Python module, by process id [ticks].

    Raises:
        InputError: this system does not report CPU time.
    """
    if not (_PROC / "self" / "stat").exists():
        raise InputError("CPU time of other processes is measured on Linux only")
    parents: dict[int, int] = {}
    ticks: dict[int, int] = {}
    for entry in _PROC.iterdir():
        with suppress(OSError, ValueError):  # this entry is not a process, or the process has ended
            number = int(entry.name)
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            parents[number] = int(fields[1])
            if module.encode() in (entry / "cmdline").read_bytes().split(b"\0"):
                ticks[number] = int(fields[11]) + int(fields[12])
    return {one: used for one, used in ticks.items() if _is_below(one, parents, os.getpid())}


def _is_below(pid: int, parents: dict[int, int], above: int) -> bool:
    """Return whether a process is a descendant of process `above`."""
    while pid in parents:
        pid = parents[pid]
        if pid == above:
            return True
    return False


@contextmanager
def running(module: str, arguments: Sequence[str]) -> Iterator[subprocess.Popen[str]]:
    """Run a Python module in its own process, and end the process on exit."""
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments], stdin=subprocess.PIPE,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.terminate()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                with suppress(BrokenPipeError):  # the process has ended before it read a line
                    pipe.close()


def first_line(process: subprocess.Popen[str]) -> str:
    """Wait for the first line of a process, which shows that the process is ready.

    Raises:
        InputError: the process has ended without a line.
    """
    assert process.stdout is not None
    line = process.stdout.readline().strip()
    if not line:
        raise InputError("a process of this bench has ended at its start")
    return line


def begin(process: subprocess.Popen[str]) -> None:
    """Start the work of a process that is ready, by sending a line to it."""
    assert process.stdin is not None
    process.stdin.write("\n")
    process.stdin.flush()
