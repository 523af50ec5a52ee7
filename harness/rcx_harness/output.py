"""A file that a command writes: whole, or not at all."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TextIO

from rcx_harness.errors import InputError

__all__ = ["OutputFile"]


class OutputFile:
    """Text that goes to a file; where one is there, beside it, to take its place at the end.

    After an error nothing of it is left, what was there before is as it was, and further calls
    do nothing.

    Args:
        path: The file; the folders above it are made. A device is written as it is.
        encoding: Of the text.

    Raises:
        InputError: it cannot be written; so do all methods.
    """

    def __init__(self, path: str | Path, encoding: str = "utf-8") -> None:
        self._path = Path(path)
        self._file: TextIO | None = None
        self._place = self._written = Path(os.path.realpath(path))
        self._regular = self._place.is_file() or not self._place.exists()
        if self._place.is_file():
            self._written = self._place.with_name(f".{self._place.name}.{os.getpid()}.part")
        try:
            self._place.parent.mkdir(parents=True, exist_ok=True)
            self._file = self._written.open("w", encoding=encoding, newline="\n")
            if self._written != self._place:
                os.chmod(self._written, self._place.stat().st_mode)
        except OSError as error:
            raise self._failed(error) from None

    def write(self, text: str) -> None:
        """Write more."""
        if self._file is not None:
            try:
                self._file.write(text)
            except OSError as error:
                raise self._failed(error) from None

    def flush(self) -> None:
        """Hand everything to the system."""
        if self._file is not None:
            try:
                self._file.flush()
            except OSError as error:
                raise self._failed(error) from None

    def close(self) -> None:
        """Write what is left; now the file is in its place."""
        self.flush()
        if self._file is not None:
            try:
                self._file.close()
                if self._written != self._place:
                    os.replace(self._written, self._place)
            except OSError as error:
                raise self._failed(error) from None
            self._file = None

    @property
    def closed(self) -> bool:
        """Is nothing written any more?"""
        return self._file is None

    def _failed(self, error: OSError) -> InputError:
        file, self._file = self._file, None
        try:
            if file is not None:
                file.close()
        except OSError:
            pass
        if self._regular and file is not None:
            self._written.unlink(missing_ok=True)
        return InputError(f"cannot be written: {error.strerror}", file=self._path)
