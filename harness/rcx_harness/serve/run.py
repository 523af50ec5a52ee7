"""The course of `rcx serve`: start controllers and page, show them until Ctrl-C, end them."""

from __future__ import annotations

import asyncio
import ipaddress
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from rcx_harness.enip.cyclic.shared import now_us
from rcx_harness.serve.host import Host, Settings
from rcx_harness.serve.lines import Lines
from rcx_harness.serve.stalls import Stalls
from structured_text.errors import InputError
from structured_text.output.system import told_to_end

__all__ = ["serve", "warnings"]

if TYPE_CHECKING:
    from rcx_harness.serve.web import WebServer

_SHOW_EVERY_S = 0.25


async def serve(every: Sequence[Settings], web_port: int | None, *, quiet: bool) -> int:
    """Serve controllers until SIGINT or SIGTERM.

    `web_port` is 0 for any free port and None for no page. With `quiet` only problems are printed.

    Returns:
        0 after a signal; 1 if a part of a controller has ended by itself. All controllers are then
        ended.

    Raises:
        InputError: a controller or the page cannot be served, or aiohttp is missing.
        OSError: the output cannot be written; all controllers are then ended.
    """
    stop = asyncio.Event()
    loop = asyncio.get_running_loop()
    with told_to_end(lambda: loop.call_soon_threadsafe(stop.set)):
        return await _serve(every, web_port, stop, quiet=quiet)


async def _serve(
    every: Sequence[Settings], web_port: int | None, stop: asyncio.Event, *, quiet: bool
) -> int:
    hosts = [Host(settings) for settings in every]
    page = _page(hosts, web_port)
    try:
        await _start(hosts, stop)
        # printed even after an early signal, because the port was open
        for line in warnings(every):
            print(f"rcx: {line}", file=sys.stderr, flush=True)
        if page is not None and not stop.is_set():
            await page.start()
        if stop.is_set():
            return 0
        if not quiet:
            _announce(hosts, page)
        shown = asyncio.create_task(_show(hosts, quiet))
        watching = asyncio.create_task(_watch(hosts))
        await _until(stop, hosts, shown)
        watching.cancel()
        with suppress(asyncio.CancelledError):
            shown.result()  # raises if the output cannot be written
        dead = [host for host in hosts if host.ended.is_set()]
        for host in dead:
            print(f"rcx: controller {host.name} is gone: {host.failure}", file=sys.stderr)
        return 1 if dead else 0
    finally:
        if page is not None:
            await page.close()
        await asyncio.gather(*(host.close() for host in hosts))


def warnings(every: Sequence[Settings]) -> list[str]:
    """Return a warning for each controller that other computers can reach."""
    beyond = [one.host for one in every if not ipaddress.IPv4Address(one.host).is_loopback]
    return [
        f"warning: {host} can be reached from the network: this simulated controller has no "
        f"password, so everybody who reaches it can drive it; allow only the PLC's network to "
        f"reach it"
        for host in beyond
    ]


def _page(hosts: Sequence[Host], port: int | None) -> WebServer | None:
    if port is None:
        return None
    try:
        from rcx_harness.serve.web import WebServer
    except ModuleNotFoundError:
        hint = "pip install aiohttp"
        raise InputError("the web page needs the library aiohttp", hint=hint) from None
    return WebServer(hosts, port)


async def _start(hosts: Sequence[Host], stop: asyncio.Event) -> None:
    """Start all controllers in parallel; stop at the first failure, or when `stop` is set."""
    starting = [asyncio.create_task(host.start()) for host in hosts]
    ending = asyncio.create_task(_wait(stop))
    waiting: set[asyncio.Task[None]] = set(starting)
    try:
        while waiting and not stop.is_set():
            done, _ = await asyncio.wait({*waiting, ending}, return_when=asyncio.FIRST_COMPLETED)
            for task in done & waiting:
                task.result()
            waiting -= done
    finally:
        ending.cancel()
        for task in waiting:
            task.cancel()
        await asyncio.gather(*starting, return_exceptions=True)


async def _until(stop: asyncio.Event, hosts: Sequence[Host], shown: asyncio.Task[None]) -> None:
    """Wait for the signal, or for the end of a controller or of the display."""
    events = (stop, *(one.ended for one in hosts))
    ends = {*(asyncio.create_task(_wait(event)) for event in events), shown}
    await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
    for task in ends:
        task.cancel()
    await asyncio.gather(*ends, return_exceptions=True)


async def _wait(event: asyncio.Event) -> None:
    await event.wait()


def _announce(hosts: Sequence[Host], page: WebServer | None) -> None:
    for host in hosts:
        settings = host.settings
        print(
            f"serving {settings.host}: TCP and UDP {settings.port}, cyclic UDP {settings.cyclic}, "
            f"{host.size} bytes"
        )
    if page is not None:
        print(f"web page: {page.address}")
    print("Ctrl-C ends it. This is a simulation: no robot moves.", flush=True)


async def _watch(hosts: Sequence[Host]) -> None:
    stalls = Stalls(hosts)
    while True:
        for line in stalls.new(now_us()):
            with suppress(OSError):  # continue if stderr is closed
                print(f"rcx: {line}", file=sys.stderr, flush=True)
        await asyncio.sleep(_SHOW_EVERY_S)


async def _show(hosts: Sequence[Host], quiet: bool) -> None:
    if quiet:
        await asyncio.Event().wait()
    if sys.stdout.isatty():
        # rich needs 2 MiB of memory, so it is imported only if it is used
        from rcx_harness.serve.terminal import show

        await show(hosts, _SHOW_EVERY_S)
    lines = Lines(hosts)
    while True:
        for line in lines.new():
            print(line, flush=True)
        await asyncio.sleep(_SHOW_EVERY_S)
