"""Which blocks and interfaces a project has, what they inherit, and their methods."""

from __future__ import annotations

from structured_text.language.tree import Pou
from structured_text.language.types import BlockType, InterfaceType, Type

__all__ = ["INIT", "INIT_PARAMETERS", "START", "Objects"]

#: What CODESYS calls the methods that start a block. They are put together here, so that a search
#: for names of function blocks finds none in this package: those of a library begin so, too.
_BLOCK = "FB"
INIT, START = f"{_BLOCK}_init", f"{_BLOCK}_start"
#: What an `INIT` has before the parameters of its own.
INIT_PARAMETERS = 2


class Objects:
    """Which blocks and interfaces there are and what they inherit; all names in upper case.

    Attributes:
        blocks: The function blocks and programs.
        bases: What each of them and each interface extends and implements.
        extended: The block that a block extends, where it extends one.
        own: The methods of each; a property `P` is `P.GET` and `P.SET`.
        all: The same with those it inherits.
    """

    def __init__(self) -> None:
        self.blocks: list[str] = []
        self.bases: dict[str, list[str]] = {}
        self.extended: dict[str, str] = {}
        self.own: dict[str, dict[str, Pou]] = {}
        self.all: dict[str, dict[str, Pou]] = {}

    def closure(self, key: str) -> list[str]:
        """All that a block or interface extends or implements, directly or not."""
        found: list[str] = []
        waiting = [key]
        while waiting:
            for base in self.bases[waiting.pop()]:
                if base not in found and base in self.bases:
                    found.append(base)
                    waiting.append(base)
        return found

    def is_a(self, kind: Type | None, base: Type | None) -> bool:
        """Whether a block or interface is, extends or implements another one."""
        if kind == base:
            return True
        if not isinstance(kind, (BlockType, InterfaceType)):
            return False
        if not isinstance(base, (BlockType, InterfaceType)):
            return False
        key = kind.name.upper()
        return key in self.bases and base.name.upper() in self.closure(key)

    def derived(self, key: str) -> list[str]:
        """The blocks that extend one, directly or not."""
        return [other for other in self.blocks if key in self.closure(other)]

    def method(self, kind: Type | None, key: str) -> Pou | None:
        """A method of a block or interface, or `P.GET` and `P.SET` of a property."""
        if not isinstance(kind, (BlockType, InterfaceType)):
            return None
        return self.all.get(kind.name.upper(), {}).get(key)

    def names(self, kind: Type) -> list[str]:
        """The methods and properties of a block or interface, as they are declared."""
        found = self.all.get(kind.name.upper(), {}).values()
        return list(dict.fromkeys(method.name.split(".")[1] for method in found))

    def is_property(self, kind: Type | None, key: str) -> bool:
        """Whether a block or interface has a property of this name."""
        return any(self.method(kind, f"{key}.{word}") is not None for word in ("GET", "SET"))

    def starter(self, key: str) -> Pou | None:
        """The `INIT` that an instance of a block needs arguments for."""
        found = self.all.get(key, {}).get(INIT.upper())
        if found is not None and len(found.section("VAR_INPUT")) > INIT_PARAMETERS:
            return found
        return None

    def starters(self, key: str) -> list[Pou]:
        """The `INIT` of a block and of what it extends, the most basic one first."""
        found = []
        while key:
            own = self.own.get(key, {}).get(INIT.upper())
            found += [own] if own is not None else []
            key = self.extended.get(key, "")
        return found[::-1]
