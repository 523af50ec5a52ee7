"""The sources of an export: each declaration with its text, its tree and its comments."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from lark import Token

from structured_text.errors import COMMAND, InputError
from structured_text.export.prefix import Renaming, renaming
from structured_text.language import syntax as s
from structured_text.language.constructs import refuse
from structured_text.language.lexer import tokens
from structured_text.language.library import Names
from structured_text.language.load import checked
from structured_text.language.parser import parse, parse_text
from structured_text.language.project import Project
from structured_text.language.registry import Registry
from structured_text.language.source import source_text
from structured_text.language.walk import declared
from structured_text.output.exported import MARK, release
from structured_text.output.paths import real
from structured_text.projects.sources import SourceFiles, not_declared, source_files

__all__ = ["Declaration", "Part", "Sources", "comment", "enumerations", "plain", "sources_of"]

Declaration = s.TypeDecl | s.Pou | s.Configuration

_COMMENT = re.compile(r"\(\*(.*?)\*\)", re.DOTALL)
_OPENING = ("TYPE", "FUNCTION", "FUNCTION_BLOCK", "PROGRAM", "CONFIGURATION")


@dataclass(frozen=True)
class Part:
    """A type, function, block, program or configuration.

    Attributes:
        kind: TYPE, FUNCTION, FUNCTION_BLOCK, PROGRAM or CONFIGURATION.
        name: Name as declared.
        file: The file with the declaration.
        folder: Folder relative to that of the library, or `program` for the user's own files.
        header: The text of the comment before the declaration, without the comment's marks.
        head: The text from the opening word to the last END_VAR; for a type or a configuration, the
            whole text.
        body: The text of the statements, with their comments.
        line: The line of the file where the body begins.
        node: The syntax tree of the declaration.
        notes: Comments of variables, fields, enumeration members, tasks and instances, by
            upper-case name. The key "" has all other comments, except for the header.
    """

    kind: str
    name: str
    file: Path
    folder: str
    header: str
    head: str
    body: str
    line: int
    node: Declaration
    notes: dict[str, str] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """Return the whole declaration as Structured Text, including the header."""
        header = f"{comment(self.header)}\n" if self.header else ""
        if self.kind in ("TYPE", "CONFIGURATION"):
            return f"{header}{self.head}\n"
        between = "\n" if self.kind == "FUNCTION" else "\n\n"
        return f"{header}{self.head}{between}{self.body}\nEND_{self.kind}\n"


@dataclass(frozen=True)
class Sources:
    """The checked sources of an export; each declaration follows the declarations that it needs.

    Attributes:
        parts: The declarations.
        renaming: The new names of the library's elements.
        names: Names and texts about the library.
    """

    parts: tuple[Part, ...]
    project: Project
    renaming: Renaming = field(default_factory=Renaming)
    names: Names = field(default_factory=Names)

    @property
    def notice(self) -> str:
        """Return the text for the head of an export, which the library's licence requires."""
        version_ = f"Version {release()}."
        licence = f"SPDX-License-Identifier: {self.names.licence}"
        owner = f"Copyright (c) {self.names.copyright}"
        return "\n".join([self.names.about, version_, "", licence, owner, MARK])

    @cached_property
    def types(self) -> dict[str, s.TypeDecl]:
        """Return the types by upper-case name."""
        found = {part.name.upper(): part.node for part in self.parts}
        return {key: node for key, node in found.items() if isinstance(node, s.TypeDecl)}

    @cached_property
    def members(self) -> dict[str, tuple[s.TypeDecl, int, str]]:
        """Return type, position and name of each enumeration member, by upper-case name."""
        return {
            member.key: (node, value, member.text)
            for node in self.types.values()
            if isinstance(node.spec, s.EnumSpec)
            for value, member in enumerate(node.spec.members)
        }

    def base(self, spec: s.TypeSpec | None) -> s.TypeSpec | None:
        """Return the definition of a named type; return any other type unchanged."""
        while isinstance(spec, s.NamedSpec) and spec.name.key in self.types:
            spec = self.types[spec.name.key].spec
        return spec

    def of(self, *kinds: str) -> list[Part]:
        """Return the declarations of some kinds (such as FUNCTION), in dependency order."""
        return [part for part in self.parts if part.kind in kinds]


