"""`rcx mcp`: a server with which an assistant checks, runs and proves programs."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import duration_us
from structured_text.errors import InputError

__all__ = ["mcp_"]

#: The module that answers a call in its own process.
_ENTRY = "rcx_harness.cli.mcp_child"
_LEAST_MEMORY, _MOST_MEMORY = 256, 1 << 20
_AT_A_TERMINAL = """\
This server is for an assistant, which starts it and talks to it over standard input and output
(Model Context Protocol). Ctrl-C ends it. A typical entry in the settings of an assistant:

  {"mcpServers": {"rcx": {"command": "rcx", "args": ["mcp", "--folder", "/path/of/the/project"]}}}

docs/how-to/assistant.md shows the settings of common assistants."""


def mcp_(
    folder: Annotated[
        list[Path] | None,
        typer.Option(help="Folder that the assistant may use; repeatable. Default: this folder."),
    ] = None,
    limit: Annotated[str, typer.Option(help="Longest real time of a call.")] = "120s",
    memory: Annotated[
        int,
        typer.Option(
            help="Greatest memory of a call [MB]; on Linux.", min=_LEAST_MEMORY, max=_MOST_MEMORY
        ),
    ] = 2048,
) -> None:
    """Serve check, run, prove and more to an assistant, by the Model Context Protocol (MCP).

    The assistant starts this command and talks to it over standard input and output. Calls read
    and write only inside of the given folders, and only below `out` they write. They use no
    network. A call that takes too long or needs too much memory is ended with a message.

    Exit code: 0 when the assistant closes standard input, 2 on bad input.
    """
    limit_us = duration_us("--limit", limit)
    if not limit_us:
        raise InputError("--limit of 0 s is too short", hint="use --limit 10s or longer")
    try:
        from rcx_harness.assistant.folders import Folders
        from rcx_harness.assistant.limits import Limits
        from rcx_harness.assistant.server import serve
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in ("anyio", "jsonschema", "mcp", "mcp_types"):
            raise
        hint = "pip install 'rcx-harness[assistant]'"
        raise InputError("rcx mcp needs the library mcp", hint=hint) from None
    folders = Folders.of(folder or [Path()])
    if sys.stdin.isatty():
        print(_AT_A_TERMINAL, file=sys.stderr, flush=True)
    serve(folders, Limits(limit_us / 1e6, memory), _ENTRY)
