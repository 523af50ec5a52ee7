"""`rcx record`: capture the traffic between a PLC and its controllers with Wireshark's tools."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import check_ipv4, check_port, counted, duration_us
from rcx_harness.enip.cyclic.connections import IO_PORT
from rcx_harness.enip.originator.client import PORT
from structured_text.errors import InputError
from structured_text.output import programs
from structured_text.output.system import told_to_end

__all__ = ["record"]

#: The programs that can capture, in the order of preference. Both have the options that are used
#: here.
_TOOLS = ("dumpcap", "tshark")
_INSTALL = "install Wireshark, whose tools dumpcap or tshark capture (Debian: apt install tshark)"
_RIGHTS = "Linux: root, or the group wireshark; macOS: ChmodBPF; Windows: Npcap"


def record(
    file: Annotated[Path, typer.Argument(help="File to write, NAME.pcapng.")],
    interface: Annotated[
        str, typer.Option(help="Network interface, e.g. eth0; usually connected to a mirror port.")
    ] = "",
    host: Annotated[
        list[str] | None,
        typer.Option(help="Capture only this address; may be repeated. Default: all addresses."),
    ] = None,
    duration: Annotated[
        str | None, typer.Option("--for", help="Time to record. Default: until Ctrl-C.")
    ] = None,
    port: Annotated[int, typer.Option(help="TCP port of explicit messages.")] = PORT,
    io_port: Annotated[int, typer.Option(help="UDP port of cyclic I/O.")] = IO_PORT,
) -> None:
    """Capture the traffic between a PLC and its controllers; nothing is sent.

    It starts dumpcap or tshark, which come with Wireshark and have the rights to capture. Begin
    before the PLC connects: the first packets contain the parameters of the connection.
    Then run rcx judge NAME.pcapng.

    Exit code: 0, or 2 if nothing can be captured.
    """
    for name, number in (("--port", port), ("--io-port", io_port)):
        check_port(name, number)
    for one in host or []:
        check_ipv4("--host", one)
    seconds = 0 if duration is None else duration_us("--for", duration) / 1e6
    if os.path.lexists(file):
        raise InputError("already exists", file=file, hint="name another file")
    if file.suffix.lower() != ".pcapng":
        raise InputError("must end with .pcapng", file=file)
    tool = next(filter(None, map(shutil.which, _TOOLS)), None)
    if tool is None:
        raise InputError("neither dumpcap nor tshark was found", hint=_INSTALL)
    if not interface:
        text = f"--interface is missing; the interfaces are: {', '.join(_interfaces(tool))}"
        raise InputError(text, hint=_RIGHTS)
    command = [tool, "-q", "-i", interface, "-f", _filter(host or [], port, io_port)]
    command += ["-w", str(file), *(["-a", f"duration:{seconds:g}"] if seconds else [])]
    print(f"capturing at {interface} with {Path(tool).name}; Ctrl-C ends it", flush=True)
    code, said = _capture(command)
    if code or not os.path.exists(file):
        raise InputError(
            f"cannot capture at {interface}: {said or 'no reason given'}", hint=_RIGHTS
        )
    print(f"written: {file}, {counted(file.stat().st_size, 'byte')}; next: rcx judge {file}")


def _filter(hosts: list[str], port: int, io_port: int) -> str:
    """Return the capture filter in pcap-filter syntax, also for packets with a VLAN tag."""
    wanted = f"(tcp port {port} or udp port {io_port})"
    if hosts:
        wanted = f"({wanted} and ({' or '.join(f'host {one}' for one in hosts)}))"
    return f"{wanted} or (vlan and {wanted})"


def _interfaces(tool: str) -> list[str]:
    """Return the names of the network interfaces at which the tool can capture."""
    found = programs.run([tool, "-D"], text=True)
    lines = [line.split(maxsplit=1) for line in found.stdout.splitlines()]
    return [line[1] for line in lines if len(line) > 1] or ["none at which you may capture"]


def _capture(command: list[str]) -> tuple[int, str]:
    """Run the capture tool to its end; return its exit code, and its last line if it has failed."""
    running: list[programs.Program] = []
    asked = 0

    def end() -> None:
        nonlocal asked
        asked += 1
        for one in running:
            # let the tool write the remaining packets
            (one.terminate if asked == 1 else one.kill)()

    with told_to_end(end), programs.Program(command, stderr=subprocess.PIPE, text=True) as process:
        running.append(process)
        if asked:
            process.terminate()
        _, said = process.communicate()
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    return 0 if asked else process.returncode, lines[-1] if lines else ""
