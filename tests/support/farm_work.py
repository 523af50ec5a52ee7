"""Tasks for tests of farms. Each worker process can import this module."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from structured_text.errors import InputError


@dataclass(frozen=True)
class Meeting:
    """A task in which item 0 waits for item 1, so both end only if they run at the same time."""

    folder: Path

    def __call__(self, item: int) -> int:
        """Return the item, 0 or 1."""
        ours, theirs = (self.folder / str(one) for one in (item, 1 - item))
        # Opening a FIFO waits for the other end.
        for fifo, mode in sorted([(ours, "w"), (theirs, "r")]):
            with fifo.open(mode):
                pass
        return item


@dataclass(frozen=True)
class FirstWaits:
    """A task in which item 0 waits until the FIFO is opened for writing."""

    fifo: Path

    def __call__(self, item: int) -> int:
        """Return the item."""
        if item == 0:
            with self.fifo.open():
                pass
        return item


@dataclass(frozen=True)
class Counted:
    """A task that counts in a file how often it was set up."""

    file: Path

    def prepare(self) -> Counted:
        """Write the number of the process."""
        with self.file.open("a") as stream:
            stream.write(f"{os.getpid()}\n")
        return self

    def __call__(self, item: int) -> int:
        """Return the number of the process."""
        return os.getpid()


@dataclass(frozen=True)
class Killed:
    """A task in which item 3 kills its worker as long as a folder contains files to remove."""

    folder: Path

    def __call__(self, item: int) -> int:
        """Return ten times the item."""
        left = sorted(self.folder.iterdir())
        if item == 3 and left:
            left[0].unlink()
            os.kill(os.getpid(), signal.SIGKILL)
        return item * 10


def refuse(item: int) -> int:
    """Return the item.

    Items 2 and 5 raise an error meant for the user. Item 9 raises an internal error.
    """
    if item in (2, 5):
        raise InputError("no such pin", file="a.st", line=item, hint="name another")
    if item == 9:
        raise KeyError(item)
    return item


def process_number(item: int) -> int:
    """Return the process number of the worker."""
    return os.getpid()


def grandchild(item: int) -> int:
    """Start a process that waits for ever, and return its number."""
    return subprocess.Popen([sys.executable, "-c", "import signal; signal.pause()"]).pid


def waits_with_a_folder(item: str) -> None:
    """Create a temporary folder in this folder, print `begun`, and wait for ever."""
    with TemporaryDirectory(dir=item):
        os.write(1, b"begun\n")
        threading.Event().wait()


def noted(item: tuple[str, int]) -> int:
    """Return ten times the number, and append the number to the file."""
    file, number = item
    with Path(file).open("a") as stream:
        stream.write(f"{number}\n")
    return number * 10
