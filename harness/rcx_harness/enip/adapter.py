"""The adapter as its parent holds it: start, the two images, stop."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import asdict
from multiprocessing.shared_memory import SharedMemory
from types import TracebackType

from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.identity import Identity
from rcx_harness.errors import InputError

__all__ = ["Adapter"]

_MODULE = "rcx_harness.enip.adapter_process"
_SIZES = (48, 256)
_STOP_S = 5.0


class Adapter:
    """A virtual controller's EtherNet/IP interface, in a process of its own.

    It serves explicit messages over TCP: Identity, Message Router, and the Assemblies 100 (robot
    to master) and 150 (master to robot; manual chapter 1, section 4). The process ends with
    `close`, or with its parent.

    Args:
        size: Bytes of each assembly, 48 or 256.
        identity: What the Identity object shows.
        host: IPv4 address to listen on.
        port: TCP port, 0 for any free one.

    Attributes:
        size: As given.
        address: Host and port it listens on.

    Raises:
        InputError: a size that the controller does not have.
        EnipError: it could not listen there, or did not start.
    """

    def __init__(
        self,
        size: int = 48,
        identity: Identity | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
    ) -> None:
        if size not in _SIZES:
            raise InputError(
                f"the areas cannot be {size} bytes long",
                hint="the controller has 48 bytes, or 256 with its word extension",
            )
        self.size = size
        self._process: subprocess.Popen[str] | None = None
        # Assembly 100, then 150. Not locked: in lock-step only one side is at work at a time.
        self._memory = SharedMemory(create=True, size=2 * size)
        assert self._memory.buf is not None
        self._images = self._memory.buf
        try:
            port = self._start(identity or Identity(), host, port)
        except BaseException:
            self.close()
            raise
        finally:
            # Both sides have it open now. Without a name nothing is left behind, however we end.
            self._memory.unlink()
        self.address: tuple[str, int] = (host, port)

    def read_to_robot(self) -> bytes:
        """What the master has written last: assembly 150."""
        return bytes(self._images[self.size : 2 * self.size])

    def write_to_master(self, image: bytes) -> None:
        """Set what the master reads, assembly 100; exactly `size` bytes."""
        self._images[: self.size] = image

    def close(self) -> None:
        """Stop the process and free the memory; more than once does no harm."""
        if self._process is not None:
            # The end of its standard input is the process's sign to end.
            for pipe in (self._process.stdin, self._process.stdout):
                if pipe is not None:
                    pipe.close()
            try:
                self._process.wait(_STOP_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._memory.close()

    def __enter__(self) -> Adapter:
        """The adapter, already running."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Stop it."""
        self.close()

    def _start(self, identity: Identity, host: str, port: int) -> int:
        """Start the process and wait until it listens; return its port."""
        settings = {
            "memory": self._memory.name,
            "size": self.size,
            "host": host,
            "port": port,
            "identity": asdict(identity),
        }
        self._process = subprocess.Popen(
            [sys.executable, "-m", _MODULE, json.dumps(settings)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self._process.stdout is not None
        line = self._process.stdout.readline()
        if not line:
            code = self._process.wait()
            raise EnipError(f"the EtherNet/IP adapter's process ended at once, exit code {code}")
        started = json.loads(line)
        if "port" not in started:
            raise EnipError(
                f"the EtherNet/IP adapter cannot listen on {host}:{port}: {started['error']}",
                hint="choose an address of this machine and a free port",
            )
        return int(started["port"])
