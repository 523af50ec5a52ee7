"""The standard streams of a command: they are always open, and their errors can be recognized."""

from __future__ import annotations

import errno
import io
import os
import sys
from typing import TextIO

from structured_text.errors import OutputError, UnreadError
from structured_text.output.system import nobody_reads

__all__ = ["discard_output", "prepare"]


class _Output(io.FileIO):
    """The raw file below the text stream of standard output."""

    def write(self, data: bytes | memoryview) -> int | None:  # type: ignore[override]
        """Write data; raise UnreadError or OutputError if the write to stdout fails."""
        try:
            return super().write(data)
        except OSError as error:
            if nobody_reads(error):
                raise UnreadError from None
            raise OutputError(error.errno, error.strerror) from None


class _Errors(io.FileIO):
    """The raw file below standard error.

    It ignores errors, because no stream could report them.
    """

    def write(self, data: bytes | memoryview) -> int | None:  # type: ignore[override]
        """Write if possible, else ignore the data."""
        try:
            return super().write(data)
        except OSError:
            return len(data)


def prepare() -> None:
    """Make the standard streams usable, even if the caller has closed or replaced them.

    A closed stream becomes the null device. Otherwise the next opened file would get the number of
    the closed stream, and receive everything that is printed.
    """
    _open_closed()
    sys.stdout = _known(sys.stdout, _Output)
    sys.stderr = _known(sys.stderr, _Errors)


def discard_output() -> None:
    """Redirect standard output to the null device, so that Python's exit does not fail again."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)


def _open_closed() -> None:
    for number in range(3):
        try:
            os.fstat(number)
        except OSError as error:
            if error.errno != errno.EBADF:
                raise
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
            os.set_inheritable(number, True)
    if sys.stdin is None:
        sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(2, "w", encoding="utf-8", closefd=False)  # noqa: SIM115


def _known(stream: TextIO, kind: type[io.FileIO]) -> TextIO:
    """Return a text stream that writes through a raw file of the class `kind`.

    A console of Windows is returned unchanged.
    """
    if not isinstance(stream, io.TextIOWrapper):
        return stream
    raw = getattr(stream.buffer, "raw", stream.buffer)
    if type(raw) is not io.FileIO:
        return stream
    stream.flush()
    file = kind(raw.fileno(), "wb", closefd=False)
    return io.TextIOWrapper(
        file if stream.buffer is raw else io.BufferedWriter(file),
        encoding=stream.encoding,
        errors=stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )
