"""The variables that a piece of Structured Text mentions, to find what reads a written variable."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import TypeAlias

__all__ = ["Path", "meet", "paths_of"]

Path: TypeAlias = tuple[str, ...]
"""A variable in upper case and its members; an element is `[3]`, or `[` if its index varies."""

_STRING = re.compile(r"\(\*.*?\*\)|'(?:\$.|[^$'])*'")
_PIECE = re.compile(r"\.\s*(\w+)|(\[)|(?<![\w#.])([^\W\d]\w*)|(\])|\w+|.", re.DOTALL)


def paths_of(text: str) -> frozenset[Path]:
    """Return all variables in a text; words of the language are among them."""
    return frozenset(_Reader(_STRING.sub(" ", text)).all())


class _Reader:
    def __init__(self, text: str) -> None:
        self._pieces = [found for found in _PIECE.finditer(text) if not found[0].isspace()]
        self._place = 0

    def all(self) -> Iterator[Path]:
        while self._place < len(self._pieces):
            found = self._pieces[self._place]
            self._place += 1
            if found[3]:
                yield from self._path(found[3].upper())

    def _path(self, name: str) -> Iterator[Path]:
        path: Path = (name,)
        while self._place < len(self._pieces):
            found = self._pieces[self._place]
            if found[1]:
                self._place += 1
                path = (*path, found[1].upper())
            elif found[2]:
                self._place += 1
                inside = self._place
                yield from self._index()
                texts = [piece[0] for piece in self._pieces[inside : self._place - 1]]
                fixed = all(text.isdigit() or text == "," for text in texts)
                path = (*path, f"[{''.join(texts)}]" if fixed else "[")
            else:
                break
        yield path

    def _index(self) -> Iterator[Path]:
        """Yield the variables of an index, up to its closing bracket."""
        while self._place < len(self._pieces):
            found = self._pieces[self._place]
            self._place += 1
            if found[4]:
                return
            if found[3]:
                yield from self._path(found[3].upper())


def meet(some: Iterable[Path], others: Iterable[Path]) -> bool:
    """Return whether a variable of `some` is a variable of `others`, or a part of one."""
    known = list(others)
    return any(_same(path, other) for path in some for other in known)


def _same(path: Path, other: Path) -> bool:
    return all(
        one == two or (one[0] == two[0] == "[" and "[" in (one, two))
        for one, two in zip(path, other, strict=False)
    )
