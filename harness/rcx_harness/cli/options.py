"""The options that several commands have, and their checks. Each message names its option."""

from __future__ import annotations

import inspect
import ipaddress
import os
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, TypeVar, get_type_hints

import typer

from rcx_harness.cell.clock import LONGEST_RPI_US, SHORTEST_RPI_US
from structured_text.errors import InputError
from structured_text.language.dialects import dialects, using
from structured_text.output.reading import check_file
from structured_text.output.units import parse_us

__all__ = [
    "Device",
    "Dialect",
    "Lib",
    "Replace",
    "Sources",
    "check_ipv4",
    "check_port",
    "choices",
    "config_data",
    "config_instance",
    "counted",
    "duration_us",
    "host_port",
    "identity_revision",
    "interval_us",
    "replacements",
    "with_options",
]

#: Greatest number of digits that a port or an instance number can have.
_DIGITS = 5


def choices(*names: str) -> Callable[[], list[str]]:
    """Return the function that gives a shell the choices of an option or argument."""
    return lambda: list(names)


def _dialects() -> list[tuple[str, str]]:
    return list(dialects().items())


#: The argument for the sources of a program.
Sources = Annotated[
    list[Path],
    typer.Argument(help="ST files, projects (PLCopen XML, TwinCAT, L5X, SCL), or folders."),
]
#: The option for files with Structured Text that replaces POUs of a project.
Replace = Annotated[
    list[str] | None,
    typer.Option(
        help="Use this ST file instead of a POU of a project: POU=file.st. May be repeated."
    ),
]
#: The option for the PLC tool that the program is written for.
Dialect = Annotated[
    str | None,
    typer.Option(
        help="The PLC tool whose behaviour the program gets, such as codesys or tia. "
        "Default: the tool of the project's format, or iec.",
        autocompletion=_dialects,
    ),
]
#: The option for the device of a project.
Device = Annotated[
    str, typer.Option(help="The device to read, if a project in PLCopen XML has several.")
]
#: The option for the library to use.
Lib = Annotated[
    Path | None, typer.Option(help="Folder of the library. Default: the library in this package.")
]

_Options = TypeVar("_Options")


def with_options(
    options: type[_Options],
) -> Callable[[Callable[[_Options], None]], Callable[..., None]]:
    """Add the fields of a dataclass to a command as its arguments and options."""

    def made(command: Callable[[_Options], None]) -> Callable[..., None]:
        def with_values(context: typer.Context | None = None, **values: Any) -> None:
            if values.get("no_robot") and context:
                from rcx_harness.cli.no_robot import refuse

                refuse(one for one in values if not _is_default(context, one))
            with using(values.get("dialect")):
                command(options(**values))

        with_values.__name__, with_values.__doc__ = command.__name__, command.__doc__
        hints = get_type_hints(options, include_extras=True)
        signature = inspect.signature(options)
        places = [one.replace(annotation=hints[one.name]) for one in signature.parameters.values()]
        with_values.__annotations__ = {"context": typer.Context, **hints}
        first = inspect.Parameter(
            "context", inspect.Parameter.KEYWORD_ONLY, annotation=typer.Context
        )
        vars(with_values)["__signature__"] = signature.replace(parameters=[*places, first])
        return with_values

    return made


def _is_default(context: typer.Context, name: str) -> bool:
    """Return whether an option has its default because the user has not typed the option."""
    source = context.get_parameter_source(name)
    return source is None or source.name.startswith("DEFAULT")


def replacements(given: list[str] | None) -> dict[str, Path]:
    """Return the files of `--replace`; the keys are the names of the POUs."""
    found: dict[str, Path] = {}
    for text in given or []:
        name, is_, file = (part.strip() for part in text.partition("="))
        if not (name and is_ and file):
            raise InputError(f"--replace {text}", hint="write it as --replace POU=file.st")
        if name.upper() in (one.upper() for one in found):
            raise InputError(f"--replace {name} is given twice")
        if not os.path.lexists(file):
            raise InputError(f"--replace {name}: no such file", file=file)
        check_file(file)
        found[name] = Path(file)
    return found


def counted(number: int, what: str) -> str:
    """Return a number with its noun, such as `no scans`, `1 scan` or `2 scans`."""
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def check_port(option: str, number: int) -> None:
    """Raise InputError if the number is not a TCP or UDP port."""
    if not 1 <= number <= 0xFFFF:
        raise InputError(f"{option} {number} is not a port", hint="use 1 to 65535")


def check_ipv4(option: str, text: str) -> None:
    """Raise InputError if the text is not an IPv4 address."""
    try:
        ipaddress.IPv4Address(text)
    except ValueError:
        hint = "write it as 192.168.0.10"
        raise InputError(f"{option} {text!r} is not an IPv4 address", hint=hint) from None


def duration_us(option: str, text: str) -> int:
    """Return a duration in microseconds; raise InputError if the text is not a duration."""
    try:
        return parse_us(text)
    except InputError as error:
        raise InputError(f"{option}: {error.message}", hint=error.hint) from None


def interval_us(option: str, text: str) -> int:
    """Return a packet interval in microseconds."""
    given_us = duration_us(option, text)
    if not SHORTEST_RPI_US <= given_us <= LONGEST_RPI_US:
        hint = "use 1ms to 3200ms"
        raise InputError(f"{option} {text} is not a packet interval", hint=hint)
    return given_us


def host_port(option: str, text: str, port: int) -> tuple[str, int]:
    """Return host and port from `HOST` or `HOST:PORT`; raise InputError for any other text."""
    host, colon, number = text.partition(":")
    if colon:
        right = number.isascii() and number.isdecimal() and len(number) <= _DIGITS
        port = int(number) if right else 0
    if not host or not 1 <= port <= 0xFFFF:
        raise InputError(
            f"{option} {text!r:.60} is not an address",
            hint="write it as 192.168.0.10 or 127.0.0.1:5020",
        )
    return host, port


def config_instance(text: str) -> int | None:
    """Return the number in `--config-instance`, or None for `none`; raise InputError otherwise."""
    if text.lower() == "none":
        return None
    if not (text.isascii() and text.isdecimal()) or len(text) > _DIGITS:
        hint = "write it as 151, or none"
        raise InputError(f"--config-instance {text:.40} is not an instance", hint=hint)
    return int(text)


def config_data(text: str) -> bytes:
    """Return the bytes of `--config-data`; raise InputError if it is not hexadecimal."""
    try:
        return bytes.fromhex(text)
    except ValueError:
        hint = "write it in hexadecimal, as 01000A00"
        raise InputError(f"--config-data {text!r:.40} is not hexadecimal", hint=hint) from None


def identity_revision(text: str) -> tuple[int, int]:
    """Return major and minor revision from a text such as `1.1`; else raise InputError."""
    major, _, minor = text.partition(".")
    if not (major.isdecimal() and minor.isdecimal()):
        raise InputError(f"{text!r} is not a revision", hint="write it as 1.1")
    return int(major), int(minor)
