"""`rcx view`: write a recording as a page for a browser."""

from __future__ import annotations

import ipaddress
import sys
import webbrowser
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import Lib, check_ipv4, counted
from rcx_harness.cli.progress import progress_bar
from rcx_harness.look.view import drawn_networks, view_file
from structured_text.bench.outputs import check_outputs
from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["view"]


def view(
    file: Annotated[Path, typer.Argument(help="A trace (jsonl) or a capture (pcapng, pcap).")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File to write. Default: NAME.html beside the recording."),
    ] = None,
    program: Annotated[
        list[Path] | None,
        typer.Option(
            help="Draw the networks of this program: a project with ladder or function blocks; may "
            "be repeated."
        ),
    ] = None,
    lib: Lib = None,
    opened: Annotated[bool, typer.Option("--open", help="Open it in the browser.")] = False,
    controller: Annotated[
        list[str] | None,
        typer.Option(
            help="In a capture: show only this controller, by its address; may be repeated."
        ),
    ] = None,
) -> None:
    """Write a recording as one page of HTML, which works without a network.

    The page has a time axis to scale with zoom, pan and two cursors. It shows commands in plain
    words, signals, variables, positions and broken rules with their section, and has a search. With
    --program it draws the networks of a ladder or function block diagram, with what had power. For
    this, the trace needs their variables: --watch 'Main.*,Main.*.*' of rcx run.

    Exit code: 0, or 2 on bad input. A truncated file is bad input, too; the page shows the part
    before its end.
    """
    page = file.parent / f"{file.stem}.html" if out is None else out
    check_outputs({"view": page}, None, file, *(program or []))
    for host in controller or []:
        check_ipv4("--controller", host)
    hosts = [ipaddress.IPv4Address(host).packed for host in controller or []]
    with progress_bar("reading", True) as progress:
        networks = drawn_networks(program, lib) if program else ()
        seen = view_file(file, hosts, progress, networks)
    replace_files({page: seen.page})
    print(f"written: {page}, {counted(seen.broken, 'broken rule')}")
    if opened and not webbrowser.open(real(page).as_uri()):
        print(f"rcx: no browser was found; open {page} in one", file=sys.stderr)
    if seen.cut is not None:
        error = seen.cut
        text = f"{error.message}; the part before it is in {page}"
        raise InputError(text, file=file, line=error.line, hint=error.hint)
