"""Reading of the files that a user names; they must be plain files of limited size."""

from __future__ import annotations

import os
import stat
from pathlib import Path
from typing import BinaryIO

from structured_text.errors import InputError
from structured_text.output.limits import Kind
from structured_text.output.paths import real
from structured_text.output.system import without_waiting

__all__ = ["SHOWN", "beginning", "check_file", "file_bytes", "file_text", "open_file", "text_of"]

#: Contents by resolved path that replace the contents of project files: the documents of an editor.
SHOWN: dict[Path, bytes] = {}

_MEGABYTE = 1 << 20
#: Names of file types that are not plain files, by the test that recognizes them.
_OTHERS = (
    (stat.S_ISDIR, "a folder"),
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


def check_file(path: str | Path) -> None:
    """Raise InputError unless the path leads to a plain file; nothing is opened.

    A device or pipe may have no end, or block for ever when it is opened.
    """
    try:
        mode = os.stat(path).st_mode
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    _check(path, mode)


def open_file(path: str | Path, kind: Kind) -> BinaryIO:
    """Open a plain file for reading.

    Raise InputError if it does not exist, is not a plain file, cannot be read, or is too large for
    its kind.
    """
    check_file(path)  # merely opening a device can have effects
    try:
        file = open(path, "rb", opener=without_waiting)  # noqa: SIM115 - the caller closes it
    except (OSError, ValueError) as error:
        raise _unreadable(path, error) from None
    try:
        found = os.fstat(file.fileno())
        _check(path, found.st_mode)
        if kind.most_bytes is not None and found.st_size > kind.most_bytes:
            raise _too_large(path, kind, found.st_size)
    except BaseException:
        file.close()
        raise
    return file


def file_bytes(path: str | Path, kind: Kind) -> bytes:
    """Read a plain file, or raise InputError."""
    if SHOWN and (shown := SHOWN.get(real(path))) is not None:
        return shown
    with open_file(path, kind) as file:
        try:
            if kind.most_bytes is None:
                return file.read()
            content = file.read(kind.most_bytes + 1)
        except OSError as error:
            raise _unreadable(path, error) from None
    if len(content) > kind.most_bytes:  # the file has grown, or its size is unknown
        raise _too_large(path, kind, len(content))
    return content


def file_text(path: str | Path, kind: Kind) -> str:
    r"""Read a plain UTF-8 file, with or without a byte order mark; `\r\n` and `\r` become `\n`.

    Raises:
        InputError: The file cannot be read, see `open_file`, or it is not UTF-8.
    """
    return text_of(file_bytes(path, kind), path)


def text_of(content: bytes, path: str | Path) -> str:
    """Return the text of a file's content; raise InputError if the bytes are not UTF-8."""
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"byte {error.start} is not UTF-8",
            file=path,
            line=content.count(b"\n", 0, error.start) + 1,
            hint="save the file as UTF-8",
        ) from None
    return text.replace("\r\n", "\n").replace("\r", "\n")


def beginning(path: str | Path, kind: Kind, length: int) -> bytes:
    """Read the first bytes of a plain file, or raise InputError."""
    with open_file(path, kind) as file:
        try:
            return file.read(length)
        except OSError as error:
            raise _unreadable(path, error) from None


def _check(path: str | Path, mode: int) -> None:
    if stat.S_ISREG(mode):
        return
    what = next((name for test, name in _OTHERS if test(mode)), "a special file")
    raise InputError(f"is {what}, not a file", file=path, hint="name a file")


def _unreadable(path: str | Path, error: OSError | ValueError) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    return InputError(f"cannot be read: {reason}", file=path)


def _too_large(path: str | Path, kind: Kind, size: int) -> InputError:
    assert kind.most_bytes is not None
    text = f"is too large for {kind.name}: {size / _MEGABYTE:,.1f} MB"
    limit = kind.most_bytes // _MEGABYTE
    return InputError(f"{text}, and the limit is {limit} MB", file=path, hint=kind.hint)
