"""A call of a tool: its folder, its output folder, and the commands that it runs."""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.assistant.folders import Folders
from structured_text.errors import InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["OUT", "Answer", "Call", "Command", "Progress", "Ran", "plain", "word"]

#: The folder inside of the user's folder for everything that the calls write.
OUT = Path("out/assistant")
_ABOUT = "call.json"
_DIGITS = 12

Progress = Callable[[str, float | None, float | None], None]
"""Reports progress: a line of text, the finished part and the whole, if they are known."""


@dataclass(frozen=True)
class Ran:
    """The result of a command: its exit code, and the lines of its output."""

    code: int
    lines: tuple[str, ...]


Command = Callable[[Sequence[str], Callable[[str], None]], Ran]
"""Runs a command of `rcx` with these words; raises InputError on bad input.

The second argument is called with each line of progress.
"""


@dataclass(frozen=True)
class Answer:
    """The answer to a call.

    Attributes:
        data: The answer for programs.
        text: The answer for readers, usually shorter.
        whole: Whether the text contains all of the data.
    """

    data: dict[str, Any]
    text: str
    whole: bool = False


@dataclass(frozen=True)
class Call:
    """A call of a tool.

    Attributes:
        tool: Name of the tool.
        given: Its arguments, already checked against the schema of the tool.
        folders: The folders that it may use.
        here: The folder that it works in, which is also the current folder.
        temporary: A folder for files that nobody sees.
        command: Runs a command of `rcx`; use `ran` to report its progress as well.
        progress: Reports progress.
    """

    tool: str
    given: Mapping[str, Any]
    folders: Folders
    here: Path
    temporary: Path
    command: Command
    progress: Progress = field(default=lambda text, done, total: None)

    def path(self, text: str) -> Path:
        """Return an argument as a path relative to the folder, checked to be inside."""
        return self.folders.inside(text, self.here)

    def paths(self, name: str) -> list[Path]:
        """Return the paths of an argument that is a list."""
        return [self.path(text) for text in self.given.get(name) or ()]

    def words(self, name: str) -> list[str]:
        """Return the paths of an argument as words of a command line, none of them an option."""
        return [word(path) for path in self.paths(name)]

    def option(self, name: str, argument: str) -> list[str]:
        """Return an argument as an option of a command line; empty if it is not given."""
        value = self.given.get(argument)
        return [] if value is None else [f"--{name}={value}"]

    def ran(self, words: Sequence[str]) -> Ran:
        """Run a command of `rcx`, and report its progress."""
        return self.command(words, lambda line: self.progress(line, None, None))

    def out(self) -> Path:
        """Return the output folder of this call, relative to the folder; make it if it is missing.

        Equal calls have the same folder. Raise InputError if files of others are in it.
        """
        about = json.dumps({"tool": self.tool, **self.given}, sort_keys=True) + "\n"
        digest = hashlib.sha256(about.encode()).hexdigest()[:_DIGITS]
        folder = OUT / f"{self.tool}-{digest}"
        place = real(self.here / folder)
        if place != self.here / folder:
            hint = "remove the link; the calls write into this folder only"
            raise InputError("is reached through a link", file=folder, hint=hint)
        mark = place / _ABOUT
        if os.path.isdir(place) and os.listdir(place):
            if not mark.is_file() or mark.read_bytes() != about.encode():
                hint = "remove or rename it"
                raise InputError("contains files of others", file=folder, hint=hint)
        elif os.path.lexists(place) and not os.path.isdir(place):
            raise InputError("is a file, not a folder", file=folder, hint="remove or rename it")
        else:
            replace_files({mark: about.encode()})
        return folder


def word(path: Path) -> str:
    """Return a path as a word of a command line that is not an option."""
    text = path.as_posix()
    return f"./{text}" if text.startswith("-") else text


def plain(data: Any) -> Any:
    """Return data of JSON with sorted keys, so that equal answers have equal bytes."""
    return json.loads(json.dumps(data, sort_keys=True, ensure_ascii=False))
