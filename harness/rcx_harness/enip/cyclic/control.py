"""The process of the cyclic part as its parent holds it: start, connections, stop."""

from __future__ import annotations

import json
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any

from rcx_harness.enip.cyclic.connections import IO_PORT, ConnectionParameters, EndReason
from rcx_harness.enip.cyclic.exchange import Role
from rcx_harness.enip.ended import how_ended, wait_for_code
from rcx_harness.enip.errors import EnipError, ProcessDiedError

__all__ = ["CyclicControl"]

_MODULE = "rcx_harness.enip.cyclic.process"
_STOP_S = 5.0


class CyclicControl:
    """Class 1 connections of one device, served by a process of its own.

    The process ends with `close`, or with its parent.

    Args:
        memory: Name of the `SharedImages` it works on.
        host: IPv4 address to send from and to receive at.
        port: UDP port, 0 for any free one.
        on_ended: Told, in a thread of its own, the number of each connection that has ended by
            itself, and why.
        role: Which end of the connections this is.

    Attributes:
        port: UDP port it receives at.

    Raises:
        EnipError: it could not listen there, or did not start.
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
        self._process = subprocess.Popen(
            [sys.executable, "-m", _MODULE, json.dumps(settings)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            start_new_session=True,  # Ctrl-C is for the parent, which decides when it ends
        )
        self._on_ended = on_ended
        self._closed = False
        try:
            self.port = self._started(host, port)
        except BaseException:
            self._stop()
            raise
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    @property
    def alive(self) -> bool:
        """Does the process still run?"""
        return self._reader.is_alive()

    @property
    def failure(self) -> str:
        """How the process has ended by itself; empty as long as it runs, and after `close`."""
        if self._closed or self.alive:
            return ""
        how = how_ended(wait_for_code(self._process))
        return f"the process of the cyclic I/O has ended by itself ({how})"

    def add(self, parameters: ConnectionParameters) -> None:
        """Open a connection: packets flow from now on.

        Raises:
            EnipError: the process has ended.
        """
        self._order({"add": parameters.as_message()})

    def remove(self, number: int) -> None:
        """Close a connection; one that has ended already does no harm.

        Raises:
            EnipError: the process has ended.
        """
        self._order({"remove": number})

    def close(self) -> None:
        """Stop the process; more than once does no harm."""
        self._closed = True
        if self._process.poll() is None or self._reader.is_alive():
            self._stop()
            self._reader.join()
            assert self._process.stdout is not None
            self._process.stdout.close()

    def __enter__(self) -> CyclicControl:
        """The process, already running."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop it."""
        self.close()

    def _started(self, host: str, port: int) -> int:
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            how = how_ended(self._process.wait())
            raise ProcessDiedError(f"the process of the cyclic I/O ended at once, {how}")
        started = json.loads(line)
        if "port" not in started:
            raise EnipError(
                f"cyclic I/O cannot use UDP port {port} of {host}: {started['error']}",
                hint="end what uses the port, or choose another address of this machine",
            )
        return int(started["port"])

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            message = json.loads(line)
            self._on_ended(message["ended"], EndReason(message["reason"]))

    def _order(self, order: dict[str, Any]) -> None:
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(json.dumps(order) + "\n")
            self._process.stdin.flush()
        except (OSError, ValueError):  # a broken pipe, a closed file
            raise ProcessDiedError(
                self.failure or "the process of the cyclic I/O has ended"
            ) from None

    def _stop(self) -> None:
        # The end of its standard input is the process's sign to end.
        assert self._process.stdin is not None
        with suppress(OSError):  # it has ended with an order unread
            self._process.stdin.close()
        try:
            self._process.wait(_STOP_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
