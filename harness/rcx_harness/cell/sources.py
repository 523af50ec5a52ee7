"""The library of the RCX3, and the sources of a program that is written with it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

from structured_text.errors import InputError, did_you_mean, similar
from structured_text.language.library import Names
from structured_text.projects import sources
from structured_text.projects.sources import Files, SourceFiles

__all__ = ["blame_lib", "default_lib", "library_folder", "library_names", "source_files"]

#: The file with the names that a library declares, in the parent of the library's folder.
_NAMES = "library.toml"
_PACKAGE = Path(__file__).resolve().parents[1]


def source_files(
    program: Files,
    lib: str | Path | None = None,
    replace: Mapping[str, str | Path] | None = None,
    dialect: str | None = None,
    device: str = "",
) -> SourceFiles:
    """Find the files of a program, and the files of the library that the program needs.

    Args:
        program: The same as in `source_files` of `structured_text.projects.sources`.
        lib: Folder of the library, searched with its subfolders; None: the library of this package.
        replace: Files with Structured Text for POUs of a project, by name.
        dialect: The PLC tool whose behaviour the program gets; None: the tool of its format.
        device: The device to read if a project has several devices.
    """
    folder = default_lib() if lib is None else Path(lib)
    return sources.source_files(program, folder, replace, dialect, device)


def library_folder(lib: str | Path | None) -> Path:
    """Return the folder of the library."""
    folder = default_lib() if lib is None else Path(lib)
    sources.check_library(folder)
    return folder


def library_names(lib: str | Path | None = None) -> Names:
    """Return the names that a library declares, from a file in the parent of its folder.

    A folder without such a file counts as a copy of this package's library.
    """
    places = [default_lib()] if lib is None else [Path(lib), default_lib()]
    files = [folder.parent / _NAMES for folder in places]
    return Names.load(next((file for file in files[:-1] if file.is_file()), files[-1]))


def blame_lib(error: InputError, lib: str | Path | None) -> InputError:
    """Return an error about an unknown name, with a hint about the library.

    The hint names a block of the library with a similar name. If only the library of this package
    declares the name, but not the library of `--lib`, the hint is to leave out `--lib`.
    """
    missing = re.match(r"there is no (?:type|function) (\w+)|(\w+) is not declared", error.message)
    if missing is None or error.hint.startswith("did you mean"):
        return error
    name = missing[1] or missing[2]
    folder = default_lib() if lib is None else Path(lib)
    if lib is not None and any(default_lib().rglob(f"{name}.st")):
        hint = (
            f"--lib {lib} does not declare it; leave out --lib to use the library in this package"
        )
    else:
        hint = (
            did_you_mean(similar(name, (file.stem for file in folder.rglob("*.st")))) or error.hint
        )
    return InputError(
        error.message, file=error.file, line=error.line, column=error.column, hint=hint
    )


def default_lib() -> Path:
    """Return the folder of the library: `plc/lib` of the repository, or its installed copy."""
    repository = _PACKAGE.parents[1] / "plc" / "lib"
    return repository if repository.is_dir() else _PACKAGE / "_data" / "plc" / "lib"