def sources_of(
    lib: Path,
    program: Sequence[Path] = (),
    *,
    only_needed: bool = False,
    prefix: str | None = None,
    names: Names | None = None,
) -> Sources:
    """Read and check the library, and a user's files with it.

    Raise InputError if a file is missing or contains an error, the prefix is not allowed, or a
    construct is not in the portable subset. No target supports other constructs.

    Args:
        lib: Folder of the library.
        program: The user's files or folders.
        only_needed: Omit the parts of the library that the program does not need.
        prefix: Prefix for the names of the library; None leaves them unchanged.
        names: Names and texts about the library.
    """
    if only_needed and not program:
        raise InputError("--needed requires a program", hint="name it with --program")
    files = _files(lib, program, only_needed)
    renamed = Renaming() if prefix is None else renaming(files, prefix)

    def read(file: Path) -> s.Source:
        text = renamed.texts.get(file)
        return parse(file) if text is None else parse_text(text, file)

    project = checked(files.all, read)
    refuse(project.uses, f"{COMMAND} export")
    found = {
        id(part.node): part
        for file in files.all
        for part in _parts(file, _folder(file, files), renamed.texts.get(file))
    }
    ordered = Registry(map(read, files.all), _raise).ordered()
    return Sources(
        tuple(found[id(declared.node)] for declared in ordered), project, renamed, names or Names()
    )


def enumerations(types: Iterable[s.TypeDecl]) -> list[str]:
    """Return a line for each enumeration, with the numbers of its members."""
    return [
        f"{node.name.text}: "
        + ", ".join(f"{value} {member.text}" for value, member in enumerate(node.spec.members))
        for node in types
        if isinstance(node.spec, s.EnumSpec)
    ]


def plain(text: str) -> str:
    """Return the text of a comment, without its marks and the stars at the beginnings of lines."""
    lines = [re.sub(r"^\s*\*(?= |$)", "", line).strip() for line in text.strip().splitlines()]
    return "\n".join(lines).strip()


def comment(text: str) -> str:
    """Return the text as a comment of Structured Text."""
    if "\n" not in text:
        return f"(* {text} *)"
    lines = "\n".join(f" * {line}".rstrip() for line in text.splitlines())
    return f"(*\n{lines}\n *)"


def _files(lib: Path, program: Sequence[Path], only_needed: bool) -> SourceFiles:
    if only_needed:
        return source_files(list(program), lib)
    whole = source_files([lib], lib).own
    if not program:
        return SourceFiles((), whole, lib)
    own = source_files(list(program), lib)
    taken = {real(file) for file in own.own}
    others = [file for file in whole if real(file) not in taken]
    return replace(own, lib=tuple(not_declared(others, own.declared)))


def _raise(error: InputError) -> None:
    raise error


def _folder(file: Path, files: SourceFiles) -> str:
    if files.folder is None or file in files.own:
        return "program"
    return file.parent.relative_to(files.folder).as_posix()


@dataclass(frozen=True)
class _Source:
    """A file's text with its tokens; `gap(k)` is the text before token k."""

    text: str
    tokens: list[Token]

    def start(self, index: int) -> int:
        """Return the offset where a token begins."""
        return self.tokens[index].start_pos or 0

    def end(self, index: int) -> int:
        """Return the offset where a token ends; 0 for the index -1, before the first token."""
        return self.start(index) + len(self.tokens[index]) if index >= 0 else 0

    def gap(self, index: int) -> str:
        """Return the blanks and comments before a token."""
        return self.text[self.end(index - 1) : self.start(index)]


def _parts(file: Path, folder: str, text: str | None) -> Iterator[Part]:
    text = source_text(file) if text is None else text
    source = _Source(text, list(tokens(text, file)))
    declared = parse_text(text, file).declarations
    nodes = iter([one for one in declared if not isinstance(one, (s.GlobalList, s.Interface))])
    first = 0
    while first < len(source.tokens):
        kind = str(source.tokens[first].type)
        assert kind in _OPENING, kind
        last = next(
            index
            for index in range(first, len(source.tokens))
            if source.tokens[index].type == f"END_{kind}"
        )
        header = _said(source.gap(first))
        if last + 1 == len(source.tokens):
            header = "\n".join(filter(None, [header, _said(text[source.end(last) :])]))
        if kind == "TYPE":
            yield from _types(source, first, last, header, file, folder, nodes)
        else:
            node = next(nodes)
            head, body, line = _split(source, first, last, kind)
            notes = _notes(source, first, last, node)
            yield Part(kind, node.name.text, file, folder, header, head, body, line, node, notes)
        first = last + 1


def _said(gap: str) -> str:
    return "\n".join(plain(found[1]) for found in _COMMENT.finditer(gap))


