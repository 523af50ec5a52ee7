"""Run `rcx serve` as a process, read its lines, send Ctrl-C, and find processes that remain."""

from __future__ import annotations

import itertools
import os
import queue
import select
import signal
import socket
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

#: Longest wait [s]. On a busy machine the start of Python alone may take some seconds.
_LIMIT_S = 60.0
_ASK_EVERY_S = 0.05
_numbers = itertools.count(1)


def own_addresses(count: int) -> list[str]:
    """Return loopback addresses that no other test process uses.

    Each call returns new addresses.
    """
    process = os.getpid()
    middle, last = 1 + process % 250, 1 + process // 250 % 250
    return [f"127.{100 + next(_numbers) % 100}.{middle}.{last}" for _ in range(count)]


@contextmanager
def watching(pids: Iterable[int]) -> Iterator[None]:
    """Check that all processes that are started inside the context end soon after it."""
    watched = {pid: os.pidfd_open(pid) for pid in pids}
    try:
        yield
        for pid, descriptor in watched.items():
            assert select.select([descriptor], [], [], _LIMIT_S)[0], f"process {pid} still runs"
    finally:
        for descriptor in watched.values():
            os.close(descriptor)


class ServeProcess:
    """A running `rcx serve`, which ends with the `with` block at the latest.

    Args:
        arguments: Arguments of the command line.
        environment: Environment of the process; None means the environment of this process.
    """

    def __init__(self, *arguments: str, environment: Mapping[str, str] | None = None) -> None:
        self.lines: list[str] = []
        self._new: queue.Queue[str | None] = queue.Queue()
        self._process = subprocess.Popen(
            [sys.executable, "-m", "rcx_harness", "serve", *arguments],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env=environment,
        )
        threading.Thread(target=self._read, daemon=True).start()

    def wait_for(self, text: str) -> str:
        """Return the next line that contains `text`."""
        while True:
            line = self._new.get(timeout=_LIMIT_S)
            assert line is not None, f"no line with {text!r} came, but: {self.lines}"
            self.lines.append(line)
            if text in line:
                return line

    def wait_for_port(self, address: str, port: int) -> None:
        """Wait until the process listens on the port, and check that it does not end meanwhile."""
        own = os.pidfd_open(self._process.pid)
        try:
            for _ in range(round(_LIMIT_S / _ASK_EVERY_S)):
                with socket.socket() as probe:
                    if probe.connect_ex((address, port)) == 0:
                        return
                ended, _, _ = select.select([own], [], [], _ASK_EVERY_S)
                assert not ended, "it has ended"
            raise AssertionError(f"no process listens on {address}:{port}")
        finally:
            os.close(own)

    def processes(self) -> set[int]:
        """Return the process numbers of the process and all its descendants."""
        found = {self._process.pid}
        while True:
            more = {pid for pid, parent in _parents().items() if parent in found} | found
            if more == found:
                return found
            found = more

    def process_of(self, module: str) -> int:
        """Return the number of the first process that runs this Python module."""
        return min(pid for pid in self.processes() if _runs(pid, module))

    def kill(self) -> None:
        """Kill the process without a clean-up."""
        self._process.kill()
        self._process.wait(_LIMIT_S)

    def interrupt(self) -> None:
        """Send Ctrl-C to the process."""
        self._process.send_signal(signal.SIGINT)

    def end(self) -> tuple[int, str]:
        """Wait for the end of the process, and return its exit code and stderr."""
        assert self._process.stderr is not None
        # stderr is short and fits into the pipe, so the process cannot block
        code = self._process.wait(_LIMIT_S)
        return code, self._process.stderr.read()

    def __enter__(self) -> ServeProcess:
        """Return the started process."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the process."""
        if self._process.poll() is None:
            self.kill()
        for pipe in (self._process.stdout, self._process.stderr):
            assert pipe is not None
            pipe.close()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self._new.put(line.rstrip("\n"))
        self._new.put(None)


def _parents() -> dict[int, int]:
    """Return the parent of each process."""
    found = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                stat = (entry / "stat").read_text()
            except OSError:  # the process has just ended
                continue
            found[int(entry.name)] = int(stat.rpartition(")")[2].split()[1])
    return found


def _runs(pid: int, module: str) -> bool:
    """Return whether the process runs this Python module, as its command or in a fork."""
    process = Path(f"/proc/{pid}")
    name = (process / "comm").read_text().strip()
    started = name.startswith("python")
    return (
        module in (process / "cmdline").read_text().split("\0")
        if started
        else module.endswith(name)
    )
