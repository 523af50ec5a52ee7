"""The description of a library, in a file beside its folder."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from functools import lru_cache
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.toml_files import check_keys, line_of, load_toml

__all__ = ["Names", "names_of"]

#: Name of a library's folder, and of the file beside the folder that describes the library.
_FOLDER, _FILE = "lib", "library.toml"


@dataclass(frozen=True)
class Names:
    """Properties of a library that its source files do not contain.

    Attributes:
        prefix: Prefix of the names of the library's types; empty if there is none.
        byte_image: Name of the library's array of BYTE for a process image; empty if there is none.
        word_image: Name of the library's array of WORD for a process image; empty if there is none.
        tested: Another engine with which the authors test the library: `matiec`, or empty.
        notes: Notes for an exported README, by `TARGET_SUBJECT`.
        project: Name of an exported project.
        file: Prefix of the names of exported files.
        about: Description of the library in one line.
        licence: SPDX identifier of the licence.
        copyright: Year and owner, for the licence.
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
    tested: str = ""
    notes: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def load(cls, file: Path) -> Names:
        """Read the properties of a library from a file.

        Raise InputError if the file cannot be read, has an unknown key, or a value is not a text.
        """
        table = load_toml(file)
        known = [one.name for one in fields(cls)]
        check_keys(table, known, file=file)
        for key, value in table.items():
            texts = value.values() if key == "notes" and isinstance(value, dict) else (value,)
            if not all(isinstance(text, str) for text in texts):
                raise InputError(f"{key} is not a text", file=file, line=line_of(file, key))
        return cls(**table)


@lru_cache(maxsize=4096)
def names_of(file: Path) -> Names:
    """Return the properties of the library that a source belongs to.

    If the source belongs to no library, the properties are empty.

    A library is a folder `lib` with `library.toml` beside it. A file of that name that belongs to
    something else is not read.
    """
    for parent in file.parents:
        if parent.name == _FOLDER and (description := parent.parent / _FILE).is_file():
            with suppress(InputError):
                return Names.load(description)
    return Names()
