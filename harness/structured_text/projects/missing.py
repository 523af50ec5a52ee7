"""Names that a program misses because a library is not read: one message for each library."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Container, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from structured_text.errors import COMMAND, InputError
from structured_text.output.toml_files import load_toml
from structured_text.projects.model import Library

__all__ = ["by_library", "libraries_of", "missing_name", "simple_type"]

_FILE = Path(__file__).with_name("vendor_libraries.toml")
#: The prefix of function block names, which the lists in the file leave out or write as `@`. The
#: text is composed here, so that a search for block names does not find this line.
_BLOCK = "FB" + "_"
_SAID = re.compile(
    r"there is no (?:type|function|interface|namespace|variable or namespace) (?P<one>[\w.]+)$"
    r"|(?P<base>[\w.]+) is not a (?:function block|structure) of these sources$"
    r"|(?P<variable>\w+) is not declared$"
)
#: Names that are built into the tools. If such a name is unknown, no library is missing.
_BUILT_IN = ("ANY", "BIT", "FAILED", "HRESULT", "PVOID", "SUCCEEDED", "__SYSTEM", "__UXINT")
#: Part of a message for a missing name that any of many libraries may declare.
_OTHERS = "libraries that the project refers to"
#: Greatest number of names in a message.
_LISTED = 8


@dataclass(frozen=True)
class _Vendor:
    """The known elements of a library, in upper case."""

    names: frozenset[str]
    begins: tuple[str, ...]
    types: dict[str, str]

    def has(self, key: str) -> bool:
        return key in self.names or key in self.types or key.startswith(self.begins)


def missing_name(error: InputError) -> str:
    """Return the name that an error says is missing; empty for other errors."""
    found = _SAID.match(error.message)
    return next(filter(None, found.groups()), "") if found else ""


def libraries_of(name: str) -> list[str]:
    """Return the libraries of PLC tools that are known to have an element of this name."""
    key = name.rpartition(".")[2].upper()
    return [library for library, vendor in _vendors().items() if vendor.has(key)]


def simple_type(name: str) -> str:
    """Return the standard's type for a simple type of a library; empty if it is not known."""
    found = (vendor.types.get(name.upper(), "") for vendor in _vendors().values())
    return next(filter(None, found), "")


def by_library(
    errors: Iterable[InputError], libraries: Sequence[Library], declared: Container[str] = ()
) -> list[InputError]:
    """Return the errors; all errors about missing elements of one library become a single error.

    A missing name belongs to a library if the library is known to have it, or if a project has the
    name with the library's namespace. Other missing types and functions of a project that refers to
    unread libraries may belong to any of these libraries; they are reported as a single error.
    `declared` are names of the project in upper case: their declarations have errors of their own.
    """
    found: list[InputError] = []
    groups: dict[str, list[tuple[str, InputError]]] = {}
    for error in errors:
        name = missing_name(error)
        if name.upper() in declared or name.upper().partition(".")[0] in _BUILT_IN:
            name = ""
        library = _library(name, error, libraries) if name else ""
        if library:
            groups.setdefault(library, []).append((name, error))
        else:
            found.append(error)
    return [*(_message(library, group) for library, group in groups.items()), *found]


def _library(name: str, error: InputError, libraries: Sequence[Library]) -> str:
    """Return the libraries that may declare a missing name, as text; empty if unknown."""
    referred = {library.name.upper(): library.name for library in libraries}
    spaces = {library.namespace.upper(): library.name for library in libraries}
    spaces |= {vendor.upper(): vendor for vendor in _vendors()} | spaces
    first = name.partition(".")[0].upper()
    if " namespace " in error.message or "." in name:
        return spaces.get(first, "")
    known = libraries_of(name)
    if known:
        named = [one for one in known if one.upper() in referred]
        return named[0] if named else " or ".join(known)
    if error.message.endswith(" is not declared") or not libraries:
        return ""
    others = [name for key, name in referred.items() if name not in _vendors()]
    every = list(dict.fromkeys(others or referred.values()))
    if len(every) > _LISTED:
        return f"{len(every)} {_OTHERS}"
    return " or ".join(every)


def _message(library: str, group: Sequence[tuple[str, InputError]]) -> InputError:
    """Return the error for a library, at the first position that needs one of its elements."""
    counts = Counter({name.upper(): 0 for name, _ in group})
    shown = {name.upper(): name for name, _ in reversed(group)}
    counts.update(name.upper() for name, _ in group)
    names = [f"{shown[key]} ({count})" for key, count in counts.most_common(_LISTED)]
    if len(counts) > _LISTED:
        names.append(f"{len(counts) - _LISTED} more")
    places = "1 place misses" if len(group) == 1 else f"{len(group):,} places miss"
    first = group[0][1]
    text = f"the library {library} is not read"
    if library.endswith(_OTHERS):
        text = f"none of the {library} is read"
    elif " or " in library:
        text = f"none of the libraries {library} is read"
    return InputError(
        f"{text}: {places} {', '.join(names)}",
        file=first.file,
        line=first.line,
        column=first.column,
        hint="give its project or sources too, or let "
        f"`{COMMAND} check --stubs DIR` write its interface",
    )


@lru_cache(maxsize=1)
def _vendors() -> dict[str, _Vendor]:
    """Return the known elements of each library."""
    found = {}
    for library, table in load_toml(_FILE).items():
        blocks = [_BLOCK + name for name in table.get("blocks", "").split()]
        names = [*blocks, *table.get("names", "").split()]
        begins = [one.replace("@", _BLOCK).upper() for one in table.get("begins", "").split()]
        types = {name.upper(): kind for name, kind in table.get("types", {}).items()}
        found[library] = _Vendor(frozenset(map(str.upper, names)), tuple(begins), types)
    return found
