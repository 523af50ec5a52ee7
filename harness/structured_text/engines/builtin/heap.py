"""Variables made by `__NEW` while a program runs, and their form in a snapshot."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from typing import Any

from structured_text.engines.builtin.storage import Storage, is_scalar
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.types import Type
from structured_text.language.walk import nodes

__all__ = ["NAMES", "Heap", "heap_lines", "kinds_of"]


class Heap(dict[int, tuple[Any, int]]):
    """The variables by their Python identity, each with the number of its type (`kinds_of`).

    Variables in a row are the elements of a list. A single scalar or array is also held in a list.

    Attributes:
        version: Number of changes. After a change, the paths to the variables are searched again.
    """

    def __init__(self) -> None:
        super().__init__()
        self.version = 0

    def put(self, held: Any, number: int) -> None:
        """Add a variable that `__NEW` has made; `number` is the number of its type."""
        self[id(held)] = held, number
        self.version += 1

    def drop(self, held: Any) -> None:
        """Remove a variable that `__DELETE` has ended."""
        self.pop(id(held), None)
        self.version += 1

    def saved(self, names: Mapping[str, Any]) -> tuple[Any, ...]:
        """Return type number, length and values of each variable.

        The length -1 means that the variable is not a list.
        """
        return tuple(
            (number, len(held), [names[f"heap_save{number}"](one) for one in held])
            if isinstance(held, list)
            else (number, -1, names[f"heap_save{number}"](held))
            for held, number in self.values()
        )

    def make(self, saved: tuple[Any, ...], names: Mapping[str, Any], shared: Any) -> None:
        """Replace all variables by new ones with the types and lengths in a snapshot.

        The new variables have their initial values.
        """
        self.clear()
        for number, length, _ in saved:
            made = names[f"heap_make{number}"]
            held = made(shared) if length < 0 else [made(shared) for _ in range(length)]
            self.put(held, number)

    def load(self, saved: tuple[Any, ...], names: Mapping[str, Any]) -> None:
        """Set all variables, which `make` has made, to their values in a snapshot."""
        for (held, number), (_, length, values) in zip(self.values(), saved, strict=True):
            load = names[f"heap_load{number}"]
            if length < 0:
                load(held, values)
            elif load is None:
                held[:] = values
            else:
                for one, value in zip(held, values, strict=True):
                    load(one, value)


NAMES: dict[str, Any] = {"Heap": Heap}


@lru_cache(maxsize=8)
def _made(project: Project) -> dict[Type, t.New]:
    found: dict[Type, t.New] = {}
    if not any(use.construct == "__NEW or __DELETE" for use in project.uses):
        return found
    for pou in project.pous.values():
        for node in nodes(pou.body):
            if isinstance(node, t.New):
                found.setdefault(node.made, node)
    return found


def kinds_of(project: Project) -> list[Type]:
    """Return the types of the variables that `__NEW` makes; the index of a type is its number."""
    return list(_made(project))


def heap_lines(project: Project, storage: Storage) -> Iterator[str]:
    """Yield functions that make, save and load a variable of each type."""
    for number, (kind, node) in enumerate(_made(project).items()):
        yield f"def heap_make{number}(g): return {storage.create(kind, node.initial)}"
        yield f"def heap_save{number}(a): return {storage.save(kind, 'a')}"
        if is_scalar(kind):
            yield f"heap_load{number} = None"
        else:
            yield f"def heap_load{number}(a, b): {storage.load(kind, 'a', 'b')}"
