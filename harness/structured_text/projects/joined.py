"""Several projects at once; a project may be a library of another one.

A project may name an element of a library with or without the library's namespace; the sources
contain the name without namespace. If two projects declare the same name, the library's element
gets a new name. The library itself then uses the new name, and so does every project that names the
element with its namespace.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

from structured_text.language.source import Line
from structured_text.projects.model import Foreign, Library, Lines, Piece, Project, Unit, made

__all__ = ["joined"]

#: Matches a comment or string literal, or a name with the namespaces before it. Comments and
#: literals are copied unchanged.
_TOKEN = re.compile(
    r"(?P<other>\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|'(?:\$.|[^$'\n])*'|\{[^}\n]*\})"
    r"|(?P<before>(?:[A-Za-z_]\w*\s*\.\s*)*|[\])^]\s*\.\s*)(?P<name>[A-Za-z_]\w*)",
    re.DOTALL,
)
#: Matches the names in a declaration of variables. `_OF_TYPE` matches the text before the name of a
#: type.
_VARIABLE = re.compile(r"^\s*(?:\{[^}\n]*\}\s*)*(\w+(?:\s*,\s*\w+)*)[^:;\n]*:(?!=)", re.MULTILINE)
_OF_TYPE = re.compile(r"(?::|\b(?:TO|OF|EXTENDS|IMPLEMENTS))\s*\Z", re.IGNORECASE)
_WORD = re.compile(r"[A-Za-z_]\w*")


def joined(projects: Sequence[Project]) -> Project:
    """Return the contents of all projects as a single project.

    If a project is a library of another project, its tasks are left out. If a library is not among
    the projects, a note says so.
    """
    whole = Project()
    used = [_users(one, projects) for one in projects]
    spaces = [
        tuple(dict.fromkeys((*one.namespaces, *(library.namespace for library in users))))
        for one, users in zip(projects, used, strict=True)
    ]
    renamed = [
        _renamed(one, projects) if users or _is_library(one, projects) else {}
        for one, users in zip(projects, used, strict=True)
    ]
    rules = {
        f"{space.upper()}.{unit.name.upper()}": names.get(unit.name.upper(), unit.name)
        for one, known, names in zip(projects, spaces, renamed, strict=True)
        for space in known
        for unit in one.units
    }
    for number, one in enumerate(projects):
        units = [unit for unit in one.units if not (used[number] and unit.kind == "CONFIGURATION")]
        if rules:
            units = [_with_names(unit, rules, renamed[number]) for unit in units]
        missing = [library for library in one.libraries if not _is_given(library, projects)]
        noted = [library for library in missing if library.noted]
        notes = [f"{lib.file}:{lib.at}: the library {lib.name} is not read" for lib in noted]
        left = [*notes, *([_tasks_note(one)] if len(units) < len(one.units) else [])]
        whole = whole.plus(
            replace(one, units=tuple(units), notes=(*one.notes, *left), libraries=tuple(missing))
        )
    return whole.plus(_declared_spaces(whole, spaces))


def _tasks_note(project: Project) -> str:
    (unit, *_) = (unit for unit in project.units if unit.kind == "CONFIGURATION")
    name = project.titles[0]
    return f"{unit.file}: the tasks of the library {name} do not run"


def _is_library(project: Project, projects: Sequence[Project]) -> bool:
    """Return whether a project is a library: it has no tasks, but another project has tasks."""
    tasks = [any(unit.kind == "CONFIGURATION" for unit in one.units) for one in projects]
    own = tasks[next(k for k, one in enumerate(projects) if one is project)]
    return bool(project.titles) and not own and any(tasks)


def _users(project: Project, projects: Sequence[Project]) -> list[Library]:
    """Return the references by which other projects use a project as a library."""
    return [
        library
        for other in projects
        if other is not project
        for library in other.libraries
        if _is_given(library, [project])
    ]


def _is_given(library: Library, projects: Sequence[Project]) -> bool:
    return any(library.name.upper() in (title.upper() for title in one.titles) for one in projects)


def _renamed(project: Project, projects: Sequence[Project]) -> dict[str, str]:
    """Return new names for the elements of a library that another project also declares."""
    others = {unit.name.upper() for one in projects if one is not project for unit in one.units}
    space = _WORD.findall("_".join((*project.namespaces, *project.titles)))[:1] or ["Library"]
    return {
        unit.name.upper(): f"{space[0]}_{unit.name}"
        for unit in project.units
        if unit.name and unit.kind != "CONFIGURATION" and unit.name.upper() in others
    }


def _with_names(unit: Unit, rules: dict[str, str], own: dict[str, str]) -> Unit:
    """Return a declaration with the renamed elements of libraries.

    `rules` has new names for names behind a namespace, `own` for names without one.
    """
    spaces = {rule.partition(".")[0] for rule in rules}
    # A method or property with the same name is another element. In its own body the name is its
    # result.
    members = {part.name.rpartition(".")[2].upper() for part in _parts(unit.piece)}
    heads = [unit.piece.head, *(part.head for part in _parts(unit.piece))]
    for head in heads:
        declared = _VARIABLE.findall("\n".join(line.text for line in head))
        members.update(name.strip().upper() for names in declared for name in names.split(","))
    members.discard(unit.name.upper())

    def text(found: re.Match[str]) -> str:
        if found["other"] is not None:
            return found[0]
        words = re.split(r"(\s*\.\s*)", found[0])  # Copy a whole path of names with dots.
        if found["before"][:1] in (")", "]", "^"):
            return found[0]
        keys = [word.upper() for word in words[:3:2]]
        if keys[0] in members and not _OF_TYPE.search(
            found.string, max(0, found.start() - 80), found.start()
        ):
            return found[0]
        if len(keys) > 1 and (new := rules.get(".".join(keys))):
            return "".join([new, *words[3:]])
        return "".join([own.get(keys[0], words[0]), *words[1:]])

    def lines(given: Lines) -> Lines:
        before = "\n".join(line.text for line in given)
        if not own and not any(space in before.upper() for space in spaces):
            return given
        whole = _TOKEN.sub(text, before).split("\n")
        if len(whole) != len(given):
            return given
        return tuple(
            line if line.text == new else Line(new, line.at, line.shift)
            for line, new in zip(given, whole, strict=True)
        )

    def piece(one: Piece, name: str) -> Piece:
        return replace(
            one,
            name=name,
            head=lines(one.head),
            body=one.body if isinstance(one.body, Foreign) else lines(one.body),
            parts=tuple(piece(part, f"{name}{part.name[len(one.name) :]}") for part in one.parts),
        )

    return replace(unit, piece=piece(unit.piece, own.get(unit.name.upper(), unit.name)))


def _parts(piece: Piece) -> Iterator[Piece]:
    """Yield the methods, properties and actions of a unit."""
    for part in piece.parts:
        yield part
        yield from _parts(part)


def _declared_spaces(whole: Project, spaces: Sequence[tuple[str, ...]]) -> Project:
    """Return a declaration of each namespace that the sources mention."""
    names = dict.fromkeys(name for known in spaces for name in known if _WORD.fullmatch(name))
    mentioned: Counter[str] = Counter()
    for unit in whole.units:
        for line in unit.piece.lines():
            mentioned.update(word.upper() for word in re.findall(r"(\w+)\s*\.", line.text))
    units = [
        Unit("NAMESPACE", Piece(name, made(1, f"NAMESPACE {name}", "END_NAMESPACE")), unit.file)
        for name in names
        for unit in whole.units[:1]
        if mentioned[name.upper()]
    ]
    return Project(tuple(units))
