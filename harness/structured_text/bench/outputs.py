"""Checks that the output files of a run overwrite no inputs and no files of other programs."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from structured_text.bench.samples import FORMAT
from structured_text.errors import COMMAND, InputError
from structured_text.output.paths import real

__all__ = ["check_outputs"]

if TYPE_CHECKING:
    from structured_text.projects.sources import SourceFiles

#: The kinds of output files: the name of each kind, and the characters with which its files begin.
_WRITTEN = {
    "trace": ("trace", f'{{"format":"{FORMAT.partition("/")[0]}/'),
    "chart": ("timing chart (SVG)", "<svg "),
    "vcd": ("wave file (VCD)", "$timescale"),
    "view": (f"page of {COMMAND} view", f"<!doctype html>\n<!-- {COMMAND} view -->"),
}


def check_outputs(
    outputs: Mapping[str, str | Path | None], files: SourceFiles | None, *inputs: object
) -> None:
    """Check that outputs overwrite no input, no other output and no foreign file.

    Args:
        outputs: The files to write, by kind: `trace`, `chart`, `vcd`, `view`; None for a kind that
            is not written.
        files: The ST files that the run reads, if there are any.
        inputs: Further inputs; entries that are not paths are ignored.

    Raises:
        InputError: An output is an input, two outputs are one file, or a file exists that no run
            has written.
    """
    if not any(outputs.values()):
        return
    read = {real(file) for file in files.all} if files else set()
    read |= {real(entry) for entry in inputs if isinstance(entry, (str, Path))}
    written: set[Path] = set()
    for kind, output in outputs.items():
        if output is None:
            continue
        place = real(output)
        if place in read:
            raise InputError("would be overwritten, but it is an input", file=output)
        if place in written:
            raise InputError("is named for two outputs", file=output)
        if os.path.isdir(place):
            raise InputError("is a folder, not a file", file=output)
        _check_earlier(kind, output)
        written.add(place)


def _check_earlier(kind: str, output: str | Path) -> None:
    """Check that an existing file is empty or the output of an earlier run."""
    if not os.path.isfile(output):  # only existing plain files can be overwritten
        return
    name, beginning = _WRITTEN[kind]
    try:
        with open(output, "rb") as file:
            found = file.read(len(beginning))
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=output) from None
    if found and found != beginning.encode("ascii"):
        raise InputError(
            f"already exists and is not a {name}; nothing was written",
            file=output,
            hint="name another file, or remove this one",
        )
