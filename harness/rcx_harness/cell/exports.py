"""The export of a program with the library of the RCX3."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rcx_harness.cell.sources import default_lib, library_names
from structured_text.export import parts, targets
from structured_text.export.output import Output

__all__ = ["export", "sources_of"]


def export(
    target: str,
    lib: Path | None = None,
    program: Sequence[Path] = (),
    *,
    only_needed: bool = False,
    prefix: str | None = None,
    ladder: bool = False,
) -> Output:
    """Write the library and a user's files in the format of a target.

    `target` is a key of `TARGETS`. If `lib` is None, the library of this package is exported. If
    `prefix` is None, the names of the library stay unchanged. With `only_needed`, only the parts
    that the program needs are exported. With `ladder`, the bodies of the user's programs and blocks
    are written as ladder.
    """
    folder = default_lib() if lib is None else lib
    names = library_names(lib)
    return targets.export(
        target,
        folder,
        program,
        only_needed=only_needed,
        prefix=prefix,
        names=names,
        ladder=ladder,
    )


def sources_of(
    lib: Path | None = None,
    program: Sequence[Path] = (),
    *,
    only_needed: bool = False,
    prefix: str | None = None,
) -> parts.Sources:
    """Read and check the library and a user's files for an export."""
    folder = default_lib() if lib is None else lib
    names = library_names(lib)
    return parts.sources_of(folder, program, only_needed=only_needed, prefix=prefix, names=names)
