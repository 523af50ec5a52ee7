"""The names of files that are projects of PLC tools."""

from __future__ import annotations

import re
from collections.abc import Iterable
from pathlib import Path

from structured_text.errors import InputError

__all__ = ["OBJECTS", "PLCPROJ", "SCL", "TASKS", "in_folder", "is_project"]

#: Endings of PLCopen XML files and of Rockwell files.
_XML, _L5X = ".xml", ".l5x"
#: Endings of a TwinCAT project, and of a task of such a project.
PLCPROJ, TASKS = ".plcproj", ".tctto"
#: Endings of TwinCAT's objects: blocks, types, lists of variables, interfaces.
OBJECTS = (".tcpou", ".tcdut", ".tcgvl", ".tcio")
#: Endings of TIA Portal's external sources: blocks, types, data blocks.
SCL = (".scl", ".udt", ".db")
#: Files of PLC tools that contain programs but cannot be read, with the alternative for each.
_CLOSED = {
    ".project": "in CODESYS: Project > Export PLCopenXML",
    ".library": "in CODESYS: Project > Export PLCopenXML",
    ".acd": "in Studio 5000: save as .L5X",
    ".l5k": "in Studio 5000: save as .L5X",
    ".tsproj": "name the .plcproj of the PLC project",
    ".sln": "name the .plcproj of the PLC project",
    ".tnzip": "unpack it and name the .plcproj",
    ".tpzip": "unpack it and name the .plcproj",
    ".zap": "in TIA Portal: Generate source from blocks",
    ".ap": "in TIA Portal: Generate source from blocks",
    ".awl": "in TIA Portal: write the block in SCL",
    ".smc2": "in Sysmac Studio: copy the bodies into .st files",
    ".gx3": "in GX Works3: copy the bodies into .st files",
}


def is_project(file: Path) -> bool:
    """Return whether a file is read as a project, and not as Structured Text.

    Raises:
        InputError: The format cannot be read; the error names an alternative.
    """
    suffix = file.suffix.lower()
    hint = _CLOSED.get(re.sub(r"\d+$", "", suffix), "")
    if hint:
        raise InputError(f"{file.suffix} cannot be read", file=file, hint=hint)
    return suffix in (_XML, _L5X, PLCPROJ, TASKS, *SCL, *OBJECTS)


def in_folder(files: Iterable[Path]) -> list[Path]:
    """Return the TwinCAT files among the files of a folder.

    The result is the .plcproj files. If there are none, the result is the objects and tasks.
    """
    suffixes: dict[str, list[Path]] = {}
    for file in files:
        suffixes.setdefault(file.suffix.lower(), []).append(file)
    projects = suffixes.get(PLCPROJ, [])
    if projects:
        return sorted(projects)
    found = [file for suffix in (*OBJECTS, TASKS) for file in suffixes.get(suffix, [])]
    return sorted(found, key=lambda file: file.parts)
