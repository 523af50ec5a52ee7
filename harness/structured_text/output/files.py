"""What a command writes is whole, or what was there before: beside it, then in its place."""

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


class NewFiles:
    """Files that are made before long work begins, and get their names after it, inside `with`.

    Nothing is ever written over: where something has appeared meanwhile it stays, and what was to
    stand there has a free name beside it.

    Args:
        paths: The files.
        hint: What to do where one is there already.

    Raises:
        InputError: one is there already, is named twice, or cannot be written.
    """

    def __init__(self, paths: Sequence[Path], hint: str = "name another one") -> None:
        self._paths = list(paths)
        self._files: list[OutputFile] = []
        for path in paths:
            if os.path.lexists(path):
                raise InputError("is there already", file=path, hint=hint)
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
        """Write them, in the order in which they were named: all, or none.

        Raises:
            InputError: one cannot be written, or now has another name, which is told.
        """
        for file, data in zip(self._files, contents, strict=True):
            file.write(data)
            file.finish()
        for file in self._files:
            file.close()
        for path, place, file in zip(self._paths, self._places, self._files, strict=True):
            if file.place != place:
                text = f"has appeared meanwhile and stays; what was to be written is {file.place}"
                raise InputError(text, file=path)

    def _discard(self) -> None:
        for file in reversed(self._files):
            file.discard()


class OutputFile:
    """A file that grows; where one is there, beside it, to take its place at the end.

    After an error nothing of it is left, what was there before is as it was, and further calls
    do nothing.

    Args:
        path: The file; the folders above it are made. A link stays one, a device is written to.
        encoding: Of text.
        whole: Until the end it stands beside its place although nothing is there.
        new: It never takes the place of another one: at the end it has a free name beside it.

    Raises:
        InputError: it cannot be written; so do all methods.
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
        there = os.path.exists(self._place)  # a name too long is told by opening it
        regular = os.path.isfile(self._place) or not there
        self._open, self._made_file = True, False
        try:
            if os.path.islink(self._place):  # in a loop with others: it is not replaced
                os.stat(self._place)
            self._make_folders()
            with suppress(FileNotFoundError):
                os.lstat(self._place)  # a name that is too long is none, whatever is beside it
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
        """Write more."""
        if self._file is not None:
            try:
                self._file.write(encoded(data, self._encoding) if isinstance(data, str) else data)
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
                if self._new:
                    self._place = _named_once(self._written, self._place)
                else:
                    os.replace(self._written, self._place)
            except OSError as error:
                raise self._failed(error) from None
        self._open = False

    @property
    def place(self) -> Path:
        """Where it is, or will be."""
        return self._place

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
        missing = [one for one in (folder, *folder.parents) if not os.path.exists(one)]
        for one in reversed(missing):
            if os.path.islink(one):  # in a loop with others
                os.stat(one)
            one.mkdir(exist_ok=True)
            self._made.append(one)

    def _failed(self, error: OSError) -> InputError:
        self.discard()
        return InputError(f"cannot be written: {error.strerror}", file=self._path)


def encoded(text: str, encoding: str = "utf-8") -> bytes:
    r"""Encode a text; bytes of a file's name that are no characters are written as `\udcff`."""
    return text.encode(encoding, "backslashreplace")


def _named_once(written: Path, place: Path) -> Path:
    """Give a file its name, or a free one beside it; which one."""
    for name in _names(place):
        with suppress(FileExistsError):
            try:
                os.link(written, name)
            except FileExistsError:
                raise
            except OSError:  # a file system without links
                _copy(written, name)
            written.unlink()
            return name
    raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST))


def _names(place: Path) -> Iterator[Path]:
    yield place
    for number in range(1, _MOST_NAMES):
        yield place.with_name(f"{place.stem}-{number}{place.suffix}")


def _copy(written: Path, name: Path) -> None:
    """To a name that nothing has."""
    data = written.read_bytes()
    with name.open("xb") as file:
        try:
            file.write(data)
            file.flush()
        except BaseException:
            file.close()
            name.unlink()
            raise
