"""The command `rcx`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version
from typing import Annotated

import typer

from rcx_harness.cli.bridge import bridge
from rcx_harness.cli.campaign import campaign
from rcx_harness.cli.check import check
from rcx_harness.cli.codec import decode, encode
from rcx_harness.cli.compare import compare
from rcx_harness.cli.debug import debug
from rcx_harness.cli.demo import demo
from rcx_harness.cli.explore import explore
from rcx_harness.cli.export import EPILOG, export
from rcx_harness.cli.import_ import import_
from rcx_harness.cli.judge import judge
from rcx_harness.cli.mutants import mutants, with_command
from rcx_harness.cli.new import new
from rcx_harness.cli.probe import probe
from rcx_harness.cli.prove import prove
from rcx_harness.cli.record import record
from rcx_harness.cli.run import EPILOG as RUN_EPILOG
from rcx_harness.cli.run import run
from rcx_harness.cli.scan import scan
from rcx_harness.cli.serve import eds, serve
from rcx_harness.cli.sweep import sweep
from rcx_harness.cli.view import view
from rcx_harness.errors import InputError

__all__ = ["app", "main"]

app = typer.Typer(
    name="rcx",
    help="Compile the RCX3 function blocks and run them against a virtual robot controller.",
    no_args_is_help=True,
    rich_markup_mode="markdown",
    pretty_exceptions_enable=False,
    add_completion=False,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        print(f"rcx {version('rcx-harness')}")
        raise typer.Exit


@app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Nothing to do before the command."""
    del show_version


app.command(epilog=RUN_EPILOG)(run)
app.command()(check)
app.command()(compare)
app.command()(encode)
app.command()(decode)
app.command()(bridge)
app.command()(campaign)
app.command()(debug)
app.command()(demo)
app.command()(eds)
app.command()(explore)
app.command(epilog=EPILOG)(export)
app.command("import")(import_)
app.command()(judge)
app.command()(mutants)
app.command()(new)
app.command()(probe)
app.command()(prove)
app.command()(record)
app.command()(scan)
app.command()(serve)
app.command()(sweep)
app.command()(view)


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        The exit code: 0, 1 or 2. Bad input is one line on stderr.
    """
    try:
        app(args=with_command(sys.argv[1:] if args is None else args))
    except InputError as error:
        print(f"rcx: {error}", file=sys.stderr)
        return error.exit_code
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0 if done.code is None else 2
    return 0
