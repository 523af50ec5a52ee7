"""`rcx debug`: a debug adapter for editors, on standard input and output or on a port."""

from __future__ import annotations

import os
import socket
import sys
from collections.abc import Mapping
from contextlib import redirect_stdout, suppress
from dataclasses import fields
from difflib import get_close_matches
from pathlib import Path
from secrets import compare_digest, token_urlsafe
from threading import Timer
from typing import Annotated, Any

import typer
from typer.core import TyperOption

from rcx_harness.cell import Cell
from rcx_harness.cell.sources import blame_lib, source_files
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli import no_robot as without
from rcx_harness.cli.options import duration_us, replacements, with_options
from rcx_harness.cli.run import RunOptions
from rcx_harness.cli.vscode_extension import write_extension
from rcx_harness.verify.debug.machine import CellMachine
from rcx_harness.verify.debug.recording import is_recording, opened
from structured_text.bench import Bench
from structured_text.bench import stimulus as stimuli
from structured_text.debug.bench import BenchMachine
from structured_text.debug.protocol import Client
from structured_text.debug.session import Launched, Session
from structured_text.errors import InputError, did_you_mean

__all__ = ["debug", "launched"]

#: The message for a user who starts the command in a terminal.
_AT_A_TERMINAL = """\
rcx debug waits for the requests of an editor (Debug Adapter Protocol) on standard input.
Let your editor start it: rcx debug --vscode FOLDER writes the extension for VS Code,
docs/how-to/debug.md says how for others. Or give clients a port: rcx debug --port 4711.
Ctrl-C ends it."""

_HOST = "127.0.0.1"

#: The options of `rcx run` that a launch may have. All other options write files or need real time.
_OPTIONS = (
    *(
        "duration",
        "scan",
        "stimulus",
        "robot",
        "lib",
        "replace",
        "device",
        "size",
        "m",
        "n",
        "seed",
    ),
    *("rpi", "jitter", "timeout", "phases", "on_loss", "engine", "no_robot", "dialect"),
)
#: The environment variable with the token of the port, and the smallest length of a token.
_TOKEN, _TOKEN_LENGTH = "RCX_DEBUG_TOKEN", 16
#: Time within which a client must launch with the token [s]. Otherwise the client is disconnected.
_PATIENCE_S = 10.0
#: Arguments of a launch that are for the client itself, so they are not options of `rcx run`.
_OF_CLIENTS = (
    *("type", "request", "name", "noDebug", "cwd", "stopOnEntry", "recording", "debugServer"),
    *("token",),
    *("presentation", "preLaunchTask", "postDebugTask", "internalConsoleOptions", "console"),
    *("serverReadyAction", "suppressMultipleSessionWarning", "restart"),
)


def debug(
    files: Annotated[
        list[Path] | None,
        typer.Argument(help="A recording or sources, if the launch of the client has none."),
    ] = None,
    port: Annotated[
        int | None,
        typer.Option(
            help="Wait for clients on this local port; 0: any free one.", min=0, max=65535
        ),
    ] = None,
    vscode: Annotated[
        Path | None,
        typer.Option(help="Write the extension for VS Code into this folder, then end."),
    ] = None,
    no_robot: Annotated[
        bool,
        typer.Option("--no-robot", help="Run the sources without a robot, as rcx run --no-robot."),
    ] = False,
) -> None:
    """Debug a program in an editor, forwards and backwards, by the Debug Adapter Protocol.

    An editor starts the command and talks to it on standard input and output, or on --port. With
    --port the launch request must contain the printed token, or the value of RCX_DEBUG_TOKEN. The
    launch takes options of rcx run: see docs/how-to/debug.md.

    Exit code: 0, or 2 on bad input.
    """
    if vscode is not None:
        write_extension(vscode)
        return
    given = list(files or ())
    if port is not None:
        _serve(port, given, alone=no_robot)
        return
    if sys.stdin.isatty():
        print(_AT_A_TERMINAL, file=sys.stderr, flush=True)
    # A separate stream: sys.stdin cannot be closed at the end while a thread reads from it.
    reading, writing = os.fdopen(os.dup(sys.stdin.fileno()), "rb"), sys.stdout.buffer
    client = Client(reading, writing)
    with redirect_stdout(sys.stderr):  # no other output may reach the client
        code = Session(client, lambda arguments: launched(arguments, given, alone=no_robot)).run()
    if code:
        raise typer.Exit(code)


