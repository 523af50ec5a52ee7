"""What an export consists of, and how it comes onto the disk without harm to what is there."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness.errors import InputError

__all__ = ["NOTICE", "Output", "write"]

#: Stands at the head of what is exported; the licence asks for it.
NOTICE = """\
YAMAHA RCX340/RCX320 over EtherNet/IP: function blocks in IEC 61131-3 Structured Text.

SPDX-License-Identifier: MIT
Copyright (c) 2026 The RCX3 function blocks maintainers
Written by `rcx export`; change the sources, not this file."""


@dataclass(frozen=True)
class Output:
    """The result of an exporter.

    Attributes:
        files: Text by path: one with the path `""` for a single file, else below a folder.
        left_out: What the target cannot carry, one line each.
        newline: How the target's tools end a line.
        inputs: What it was made from; never written over.
    """

    files: dict[str, str]
    left_out: tuple[str, ...] = field(default_factory=tuple)
    newline: str = "\n"
    inputs: frozenset[Path] = frozenset()


def write(output: Output, place: Path, *, force: bool = False) -> list[Path]:
    """Write an export to a file, or to a folder that is made where it is missing.

    Args:
        output: What to write.
        place: The file; or the folder, where the export has several.
        force: Write over files that exist.

    Returns:
        The files written.

    Raises:
        InputError: a file is there already, is an input, has a file in place of its folder, or
            cannot be written. Nothing is written in the first three cases.
    """
    files = {place / path if path else place: text for path, text in output.files.items()}
    inputs = {file.resolve() for file in output.inputs}
    for file in files:
        if file.resolve() in inputs:
            raise InputError("would be overwritten, but it is an input", file=file)
        for folder in file.parents:
            if folder.exists() and not folder.is_dir():
                raise InputError("is a file", file=folder, hint="name a folder")
        if file.is_dir() or (file.exists() and not force):
            hint = "name a file" if file.is_dir() else "--force writes over it"
            raise InputError("is there already", file=file, hint=hint)
    for file, text in files.items():
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8", newline=output.newline)
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror}", file=file) from None
    return list(files)
