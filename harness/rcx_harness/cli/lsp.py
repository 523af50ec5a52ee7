"""`rcx lsp`: a language server for editors, on standard input and output."""

from __future__ import annotations

import gc
import logging
import os
import sys
from contextlib import redirect_stdout
from multiprocessing import get_context
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.vscode_extension import write_extension
from structured_text.errors import InputError

__all__ = ["lsp"]

#: The message for a user who starts the command in a terminal.
_AT_A_TERMINAL = """\
rcx lsp waits for the messages of an editor (Language Server Protocol) on standard input.
Let your editor start it: docs/how-to/editor.md says how for VS Code, Neovim and others.
Ctrl-C ends it."""


def _quietly() -> None:
    """Keep output of the process for slow checks away from the editor."""
    os.dup2(2, 1)


def lsp(
    vscode: Annotated[
        Path | None,
        typer.Option(help="Write the extension for VS Code into this folder, then end."),
    ] = None,
) -> None:
    """Show mistakes while you type, in an editor that knows the Language Server Protocol.

    An editor starts the command and talks to it on standard input and output. It gets mistakes and
    warnings of rcx check after each pause of typing, and what is known of the name at the cursor.
    Settings and editors: docs/how-to/editor.md.

    Exit code: 0, or 2 if the package pygls is missing.
    """
    if vscode is not None:
        write_extension(vscode)
        return
    try:
        from structured_text.editor.server import Server
    except ModuleNotFoundError as error:
        if error.name not in ("pygls", "lsprotocol"):
            raise
        raise InputError(
            "rcx lsp needs the package pygls",
            hint="install it: pip install 'rcx-harness[editor]'",
        ) from None
    from concurrent.futures import ProcessPoolExecutor

    from rcx_harness.editor.extras import RobotExtras

    if sys.stdin.isatty():
        print(_AT_A_TERMINAL, file=sys.stderr, flush=True)
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING)
    # Separate streams: the server closes them, and no other output may reach the editor.
    reading, writing = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    slow = ProcessPoolExecutor(1, get_context("spawn"), _quietly)
    server = Server(RobotExtras(), slow, gc.freeze)
    with redirect_stdout(sys.stderr):
        try:
            server.start_io(reading, writing)
        finally:
            server.end()
