"""Copies of the user's files for workers, which may run on computers without these files."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

from structured_text.errors import COMMAND, InputError
from structured_text.output.limits import OTHER
from structured_text.output.paths import real
from structured_text.output.reading import file_bytes

__all__ = ["Parcel"]


@dataclass(frozen=True)
class Parcel:
    """Files with their contents at the time of packing.

    Attributes:
        files: For each file: its name as the user wrote it, its path below the common folder of
            all files, and its content.
    """

    files: tuple[tuple[str, str, bytes], ...]

    @classmethod
    def of(cls, files: Iterable[Path]) -> Parcel:
        """Read files into a parcel, or raise InputError."""
        named = list(files)
        contents = [file_bytes(file, OTHER) for file in named]
        return cls(tuple(zip(map(str, named), _names(named), contents, strict=True)))

    def digest(self) -> str:
        """Return a hash of the contents and relative paths; it does not depend on the folder."""
        found = hashlib.sha256()
        for _, name, content in self.files:
            found.update(f"{name} {len(content)}\n".encode())
            found.update(content)
        return found.hexdigest()[:16]

    @contextmanager
    def unpacked(self) -> Iterator[list[Path]]:
        """Write the files to a temporary folder and yield their paths, in the order of `of`.

        Their relative positions are preserved. An InputError from inside the context names the
        files as the user wrote them.
        """
        with TemporaryDirectory(prefix=f"{COMMAND}-") as folder:
            here = [real(folder) / name for _, name, _ in self.files]
            for file, (_, _, content) in zip(here, self.files, strict=True):
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_bytes(content)
            try:
                yield here
            except InputError as error:
                homes = zip(map(str, here), self.files, strict=True)
                raise _at_home(error, {there: home for there, (home, _, _) in homes}) from None


def _names(files: Iterable[Path]) -> list[str]:
    paths = [real(file) for file in files]
    try:
        common = os.path.commonpath([path.parent for path in paths])
        return [path.relative_to(common).as_posix() for path in paths]
    except ValueError:  # there is no common folder without files, or with files on several drives
        return [path.as_posix().replace(":", "").lstrip("/") for path in paths]


def _at_home(error: InputError, homes: Mapping[str, str]) -> InputError:
    for there, home in homes.items():
        if error.file == there:
            error.file = home
        error.message = error.message.replace(there, home)
        error.hint = error.hint.replace(there, home)
    error.args = (str(error),)
    return error
