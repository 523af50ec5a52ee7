"""`rcx serve`: virtual controllers over EtherNet/IP in real time."""

from __future__ import annotations

import asyncio
import ipaddress
from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import check_port, duration_us, identity_revision, interval_us
from rcx_harness.enip.cyclic.connections import IO_PORT
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.enip.originator.client import PORT
from rcx_harness.serve.host import Settings
from rcx_harness.serve.run import serve as serve_controllers
from rcx_harness.spec.wire import check_size
from structured_text.bench.outputs import check_outputs
from structured_text.errors import InputError

__all__ = ["serve"]

#: The address at which the web page is served (see serve/guard.py).
_WEB_HOST = "127.0.0.1"


def serve(
    address: Annotated[
        list[str] | None,
        typer.Option(help="IPv4 address of a controller; once for each. Default: 127.0.0.1."),
    ] = None,
    robot: Annotated[
        list[Path] | None,
        typer.Option(help="Robot file (TOML): one for all, or one per address."),
    ] = None,
    size: Annotated[
        int | None, typer.Option(help="Bytes of the areas, 48 or 256. Default: the robot's, 48.")
    ] = None,
    web: Annotated[
        int | None, typer.Option(help="TCP port of the web page on 127.0.0.1; 0: any free one.")
    ] = None,
    rpi_min: Annotated[
        str, typer.Option(help="Smallest packet interval that is accepted, from 1ms.")
    ] = "2ms",
    seed: Annotated[
        int, typer.Option(help="Seed of the random numbers.", min=0, max=2**63 - 1)
    ] = 0,
    product_code: Annotated[int, typer.Option(help="Product code of the identity.")] = 5,
    revision: Annotated[str, typer.Option(help="Revision of the identity.")] = "1.1",
    port: Annotated[int, typer.Option(help="TCP and UDP port of explicit messages.")] = PORT,
    io_port: Annotated[int, typer.Option(help="UDP port of cyclic I/O.")] = IO_PORT,
    first_packet: Annotated[
        str, typer.Option(help="Longest wait for the first packet of a connection, from 10s.")
    ] = "10s",
    trace: Annotated[
        list[Path] | None,
        typer.Option(help="Write the trace of a controller (JSON lines); once for each address."),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", help="Print errors only.")] = False,
) -> None:
    """Serve virtual controllers over EtherNet/IP in real time, for a real PLC.

    Ctrl-C ends it. Exit code: 0, 1 if a controller ended by itself, 2 on bad input.
    """
    addresses = _addresses(address or ["127.0.0.1"])
    robots = _robots(robot or [], len(addresses))
    traces = _traces(trace or [], len(addresses), robot or [])
    if size is not None:
        check_size(size)
    for name, number in (("--port", port), ("--io-port", io_port), ("--web", web or 1)):
        check_port(name, number)
    _check_clashes(addresses, port, io_port, web)
    options = AdapterOptions(
        rpi_min_us=interval_us("--rpi-min", rpi_min),
        first_packet_us=duration_us("--first-packet", first_packet),
    )
    major, minor = identity_revision(revision)
    every = [
        Settings(
            host=one,
            port=port,
            cyclic=io_port,
            robot=file,
            trace=written,
            size=size,
            seed=seed + number,
            identity=Identity(
                product_code=product_code,
                major_revision=major,
                minor_revision=minor,
                serial_number=number + 1,
            ),
            options=options,
        )
        for number, (one, file, written) in enumerate(
            zip(addresses, cycle(robots), traces, strict=False)
        )
    ]
    if code := asyncio.run(serve_controllers(every, web, quiet=quiet)):
        raise typer.Exit(code)


def _addresses(texts: Sequence[str]) -> list[str]:
    for text in texts:
        try:
            ipaddress.IPv4Address(text)
        except ValueError:
            hint = "write it as 127.0.0.1"
            raise InputError(f"{text!r} is not an IPv4 address", hint=hint) from None
    twice = [text for text in texts if texts.count(text) > 1]
    if twice:
        hint = "use 127.0.0.2, 127.0.0.3 ...: they also belong to this computer"
        raise InputError(f"each controller needs its own address, not {twice[0]} twice", hint=hint)
    return list(texts)


def _check_clashes(addresses: Sequence[str], port: int, io_port: int, web: int | None) -> None:
    """Raise InputError if two services would use the same port."""
    if port == io_port:
        raise InputError(
            f"--port and --io-port are both {port}",
            hint="use different ports for explicit and cyclic messages",
        )
    if web == port and _WEB_HOST in addresses:
        hint = "give the page another port"
        raise InputError(f"--web and --port are both {port} of {_WEB_HOST}", hint=hint)


def _robots(files: Sequence[Path], controllers: int) -> list[str]:
    if len(files) > 1 and len(files) != controllers:
        raise InputError(
            f"{len(files)} robot files are given for {controllers} addresses",
            hint="give one for all, or one per address in their order",
        )
    return [str(file) for file in files] or [""]


def _traces(files: Sequence[Path], controllers: int, robots: Sequence[Path]) -> list[str]:
    if files and len(files) != controllers:
        hint = "give one per address, in their order"
        raise InputError(f"{len(files)} traces are given for {controllers} addresses", hint=hint)
    for number, file in enumerate(files):
        check_outputs({"trace": file}, None, *robots, *files[:number])
    return [str(file) for file in files] or [""] * controllers
