"""The blocks and interfaces of a project, their inheritance and their methods."""

from __future__ import annotations

from structured_text.language.tree import Pou
from structured_text.language.types import BlockType, InterfaceType, Type

__all__ = ["EXIT", "INIT", "INIT_PARAMETERS", "START", "Objects"]

#: Names in CODESYS of the methods that start a block. The names are composed here, because a search
#: for library blocks, whose names begin with the same prefix, must not find this module.
_BLOCK = "FB"
INIT, START, EXIT = f"{_BLOCK}_init", f"{_BLOCK}_start", f"{_BLOCK}_exit"
#: Number of standard parameters, which stand before the other parameters of an `INIT`.
INIT_PARAMETERS = 2


class Objects:
    """The blocks and interfaces of a project and their inheritance, by upper-case name.

    Attributes:
        blocks: The function blocks and programs.
        bases: The bases of each block and interface: what it extends and implements.
        extended: The block that a block extends, if there is one.
        own: The methods that each block and interface declares; a property `P` is `P.GET` and
            `P.SET`.
        all: The methods of each block and interface, including inherited methods.
    """

    def __init__(self) -> None:
        self.blocks: list[str] = []
        self.bases: dict[str, list[str]] = {}
        self.extended: dict[str, str] = {}
        self.own: dict[str, dict[str, Pou]] = {}
        self.all: dict[str, dict[str, Pou]] = {}

    def closure(self, key: str) -> list[str]:
        """Return all direct and indirect bases of a block or interface."""
        found: list[str] = []
        waiting = [key]
        while waiting:
            for base in self.bases[waiting.pop()]:
                if base not in found and base in self.bases:
                    found.append(base)
                    waiting.append(base)
        return found

    def is_a(self, kind: Type | None, base: Type | None) -> bool:
        """Return whether a block or interface is, extends or implements another one."""
        if kind == base:
            return True
        if not isinstance(kind, (BlockType, InterfaceType)):
            return False
        if not isinstance(base, (BlockType, InterfaceType)):
            return False
        key = kind.name.upper()
        return key in self.bases and base.name.upper() in self.closure(key)

    def derived(self, key: str) -> list[str]:
        """Return all direct and indirect extensions or implementations of a block or interface."""
        return [other for other in self.blocks if key in self.closure(other)]

    def method(self, kind: Type | None, key: str) -> Pou | None:
        """Return a method of a block or interface; a property has `P.GET` and `P.SET`."""
        if not isinstance(kind, (BlockType, InterfaceType)):
            return None
        return self.all.get(kind.name.upper(), {}).get(key)

    def names(self, kind: Type) -> list[str]:
        """Return the declared names of the methods and properties of a block or interface."""
        found = self.all.get(kind.name.upper(), {}).values()
        return list(dict.fromkeys(method.name.split(".")[1] for method in found))

    def is_property(self, kind: Type | None, key: str) -> bool:
        """Return whether a block or interface has a property of this name."""
        return any(self.method(kind, f"{key}.{word}") is not None for word in ("GET", "SET"))

    def starter(self, key: str) -> Pou | None:
        """Return the `INIT` of a block if its instances need arguments for it."""
        found = self.all.get(key, {}).get(INIT.upper())
        if found is not None and len(found.section("VAR_INPUT")) > INIT_PARAMETERS:
            return found
        return None

    def starters(self, key: str) -> list[Pou]:
        """Return the `INIT` methods of a block and its bases; the most basic block comes first."""
        found = []
        while key:
            own = self.own.get(key, {}).get(INIT.upper())
            found += [own] if own is not None else []
            key = self.extended.get(key, "")
        return found[::-1]