def _serve(port: int, given: list[Path], *, alone: bool) -> None:
    """Serve clients one after the other, until Ctrl-C."""
    token, told = _token()
    given, folder = [file.absolute() for file in given], Path.cwd()
    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((_HOST, port))
        except OSError as error:
            hint = "choose another port, or end the program that uses it"
            raise InputError(f"--port {port}: {error.strerror}", hint=hint) from None
        listening.listen(1)
        where = f"{_HOST}:{listening.getsockname()[1]}"
        print(f"waiting for a debug client on {where}; Ctrl-C ends", file=sys.stderr)
        print(told, file=sys.stderr, flush=True)
        while True:
            connection, _ = listening.accept()
            with connection:
                try:
                    _one_client(connection, token, given, alone=alone)
                except InputError as error:
                    print(f"rcx: {error}", file=sys.stderr, flush=True)
            os.chdir(folder)  # the last launch may have changed the folder


def _one_client(connection: socket.socket, token: str, given: list[Path], *, alone: bool) -> None:
    """Serve a client that launches with the token in time; other clients are disconnected."""

    def end() -> None:
        with suppress(OSError):  # the client has disconnected
            connection.shutdown(socket.SHUT_RDWR)

    patience = Timer(_PATIENCE_S, end)
    patience.daemon = True
    reading, writing = connection.makefile("rb"), connection.makefile("wb")
    client = Client(reading, writing)

    def launch(arguments: Mapping[str, Any]) -> Launched:
        named = arguments.get("token")
        if not isinstance(named, str) or not compare_digest(named.encode(), token.encode()):
            hint = 'write the token that rcx debug has printed, "token": "..."'
            raise InputError(
                "the launch request does not contain the token of this port", hint=hint
            )
        patience.cancel()
        return launched(arguments, given, alone=alone)

    patience.start()
    try:
        Session(client, launch).run()
    finally:
        patience.cancel()
        end()
        client.close()
        for stream in (reading, writing):  # both must be closed, or the client can still send
            with suppress(OSError):
                stream.close()


def _token() -> tuple[str, str]:
    """Return the token of the port, and a line for the user about the token."""
    if not (token := os.environ.get(_TOKEN, "")):
        token = token_urlsafe()
        return token, f'its launch must contain this token: "token": "{token}"'
    if len(token) < _TOKEN_LENGTH:
        hint = f"give at least {_TOKEN_LENGTH} characters, or leave it out"
        raise InputError(f"{_TOKEN} is too short for a token", hint=hint)
    return token, f'its launch must contain the token of {_TOKEN}: "token": "..."'


# --- what a client launches ---------------------------------------------------------------------


def launched(arguments: Mapping[str, Any], given: list[Path], *, alone: bool = False) -> Launched:
    """Build the program or open the recording that a client launches.

    `arguments` are the arguments of the client's request: the options of `rcx run` by their names,
    `sources`, `recording` and `cwd`. `given` are the files of the command line, which are used if
    the client names no files. With `alone`, sources run without a robot.
    """
    folder = arguments.get("cwd")
    if folder is not None:
        try:
            os.chdir(_text("cwd", folder))
        except (OSError, ValueError):
            raise InputError(f"cwd {folder!r} is not a folder") from None
    recording = arguments.get("recording")
    if recording is None and "sources" not in arguments and "program" not in arguments:
        recording = given[0] if len(given) == 1 and is_recording(given[0]) else None
    if recording is not None:
        mixed = [key for key in arguments if key not in _OF_CLIENTS]
        if mixed:
            hint = "leave it out: a recording has its own options"
            raise InputError(f"{mixed[0]} cannot be combined with a recording", hint=hint)
        machine, notice, last = opened(Path(_text("recording", recording)))
        return Launched(machine, notice, last)
    return _of_cell(_options(arguments, given, alone=alone))


