"""The extension for VS Code: it starts `rcx lsp` and `rcx debug`."""

from __future__ import annotations

import os
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.files import replace_files

__all__ = ["write_extension"]

_EXTENSION = Path(__file__).resolve().parents[1] / "verify" / "debug" / "vscode"


def write_extension(folder: Path) -> None:
    """Write the extension into a folder; raise InputError if other files are in the way."""
    contents = {folder / file.name: file.read_bytes() for file in sorted(_EXTENSION.iterdir())}
    for path, data in contents.items():
        if os.path.exists(path) and path.read_bytes() != data:
            hint = "name another folder, or remove it"
            raise InputError(
                "already exists with other contents; nothing was written", file=path, hint=hint
            )
    replace_files(contents)
    print("written: " + ", ".join(os.fspath(path) for path in contents))
    print(f"run npm install in {folder}: it gets vscode-languageclient, which rcx lsp needs")
