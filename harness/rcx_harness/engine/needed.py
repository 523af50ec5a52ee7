"""Which files of a library a program needs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

__all__ = ["needed"]

#: Comments and texts: what they mention is not needed.
_SAID = re.compile(r"\(\*.*?\*\)|'(?:\$.|[^$'\n])*'", re.DOTALL)
_NAME = re.compile(r"[A-Z_]\w*")
_TYPES = re.compile(r"\bTYPE\b(.*?)\bEND_TYPE\b", re.DOTALL)
_POUS = ("FUNCTION_BLOCK", "FUNCTION", "PROGRAM")
_OTHERS = {"CONFIGURATION", "VAR_GLOBAL"}


def needed(program: Iterable[Path], library: Sequence[Path]) -> list[Path]:
    """The files of a library whose names a program mentions, and those that these mention.

    Args:
        program: The program's own files; one that cannot be read mentions nothing.
        library: Files of the library.

    Returns:
        Part of `library`, in its order: those that declare a name which is needed, and those that
        declare nothing that could be named, or a configuration.
    """
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


@dataclass(frozen=True)
class _File:
    """The names in a file, in upper case, without those in comments and texts.

    `declared` is empty where nothing is, or where a configuration is among it; of types it has
    the names of the fields, too.
    """

    mentioned: frozenset[str] = frozenset()
    declared: frozenset[str] = frozenset()


def _look(file: Path) -> _File:
    try:
        return _read(file, file.stat().st_mtime_ns)
    except OSError:
        return _File()


@lru_cache(maxsize=1024)
def _read(file: Path, stamp: int) -> _File:
    """The names in a file as it was at `stamp`."""
    code = _SAID.sub(" ", file.read_text(encoding="utf-8", errors="replace")).upper()
    words = _NAME.findall(code)
    mentioned = frozenset(words)
    names = [name for word, name in pairwise(words) if word in _POUS]
    if "TYPE" in mentioned:
        for types in _TYPES.findall(code):
            names += re.findall(r"(\w+)\s*:", types)
    return _File(mentioned, frozenset() if mentioned & _OTHERS else frozenset(names))
