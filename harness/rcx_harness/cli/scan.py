"""`rcx scan`: look at a controller as a PLC's scanner does."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import check_ipv4, check_port, duration_us, interval_us
from rcx_harness.cli.options import config_data as data_of
from rcx_harness.cli.options import config_instance as instance_of
from rcx_harness.enip.cyclic.connections import ConnectionKind
from rcx_harness.enip.originator.client import PORT
from rcx_harness.enip.originator.scanner import Assemblies
from rcx_harness.look.look import ScanOptions
from rcx_harness.look.look import scan as look
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.bench.outputs import check_outputs
from structured_text.errors import InputError

__all__ = ["scan"]


def scan(
    host: Annotated[str, typer.Argument(help="Address of the controller, real or virtual.")],
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE,
    rpi: Annotated[str, typer.Option(help="Packet interval.")] = "10ms",
    duration: Annotated[
        str, typer.Option("--for", help="Time to print changes; 0s: print the areas once.")
    ] = "5s",
    input_only: Annotated[
        bool,
        typer.Option("--input-only", help="Read only, with or without another master (default)."),
    ] = False,
    listen_only: Annotated[
        bool, typer.Option("--listen-only", help="Listen to an existing connection (listen only).")
    ] = False,
    write: Annotated[
        list[str] | None,
        typer.Option(
            help="Become the master and write, e.g. SI00=1, SI(20)=1, SIW(2)=5; all else 0."
        ),
    ] = None,
    heartbeat: Annotated[
        int | None, typer.Option(help="Connection point of a reader's heartbeat, if unusual.")
    ] = None,
    config_instance: Annotated[
        str, typer.Option(help="Configuration instance to name: a number, or none.")
    ] = "none",
    config_data: Annotated[
        str, typer.Option(help="Data for the configuration instance, in hexadecimal.")
    ] = "",
    input_size: Annotated[
        int | None, typer.Option(help="Number of bytes from an adapter of another kind.")
    ] = None,
    output_size: Annotated[
        int | None,
        typer.Option(help="Number of bytes to an adapter of another kind; write --write 3=0x12."),
    ] = None,
    input_instance: Annotated[int, typer.Option(help="Assembly from the adapter.")] = 100,
    output_instance: Annotated[int, typer.Option(help="Assembly to the adapter.")] = 150,
    trace: Annotated[
        Path | None, typer.Option(help="Write the observed areas as a trace (JSON lines).")
    ] = None,
    port: Annotated[int, typer.Option(help="TCP port of the controller.")] = PORT,
    address: Annotated[str, typer.Option("--from", help="Local address for the connection.")] = "",
) -> None:
    """Open a cyclic connection as a PLC does, and print identity, both areas and every change.

    Without --write the connection carries no data to the robot. With --write this command is the
    master of the robot; when it ends, the robot has lost its master.

    Exit code: 0, 1 if the connection was lost on the way, 2 if there was none.
    """
    if sum((input_only, listen_only, bool(write))) > 1:
        raise InputError("--input-only, --listen-only and --write exclude each other")
    check_size(size)
    check_port("--port", port)
    check_outputs({"trace": trace}, None)
    if heartbeat is not None and not 1 <= heartbeat <= 0xFFFF:
        hint = "use 1 to 65535"
        raise InputError(f"--heartbeat {heartbeat} is not a connection point", hint=hint)
    if address:
        check_ipv4("--from", address)
    asked = Assemblies(
        size if input_size is None else input_size,
        size if output_size is None else output_size,
        input_instance,
        output_instance,
        heartbeat,
        instance_of(config_instance),
        data_of(config_data),
    )
    kind = ConnectionKind.EXCLUSIVE_OWNER if write else ConnectionKind.INPUT_ONLY
    options = ScanOptions(
        host=host,
        assemblies=asked,
        rpi_us=interval_us("--rpi", rpi),
        duration_us=duration_us("--for", duration),
        kind=ConnectionKind.LISTEN_ONLY if listen_only else kind,
        writes=write or (),
        port=port,
        address=address,
        trace=trace,
    )
    try:
        held = look(options, lambda line: print(line, flush=True))
    except KeyboardInterrupt:
        return  # Ctrl-C ends the command; `look` has closed connection and session
    if not held:
        raise typer.Exit(1)
