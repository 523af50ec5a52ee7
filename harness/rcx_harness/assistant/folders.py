"""The folders of the server, and the check that a path is inside of them."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.paths import real

__all__ = ["Folders"]


@dataclass(frozen=True)
class Folders:
    """The folders that the calls may use.

    Attributes:
        roots: The folders, without links.
    """

    roots: tuple[Path, ...]

    @classmethod
    def of(cls, given: Sequence[Path]) -> Folders:
        """Return the given folders; raise InputError if one is not a folder."""
        for folder in given:
            if not os.path.isdir(folder):
                reason = "is not a folder" if os.path.lexists(folder) else "does not exist"
                raise InputError(reason, file=folder, hint="name an existing folder")
        return cls(tuple(dict.fromkeys(real(folder) for folder in given)))

    def chosen(self, text: str) -> Path:
        """Return the folder that a call works in; an empty text means the first folder."""
        if not text:
            return self.roots[0]
        folder = real(self.roots[0] / text)
        if folder not in self.roots:
            names = ", ".join(map(str, self.roots))
            raise InputError(f"{text!r:.200} is not a folder of this server", hint=f"use {names}")
        return folder

    def has(self, path: Path) -> bool:
        """Return whether a path without links is inside of a folder."""
        return any(path.is_relative_to(root) for root in self.roots)

    def inside(self, text: str, here: Path) -> Path:
        """Return a path relative to the folder `here`, without links.

        Raise InputError if it leaves the folders: by `..`, as an absolute path, or by a link. The
        message does not say whether the path exists.
        """
        if not text or "\0" in text:
            raise InputError("the name of a file or folder is empty or contains a null character")
        path = real(here / text)
        if not self.has(path):
            hint = "name a path inside of a folder that is given with rcx mcp --folder"
            raise InputError("is outside of the folders of this server", file=text, hint=hint)
        return Path(os.path.relpath(path, here))
