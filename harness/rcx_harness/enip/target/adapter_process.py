"""The process of the adapter: the device with its TCP and UDP ports.

`rcx_harness.enip.target.adapter` starts the process with its settings as JSON. The process reports
on standard output where it listens, or why it cannot listen. The process ends when its standard
input ends, at the latest with its parent.
"""

from __future__ import annotations

import asyncio
import itertools
import json
import os
import random
import signal
import socket
import sys
import threading
from contextlib import suppress
from dataclasses import asdict
from typing import Any

from rcx_harness.enip import child
from rcx_harness.enip.child import tell
from rcx_harness.enip.cyclic.connections import EndReason, OwnerState
from rcx_harness.enip.cyclic.control import CyclicControl
from rcx_harness.enip.cyclic.journal import RefusedOpen
from rcx_harness.enip.cyclic.shared import LinkState, SharedImages, Word, now_us
from rcx_harness.enip.errors import EnipError
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.target.device import Device
from rcx_harness.enip.target.listing import Datagrams
from rcx_harness.enip.target.network_interface import (
    NetworkInterface,
    address_toward,
    find_interface,
)
from rcx_harness.enip.target.servers import TcpServer, UdpServer

__all__ = ["main"]

_LOOK_S, _LOOKS_PER_CHECK = 0.05, 20
_LONGEST_TEXT = 900  # longest text in a record of the journal
_TRIES = 20  # number of attempts to find a port that is free for both TCP and UDP


def main(argument: str) -> None:
    """Run the adapter until the parent closes our standard input.

    Args:
        argument: JSON object with `memory` (name of the shared images), `host`, `port` (0: any
            free one), `cyclic` (UDP port of class 1, null for none), `identity` and `options`.
    """
    # Ctrl-C reaches the whole process group; the parent decides when the adapter ends.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    settings = json.loads(argument)
    try:
        shared = SharedImages.attach(settings["memory"])
    except FileNotFoundError:  # the parent has ended and its memory is gone
        return
    with shared:
        asyncio.run(_Adapter(settings, shared).run())


class _Adapter:
    """The sockets of the device, and its periodic tasks."""

    def __init__(self, settings: dict[str, Any], shared: SharedImages) -> None:
        self._settings = settings
        self._shared = shared
        self._control: CyclicControl | None = None
        self._device: Device | None = None
        self._failure = ""

    async def run(self) -> None:
        """Serve until the parent or the cyclic process has ended."""
        self._loop = asyncio.get_running_loop()
        try:
            await self._start()
        except EnipError as error:
            tell({"refused": str(error)})
        # A bad port or host name also raises one of these errors.
        except (OSError, OverflowError, UnicodeError) as error:
            tell({"error": str(error)})
        else:
            await self._until_parent_gone()
            self._server.close()
            self._tcp.close_all()
            if self._failure:
                tell({"died": self._failure})
                sys.exit(1)
        finally:
            if self._control is not None:
                self._control.close()

    async def _start(self) -> None:
        """Open all ports, and report them to the parent.

        Raises:
            EnipError: The port of cyclic I/O is in use.
            OSError: The TCP or UDP port is in use, or the address does not belong to this machine.
        """
        host = socket.gethostbyname(self._settings["host"])
        if self._settings["cyclic"] is not None:
            self._control = self._start_cyclic(host, self._settings["cyclic"])
        interface = find_interface(address_toward(host))
        self._device = device = self._make_device(interface)
        self._tcp = TcpServer(device)
        device.on_reset = self._reset
        datagrams = Datagrams(device.listing, random.random)
        wanted = self._settings["port"]
        for left in reversed(range(1 if wanted else _TRIES)):
            self._server = await self._loop.create_server(
                self._tcp.protocol, host, wanted, family=socket.AF_INET
            )
            local = host, self._server.sockets[0].getsockname()[1]
            try:
                self._udp = UdpServer(
                    datagrams,
                    local,
                    interface.broadcast_addresses(),
                    device.objects.explicit_dscp,
                )
                break
            except OSError:
                self._server.close()
                if not left:
                    raise
        await self._udp.start()
        tell({"port": local[1], "io_port": self._control.port if self._control else None})

    def _start_cyclic(self, host: str, port: int) -> CyclicControl:
        def ended(number: int, reason: EndReason) -> None:
            with suppress(RuntimeError):  # the event loop may already have ended
                self._loop.call_soon_threadsafe(self._ended, number)

        return CyclicControl(self._shared.name, host, port, ended)

    def _make_device(self, interface: NetworkInterface) -> Device:
        return Device(
            self._shared.to_master,
            self._shared.to_robot,
            Identity(**self._settings["identity"]),
            AdapterOptions(**self._settings["options"]),
            self._control,
            lambda: self._shared.owner,
            interface,
            on_refused=self._note_refused,
        )

    def _note_refused(self, text: str) -> None:
        self._shared.refusals.write(asdict(RefusedOpen(now_us(), text[:_LONGEST_TEXT])))

    def _reset(self) -> None:
        # Close after the reply to the reset has been sent.
        self._loop.call_soon(self._tcp.close_all)

    def _ended(self, number: int) -> None:
        if self._device is not None:
            self._device.connections.ended(number)

    async def _until_parent_gone(self) -> None:
        parent_gone = asyncio.Event()

        def wait_for_parent() -> None:
            while os.read(0, 1):
                pass
            self._loop.call_soon_threadsafe(parent_gone.set)

        # A thread waits, because the event loop of some platforms cannot wait for a pipe.
        threading.Thread(target=wait_for_parent, daemon=True).start()
        waiting = asyncio.create_task(parent_gone.wait())
        looking = asyncio.create_task(self._look())
        await asyncio.wait((waiting, looking), return_when=asyncio.FIRST_COMPLETED)
        waiting.cancel()
        if looking.done():
            looking.result()  # raises the error that has ended the task
        looking.cancel()

    def _lose_cyclic_part(self, device: Device) -> None:
        """Publish the loss of the owner, because the cyclic process has ended and cannot do it."""
        device.connections.forget_cyclic()
        if self._shared.owner in (OwnerState.WAITING, OwnerState.RUN, OwnerState.IDLE):
            self._shared.set_owner(OwnerState.TIMED_OUT, None)

    async def _look(self) -> None:
        """Check link state and time-outs every second, until one of the processes ends."""
        assert self._device is not None
        for turn in itertools.count():
            self._shared.beat(Word.ADAPTER_ALIVE, now_us())
            link = self._shared.link
            self._tcp.accepts = self._udp.answers = link is LinkState.UP
            if link is not LinkState.UP:
                self._tcp.abort_all()
            if turn % _LOOKS_PER_CHECK == 0:
                self._tcp.close_overdue()
                self._device.connections.expire()
            if self._control is not None and not self._control.alive:
                self._failure = self._control.failure
                self._lose_cyclic_part(self._device)
                return
            await asyncio.sleep(_LOOK_S)


if __name__ == "__main__":
    child.run(main)
