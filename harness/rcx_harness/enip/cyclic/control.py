"""The parent's handle of the cyclic process: start, connections, stop."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from rcx_harness.enip.child import Child, how_ended
from rcx_harness.enip.closing import Closing
from rcx_harness.enip.cyclic.connections import IO_PORT, ConnectionParameters, EndReason
from rcx_harness.enip.cyclic.exchange import Role
from rcx_harness.enip.errors import EnipError, ProcessDiedError

__all__ = ["CyclicControl"]

_MODULE = "rcx_harness.enip.cyclic.process"


class CyclicControl(Closing):
    """The class 1 connections of one device, which a separate process serves.

    The process ends with `close`, or with its parent.

    Args:
        memory: Name of the `SharedImages` with the assemblies.
        port: UDP port, 0 for any free one.
        on_ended: Called in a separate thread for each connection that ends by itself, with its
            number and the reason.
    """

    def __init__(
        self,
        memory: str,
        host: str,
        port: int = IO_PORT,
        on_ended: Callable[[int, EndReason], None] = lambda number, reason: None,
        role: Role = Role.TARGET,
    ) -> None:
        settings = {"memory": memory, "host": host, "port": port, "role": role.value}
        self._child = Child(_MODULE, settings, "the process of the cyclic I/O")
        self._on_ended = on_ended
        self._closed = False
        if "port" not in self._child.started:
            self._child.stop()
            raise EnipError(
                f"cyclic I/O cannot use UDP port {port} of {host}: {self._child.started['error']}",
                hint="end the program that uses the port (a program on 0.0.0.0 uses it on every "
                "address), or choose another address or port",
            )
        self.port = int(self._child.started["port"])
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def pid(self) -> int:
        """Return the process id of the process of the cyclic I/O."""
        return self._child.process.pid

    @property
    def alive(self) -> bool:
        """Return whether the process of the cyclic I/O still runs."""
        return self._reader.is_alive()

    @property
    def failure(self) -> str:
        """Describe the unexpected end of the process; empty while it runs and after `close`."""
        if self._closed or self.alive:
            return ""
        how = how_ended(self._child.wait_for_code())
        return f"the process of the cyclic I/O has ended by itself ({how})"

    def add(self, parameters: ConnectionParameters) -> None:
        """Add a connection to the process, which sends and accepts its packets from now on."""
        self._order({"add": asdict(parameters)})

    def remove(self, number: int) -> None:
        """Remove a connection from the process; do nothing if the connection has already ended."""
        self._order({"remove": number})

    def close(self) -> None:
        """Stop the process of the cyclic I/O; do nothing if it is already stopped."""
        self._closed = True
        if self._child.process.poll() is None or self._reader.is_alive():
            self._child.stop()
            self._reader.join()
            self._child.reports.close()

    def _read(self) -> None:
        for line in self._child.reports:
            message = json.loads(line)
            self._on_ended(message["ended"], EndReason(message["reason"]))

    def _order(self, order: dict[str, Any]) -> None:
        try:
            self._child.orders.write(json.dumps(order) + "\n")
            self._child.orders.flush()
        except (OSError, ValueError):  # the process has ended, so the pipe is broken or closed
            raise ProcessDiedError(
                self.failure or "the process of the cyclic I/O has ended"
            ) from None
