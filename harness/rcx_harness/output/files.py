"""What a command writes is whole, or what was there before: beside it, then in its place."""

from __future__ import annotations

import itertools
import os
import shutil
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from rcx_harness.errors import InputError

__all__ = ["OutputFile", "replace_files"]

_numbers = itertools.count()


def replace_files(contents: Mapping[Path, bytes]) -> None:
    """Write a set of files: none takes its place before all are written.

    So a full disk, a fault or Ctrl-C leaves what was there as it was.

    Raises:
        InputError: a file cannot be written.
    """
    files: list[OutputFile] = []
    try:
        for path, data in contents.items():
            files.append(OutputFile(path, whole=True))
            files[-1].write(data)
            files[-1].finish()
        for file in files:
            file.close()
    except BaseException:
        for file in reversed(files):
            file.discard()
        raise


class OutputFile:
    """A file that grows; where one is there, beside it, to take its place at the end.

    After an error nothing of it is left, what was there before is as it was, and further calls
    do nothing.

    Args:
        path: The file; the folders above it are made. A link stays one, a device is written to.
        encoding: Of text.
        whole: Until the end it stands beside its place although nothing is there.

    Raises:
        InputError: it cannot be written; so do all methods.
    """

    def __init__(self, path: str | Path, encoding: str = "utf-8", *, whole: bool = False) -> None:
        self._path, self._encoding = Path(path), encoding
        self._file: BinaryIO | None = None
        self._made: list[Path] = []
        self._place = self._written = Path(os.path.realpath(path))
        there = self._place.exists()
        regular = self._place.is_file() or not there
        self._open, self._made_file = True, False
        try:
            self._make_folders()
            if regular and (whole or there):
                name = f".rcx-{os.getpid()}-{next(_numbers)}.new"
                self._written = self._place.with_name(name)
            self._file = self._written.open("xb" if regular else "wb")
            self._made_file = regular
            if there and regular:
                shutil.copymode(self._place, self._written)
        except OSError as error:
            raise self._failed(error) from None

    def write(self, data: str | bytes) -> None:
        """Write more."""
        if self._file is not None:
            try:
                self._file.write(data.encode(self._encoding) if isinstance(data, str) else data)
            except OSError as error:
                raise self._failed(error) from None

    def flush(self) -> None:
        """Hand everything to the system."""
        if self._file is not None:
            try:
                self._file.flush()
            except OSError as error:
                raise self._failed(error) from None

    def finish(self) -> None:
        """Write what is left; it does not take its place yet."""
        self.flush()
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                raise self._failed(error) from None
            self._file = None

    def close(self) -> None:
        """Write what is left; now the file is in its place."""
        self.finish()
        if self._open and self._written != self._place:
            try:
                os.replace(self._written, self._place)
            except OSError as error:
                raise self._failed(error) from None
        self._open = False

    @property
    def closed(self) -> bool:
        """Is nothing written any more?"""
        return not self._open

    def discard(self) -> None:
        """Leave nothing of it, unless it is in its place already."""
        if not self._open:
            return
        self._open = False
        file, self._file = self._file, None
        with suppress(OSError):
            if file is not None:
                file.close()
        with suppress(OSError):
            if self._made_file:
                self._written.unlink(missing_ok=True)
            for folder in reversed(self._made):
                folder.rmdir()  # of others it is, unless it is empty

    def _make_folders(self) -> None:
        folder = self._place.parent
        missing = [one for one in (folder, *folder.parents) if not one.exists()]
        for one in reversed(missing):
            one.mkdir(exist_ok=True)
            self._made.append(one)

    def _failed(self, error: OSError) -> InputError:
        self.discard()
        return InputError(f"cannot be written: {error.strerror}", file=self._path)
