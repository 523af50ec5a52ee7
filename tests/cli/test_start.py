"""A command imports only the modules that it needs, and its help is complete."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from importlib import import_module
from inspect import getdoc
from pathlib import Path

import pytest

from imports import PACKAGES
from rcx_harness.cli.app import COMMANDS, OPTION_PANELS, PANELS, Later, app, home_of, main
from structured_text.engines.matiec.build import find_matiec

#: A script that runs commands one after the other. After each command it prints the exit code and
#: the newly imported modules.
_RUN = """
import contextlib, io, json, sys
report = []
for words in json.loads(sys.argv[1]):
    before = set(sys.modules)
    with contextlib.redirect_stdout(io.StringIO()):
        from rcx_harness.cli.app import main
        code = main(words)
    report.append([code, sorted(set(sys.modules) - before)])
print(json.dumps(report))
"""
#: Modules that need 0.1 s or more for their import, and that the tested commands must not import.
_SLOW_IMPORTS = {
    "asyncio",
    "cpppo",
    "distributed",
    "hypothesis",
    "numpy",
    "pytest",
    "selenium",
    "z3",
}
_SLOW_IMPORTS |= {"aiohttp", "pymodbus", "pydantic", "http.server"}


def _imported(*commands: list[str], **environment: str) -> list[set[str]]:
    """Run commands in one process, and return the modules that each command imports first."""
    done = subprocess.run([sys.executable, "-c", _RUN, json.dumps(commands)], capture_output=True,
                          text=True, check=True, env={**os.environ, **environment})  # fmt: skip
    report = json.loads(done.stdout)
    assert [code for code, _ in report] == [0] * len(commands)
    return [set(modules) for _, modules in report]


#: Packages of structured_text that measure, prove or debug programs.
_MEASURES = ("coverage", "mutants", "prove", "explore", "debug", "farm")


def _loaded(*modules: str) -> set[str]:
    """Import the given modules in a new process, and return all modules that it has imported."""
    code = f"import sys, {', '.join(modules)}; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, check=True)
    return set(done.stdout.decode().split())


def _below(modules: set[str], *names: str) -> set[str]:
    """Return the modules that belong to one of the packages `names`."""
    return {one for one in modules if any(f"{one}.".startswith(f"{name}.") for name in names)}


def test_a_command_imports_only_what_it_needs(repository: Path) -> None:
    """Commands do not import modules that they do not need; each would cost 10 to 300 ms."""
    example = repository / "plc" / "examples" / "01_power_up"
    version, helped, codec, check, run = _imported(
        ["--version"],
        ["--help"],
        ["decode", "0x0001", "0x0004", "0", "50", "19"],
        ["check", str(example)],
        ["run", str(example), "--robot", str(example / "robot.toml"), "--for", "10ms"],
    )
    assert not _below(version, "rich", "lark", *_SLOW_IMPORTS)
    own = {"rcx_harness", "rcx_harness.cli", "rcx_harness.cli.app"}
    assert _below(version, *PACKAGES) == {*own, "structured_text", "structured_text.errors"}
    assert not _below(helped, "rich", *PACKAGES, "lark", *_SLOW_IMPORTS)
    assert not _below(
        codec, "structured_text.engines", "rcx_harness.robot", "rcx_harness.cell", "lark"
    )
    rooms = ("robot", "enip", "trace", "look", "serve", "verify", "bridge", "new", "testing")
    engines = ["engines.load", "engines.builtin", "engines.strucpp", "export.targets"]
    engines += _MEASURES
    if find_matiec() is None:  # if matiec is installed, `rcx check` imports its engine
        engines.append("engines.matiec.program")
    cells = ("cell.cell", "cell.node")
    assert not _below(check, *(f"rcx_harness.{one}" for one in (*rooms, *cells)))
    assert not _below(check, *(f"structured_text.{one}" for one in engines))
    assert not _below(check, "rich.progress", *_SLOW_IMPORTS)
    others = ("look", "serve", "bridge", "new", "testing", "verify", "cell.elsewhere", "enip")
    assert not _below(run, *(f"rcx_harness.{one}" for one in others))
    assert not _below(run, *(f"structured_text.{one}" for one in _MEASURES))
    assert not _below(run, *_SLOW_IMPORTS)


@pytest.mark.exhaustive
def test_a_second_run_of_a_program_does_not_import_the_front_end(
    repository: Path, tmp_path: Path
) -> None:
    """A second run uses the cached program, so it does not import the front end."""
    example = repository / "plc" / "examples" / "01_power_up"
    words = ["run", str(example), "--robot", str(example / "robot.toml"), "--for", "10ms"]
    # Programs in the temporary folder are not cached, and this repository may be in that folder.
    kept = {"TMPDIR": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path), "RCX_CACHE": "on"}
    _imported(words, **kept)
    (again,) = _imported(words, **kept)
    front = ("parser", "lexer", "load", "bodies", "declare")
    assert not _below(again, "lark", *(f"structured_text.language.{one}" for one in front))
    engines = ("builtin.compile", "builtin.statements", "strucpp.program")
    others = ("projects.open", *(f"engines.{one}" for one in engines))
    assert not _below(again, *(f"structured_text.{one}" for one in others))


@pytest.mark.exhaustive
def test_the_processes_of_a_served_controller_import_only_what_they_need() -> None:
    """The processes of `rcx serve` import only what they need, to save memory.

    Source: timing.md.
    """
    parent = _loaded(*(f"rcx_harness.cli.{one}" for one in ("start", "app", "serve")))
    found = _loaded("rcx_harness.serve.station_process")
    of_programs = ("language.load", "engines.load", "engines.builtin", "export")
    of_others = ("cell.cell", "cell.node", "trace.view.page", "serve.terminal")
    assert not _below(parent, *(f"structured_text.{one}" for one in of_programs))
    assert not _below(parent, *(f"rcx_harness.{one}" for one in of_others))
    assert not _below(parent, "rich", "lark", *_SLOW_IMPORTS - {"asyncio"})
    rooms = ("cell", "cli", "look", "verify", "testing", "bridge", "trace.view", "watch")
    toolkit = ("language.load", "engines", "projects", "export", *_MEASURES)
    assert not _below(found, *(f"rcx_harness.{one}" for one in rooms))
    assert not _below(found, *(f"structured_text.{one}" for one in toolkit))
    assert not _below(found, "rich", "typer", "lark", "ssl", *_SLOW_IMPORTS)


@pytest.mark.parametrize("name", COMMANDS)
def test_a_command_is_listed_with_the_first_sentence_of_its_docstring(name: str) -> None:
    """`rcx --help` describes a command with the first sentence of `rcx <command> --help`."""
    module, function = home_of(name)
    command = getattr(import_module(f"rcx_harness.cli.{module}"), function)
    assert " ".join((getdoc(command) or "").partition("\n\n")[0].split()) == COMMANDS[name]
    assert function.rstrip("_") == name


def test_the_list_of_commands_has_complete_sentences(capsys: pytest.CaptureFixture[str]) -> None:
    """`rcx --help` shows the whole sentence of each command, without a cut."""
    assert main(["--help"]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert [name for name, first in COMMANDS.items() if f"{name} {first}" not in said] == []


def test_each_command_is_in_one_of_five_panels(capsys: pytest.CaptureFixture[str]) -> None:
    """`rcx --help` lists each command under one of five headings, and none under `Commands:`."""
    assert main(["--help"]) == 0
    shown: dict[str, list[str]] = {}
    for line in capsys.readouterr().out.splitlines():
        if line.endswith(":") and not line.startswith(" "):
            panel = shown.setdefault(line[:-1], [])
        elif line.startswith("  ") and line[2:3].strip() and shown:
            panel.append(line.split()[0])
    assert shown.pop("Options") == ["--version", "-h,"]
    assert shown == {panel: [*commands] for panel, commands in PANELS.items()}
    assert [*shown] == ["Program", "Robot", "Verify", "Network", "Data"]
    assert sorted(name for names in shown.values() for name in names) == sorted(app.commands)


def test_a_command_with_many_options_has_panels_for_rare_options() -> None:
    """At most 15 options of a command have no panel, because long lists are hard to search.

    Each name in OPTION_PANELS is the name of an option.
    """
    rare = {name for names in OPTION_PANELS.values() for name in names.split()}
    seen: set[str] = set()
    for command in app.commands.values():
        assert isinstance(command, Later)
        options = [one for one in command.loaded().params if one.param_type_name == "option"]
        panels = {one.name: one.rich_help_panel for one in options}
        if len(options) > 15:
            assert {name for name, panel in panels.items() if panel} == rare & panels.keys()
            seen |= rare & panels.keys()
        assert list(panels.values()).count(None) <= 15
    assert seen == rare


@pytest.mark.exhaustive(but=["", "run", "check", "test", "serve"])
@pytest.mark.parametrize("words", [[], *([name] for name in COMMANDS)], ids=" ".join)
def test_h_is_short_for_help(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """The options -h and --help print the same text."""
    shown = []
    for option in ("--help", "-h"):
        assert main([*words, option]) == 0
        shown.append(capsys.readouterr().out)
    assert shown[0].strip()
    assert shown[0] == shown[1]


def test_every_command_is_in_the_table_of_commands() -> None:
    """The table COMMANDS contains each module of `cli` that has a function with its own name."""
    folder = Path(str(sys.modules["rcx_harness.cli.app"].__file__)).parent
    found = set()
    for file in folder.glob("[a-z]*.py"):
        module = import_module(f"rcx_harness.cli.{file.stem}")
        if callable(getattr(module, file.stem, None)):
            found.add(file.stem.rstrip("_"))
    found.remove("app")
    assert found <= COMMANDS.keys()
    assert COMMANDS.keys() - found == {"encode", "decode"}
    assert [*app.commands] == [*COMMANDS]


def test_the_help_ends_with_the_additional_lists(capsys: pytest.CaptureFixture[str]) -> None:
    """`rcx export --help` ends with the list of targets, `rcx run --help` with the events."""
    assert main(["export", "--help"]) == 0
    assert "Targets:" in capsys.readouterr().out.partition("--force")[2]
    assert main(["run", "--help"]) == 0
    assert "Events of a stimulus:" in capsys.readouterr().out.partition("--cover-fail-under")[2]
