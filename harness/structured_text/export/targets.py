"""The export formats, by their names on the command line."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from structured_text.errors import InputError
from structured_text.export.keyence import to_keyence
from structured_text.export.l5x.project import to_l5x
from structured_text.export.mitsubishi import to_mitsubishi
from structured_text.export.omron import to_omron
from structured_text.export.output import Output
from structured_text.export.parts import Sources, comment, sources_of
from structured_text.export.plcopen import to_ladder, to_plcopen
from structured_text.export.scl import to_scl
from structured_text.export.twincat import to_twincat
from structured_text.language.compiling import deeply
from structured_text.language.library import Names
from structured_text.language.load import too_deep
from structured_text.projects.sources import source_files

__all__ = ["TARGETS", "Target", "export"]


@dataclass(frozen=True)
class Target:
    """An export format.

    Attributes:
        about: A description in one line.
        ending: End of the name of the output; `/` stands for a folder.
        write: The function that creates the output from the sources.
        write_ladder: The function that writes the user's programs as ladder; None if the format
            has no ladder.
    """

    about: str
    ending: str
    write: Callable[[Sources], Output]
    write_ladder: Callable[[Sources], Output] | None = None


def _to_st(sources: Sources) -> Output:
    """Join the sources into one text, in dependency order."""
    return Output(
        {"": "\n".join([f"{comment(sources.notice)}\n", *(part.text for part in sources.parts)])}
    )


TARGETS = {
    "st": Target("one file of Structured Text, in dependency order", ".st", _to_st),
    "plcopen": Target(
        "PLCopen TC6 XML 2.01: Beremiz, CODESYS, Machine Expert",
        ".xml",
        to_plcopen,
        to_ladder,
    ),
    "twincat": Target(
        "TwinCAT 3: .TcPOU, .TcDUT and a .plcproj to copy from", "_twincat/", to_twincat
    ),
    "scl": Target("Siemens SCL: an external source file for TIA Portal", ".scl", to_scl),
    "l5x": Target(
        "Rockwell L5X: data types and Add-On Instructions for Studio 5000", ".L5X", to_l5x
    ),
    "omron": Target(
        "Omron Sysmac Studio: variable tables to paste, bodies in ST", "_omron/", to_omron
    ),
    "mitsubishi": Target(
        "Mitsubishi GX Works3: label tables as CSV, bodies in ST",
        "_mitsubishi/",
        to_mitsubishi,
    ),
    "keyence": Target(
        "Keyence KV STUDIO: variable tables to paste, bodies in ST (least known)",
        "_keyence/",
        to_keyence,
    ),
}


def export(
    target: str,
    lib: Path,
    program: Sequence[Path] = (),
    *,
    only_needed: bool = False,
    prefix: str | None = None,
    names: Names | None = None,
    ladder: bool = False,
) -> Output:
    """Return the library, and a user's files with it, in a target's format, or raise InputError.

    Args:
        target: A key of `TARGETS`.
        lib: Folder of the library.
        program: The user's files or folders.
        only_needed: Omit the parts of the library that the program does not need.
        prefix: Prefix for the names of the library; None leaves them unchanged.
        names: Names and texts about the library.
        ladder: Write the bodies of the user's programs and blocks as ladder.
    """
    found = TARGETS.get(target)
    if found is None:
        raise InputError(f"there is no target {target!r}", hint=f"use {', '.join(TARGETS)}")
    write = found.write_ladder if ladder else found.write
    if write is None:
        able = ", ".join(name for name, one in TARGETS.items() if one.write_ladder)
        raise InputError(f"--ladder is not possible for {target}", hint=f"it is for {able}")
    if ladder and not program:
        raise InputError("--ladder requires a program", hint="name it with --program")

    def made() -> Output:
        sources = sources_of(lib, program, only_needed=only_needed, prefix=prefix, names=names)
        inputs = frozenset(part.file for part in sources.parts)
        return replace(write(sources), inputs=inputs, recorded=True)

    try:
        return deeply(made)
    except RecursionError:
        raise too_deep(source_files(list(program), lib).all if program else []) from None
