"""`rcx completion` prints a script, which asks `rcx` for commands, options and choices."""

from __future__ import annotations

import pytest

from rcx_harness.cli.app import COMMANDS, main

Captured = pytest.CaptureFixture[str]

_TOOLS = "codesys twincat siemens rockwell omron mitsubishi keyence matiec"


@pytest.mark.parametrize(
    ("typed", "expected"),
    [
        ("rcx sw", "sweep"),
        ("rcx check --sar", "--sarif"),
        ("rcx check --for ", _TOOLS),
        ("rcx check --for o", "omron"),
        ("rcx run --engine ", "auto matiec builtin strucpp"),
        ("rcx campaign plc --link e", "enip"),
        ("rcx export sc", "scl"),
        ("rcx test plc --dialect t", "twincat tia"),
        ("rcx completion p", "powershell pwsh"),
        ("rcx points b", "backup"),
        ("rcx new cell --ci g", "github gitlab"),
        ("rcx encode MoveP", "MovePtp"),
        ("rcx check pl", ""),
    ],
)
def test_bash_receives_commands_options_and_choices(
    typed: str, expected: str, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nothing is printed for a file, so that the shell completes it.

    Source: docs/how-to/ci.md, completion in a shell
    """
    words = typed.split(" ")
    monkeypatch.setenv("_RCX_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", " ".join(words))
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    assert main([]) == 0
    assert capsys.readouterr().out.split() == expected.split()


def test_every_command_is_completed_with_its_sentence(
    capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Fish shows the beginning of the sentence beside the command."""
    monkeypatch.setenv("_RCX_COMPLETE", "complete_fish")
    monkeypatch.setenv("_TYPER_COMPLETE_FISH_ACTION", "get-args")
    monkeypatch.setenv("_TYPER_COMPLETE_ARGS", "rcx ")
    assert main([]) == 0
    lines = [line.partition("\t") for line in capsys.readouterr().out.splitlines()]
    assert {name for name, _, _ in lines} == set(COMMANDS)
    assert all(COMMANDS[name].startswith(text.removesuffix("...")) for name, _, text in lines)


@pytest.mark.parametrize(
    ("shell", "part"),
    [
        ("bash", "_RCX_COMPLETE=complete_bash"),
        ("zsh", "#compdef rcx"),
        ("fish", "complete --command rcx"),
        ("powershell", "Register-ArgumentCompleter -Native -CommandName rcx"),
    ],
)
def test_the_script_of_each_shell_is_printed(shell: str, part: str, capsys: Captured) -> None:
    """Source: docs/how-to/ci.md, completion in a shell."""
    assert main(["completion", shell]) == 0
    assert part in capsys.readouterr().out


def test_an_unknown_shell_is_refused(capsys: Captured) -> None:
    assert main(["completion", "tcsh"]) == 2
    said = "rcx: tcsh: no such shell; use bash, zsh, fish, powershell, pwsh\n"
    assert capsys.readouterr().err == said
