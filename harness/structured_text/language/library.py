"""What a library says of itself, in a file beside its folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.toml_files import check_keys, line_of, load_toml

__all__ = ["Names"]


@dataclass(frozen=True)
class Names:
    """Names of a library that its files do not say.

    Attributes:
        prefix: How the names of its types begin; empty: in any way.
        byte_image: Its array of BYTE that is a process image; empty: it has none.
        word_image: The same of WORD.
        notes: What an exported README says of the library, by `TARGET_SUBJECT`.
        project: What an exported project is called.
        file: How the names of exported files begin.
        about: What it is, in a line.
        licence: Its SPDX identifier.
        copyright: Year and owner, for the licence.
        owner: Whose it is.
    """

    prefix: str = ""
    project: str = "Library"
    file: str = "library"
    about: str = ""
    licence: str = ""
    copyright: str = ""
    owner: str = ""
    byte_image: str = ""
    word_image: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def load(cls, file: Path) -> Names:
        """Read a file.

        Raises:
            InputError: it cannot be read, or has another key or no text.
        """
        table = load_toml(file)
        known = [one.name for one in fields(cls)]
        check_keys(table, known, file=file)
        for key, value in table.items():
            texts = value.values() if key == "notes" and isinstance(value, dict) else (value,)
            if not all(isinstance(text, str) for text in texts):
                raise InputError(f"{key} is not a text", file=file, line=line_of(file, key))
        return cls(**table)
