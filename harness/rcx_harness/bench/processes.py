"""Processes that the bench looks at from outside: their CPU time, and loads it starts."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from rcx_harness.errors import InputError

__all__ = ["PROC", "cpu_of_children", "peak_memory", "running"]

#: Where Linux tells of its processes; without it CPU time and memory cannot be measured.
PROC = Path("/proc")


def cpu_of_children(module: str) -> float:
    """CPU time of the processes below this one that run a Python module [s].

    Raises:
        InputError: this system does not tell.
    """
    if not (PROC / "self" / "stat").exists():
        raise InputError("CPU time of other processes is measured on Linux only")
    parents: dict[int, int] = {}
    ticks: dict[int, int] = {}
    for entry in PROC.iterdir():
        with suppress(OSError, ValueError):  # it has ended meanwhile, or is no process
            number = int(entry.name)
            fields = (entry / "stat").read_text().rpartition(")")[2].split()
            parents[number] = int(fields[1])
            if module.encode() in (entry / "cmdline").read_bytes().split(b"\0"):
                ticks[number] = int(fields[11]) + int(fields[12])
    return sum(ticks[one] for one in ticks if _is_below(one, parents)) / os.sysconf("SC_CLK_TCK")


def _is_below(pid: int, parents: dict[int, int]) -> bool:
    """Is it a child of this process, or a child of one?"""
    me = os.getpid()
    while pid in parents:
        pid = parents[pid]
        if pid == me:
            return True
    return False


def peak_memory() -> int:
    """The most memory that this process has held so far [KiB]."""
    import resource  # not on Windows

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@contextmanager
def running(module: str, arguments: Sequence[str]) -> Iterator[subprocess.Popen[str]]:
    """A Python module as a process of its own, ended at the end."""
    process = subprocess.Popen(
        [sys.executable, "-m", module, *arguments], stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.terminate()
        process.wait()
        if process.stdout is not None:
            process.stdout.close()
