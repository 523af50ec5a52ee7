"""The options of a cell, for every command that builds a cell."""

from __future__ import annotations

import inspect
import os
import shlex
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

import typer

from rcx_harness.cell import Cell
from rcx_harness.cli.options import (
    Device,
    Dialect,
    Lib,
    Replace,
    Sources,
    choices,
    replacements,
)
from structured_text.bench.agenda import Duration

__all__ = ["CellOptions"]


@dataclass(frozen=True)
class CellOptions:
    """The options of a cell, with type, default and help.

    An option whose name is an argument of `Cell.build` is passed to this function.
    """

    files: Sources
    lib: Lib = None
    replace: Replace = None
    dialect: Dialect = None
    device: Device = ""
    scan: Annotated[
        str | None, typer.Option(help="Period of the PLC. Default: its task's interval, or 10ms.")
    ] = None
    engine: Annotated[
        str,
        typer.Option(
            help="auto, matiec, builtin or strucpp.",
            autocompletion=choices("auto", "matiec", "builtin", "strucpp"),
        ),
    ] = "auto"
    link: Annotated[
        str,
        typer.Option(
            help="direct, or enip: real EtherNet/IP.", autocompletion=choices("direct", "enip")
        ),
    ] = "direct"
    size: Annotated[
        int | None, typer.Option(help="Bytes of the areas, 48 or 256. Default: the robot's, 48.")
    ] = None
    m: Annotated[
        list[int] | None,
        typer.Option("--m", help="First byte of the area in the inputs; once for each robot."),
    ] = None
    n: Annotated[
        list[int] | None,
        typer.Option("--n", help="First byte of the area in the outputs; once for each robot."),
    ] = None
    robot: Annotated[
        list[Path] | None,
        typer.Option(help="Robot file (TOML); repeat it for several robots."),
    ] = None
    rpi: Annotated[str, typer.Option(help="Packet interval.")] = "10ms"
    jitter: Annotated[str, typer.Option(help="Longest delay of a packet.")] = "0ms"
    timeout: Annotated[
        str | None,
        typer.Option(
            help=(
                "Time without packets after which the link is lost. Default: 4 RPI, at least "
                "100ms; with --realtime 32 RPI, at least 320ms."
            )
        ),
    ] = None
    phases: Annotated[
        str, typer.Option(help="zero, random, or e.g. scan=3ms,to_robot=1ms,to_plc=2ms,cycle=1ms.")
    ] = "zero"
    on_loss: Annotated[
        str,
        typer.Option(
            help="The PLC's inputs without a link: hold or clear.",
            autocompletion=choices("hold", "clear"),
        ),
    ] = "hold"

    def of_cell(self) -> dict[str, Any]:
        """Return the arguments of `Cell.build`; an option that is not given has its default."""
        arguments = inspect.signature(Cell.build).parameters
        given = {one.name: getattr(self, one.name) for one in fields(CellOptions)}
        given |= {"replace": replacements(self.replace), "phases": self._phases()}
        return {name: given[name] for name in arguments if given.get(name) not in (None, [])}

    def words(self) -> list[str]:
        """Return these options as words of a command line, quoted for a shell, without defaults."""
        return [shlex.quote(word) for word in self._words()]

    def _words(self) -> Iterator[str]:
        yield from (os.fspath(file) for file in self.files)
        for one in fields(CellOptions):
            value = getattr(self, one.name)
            if one.name == "files" or value == one.default:
                continue
            for each in value if isinstance(value, list) else [value]:
                yield from (f"--{one.name.replace('_', '-')}", str(each))

    def _phases(self) -> str | dict[str, Duration]:
        """Convert phases such as `scan=3ms,cycle=1ms` to a table, but return a word unchanged."""
        if "=" not in self.phases:
            return self.phases
        pairs = [part.partition("=") for part in self.phases.split(",")]
        return {name.strip(): value.strip() for name, _, value in pairs}
