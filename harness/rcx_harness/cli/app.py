"""The command `rcx` with its subcommands; a subcommand is imported when it is called."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup

from structured_text.errors import InputError, OutputError, refused

__all__ = ["COMMANDS", "COMPLETE", "OPTION_PANELS", "PANELS", "Later", "app", "home_of", "main"]

#: The panels of `rcx --help` in their order, and the commands of each panel with the first
#: sentences of their docstrings. If a command's module has an `EPILOG`, it is the end of the help.
PANELS = {
    "Program": {
        "run": "Run a program in a virtual cell.",
        "check": (
            "Check ST sources: syntax, types, portability, calls; also with matiec if it is "
            "installed."
        ),
        "demo": (
            "Run the first example against the virtual robot: its timing chart, and a page to "
            "look at."
        ),
        "new": (
            "Write a repository for a cell of your own: program, tests, virtual robot, CI files."
        ),
        "debug": (
            "Debug a program in an editor, forwards and backwards, by the Debug Adapter Protocol."
        ),
        "mcp": (
            "Serve check, run, prove and more to an assistant, by the Model Context Protocol (MCP)."
        ),
        "format": (
            "Format ST files in the layout of the library: indentation, spaces, columns, capitals."
        ),
        "lsp": (
            "Show mistakes while you type, in an editor that knows the Language Server Protocol."
        ),
        "import": "Write the Structured Text of a project as .st files, one for each declaration.",
        "export": (
            "Write the library for a PLC tool; `docs/how-to/export.md` shows the state of each."
        ),
    },
    "Robot": {
        "serve": "Serve virtual controllers over EtherNet/IP in real time, for a real PLC.",
        "points": (
            "Back up, restore or compare points, comments, shifts, hands and pallets of a "
            "controller."
        ),
        "probe": (
            "Check the assumptions of the virtual controller at a real one; you confirm each step."
        ),
        "compare": (
            "Feed a recording to the virtual controller, and show where the real controller "
            "differs."
        ),
    },
    "Verify": {
        "test": (
            "Run the unit tests of a program: TcUnit suites, in virtual time, without TwinCAT."
        ),
        "campaign": ("Run a cell with random faults, and report which rules and properties break."),
        "sweep": (
            "Inject a fault at every scan of a good run, and report when the cell does not recover."
        ),
        "explore": (
            "Visit all states of a small program with a small controller, in every order of events."
        ),
        "prove": (
            "Prove properties of a program for every run, every answer of the robot and every "
            "input."
        ),
        "mutants": (
            "Put small mistakes into a program, one at a time, and report which of them its "
            "tests find."
        ),
    },
    "Network": {
        "scan": (
            "Open a cyclic connection as a PLC does, and print identity, both areas and every "
            "change."
        ),
        "bridge": "Bridge a PLC with Modbus TCP, such as OpenPLC, and a controller on EtherNet/IP.",
        "record": "Capture the traffic between a PLC and its controllers; nothing is sent.",
        "judge": (
            "Judge a recording of a PLC and its controllers: who broke a rule of the wire, and "
            "when."
        ),
        "why": "Explain why the robot stands: the chain of causes, and who has to act.",
        "eds": (
            "Write the virtual controller's electronic data sheet (EDS) for a PLC's "
            "configuration tool."
        ),
    },
    "Data": {
        "encode": "Print the telegram of a remote command, in words and in plain language.",
        "decode": "Explain the words of a telegram.",
        "view": "Write a recording as one page of HTML, which works without a network.",
        "completion": (
            "Print the script that completes commands, options and choices in your shell."
        ),
    },
}
COMMANDS = {name: first for commands in PANELS.values() for name, first in commands.items()}
#: Maps a command to its module and function, if these do not have the name of the command.
_HOMES = {
    "import": ("import_", "import_"),
    "format": ("format_", "format_"),
    "encode": ("codec", "encode"),
    "decode": ("codec", "decode"),
    "mcp": ("mcp_", "mcp_"),
    "test": ("test_", "test_"),
}

#: If a command has more options than this number, its help shows rare options in these panels,
#: after the common options. The panels contain the names of the options' parameters.
_MOST_OPTIONS = 15
OPTION_PANELS = {
    "Projects of PLC tools": "replace dialect device",
    "Network and clocks": "link size m n rpi jitter timeout phases on_loss",
    "Real time and other controllers": (
        "realtime panel connect yes input_instance output_instance input_size output_size "
        "config_instance config_data heartbeat port address"
    ),
    "Output": "trace chart vcd view watch positions scale show",
    "Comparison with an old version": "against output without relate drawn_runs drawn_seed",
    "Coverage": "coverage coverage_out coverage_library cover_fail_under",
    "Cluster": "cluster cluster_ca cluster_cert cluster_key cluster_plain",
}

_HINT_EMPTY = "a variable of the shell may not be set; . is the current folder"

#: The environment variable by which the script of `rcx completion` asks for completions.
COMPLETE = "_RCX_COMPLETE"

_SETTINGS: dict[str, Any] = {
    "rich_markup_mode": "markdown",
    "pretty_exceptions_enable": False,
    # The options of typer for completion change start files of the user's shell.
    # `rcx completion` only prints the script.
    "add_completion": False,
    "context_settings": {"help_option_names": ["--help", "-h"]},
}


class _Commands(TyperGroup):
    """The group of all commands.

    The list of commands is plain text, because `rich` doubles its time.
    """

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the help page of the command."""
        super(TyperGroup, self).format_help(ctx, formatter)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the commands of each panel; all sentences begin in the same column."""
        width = max(map(len, COMMANDS))
        for panel, commands in PANELS.items():
            with formatter.section(panel):
                formatter.write_dl([(f"{name:{width}}", first) for name, first in commands.items()])


_app = typer.Typer(
    name="rcx",
    cls=_Commands,
    help="Compile the RCX3 function blocks and run them against a virtual robot controller.",
    no_args_is_help=True,
    **_SETTINGS,
)


def home_of(name: str) -> tuple[str, str]:
    """Return the name of the module in this folder that has a command, and of its function."""
    return _HOMES.get(name, (name, name))


class Later(TyperCommand):
    """A command whose module is imported on first use.

    Until then only its first sentence is known.
    """

    def loaded(self) -> Any:
        """Return the command itself, and import its module on first use."""
        module, function = home_of(str(self.name))
        # All imported objects stay. A garbage collection would only cost a tenth of the start time.
        gc.disable()
        try:
            home = import_module(f"rcx_harness.cli.{module}")
        finally:
            gc.enable()
        alone = typer.Typer(**_SETTINGS)
        alone.command(self.name, epilog=getattr(home, "EPILOG", None))(getattr(home, function))
        command = typer.main.get_command(alone)
        options = [each for each in command.params if each.param_type_name == "option"]
        panel = {name: title for title, names in OPTION_PANELS.items() for name in names.split()}
        for each in options if len(options) > _MOST_OPTIONS else ():
            vars(each)["rich_help_panel"] = panel.get(str(each.name))
        return command

    def make_context(
        self, info_name: str | None, args: list[str], parent: Any = None, **extra: Any
    ) -> Any:
        """Load the command and parse its arguments, which help and completion need as well."""
        command = self.loaded()
        _refuse_empty_paths(command, args)
        return command.make_context(info_name, args, parent, **extra)


def _refuse_empty_paths(command: Any, args: Sequence[str]) -> None:
    """Raise InputError if a file name is empty, because Python treats it as the current folder.

    An unset variable of the shell gives an empty name, for example in `rcx run "$FILE"`.
    """
    of_paths = [each for each in command.params if each.type.name == "path"]
    options = {name for each in of_paths for name in each.opts if name.startswith("-")}
    argument = any(each.param_type_name == "argument" for each in of_paths)
    before = ""
    for word in args:
        name = word[:-1] if word.endswith("=") else before
        if name in options and word in ("", f"{name}="):
            raise InputError(f"{name}: the name of a file or folder is empty", hint=_HINT_EMPTY)
        if not word and argument and not before.startswith("-"):
            raise InputError("the name of a file or folder is empty", hint=_HINT_EMPTY)
        before = word


def _show_version(wanted: bool) -> None:
    if wanted:
        from importlib.metadata import version

        print(f"rcx {version('rcx-harness')}")
        raise typer.Exit


@_app.callback()
def _options(
    show_version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version."),
    ] = False,
) -> None:
    """Accept the options before the command; the callback of `--version` prints the version."""
    del show_version


def _group() -> TyperGroup:
    group = typer.main.get_command(_app)
    assert isinstance(group, TyperGroup)
    for name, first in COMMANDS.items():
        group.add_command(Later(name, help=first, rich_markup_mode="markdown"))
    return group


app = _group()


def _with_command(args: Sequence[str]) -> list[str]:
    """Return the arguments of the command line in the form that the parser accepts.

    Each word behind `--` of `rcx mutants` becomes an option, and `--json` without a file becomes
    `--json -`.
    """
    place = list(args).index("--") if "--" in args else len(args)
    given, rest = list(args[:place]), list(args[place:])
    for number in range(len(given) - 1, -1, -1):
        following = given[number + 1 : number + 2]
        if given[number] == "--json" and (not following or following[0].startswith("--")):
            given.insert(number + 1, "-")
    if given[:1] == ["mutants"]:
        rest = [f"--word={word}" for word in rest[1:]]
    return given + rest


def main(args: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        The exit code: 0, 1 or 2. Bad input is one line on stderr.
    """
    if os.environ.get(COMPLETE):
        from typer.completion import get_completion_inspect_parameters

        get_completion_inspect_parameters()  # registers the shells
    try:
        given = _with_command(sys.argv[1:] if args is None else args)
        app(args=given, complete_var=COMPLETE)
    except InputError as error:
        print(f"rcx: {error}", file=sys.stderr)
        return error.exit_code
    # Commands that can report the source line catch this error themselves.
    except RecursionError:
        text = "expressions, statements or types are nested too deeply; divide them"
        print(f"rcx: {text}", file=sys.stderr)
        return 2
    except OutputError:
        raise
    except OSError as error:
        print(f"rcx: {refused(error)}", file=sys.stderr)
        return 2
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else 0 if done.code is None else 2
    return 0