def _of_cell(options: RunOptions) -> Launched:
    if options.engine not in ("auto", "builtin"):
        hint = "leave the engine out"
        raise InputError(f"the {options.engine} engine cannot be debugged", hint=hint)
    end_us = duration_us("for", options.duration)
    kind: type[stimuli.Stimulus] = Stimulus
    if options.no_robot:
        kind = without.Stimulus
    stimulus = kind.load(options.stimulus) if options.stimulus is not None else None
    built: dict[str, Any] = {"engine": "builtin", "keep": 1}
    cell: Bench
    try:
        if options.no_robot:
            replaced = replacements(options.replace)
            files = source_files(
                list(options.files), options.lib, replaced, options.dialect, options.device
            )
            cell = options.bench(files, **built)
        else:
            cell = Cell.build(list(options.files), **{**options.of_cell(), **built})
    except InputError as error:
        raise blame_lib(error, options.lib) from None
    try:
        if stimulus is not None:
            stimulus.schedule(cell)
    except BaseException:
        cell.close()
        raise
    late = stimulus.late(end_us) if stimulus is not None else ""
    notice = "\n".join(filter(None, (cell.notice, late)))
    if isinstance(cell, Cell):
        return Launched(CellMachine(cell, end_us, options.duration), notice)
    return Launched(BenchMachine(cell, end_us, options.duration), notice)


def _options(arguments: Mapping[str, Any], given: list[Path], *, alone: bool) -> RunOptions:
    """Return the options of `rcx run` in a launch, checked by the rules of `rcx run`."""
    made: list[RunOptions] = []

    @with_options(RunOptions)
    def launch(options: RunOptions) -> None:
        made.append(options)

    app = typer.Typer(add_completion=False)
    app.command()(launch)
    command = typer.main.get_command(app)
    sources = arguments.get("sources", arguments.get("program"))
    files = list(map(os.fspath, given)) if sources is None else _files(sources)
    if not files:
        raise InputError("no program is named", hint='write "sources": ["plc/Main.st"]')
    options = {
        name: one
        for one in command.params
        if isinstance(one, TyperOption) and (name := str(one.name)) in _OPTIONS
    }
    line = ["--no-robot"] if alone else []
    for key, value in arguments.items():
        if key in (*_OF_CLIENTS, "sources", "program") or key.startswith("__"):
            continue
        option = options.get(_name(key))
        if option is None:
            raise _unknown(key, options)
        if option.is_flag:
            if not isinstance(value, bool):
                raise InputError(f"{key} is not true or false")
            line += [option.opts[0]] * value
            continue
        for one in _several(value):
            if isinstance(one, bool) or not isinstance(one, (str, int, float, type(None))):
                raise InputError(f"{key} is not a text or a number")
            if one is not None:
                line.append(f"{option.opts[0]}={one}")
    try:
        # After `--` no word is an option, so the sources of a client cannot become options.
        command.main([*line, "--", *files], prog_name="launch", standalone_mode=False)
    except Exception as error:
        # some versions of typer contain a copy of click, other versions depend on click
        told = getattr(error, "format_message", None)
        if told is None:
            raise
        raise InputError(told().rstrip(".")) from None
    return made[0]


def _files(sources: Any) -> list[str]:
    """Return the sources that a launch names."""
    found = [_text("sources", one) for one in _several(sources)]
    for one in found:
        if one.startswith("-"):
            hint = f"write options as keys of the launch; for a file of this name write ./{one}"
            raise InputError(f"sources: {one} is an option, not a file", hint=hint)
    return found


def _text(key: str, value: Any) -> str:
    """Return the value of a key; raise InputError if it is not a text."""
    if not isinstance(value, str):
        raise InputError(f"{key} is not a text")
    return value


def _several(value: Any) -> list[Any]:
    return list(value) if isinstance(value, (list, tuple)) else [value]


def _name(key: str) -> str:
    """Return the field name of a launch option, for example `on_loss` for `onLoss`."""
    plain = "".join(f"_{c.lower()}" if c.isupper() else c for c in key).replace("-", "_")
    return "duration" if plain == "for" else plain


def _unknown(key: str, options: Mapping[str, Any]) -> InputError:
    if _name(key) in {one.name for one in fields(RunOptions)}:
        return InputError(f"{key} is an option of rcx run, not of rcx debug", hint="leave it out")
    near = did_you_mean(get_close_matches(_name(key), options, n=1))
    return InputError(f"launch has no option {key!r}", hint=near or f"use {', '.join(options)}")
