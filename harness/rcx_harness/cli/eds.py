"""`rcx eds`: the virtual controller's electronic data sheet for PLC tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import duration_us, identity_revision
from rcx_harness.enip.eds import eds_text
from rcx_harness.enip.options import AdapterOptions, Identity
from rcx_harness.spec.wire import SIZE
from structured_text.export.output import Output, write

__all__ = ["eds"]


def eds(
    file: Annotated[
        Path | None, typer.Argument(help="File to write. Default: standard output.")
    ] = None,
    size: Annotated[
        int, typer.Option(help="Bytes of the areas that the sheet proposes: 48 or 256.")
    ] = SIZE,
    product_code: Annotated[int, typer.Option(help="The same value as for `rcx serve`.")] = 5,
    revision: Annotated[str, typer.Option(help="The same value as for `rcx serve`.")] = "1.1",
    rpi_min: Annotated[str, typer.Option(help="The same value as for `rcx serve`.")] = "2ms",
    force: Annotated[bool, typer.Option("--force", help="Overwrite an existing file.")] = False,
) -> None:
    """Write the virtual controller's electronic data sheet (EDS) for a PLC's configuration tool.

    The file describes the simulation only. Use the vendor's file for a real controller.

    Exit code: 0, or 2 on bad input or if the file exists.
    """
    major, minor = identity_revision(revision)
    identity = Identity(product_code=product_code, major_revision=major, minor_revision=minor)
    options = AdapterOptions(rpi_min_us=duration_us("--rpi-min", rpi_min))
    text = eds_text(size, identity, options)
    if file is None:
        print(text, end="")
        return
    write(Output({"": text}, mark="written by `rcx eds`"), file, force=force)
    print(f"written: {file}")
