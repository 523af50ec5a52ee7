"""The command `rcx`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cell import EVENTS
from rcx_harness.cell.clock import Duration
from rcx_harness.cli.bridge import bridge
from rcx_harness.cli.check import check as check_files
from rcx_harness.cli.codec import decode as print_decoded
from rcx_harness.cli.codec import encode as print_encoded
from rcx_harness.cli.eds import eds
from rcx_harness.cli.export import EPILOG, export
from rcx_harness.cli.new import new
from rcx_harness.cli.run import RunOptions
from rcx_harness.cli.run import run as run_cell
from rcx_harness.cli.run_report import RunProgress, print_outcome
from rcx_harness.cli.scan import scan
from rcx_harness.cli.serve import serve
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

_EVENTS = "Events of a stimulus:\n\n" + "\n".join(f"- {one}: {EVENTS[one]}" for one in EVENTS)


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


@app.command(epilog=_EVENTS)
def run(
    files: Annotated[list[Path], typer.Argument(help="ST files, or folders of them.")],
    lib: Annotated[
        Path | None, typer.Option(help="Folder of the library. Default: that of this package.")
    ] = None,
    scan: Annotated[
        str | None, typer.Option(help="Period of the PLC. Default: its task's interval, or 10ms.")
    ] = None,
    duration: Annotated[str, typer.Option("--for", help="Virtual time to run.")] = "5s",
    engine: Annotated[str, typer.Option(help="auto, matiec or builtin.")] = "auto",
    link: Annotated[str, typer.Option(help="direct, or enip: real EtherNet/IP.")] = "direct",
    realtime: Annotated[
        bool, typer.Option("--realtime", help="With --link enip: cyclic I/O, at the clock's pace.")
    ] = False,
    size: Annotated[
        int | None, typer.Option(help="Bytes of the areas, 48 or 256. Default: the robot's, 48.")
    ] = None,
    m: Annotated[
        list[int] | None,
        typer.Option("--m", help="Where in the inputs the area begins; once for each robot."),
    ] = None,
    n: Annotated[
        list[int] | None,
        typer.Option("--n", help="Where in the outputs the area begins; once for each robot."),
    ] = None,
    robot: Annotated[
        list[Path] | None,
        typer.Option(help="Properties of the robot (TOML); of several robots once for each."),
    ] = None,
    stimulus: Annotated[Path | None, typer.Option(help="What happens when (TOML).")] = None,
    seed: Annotated[int, typer.Option(help="Seed of all that is drawn.", min=0, max=2**63 - 1)] = 0,
    rpi: Annotated[str, typer.Option(help="Packet interval.")] = "10ms",
    jitter: Annotated[str, typer.Option(help="Greatest delay of a packet.")] = "0ms",
    timeout: Annotated[
        str | None,
        typer.Option(
            help="Loss of the link. Default: 4 RPI, at least 100ms; "
            "with --realtime 32 RPI, at least 320ms."
        ),
    ] = None,
    phases: Annotated[
        str, typer.Option(help="zero, random, or e.g. scan=3ms,to_robot=1ms,to_plc=2ms,cycle=1ms.")
    ] = "zero",
    on_loss: Annotated[
        str, typer.Option(help="The PLC's inputs without a link: hold or clear.")
    ] = "hold",
    trace: Annotated[Path | None, typer.Option(help="Write the trace (JSON lines).")] = None,
    chart: Annotated[Path | None, typer.Option(help="Write the timing chart (SVG).")] = None,
    vcd: Annotated[Path | None, typer.Option(help="Write a wave file (VCD).")] = None,
    watch: Annotated[
        list[str] | None, typer.Option(help="Variable for the trace, e.g. Main.Robot.Status.")
    ] = None,
    show: Annotated[
        bool, typer.Option("--show/--no-show", help="Print the timing chart at the end.")
    ] = False,
) -> None:
    """Run a program in a virtual cell.

    Exit code: 0 without a violation, 1 with violations, 2 on bad input.
    """
    options = RunOptions(
        files=files,
        lib=lib,
        scan=scan,
        duration=duration,
        engine=engine,
        link=link,
        realtime=realtime,
        size=size,
        m=m or 0,
        n=n or 0,
        robot=robot or None,
        stimulus=stimulus,
        seed=seed,
        rpi=rpi,
        jitter=jitter,
        timeout=timeout,
        phases=_phases(phases),
        on_loss=on_loss,
        trace=trace,
        chart=chart,
        vcd=vcd,
        watch=watch or [],
    )
    with RunProgress() as progress:
        outcome = run_cell(options, progress)
    print_outcome(outcome, show=show)
    if outcome.violations:
        raise typer.Exit(1)


@app.command()
def check(
    files: Annotated[list[Path], typer.Argument(help="ST files, or folders of them.")],
    lib: Annotated[
        Path | None, typer.Option(help="Folder of the library. Default: that of this package.")
    ] = None,
    lint: Annotated[
        bool, typer.Option("--lint", help="Only the portability rules; they bind every file.")
    ] = False,
) -> None:
    """Check ST sources: syntax, types, portability, calls; with matiec too, where it is found.

    Calls: each block of a robot once per scan, between FB_ReadArea and FB_WriteArea.

    Exit code: 0 if all is well (warnings allowed), 1 if a rule of the library or of its calls is
    broken, 2 on an error in the sources.
    """
    raise typer.Exit(check_files(files, lib, lint))


@app.command()
def encode(
    name: Annotated[str, typer.Argument(help="Command, e.g. MovePtp or 16#0001.")],
    fields: Annotated[list[str] | None, typer.Argument(help="Fields, e.g. point=19.")] = None,
    robot: Annotated[int, typer.Option(help="Robot number R, 0 to 4.")] = 0,
) -> None:
    """Print the telegram of a remote command, in words and in plain language."""
    print_encoded(name, fields or [], robot)


@app.command()
def decode(
    words: Annotated[list[str], typer.Argument(help="Words from n on, e.g. 16#0001 16#0004.")],
    response: Annotated[
        str, typer.Option(help="The words are from m on, the answer to this command.")
    ] = "",
) -> None:
    """Say what the words of a telegram mean."""
    print_decoded(words, response)


app.command()(bridge)
app.command()(eds)
app.command(epilog=EPILOG)(export)
app.command()(new)
app.command()(scan)
app.command()(serve)


def _phases(text: str) -> str | dict[str, Duration]:
    """`scan=3ms,cycle=1ms` as a table; a single word stays one."""
    if "=" not in text:
        return text
    pairs = [part.partition("=") for part in text.split(",")]
    return {name.strip(): value.strip() for name, _, value in pairs}


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        The exit code: 0, 1 or 2. Bad input is one line on stderr.
    """
    try:
        app(args=args)
    except InputError as error:
        print(f"rcx: {error}", file=sys.stderr)
        return error.exit_code
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0 if done.code is None else 2
    return 0
