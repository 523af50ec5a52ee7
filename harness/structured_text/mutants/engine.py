"""A checked project in which a POU can be checked and compiled again with another body."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import Any

from structured_text.engines.builtin.statements import Writer
from structured_text.engines.builtin.storage import Storage
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.bodies import check_body
from structured_text.language.declare import Scope
from structured_text.language.parser import parse
from structured_text.language.project import Project

__all__ = ["Checked", "bodies_of", "load_checked", "python_of", "rechecked"]

# Imported by name, because the package has a function with the same name as this module.
front: Any = import_module("structured_text.language.load")
_stages: Any = import_module("structured_text.language.stages")


@dataclass
class Checked:
    """A checked project, with the scopes that are needed to check one of its POUs again."""

    project: Project
    scopes: dict[str, Scope]


def bodies_of(source: s.Source) -> dict[str, s.Pou | s.Method]:
    """Return the POUs of a file with their methods, by upper-case name: `DRIVE`, `DRIVE.METHOD`."""
    found: dict[str, s.Pou | s.Method] = {}
    for node in source.declarations:
        if isinstance(node, s.Pou):
            name = node.name.key
            found[name] = node
            for member in node.members:
                if isinstance(member, s.Method):
                    found[f"{name}.{member.name.key}"] = member
                else:
                    accessors = (("GET", member.getter), ("SET", member.setter))
                    inner = f"{name}.{member.name.key}"
                    found |= {f"{inner}.{word}": one for word, one in accessors if one is not None}
    return found


def rechecked(checked: Checked, name: str, body: tuple[s.Statement, ...]) -> t.Pou:
    """Check a POU with another body, and return it.

    A mutant of a function may leave out the assignment of the result.

    Raises:
        InputError: The body has a mistake; the first one is reported.
    """
    scope = checked.scopes[name]
    pou = replace(scope.pou, body=())
    errors: list[InputError] = []
    check_body(replace(scope, pou=pou), body, errors.append)
    errors = [error for error in errors if "never sets its result" not in error.message]
    if errors:
        raise errors[0]
    return pou


def python_of(project: Project, pou: t.Pou, storage: Storage) -> str:
    """Return the Python code of a POU."""
    writer = Writer(project, pou, storage)
    writer.write()
    return "\n".join([*writer.lines, ""])


def load_checked(paths: list[Path], parsing: Callable[[Path], s.Source] = parse) -> Checked:
    """Load a project, and return it with the scopes of its POUs, or raise InputError.

    `parsing` is a function that parses a file and returns its syntax.
    """
    scopes: dict[str, Scope] = {}

    def keeping(scope: Scope, body: Any, report: Callable[[InputError], None]) -> None:
        scopes[scope.pou.name.upper()] = scope
        check_body(scope, body, report)

    usual, _stages.check_body = _stages.check_body, keeping
    try:
        project = front.load(paths, parsing)
    finally:
        _stages.check_body = usual
    return Checked(project, scopes)
