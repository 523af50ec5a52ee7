"""Files of the user's are written whole or not at all: beside what is there, then in its place."""

from __future__ import annotations

import os
import shutil
from collections.abc import Mapping
from pathlib import Path

from rcx_harness.errors import InputError

__all__ = ["replace_files"]


def replace_files(contents: Mapping[Path, bytes]) -> None:
    """Write files, making the folders they need.

    All are written under other names first, so that a full disk, a fault or Ctrl-C leaves what
    was there as it was. A link stays one; a device is written to.

    Raises:
        InputError: a file cannot be written.
    """
    beside: dict[Path, Path] = {}
    made: list[Path] = []
    try:
        for file, data in contents.items():
            try:
                _make(file.parent, made)
                _write(file, data, beside)
            except OSError as error:
                raise InputError(f"cannot be written: {error.strerror}", file=file) from None
        for place in list(beside):
            try:
                os.replace(beside[place], place)
            except OSError as error:
                raise InputError(f"cannot be written: {error.strerror}", file=place) from None
            del beside[place]
    except BaseException:
        for new in beside.values():
            new.unlink(missing_ok=True)
        for folder in reversed(made):
            if not any(folder.iterdir()):
                folder.rmdir()
        raise


def _make(folder: Path, made: list[Path]) -> None:
    missing = [one for one in (folder, *folder.parents) if not one.exists()]
    for one in reversed(missing):
        one.mkdir()
        made.append(one)


def _write(file: Path, data: bytes, beside: dict[Path, Path]) -> None:
    place = file.resolve()
    there = place.exists()
    if there and not place.is_file():
        place.write_bytes(data)
        return
    new = place.with_name(f".rcx-{os.getpid()}-{len(beside)}.new")
    with new.open("xb") as stream:
        beside[place] = new
        stream.write(data)
    if there:
        shutil.copymode(place, new)
