"""The command `rcx bridge`."""

from __future__ import annotations

from typing import Annotated

import typer

from rcx_harness.cli.options import check_ipv4, duration_us, host_port
from rcx_harness.enip.originator.client import PORT
from rcx_harness.spec.wire import SIZE
from structured_text.errors import InputError

__all__ = ["bridge"]

_SHORTEST_US, _LONGEST_US = 1_000, 1_000_000


def bridge(
    plc: Annotated[str, typer.Option(help="Modbus TCP server of the PLC: HOST or HOST:PORT.")],
    robot: Annotated[str, typer.Option(help="The controller, real or virtual: HOST or HOST:PORT.")],
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE,
    read: Annotated[
        int, typer.Option(help="First holding register of the PLC's outputs; OpenPLC: %QW0 is 0.")
    ] = 0,
    write: Annotated[
        int, typer.Option(help="First holding register to write; OpenPLC: %MW0 is 1024.")
    ] = 1024,
    unit: Annotated[int, typer.Option(help="Modbus unit identifier, 0 to 255.")] = 1,
    period: Annotated[str, typer.Option(help="Period of the exchange with the PLC.")] = "10ms",
    rpi: Annotated[str, typer.Option(help="Packet interval of the controller.")] = "10ms",
    timeout: Annotated[
        str,
        typer.Option(help="Longest time between two reads of the PLC; its Margin must cover it."),
    ] = "100ms",
    heartbeat: Annotated[
        str,
        typer.Option(
            help="Longest time without a change of the PLC's heartbeat word; 0s: no check."
        ),
    ] = "500ms",
    hold: Annotated[
        str, typer.Option(help="Shortest time to report a loss to the PLC: two of its scans.")
    ] = "200ms",
    wait: Annotated[
        bool, typer.Option("--wait", help="Start even if a side cannot be reached yet.")
    ] = False,
    address: Annotated[
        str, typer.Option("--from", help="Local address for the connection to the controller.")
    ] = "",
    quiet: Annotated[bool, typer.Option("--quiet", help="Print errors only.")] = False,
) -> None:
    """Bridge a PLC with Modbus TCP, such as OpenPLC, and a controller on EtherNet/IP.

    If one side is lost, the bridge puts the other side into its safe state. It continues by itself
    when both sides are back and the PLC has cleared its outputs. Ctrl-C ends it.

    Exit code: 0, 1 if it ended by itself, 2 on bad input or if one side cannot be reached.
    """
    try:
        from rcx_harness.bridge.core import Limits, Registers
        from rcx_harness.bridge.run import BridgeOptions
        from rcx_harness.bridge.run import bridge as run_bridge
    except ModuleNotFoundError as error:
        if error.name is None or not error.name.startswith("pymodbus"):
            raise
        hint = "pip install pymodbus"
        raise InputError("rcx bridge needs the library pymodbus", hint=hint) from None
    if not 0 <= unit <= 0xFF:
        raise InputError(f"--unit {unit} is not a unit identifier", hint="use 0 to 255")
    if address:
        check_ipv4("--from", address)
    period_us, rpi_us = duration_us("--period", period), duration_us("--rpi", rpi)
    gap_us = duration_us("--timeout", timeout)
    for name, given, given_us in (("--period", period, period_us), ("--rpi", rpi, rpi_us)):
        if not _SHORTEST_US <= given_us <= _LONGEST_US:
            raise InputError(f"{name} {given} cannot be served", hint="use 1ms to 1s")
    if gap_us < 2 * period_us:
        hint = "give a longer --timeout or a shorter --period"
        raise InputError(f"--timeout {timeout} is less than two periods of {period}", hint=hint)
    plc_host, plc_port = host_port("--plc", plc, 502)
    robot_host, robot_port = host_port("--robot", robot, PORT)
    options = BridgeOptions(
        plc_host=plc_host,
        plc_port=plc_port,
        robot=robot_host,
        robot_port=robot_port,
        address=address,
        registers=Registers(read, write, size),
        unit=unit,
        period_us=period_us,
        rpi_us=rpi_us,
        limits=Limits(
            gap_us=gap_us,
            beat_us=duration_us("--heartbeat", heartbeat),
            hold_us=duration_us("--hold", hold),
        ),
        wait=wait,
        quiet=quiet,
    )
    if code := run_bridge(options):
        raise typer.Exit(code)
