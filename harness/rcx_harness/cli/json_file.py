"""The option `--json` of several commands: a file, or `-` for standard output."""

from __future__ import annotations

import os
import sys
from collections.abc import Collection, Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Annotated

import typer

from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["JsonFile", "JsonOutput"]

JsonFile = Annotated[
    Path | None,
    typer.Option(
        "--json", help="Write the result to this file as one object of JSON; - prints it alone."
    ),
]
_PRINTED = Path("-")


class JsonOutput:
    """The JSON output of a command, if the option `--json` is given.

    Args:
        beginning: The first bytes of every JSON file of this command; a file with another beginning
            is not overwritten.
        read: Files that the command reads; they are not overwritten either.

    Raises:
        InputError: the file is an input, or this command has not written it.
    """

    def __init__(self, file: Path | None, beginning: str, read: Collection[Path] = ()) -> None:
        self._file = file
        self.printed = file == _PRINTED
        if file is None or self.printed:
            return
        if os.path.isdir(file):
            raise InputError("is a folder, not a file", file=file)
        if not os.path.isfile(file):  # the file does not exist, or is a device
            return
        with file.open("rb") as stream:
            found = stream.read(len(beginning))
        if found not in (b"", beginning.encode()):
            raise InputError(
                "already exists and was not written by this command; nothing was written",
                file=file,
                hint="name another file, or remove this one",
            )
        if real(file) in map(real, read):  # an empty file can be an input, too
            raise InputError("would be overwritten, but it is an input", file=file)

    @contextmanager
    def apart(self) -> Iterator[None]:
        """Redirect all other output to standard error if the JSON is printed."""
        if not self.printed:
            yield
            return
        with redirect_stdout(sys.stderr):
            yield

    def write(self, text: str) -> None:
        """Write the JSON to the file, or print it; do nothing without the option."""
        if self._file is None:
            return
        if self.printed:
            print(text, end="")
            return
        replace_files({self._file: text.encode()})
        print(f"written: {self._file}")
