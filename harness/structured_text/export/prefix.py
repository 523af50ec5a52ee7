"""The option `--prefix`: a prefix for the library's names, if a project has the same names."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from structured_text.errors import BLOCKS, InputError
from structured_text.language import syntax as s
from structured_text.language.lexer import tokens
from structured_text.language.parser import parse
from structured_text.language.source import source_text
from structured_text.language.walk import declared, nodes
from structured_text.output.paths import real
from structured_text.projects.sources import SourceFiles, st_files

__all__ = ["Renaming", "renaming"]

_LEGAL = re.compile(r"[A-Z](_?[A-Z0-9])*_?", re.IGNORECASE | re.ASCII)
#: A word of a comment that is not part of a path.
_WORD = re.compile(r"(?<![\w/.-])[A-Za-z]\w*(?![\w/]|\.\w)")


@dataclass(frozen=True)
class Renaming:
    """The new names of the library's elements.

    Attributes:
        prefixes: The prefix of each renamed name, by the name as declared.
        texts: The sources with the new names, by their files; lines stay where they are.
    """

    prefixes: Mapping[str, str] = field(default_factory=dict)
    texts: Mapping[Path, str] = field(default_factory=dict)

    def said(self, text: str) -> str:
        """Return a text, such as a note for users, with the new names instead of the old names."""
        return _said(text, self.prefixes)


def renaming(files: SourceFiles, prefix: str) -> Renaming:
    """Give the library's names a prefix, in the library and where the user's program uses them.

    If the user declares the same name as the library, this name is not changed in the user's files.
    A name of the library that begins with the prefix is not changed at all. If a new name would be
    equal to such an unchanged name, the prefix is written twice. Raise InputError if a name cannot
    begin with the prefix, or a new name is already in use.
    """
    if not _LEGAL.fullmatch(prefix):
        raise InputError(
            f"--prefix {prefix!r} cannot begin a name",
            hint=f"use a letter, then letters, digits and single underscores, such as {BLOCKS}",
        )
    users, library = files.users
    # Comments may name blocks of the whole library, including blocks that are not exported.
    whole = dict.fromkeys([*library, *_unneeded(files)])
    known = frozenset(name.text for file in whole for name in _declared(parse(file)))
    staying = {name.upper() for name in known if name.upper().startswith(prefix.upper())}
    prefixes = {
        name: 2 * prefix if f"{prefix}{name}".upper() in staying else prefix
        for name in known
        if name.upper() not in staying
    }
    _check({f"{begin}{name}".upper(): name for name, begin in prefixes.items()}, files.all, prefix)
    own = frozenset(name.key for file in users for name in _declared(parse(file)))
    globals_ = frozenset(name.key for file in users for name in _globals(parse(file)))
    in_library = _Names(known, prefixes)
    in_users = _Names(
        frozenset(name for name in known if name.upper() not in own),
        {name: begin for name, begin in prefixes.items() if name.upper() not in own},
        globals_,
    )
    texts = {file: _renamed(file, in_library) for file in library}
    texts |= {file: _renamed(file, in_users) for file in users}
    return Renaming(prefixes, texts)


def _unneeded(files: SourceFiles) -> Iterator[Path]:
    """Yield the files of the library that are not exported."""
    taken = {real(file) for file in files.all}
    there = [] if files.folder is None else st_files(files.folder)
    return (file for file in there if real(file) not in taken)


@dataclass(frozen=True)
class _Names:
    """The meaning of the names in a file.

    Attributes:
        known: Names of the library, as declared.
        prefixes: The prefix of each renamed name.
        hidden: Upper-case names of variables, which hide names of the library.
    """

    known: frozenset[str]
    prefixes: Mapping[str, str]
    hidden: frozenset[str] = frozenset()

    @cached_property
    def keys(self) -> Mapping[str, str]:
        """Return a dict from each renamed name, in upper case, to its prefix."""
        return {name.upper(): begin for name, begin in self.prefixes.items()}

    @cached_property
    def known_keys(self) -> frozenset[str]:
        """Return all names of the library, in upper case."""
        return frozenset(map(str.upper, self.known))

    def of(self, word: str) -> str:
        """Return the name under which the export writes a name of the sources."""
        return self.keys.get(word.upper(), "") + word


def _declared(source: s.Source) -> Iterator[s.Name]:
    """Yield the names of types and POUs, and the members of enumerations."""
    for node in source.declarations:
        if not isinstance(node, s.Configuration):
            yield node.name
        if isinstance(node, s.TypeDecl) and isinstance(node.spec, s.EnumSpec):
            yield from node.spec.members


def _globals(source: s.Source) -> Iterator[s.Name]:
    for node in source.declarations:
        if isinstance(node, s.Configuration):
            yield from (name for _, _, name in declared(node.globals))


def _check(made: Mapping[str, str], files: Iterable[Path], prefix: str) -> None:
    """Refuse a new name that is already in use."""
    for file in files:
        for token in tokens(source_text(file), file):
            words = token.split("#") if token.type == "TYPED" else [token]
            for word in words:
                if token.type in ("IDENT", "LABEL", "TYPED") and word.upper() in made:
                    raise InputError(
                        f"{word} already exists, and --prefix {prefix} makes the same name from "
                        f"{made[word.upper()]} of the library",
                        file=file,
                        line=token.line,
                        hint="use another prefix",
                    )


def _renamed(file: Path, names: _Names) -> str:
    """Return the text of a file with the new names.

    In a literal `TYPE#MEMBER` both names are replaced.
    """
    text = source_text(file)
    source = parse(file)
    places = {name.at for name in _declared(source) if name.key in names.keys}
    for node in source.declarations:
        if not isinstance(node, (s.GlobalList, s.Interface)):
            places.update(_uses(node, names))
    written, behind = [], 0
    for token in tokens(text, file):
        start = token.start_pos or 0
        written.append(_said(text[behind:start], names.prefixes))
        named = s.Position(token.line or 0, token.column or 0) in places
        written.append("#".join(map(names.of, token.split("#"))) if named else str(token))
        behind = start + len(token)
    return "".join([*written, _said(text[behind:], names.prefixes)])


def _said(text: str, prefixes: Mapping[str, str]) -> str:
    """Return comments with the new names.

    Only words in the declared spelling are replaced.
    """
    return _WORD.sub(lambda found: prefixes.get(found[0], "") + found[0], text)


def _uses(declaration: s.TypeDecl | s.Pou | s.Configuration, names: _Names) -> Iterator[s.Position]:
    """Yield the positions where a declaration names types, POUs and members of the library."""
    hidden = names.hidden
    if isinstance(declaration, s.Pou):
        hidden |= frozenset(name.key for _, _, name in declared(declaration.sections))
    members: set[s.Name] = set()
    for node in nodes(declaration):
        if isinstance(node, s.Name):
            if node.key in names.keys and node.key not in hidden and node not in members:
                yield node.at
        elif isinstance(node, s.StructInit):
            members.update(name for name, _ in node.fields)
        elif isinstance(node, s.Literal):
            if node.text.partition("#")[0].upper() in names.known_keys:
                yield node.at
        else:
            yield from (name.at for name in _named(node) if name.key in names.keys)


def _named(node: Any) -> Iterable[s.Name]:
    """Return the names of types and POUs that a syntax node contains outside of its child nodes."""
    if isinstance(node, s.NamedSpec):
        return (node.name,)
    if isinstance(node, s.Call):
        return (node.function,)
    return (node.program,) if isinstance(node, s.ProgramInstance) else ()
