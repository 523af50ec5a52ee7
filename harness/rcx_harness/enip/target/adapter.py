"""The adapter as its parent process uses it: start, exchange of the two images, stop."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import Any

from rcx_harness.enip.child import Child, how_ended
from rcx_harness.enip.closing import Closing
from rcx_harness.enip.cyclic.shared import SharedImages
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.spec.wire import SIZE, check_size

__all__ = ["MODULE", "Adapter"]

#: The module that runs in the adapter's process.
MODULE = "rcx_harness.enip.target.adapter_process"


class Adapter(Closing):
    """A virtual controller's EtherNet/IP interface, in a separate process.

    It serves explicit messages to the Assemblies 100 (robot to master) and 150 (master to robot;
    manual chapter 1, section 4) and to the objects around them. It answers device searches, and
    opens cyclic connections if it has a port for them. The process ends with `close`, or with its
    parent.

    Args:
        port: TCP and UDP port of explicit messages, 0 for any free one.
        cyclic: UDP port of cyclic I/O, 0 for any free one; None for explicit messages only. An
            adapter without cyclic I/O starts faster.

    Attributes:
        shared: Both assemblies, and the state of the cyclic connections.
    """

    def __init__(
        self,
        size: int = SIZE,
        identity: Identity | None = None,
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        cyclic: int | None = None,
        options: AdapterOptions | None = None,
    ) -> None:
        check_size(size)
        self.size = size
        self._closed = False
        self._failure = ""
        self.shared = SharedImages.create(size)
        settings = {
            "memory": self.shared.name,
            "host": host,
            "port": port,
            "cyclic": cyclic,
            "identity": asdict(identity or Identity()),
            "options": asdict(options or AdapterOptions()),
        }
        try:
            self._child = Child(MODULE, settings, "the EtherNet/IP adapter's process")
        except BaseException:
            self.shared.close()
            raise
        finally:
            # All processes have opened the memory. Once the name of the memory is removed, the
            # system frees the memory after its last use.
            self.shared.unlink()
        started = self._child.started
        if "port" not in started:
            self.close()
            raise _refused(started, f"{host}:{port}")
        self.address: tuple[str, int] = (host, started["port"])
        self.io_port: int | None = started["io_port"]

    @property
    def pid(self) -> int:
        """Return the id of the adapter's process."""
        return self._child.process.pid

    @property
    def alive(self) -> bool:
        """Return whether the adapter's process runs; if not, `shared` shows its last state."""
        return self._child.process.poll() is None

    @property
    def failure(self) -> str:
        """Return a text about the process that has ended unexpectedly; empty if none has."""
        if not self._failure and not self._closed and not self.alive:
            self._failure = self._find_failure()
        return self._failure

    def read_to_robot(self) -> bytes:
        """Return the content of assembly 150 that the master has written last."""
        return self.shared.to_robot.read()

    def write_to_master(self, image: bytes) -> None:
        """Set assembly 100, which the master reads, to exactly `size` bytes."""
        self.shared.to_master.write(image)

    def close(self) -> None:
        """Stop the adapter's process and free the shared memory; a second call does nothing."""
        self._closed = True
        self._child.stop()
        self._child.reports.close()
        self.shared.close()

    def wait_for_failure(self) -> str:
        """Wait briefly for the end of the adapter's process, and return the text of `failure`."""
        if not self._closed:
            self._child.wait_for_code()
        return self.failure

    def _find_failure(self) -> str:
        if last := self._child.reports.readline():
            return f"the EtherNet/IP adapter has ended: {json.loads(last)['died']}"
        how = how_ended(self._child.process.returncode)
        return f"the process of the EtherNet/IP adapter has ended by itself ({how})"


def _refused(started: dict[str, Any], where: str) -> EnipError:
    """Return the error for a process that could not listen."""
    if "refused" in started:
        return EnipError(started["refused"])
    return EnipError(
        f"the EtherNet/IP adapter cannot listen on {where}: {started['error']}",
        hint="choose an address of this machine and a free port",
    )
