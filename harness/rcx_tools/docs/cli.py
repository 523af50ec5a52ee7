"""Generators of docs/reference/cli.md and docs/reference/cli: `rcx` commands with all options."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rcx_harness.cli.app import COMMANDS, Later

__all__ = ["command_page", "commands_index"]


def commands_index() -> Iterator[str]:
    """Yield the lines of the page that lists the commands."""
    yield "Each command has a page with all its options. `rcx COMMAND --help` prints the same."
    yield "Exit codes: 0 is fine, 1 means that a rule is broken or that something was found, 2 is a"
    yield "mistake in the input, 3 is an error of `rcx` itself.\n"
    yield "| Command | What it does |\n|---|---|"
    for name in sorted(COMMANDS):
        yield f"| [`rcx {name}`](cli/{name}.md) | {_cell(COMMANDS[name])} |"


def command_page(name: str) -> Iterator[str]:
    """Yield the lines of the page of one command.

    Args:
        name: The command as users type it, such as `run`.
    """
    command = Later(name=name).loaded()
    arguments = [each for each in command.params if each.param_type_name == "argument"]
    options = [each for each in command.params if each.param_type_name == "option"]
    usage = " ".join(["rcx", name, *(["[OPTIONS]"] if options else []), *map(_usage, arguments)])
    yield f"```\n{usage}\n```\n"
    yield f"{_paragraphs(command.help)}\n"
    if arguments:
        yield "| Argument | What it is |\n|---|---|"
        for each in arguments:
            yield f"| `{_usage(each)}` | {_cell(each.help)} |"
        yield ""
    for panel, members in _panels(options).items():
        yield f"## {panel}\n\n| Option | Value | Default | What it does |\n|---|---|---|---|"
        for each in members:
            yield f"| {_names(each)} | {_value(each)} | {_default(each)} | {_cell(each.help)} |"
        yield ""
    if command.epilog:
        yield f"{_paragraphs(command.epilog)}\n"
    yield "All commands: [cli.md](../cli.md)."


def _panels(options: list[Any]) -> dict[str, list[Any]]:
    """Return the options of a command by the title of their panel, in the order of `--help`."""
    panels: dict[str, list[Any]] = {"Options": []}
    for each in options:
        title = getattr(each, "rich_help_panel", None) or "Options"
        panels.setdefault(title, []).append(each)
    return {title: members for title, members in panels.items() if members}


def _usage(argument: Any) -> str:
    shown = (argument.metavar or argument.name).upper().strip("[]{}.")
    shown += "..." if argument.nargs != 1 else ""
    return shown if argument.required else f"[{shown}]"


def _names(option: Any) -> str:
    return ", ".join(f"`{name}`" for name in (*option.opts, *option.secondary_opts))


def _value(option: Any) -> str:
    if option.is_flag:
        return ""
    choices = getattr(option.type, "choices", None)
    if choices:
        return ", ".join(f"`{getattr(one, 'value', one)}`" for one in choices)
    return f"`{option.metavar or option.type.name}`" + (", repeatable" if option.multiple else "")


def _default(option: Any) -> str:
    shown = option.show_default if isinstance(option.show_default, str) else option.default
    if option.required:
        return "required"
    if option.is_flag or callable(shown) or shown in (None, "", (), []):
        return ""
    return f"`{getattr(shown, 'value', shown)}`"


def _cell(text: str | None) -> str:
    return " ".join((text or "").split()).replace("|", "\\|")


def _paragraphs(text: str | None) -> str:
    """Return a help text as paragraphs, without the parts that typer does not display."""
    shown = (text or "").partition("\f")[0].replace("\b", "")
    return "\n\n".join(" ".join(part.split()) for part in shown.split("\n\n") if part.strip())
