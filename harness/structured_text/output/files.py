"""Atomic output: a command writes a file completely, or leaves the old file unchanged.

The new file is written in the folder of the old file, and then renamed.
"""

from __future__ import annotations

import errno
import itertools
import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO

from structured_text.errors import COMMAND, InputError

__all__ = ["NewFiles", "OutputFile", "encoded", "replace_files"]

_numbers = itertools.count()
_MOST_NAMES = 1_000


def replace_files(contents: Mapping[Path, bytes | str]) -> None:
    """Write a set of files, or raise InputError; none is replaced before all are written.

    A full disk, a fault or Ctrl-C leaves the previous files unchanged.
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


class NewFiles:
    """Files that are created before a long job and renamed to their names after the job.

    The class never overwrites a file. If another program has created a file of this name meanwhile,
    the new file gets a free name in the same folder. `hint` is for the message about a file that
    already exists.

    Raises:
        InputError: A file already exists, is named twice, or cannot be written.
    """

    def __init__(self, paths: Sequence[Path], hint: str = "name another one") -> None:
        self._paths = list(paths)
        self._files: list[OutputFile] = []
        for path in paths:
            if os.path.lexists(path):
                raise InputError("already exists", file=path, hint=hint)
        if len({os.path.realpath(path) for path in paths}) < len(paths):
            raise InputError("both files are the same", file=paths[0], hint=hint)
        try:
            for path in paths:
                self._files.append(OutputFile(path, whole=True, new=True))
        except BaseException:
            self._discard()
            raise
        self._places = [file.place for file in self._files]

    def __enter__(self) -> NewFiles:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self._discard()

    def write(self, *contents: bytes | str) -> None:
        """Write all files, in the order of their names, or none.

        Raise InputError if a file cannot be written, or was given another name, which the message
        shows.
        """
        for file, data in zip(self._files, contents, strict=True):
            file.write(data)
            file.finish()
        for file in self._files:
            file.close()
        for path, place, file in zip(self._paths, self._places, self._files, strict=True):
            if file.place != place:
                text = f"was created by another program; the output is in {file.place}"
                raise InputError(text, file=path)

    def _discard(self) -> None:
        for file in reversed(self._files):
            file.discard()


class OutputFile:
    """An output file with a temporary name; at the end it replaces an existing file.

    After an error the new file is removed, an existing file is unchanged, and further calls do
    nothing.

    Args:
        path: The file; missing folders are created. If it is a link, the target of the link is
            replaced. A device is written to directly.
        encoding: Encoding of text.
        whole: Use a temporary name even if the file does not exist yet.
        new: Never replace a file. If the file exists at the end, use a free name in the same
            folder.

    Raises:
        InputError: The file cannot be written; all methods can raise it.
    """

    def __init__(
        self,
        path: str | Path,
        encoding: str = "utf-8",
        *,
        whole: bool = False,
        new: bool = False,
    ) -> None:
        self._path, self._encoding = Path(path), encoding
        self._file: BinaryIO | None = None
        self._made: list[Path] = []
        self._place = self._written = Path(os.path.realpath(path))
        self._new = new
        # Opening a file with a name that is too long reports this error.
        there = os.path.exists(self._place)
        regular = os.path.isfile(self._place) or not there
        self._open, self._made_file = True, False
        try:
            if os.path.islink(self._place):  # stat fails for a loop of links
                os.stat(self._place)
            self._make_folders()
            with suppress(FileNotFoundError):
                os.lstat(self._place)  # fails if the name is too long
            if regular and (whole or there):
                name = f".{COMMAND}-{os.getpid()}-{next(_numbers)}.new"
                self._written = self._place.with_name(name)
            self._file = self._written.open("xb" if regular else "wb")
            self._made_file = regular
            if there and regular:
                shutil.copymode(self._place, self._written)
        except OSError as error:
            raise self._failed(error) from None

    def write(self, data: str | bytes) -> None:
        """Append data."""
        if self._file is not None:
            try:
                self._file.write(encoded(data, self._encoding) if isinstance(data, str) else data)
            except OSError as error:
                raise self._failed(error) from None

    def flush(self) -> None:
        """Write buffered data to the system."""
        if self._file is not None:
            try:
                self._file.flush()
            except OSError as error:
                raise self._failed(error) from None

    def finish(self) -> None:
        """Write buffered data and close the file, which keeps its temporary name."""
        self.flush()
        if self._file is not None:
            try:
                self._file.close()
            except OSError as error:
                raise self._failed(error) from None
            self._file = None

    def close(self) -> None:
        """Write buffered data, and rename the file to its final name."""
        self.finish()
        if self._open and self._written != self._place:
            try:
                if self._new:
                    self._place = _named_once(self._written, self._place)
                else:
                    os.replace(self._written, self._place)
            except OSError as error:
                raise self._failed(error) from None
        self._open = False

    @property
    def place(self) -> Path:
        """Return the path that the file has or will get."""
        return self._place

    @property
    def closed(self) -> bool:
        """Return whether the file is complete or discarded."""
        return not self._open

    def discard(self) -> None:
        """Remove the file, unless it already has its final name."""
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
                folder.rmdir()  # fails if other programs have put files into the folder

    def _make_folders(self) -> None:
        folder = self._place.parent
        missing = [one for one in (folder, *folder.parents) if not os.path.exists(one)]
        for one in reversed(missing):
            if os.path.islink(one):  # stat fails for a loop of links
                os.stat(one)
            one.mkdir(exist_ok=True)
            self._made.append(one)

    def _failed(self, error: OSError) -> InputError:
        self.discard()
        return InputError(f"cannot be written: {error.strerror}", file=self._path)


def encoded(text: str, encoding: str = "utf-8") -> bytes:
    r"""Encode a text; undecodable bytes of a file's name are written as `\udcff`."""
    return text.encode(encoding, "backslashreplace")


def _named_once(written: Path, place: Path) -> Path:
    """Rename a file to its final name, or to a free name in the folder, and return the name."""
    for name in _names(place):
        with suppress(FileExistsError):
            try:
                os.link(written, name)
            except FileExistsError:
                raise
            except OSError:  # a file system without hard links
                _copy(written, name)
            written.unlink()
            return name
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))


def _names(place: Path) -> Iterator[Path]:
    yield place
    for number in range(1, _MOST_NAMES):
        yield place.with_name(f"{place.stem}-{number}{place.suffix}")


def _copy(written: Path, name: Path) -> None:
    """Copy a file to a name that does not exist yet."""
    data = written.read_bytes()
    with name.open("xb") as file:
        try:
            file.write(data)
            file.flush()
        except BaseException:
            file.close()
            name.unlink()
            raise
