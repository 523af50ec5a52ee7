"""Standard input as a stream of lines whose reading can be given up.

The library reads in a thread that cannot be interrupted, so that Ctrl-C and SIGTERM would wait for
the next line. Here the thread is a daemon, which does not delay the end of the process.
"""

from __future__ import annotations

import os
import sys
from collections.abc import AsyncIterator
from concurrent.futures import CancelledError
from contextlib import asynccontextmanager, suppress
from threading import Thread

import anyio
from anyio.from_thread import BlockingPortal
from anyio.streams.memory import MemoryObjectReceiveStream, MemoryObjectSendStream

__all__ = ["lines_of_standard_input"]


@asynccontextmanager
async def lines_of_standard_input() -> AsyncIterator[MemoryObjectReceiveStream[str]]:
    """Read the lines of standard input, until its end or the end of this block."""
    sending, receiving = anyio.create_memory_object_stream[str](0)
    async with BlockingPortal() as portal:
        Thread(target=_read, args=(portal, sending), daemon=True).start()
        try:
            yield receiving
        finally:
            receiving.close()
            await portal.stop(cancel_remaining=True)


def _read(portal: BlockingPortal, sending: MemoryObjectSendStream[str]) -> None:
    # A separate stream, because sys.stdin cannot be closed at the end while a thread reads from it.
    stream = os.fdopen(os.dup(sys.stdin.fileno()), "rb")
    with suppress(OSError, RuntimeError, CancelledError, anyio.BrokenResourceError):
        while line := stream.readline():
            portal.call(sending.send, line.decode("utf-8", "replace"))
        portal.call(sending.aclose)
