"""The selection of the library files that a program needs.

A file is needed if it declares a name that the program, or another needed file, mentions. The names
are found with regular expressions; the files are not compiled.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language import cache
from structured_text.language.source import source_text
from structured_text.language.words import ACCESS_WORDS

__all__ = ["declared_names", "needed"]

#: Comments and string literals. A name in them does not make a file needed.
_SAID = re.compile(r"\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|'(?:\$.|[^$'\n])*'", re.DOTALL)
_NAME = re.compile(r"[^\W\d]\w*")
_TYPES = re.compile(r"\bTYPE\b(.*?)(?:\bEND_TYPE\b|\Z)", re.DOTALL)
_FIELDS = re.compile(r"\b(STRUCT|UNION)\b.*?(?:\bEND_\1\b|\Z)", re.DOTALL)
_POUS = ("FUNCTION_BLOCK", "FUNCTION", "PROGRAM", "INTERFACE")
_OTHERS = {"CONFIGURATION", "VAR_GLOBAL"}


def needed(program: Iterable[Path], library: Sequence[Path]) -> list[Path]:
    """Return the files of a library that a program mentions, directly or through other files.

    An unreadable file of the program mentions nothing.

    Returns:
        Part of `library`, in its order: the files that declare a needed name. Files that declare
        no name, or global variables or a configuration, are always included.
    """
    own = list(program)
    files = [*own, *library]
    key = cache.sources_key(files)
    # The key has the number of program files, because a library file may become a program file.
    key = key and f"{key}-{len(own)}"
    return cache.made_of("needed", key, files, lambda: _needed(own, library))


def _needed(program: list[Path], library: Sequence[Path]) -> list[Path]:
    """Compute the result of `needed` without the cache."""
    declaring: dict[str, list[Path]] = {}
    found = set()
    for file in library:
        names = _look(file).declared
        found |= set() if names else {file}
        for name in names:
            declaring.setdefault(name, []).append(file)
    waiting = [*program, *found]
    while waiting:
        for name in _look(waiting.pop()).mentioned & declaring.keys():
            new = [file for file in declaring[name] if file not in found]
            found.update(new)
            waiting += new
    return [file for file in library if file in found]


def declared_names(file: Path) -> frozenset[str]:
    """Return the names that a file declares, in upper case."""
    return _look(file).declared


@dataclass(frozen=True)
class _File:
    """The names in a file, in upper case, without names in comments and string literals.

    `declared` is empty if the file declares no name, or if it declares global variables or a
    configuration.
    """

    mentioned: frozenset[str] = frozenset()
    declared: frozenset[str] = frozenset()


def _look(file: Path) -> _File:
    try:
        return _read(file, file.stat().st_mtime_ns)
    except (OSError, InputError):
        return _File()


@lru_cache(maxsize=1024)
def _read(file: Path, stamp: int) -> _File:
    """Return the names in a file.

    `stamp` is the file's time of change. A changed file is therefore read again.
    """
    code = _SAID.sub(" ", source_text(file)).upper()
    words = _NAME.findall(code)
    mentioned = frozenset(words)
    plain = [word for word in words if word not in ACCESS_WORDS]
    names = [name for word, name in pairwise(plain) if word in _POUS]
    if "TYPE" in mentioned:
        for types in _TYPES.findall(code):
            names += re.findall(r"(\w+)\s*:", _FIELDS.sub(" ", types))
    return _File(mentioned, frozenset() if mentioned & _OTHERS else frozenset(names))
