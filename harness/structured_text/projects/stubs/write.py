"""Interface stubs for the names that are missing in the sources."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from structured_text.errors import COMMAND, InputError
from structured_text.language import syntax as s
from structured_text.language.declare import Scope
from structured_text.language.load import Read, read_file, survey
from structured_text.language.source import Extract, Line
from structured_text.projects.missing import by_library, libraries_of, missing_name
from structured_text.projects.model import Library
from structured_text.projects.stubs.kinds import Mentions
from structured_text.projects.stubs.model import CONSTANT, Stub
from structured_text.projects.stubs.uses import Uses

__all__ = ["Stubs", "infer_stubs"]

#: Largest number of passes. The stubs of a pass can reveal further missing names.
_PASSES = 10
_HEAD = (
    "(* An interface without statements, inferred from its use by `{command} check --stubs`.\n"
    "   Complete it: what the program does not use is missing, and types may differ. *)\n"
)
#: The name of the file with the stubs of all missing constants.
_CONSTANTS = "Missing_Constants"
#: The name of the stubs' file in messages, before the stubs are written.
_PLACE = "(stubs)"
_CONSTANT = re.compile(r"[A-Z][A-Z0-9_]{2,}")


@dataclass(frozen=True)
class Stubs:
    """The interfaces of the names that are missing in the sources.

    Attributes:
        texts: The text of each file by its name.
        errors: The errors of the sources if they are checked together with the stubs.
    """

    texts: dict[str, str]
    errors: list[InputError]


def infer_stubs(
    paths: Sequence[Path], libraries: Sequence[Library], declared: frozenset[str]
) -> Stubs:
    """Return interfaces for names that are missing in the sources, as far as their use shows them.

    `libraries` are the libraries that a project refers to. `declared` are names of the project:
    errors in their declarations are not missing names.
    """
    known: dict[Path, s.Source] = {}

    def read(path: Path) -> s.Source:
        if path not in known:
            known[path] = read_file(path)
        return known[path]

    stubs: dict[str, Stub] = {}
    spaces = {library.namespace.upper() for library in libraries}
    errors: list[InputError] = []
    before: dict[str, str] = {}
    mentions: Mentions | None = None
    for _ in range(_PASSES):
        visit = partial(_visit, stubs)
        extra = _extracts(stubs)
        errors = survey([*paths, *extra], visit, read)
        if mentions is None:
            mentions = Mentions(_read_all(paths, read))
        for error in errors:
            if str(error.file) == _PLACE:
                continue
            stub = _missing(error, mentions, declared, spaces, bool(libraries))
            if stub is not None:
                stub.number = len(stubs)
                stubs.setdefault(stub.name.upper(), stub)
        texts = {name: stub.text() for name, stub in stubs.items()}
        if texts == before:
            break
        before = texts
    head = _HEAD.format(command=COMMAND)
    files = {
        f"{stub.name}.st": head + stub.text() for stub in stubs.values() if stub.kind != CONSTANT
    }
    constants = [stub.text() for stub in stubs.values() if stub.kind == CONSTANT]
    if constants:
        files[f"{_CONSTANTS}.st"] = head + "".join(constants)
    return Stubs(files, by_library(errors, libraries, declared))


def _visit(stubs: dict[str, Stub], scope: Scope, body: tuple[s.Statement, ...]) -> None:
    if str(scope.where.file) != _PLACE:
        Uses(scope, stubs).note(body)


def _extracts(stubs: dict[str, Stub]) -> list[Path]:
    """Return the stubs as sources."""
    return [
        Extract.make(
            Path(_PLACE),
            tuple(Line(text, at) for at, text in enumerate(stub.text().splitlines(), 1)),
            stub.name,
        )
        for stub in stubs.values()
    ]


def _read_all(paths: Sequence[Path], read: Read) -> list[s.Source]:
    found = []
    for path in paths:
        try:
            found.append(read(path))
        except InputError:
            continue
    return found


def _missing(
    error: InputError,
    mentions: Mentions,
    declared: frozenset[str],
    spaces: set[str],
    referring: bool,
) -> Stub | None:
    """Return the stub of the name that an error says is missing; None for another error."""
    whole = missing_name(error)
    name = whole.rpartition(".")[2]
    key = name.upper()
    if not name or key in declared:
        return None
    message = error.message
    if " namespace " in message:
        return mentions.space_stub(whole) if whole.upper() in spaces or "." in whole else None
    if "there is no function" in message:
        return mentions.function_stub(name)
    if key in spaces:
        return mentions.space_stub(name)
    if not message.endswith(" is not declared"):
        return mentions.type_stub(name)
    if mentions.is_base(name) and (referring or libraries_of(name)):
        return mentions.name_stub(name)
    if libraries_of(name) or (referring and _CONSTANT.fullmatch(name)):
        return mentions.function_stub(name) if mentions.is_called(name) else Stub(name, CONSTANT)
    return None
