"""`rcx completion`: the script that completes commands, options and choices in a shell."""

from __future__ import annotations

from typing import Annotated

import typer

from rcx_harness.cli.options import choices
from structured_text.errors import InputError

__all__ = ["EPILOG", "completion"]

_SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")

EPILOG = """For each new shell:

- bash: `eval "$(rcx completion bash)"` in `~/.bashrc`
- zsh: `eval "$(rcx completion zsh)"` in `~/.zshrc`, behind `compinit`
- fish: `rcx completion fish > ~/.config/fish/completions/rcx.fish`
- PowerShell: `rcx completion powershell >> $PROFILE`
"""


def completion(
    shell: Annotated[
        str, typer.Argument(help=f"{', '.join(_SHELLS)}.", autocompletion=choices(*_SHELLS))
    ],
) -> None:
    """Print the script that completes commands, options and choices in your shell.

    Exit code: 0, or 2 for an unknown shell.
    """
    if shell not in _SHELLS:
        raise InputError(f"{shell}: no such shell", hint=f"use {', '.join(_SHELLS)}")
    from typer.completion import get_completion_inspect_parameters, shell_complete

    from rcx_harness.cli.app import COMPLETE, app

    get_completion_inspect_parameters()  # registers the shells
    raise typer.Exit(shell_complete(app, {}, "rcx", COMPLETE, f"source_{shell}"))
