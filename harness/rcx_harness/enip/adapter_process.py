"""The adapter's own process: the device, its TCP port, and nothing of the parent's.

Started by `rcx_harness.enip.adapter` with its settings as JSON; says on standard output where it
listens, or why it cannot; ends when its standard input does, that is with its parent at the latest.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import signal
import socket
import sys
import threading
from collections.abc import Callable, Sized
from multiprocessing import resource_tracker
from multiprocessing.shared_memory import SharedMemory
from typing import Any

from rcx_harness.enip.encapsulation import socket_address
from rcx_harness.enip.identity import Identity
from rcx_harness.enip.objects import ObjectModel
from rcx_harness.enip.router import Router
from rcx_harness.enip.session import Session

__all__ = ["main"]


class _Connection(asyncio.Protocol):
    """One scanner on the TCP port."""

    def __init__(self, router: Router, new_handle: Callable[[], int]) -> None:
        self._router = router
        self._new_handle = new_handle

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start a session; asyncio has set TCP_NODELAY."""
        assert isinstance(transport, asyncio.Transport)
        self._transport = transport
        address = socket_address(*transport.get_extra_info("sockname"))
        self._session = Session(self._router, self._new_handle, address)

    def data_received(self, data: bytes) -> None:
        """Answer what is complete."""
        if answers := self._session.receive(data):
            self._transport.write(answers)
        if self._session.ended:
            self._transport.close()


def main(argument: str) -> None:
    """Run the adapter until the parent closes our standard input.

    Args:
        argument: JSON object with `memory` (name of the shared images, 100 then 150), `size` of
            each in bytes, `host`, `port` (0: any free one) and `identity`.
    """
    # Ctrl-C reaches the whole process group; the parent decides when the adapter ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    settings = json.loads(argument)
    size = settings["size"]
    identity = Identity(**settings["identity"])
    memory = _attach(settings["memory"])
    images = memory.buf
    assert images is not None
    with images[:size] as to_master, images[size : 2 * size] as to_robot:
        router = Router(ObjectModel(to_master, to_robot, identity), identity)
        asyncio.run(_serve(router, settings["host"], settings["port"]))
    memory.close()


async def _serve(router: Router, host: str, port: int) -> None:
    loop = asyncio.get_running_loop()
    handles = itertools.count(1)
    try:
        server = await loop.create_server(
            lambda: _Connection(router, handles.__next__), host, port, family=socket.AF_INET
        )
    except (OSError, OverflowError, UnicodeError) as error:  # also: no port, no host name
        _tell({"error": str(error)})
        return
    parent_gone = asyncio.Event()

    def wait_for_parent() -> None:
        while os.read(0, 1):
            pass
        loop.call_soon_threadsafe(parent_gone.set)

    # A thread, because not every platform's event loop can wait for a pipe.
    threading.Thread(target=wait_for_parent, daemon=True).start()
    _tell({"port": server.sockets[0].getsockname()[1]})
    await parent_gone.wait()
    server.close()


def _attach(name: str) -> SharedMemory:
    """Open the parent's memory without answering for it: the parent removes its name."""
    if sys.version_info >= (3, 13):
        return SharedMemory(name, track=False)

    def no_tracking(name: Sized, rtype: str) -> None:
        """Before Python 3.13 the only way to keep the resource tracker out."""

    resource_tracker.register = no_tracking
    return SharedMemory(name)


def _tell(message: dict[str, Any]) -> None:
    print(json.dumps(message), flush=True)


if __name__ == "__main__":
    main(sys.argv[1])