def _split(source: _Source, first: int, last: int, kind: str) -> tuple[str, str, int]:
    """Return the head and the body of a POU, and the line in which the body begins."""
    if kind == "CONFIGURATION":
        return source.text[source.start(first) : source.end(last)], "", 1
    ends = [at for at in range(first, last) if source.tokens[at].type == "END_VAR"]
    head_end = ends[-1] if ends else first + (3 if kind == "FUNCTION" else 1)
    body = source.text[source.end(head_end) : source.start(last)]
    body = "\n".join(line.rstrip() for line in body.splitlines())
    begin = source.text.count("\n", 0, source.end(head_end)) + 1
    begin += len(body) - len(body.lstrip("\n"))
    return source.text[source.start(first) : source.end(head_end)], body.strip("\n"), begin


def _types(
    source: _Source,
    first: int,
    last: int,
    header: str,
    file: Path,
    folder: str,
    nodes: Iterator[Declaration],
) -> Iterator[Part]:
    """Yield the types between TYPE and END_TYPE, each in a block of its own."""
    begin, depth = first + 1, 0
    for index in range(first + 1, last):
        word = source.tokens[index].type
        depth += {"STRUCT": 1, "END_STRUCT": -1}.get(str(word), 0)
        if word != "SEMICOLON" or depth:
            continue
        node = next(nodes)
        body = source.text[source.end(begin - 1) : source.end(index)].strip("\n")
        remark = source.gap(index + 1)
        if index + 1 == last:
            body += remark.rstrip()
        head = f"TYPE\n{body}\nEND_TYPE"
        notes = _notes(source, begin, index, node)
        around = [
            *_remarks(source.gap(begin), own=begin > first + 1),
            *filter(None, [notes.get("")]),
            *_remarks(remark, own=False, last=index + 1 == last),
        ]
        notes |= {"": "\n".join(around)} if around else {}
        yield Part("TYPE", node.name.text, file, folder, header, head, "", 1, node, notes)
        begin, header = index + 1, ""


def _remarks(gap: str, *, own: bool, last: bool = True) -> Iterator[str]:
    """Yield the comments between two types that belong to the first or to the second type.

    If `own` is false, comments on the line of the first type are left out. If `last` is false,
    comments on lines of their own are left out.
    """
    for found in _COMMENT.finditer(gap):
        on_line = "\n" not in gap[: found.start()]
        if (on_line and not own) or (not on_line and last):
            yield plain(found[1])


def _notes(source: _Source, first: int, last: int, node: Declaration) -> dict[str, str]:
    """Return the comment of each name inside a declaration.

    A comment belongs to the name before it on its line. A comment on a line of its own belongs to
    the next name, or to the last name if no name follows.
    """
    places = {name.at: name.key for name in _names(node)}
    notes: dict[str, list[str]] = {}
    waiting: list[str] = []
    current = ""
    for index in range(first + 1, last + 1):
        token = source.tokens[index]
        gap = source.gap(index)
        for found in _COMMENT.finditer(gap):
            own_line = "\n" in gap[: found.start()]
            said = plain(found[1])
            if current and not own_line:
                notes.setdefault(current, []).append(said)
            else:
                waiting.append(said)
        if token.type == "END_VAR" and current:
            notes.setdefault(current, []).extend(waiting)
            waiting = []
        if key := places.get(s.Position(token.line or 0, token.column or 0)):
            current = key
            notes.setdefault(current, []).extend(waiting)
            waiting = []
        ended = token.type == "END_VAR" and not _more(source, index, last)
        if (index == last and not isinstance(node, s.Pou)) or (ended and not current):
            notes.setdefault(current, []).extend(waiting)
        if ended and isinstance(node, s.Pou):
            break
    return {key: "\n".join(said) for key, said in notes.items() if said}


def _more(source: _Source, index: int, last: int) -> bool:
    """Return whether a section of variables follows the current token."""
    return any(source.tokens[at].type == "END_VAR" for at in range(index + 1, last))


def _names(node: Declaration) -> Iterator[s.Name]:
    if isinstance(node, s.TypeDecl):
        if isinstance(node.spec, s.EnumSpec):
            yield from node.spec.members
        elif isinstance(node.spec, s.StructSpec):
            for one in node.spec.fields:
                yield from one.names
        return
    if isinstance(node, s.Configuration):
        yield from [one.name for one in node.tasks] + [one.name for one in node.programs]
    sections = node.sections if isinstance(node, s.Pou) else node.globals
    yield from (name for _, _, name in declared(sections))
