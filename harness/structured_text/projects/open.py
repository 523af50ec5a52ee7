"""The sources that are made from project files, including the user's replacements."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import ELSEWHERE, Extract, Line, Unread, source_text
from structured_text.language.unread import refusal
from structured_text.projects import rockwell, siemens, twincat
from structured_text.projects.formats import OBJECTS, PLCPROJ, SCL, TASKS
from structured_text.projects.joined import joined
from structured_text.projects.model import (
    Foreign,
    Library,
    Lines,
    Piece,
    Project,
    Unit,
    declared_kind,
    without_comments,
)
from structured_text.projects.plcopen.drawn import translated
from structured_text.projects.plcopen.read import read_plcopen, written_by
from structured_text.projects.tasks import NAME, NEVER
from structured_text.projects.xml import read_xml

__all__ = ["Sources", "project_sources", "read_project"]

_WORD = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True)
class Sources:
    """The sources that were made from project files.

    Attributes:
        paths: The sources in order: an `Extract` of each declaration, and replacing files.
        declared: The names of all POUs, types and lists of variables, in upper case.
        notes: One line for each part that is not read.
        libraries: The libraries that the projects refer to and that are not among the projects.
        dialects: The dialect of each file with a format that belongs to one tool.
    """

    paths: tuple[Path, ...] = ()
    declared: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    libraries: tuple[Library, ...] = ()
    dialects: tuple[tuple[str, Path], ...] = ()


def read_project(files: Sequence[Path], device: str = "") -> Project:
    """Read project files, or raise InputError.

    `device` chooses from the devices of a project in PLCopen XML.
    """
    found = Project()
    projects: list[Project] = []
    tasks = [file for file in files if file.suffix.lower() == TASKS]
    calls = siemens.called(file for file in files if file.suffix.lower() in SCL)
    for file in files:
        if file.suffix.lower() in SCL:
            found = found.plus(siemens.read_scl(file, calls)).plus(_of("tia", file))
        elif file not in tasks:
            read = _read(file, device)
            if read.titles:
                projects.append(read)
            else:
                found = found.plus(read)
    found = found.plus(twincat.read_tasks(tasks))
    found = found.plus(siemens.started(found.units))
    projects += [found] if found.units or not projects else []
    known = [unit for one in projects for unit in one.units]
    return joined([translated(one, known) for one in projects])


def _read(file: Path, device: str) -> Project:
    suffix = file.suffix.lower()
    if suffix in OBJECTS:
        return twincat.read_object(file).plus(_of("twincat", file))
    if suffix == PLCPROJ:
        return twincat.read_plcproj(file).plus(_of("twincat", file))
    root = read_xml(file)
    if root.name == "project":
        return read_plcopen(root, file, device).plus(_of(written_by(root), file))
    if root.name == "RSLogix5000Content":
        return rockwell.read_l5x(root, file).plus(_of("logix", file))
    raise InputError(
        f"is neither a PLCopen XML project nor an L5X, its root is <{root.name}>", file=file
    )


def _of(dialect: str, file: Path) -> Project:
    """Return an empty project that records the dialect of a file, if it has one."""
    return Project(dialects=((dialect, file),) if dialect else ())


def project_sources(
    files: Sequence[Path], replaced: Mapping[str, Path], device: str = ""
) -> Sources:
    """Make sources from project files.

    `replaced` maps the name of a POU, or of a part of it (`Block.Method`), to a file with its body
    or its whole declaration; `Tasks` is the name of the tasks. `device`: see `read_project`.

    Raises:
        InputError: A project cannot be read, a body with unsupported statements is needed, or a
            replacement names an unknown POU. A body in another language that may be needed becomes
            an empty body; see `language.unread`.
    """
    project = read_project(files, device)
    units, extra = _replaced(project.units, replaced)
    places = {unit.name.upper(): unit.file for unit in project.units}
    needed, notes = _foreign(units, places)
    unsupported = [one for _, one, body in needed if body.why and body.language == "ST"]
    if unsupported:
        raise refusal(unsupported)
    declared = {unit for unit, _, _ in needed}
    paths = [
        _extract(
            unit,
            places[unit.name.upper()],
            tuple(one for owner, one, _ in needed if owner is unit),
        )
        for unit in units
        if unit in declared or not isinstance(unit.piece.body, Foreign)
    ]
    names = frozenset(unit.name.upper() for unit in project.units)
    notes = [*_left(project, replaced), *notes]
    if NAME.upper() in (name.upper() for name in replaced):
        notes = [note for note in notes if NEVER not in note]
    return Sources((*paths, *extra), names, tuple(notes), project.libraries, project.dialects)


def _extract(unit: Unit, project: Path, unread: tuple[Unread, ...]) -> Extract:
    """Return the source of a unit.

    If the user has replaced the body, all other lines still have their numbers in the project file.
    """
    whole = str(project) if unit.file != project else ""
    drawn = tuple(unit.piece.diagrams())
    lines, made = unit.piece.lines(), unit.generated
    return Extract.make(unit.file, lines, unit.name, whole, unread, diagrams=drawn, generated=made)


# --- bodies in other languages ----------------------------------------------------------------


def _foreign(
    units: Sequence[Unit], files: Mapping[str, Path]
) -> tuple[list[tuple[Unit, Unread, Foreign]], list[str]]:
    """Return the bodies in other languages that may be needed, and a note for each body.

    A body may be needed if another part of the project mentions its name, or if it is a program and
    there is no configuration. `files` maps the name of each unit to its project file.
    """
    found = [(unit, name, body) for unit in units for name, body in unit.piece.foreign()]
    if not found:
        return [], []
    words = {unit: _words(_readable(unit.piece)) for unit in units}
    configured = any(unit.kind == "CONFIGURATION" for unit in units)
    needed, notes = [], []
    for unit, name, body in found:
        last = name.rpartition(".")[2].upper()
        own = name.upper() == unit.name.upper()
        mentioned = any(last in words[one] for one in units if one is not unit or not own)
        file = files[unit.name.upper()]
        text = f"{file}:{body.at}: the body of {name} {body.says}"
        if mentioned or (own and unit.kind == "PROGRAM" and not configured):
            needed.append((unit, Unread(name, body.says, body.language, file, body.at), body))
            notes.append(text)
        else:
            notes.append(f"{text}; nothing mentions it")
    return needed, notes


def _readable(piece: Piece) -> Lines:
    """Return the lines of a POU that can mention other POUs.

    Bodies in other languages are left out; a method without a readable body is left out as a whole.
    """
    parts = tuple(part for part in piece.parts if not isinstance(part.body, Foreign))
    lines = tuple(line for part in parts for line in _readable(part))
    return (*piece.head, *lines, *(() if isinstance(piece.body, Foreign) else piece.body))


def _words(lines: Lines) -> set[str]:
    text = without_comments("\n".join(line.text for line in lines))
    return {word.upper() for word in _WORD.findall(text)}


# --- replacements -----------------------------------------------------------------------------


def _replaced(units: Sequence[Unit], replaced: Mapping[str, Path]) -> tuple[list[Unit], list[Path]]:
    """Return the declarations with replaced bodies, and files that replace whole declarations."""
    found, whole = list(units), []
    for name, file in replaced.items():
        number = next((k for k, unit in enumerate(found) if _has(unit.piece, name)), None)
        if number is None and name.upper() == NAME.upper():
            number = next((k for k, one in enumerate(found) if one.kind == "CONFIGURATION"), None)
            if number is None:
                whole.append(file)
                continue
        if number is None:
            names = [one for unit in units for one in _names(unit.piece)]
            near = get_close_matches(name.upper(), [one.upper() for one in names], 1)
            meant = next((one for one in names if one.upper() in near), "")
            raise InputError(
                f"--replace {name}: there is no POU of this name in the project",
                hint=f"did you mean {meant}?" if meant else "",
            )
        unit = found[number]
        text = source_text(file).splitlines()
        kind = declared_kind(Line(line, 1) for line in text)
        if kind == unit.kind:
            del found[number]
            whole.append(file)
        else:
            found[number] = replace(unit, piece=_with_body(unit.piece, name, text), file=file)
    return found, whole


def _left(project: Project, replaced: Collection[str]) -> list[str]:
    """Return the notes of a project without those about bodies that are replaced."""
    wanted = {name.upper() for name in replaced}
    about = [
        (unit.file, piece)
        for unit in project.units
        for piece in _pieces(unit.piece)
        if piece.name.upper() in wanted
    ]
    return [note for note in project.notes if not any(_is_about(note, *one) for one in about)]


def _is_about(note: str, file: Path, piece: Piece) -> bool:
    """Return whether a note names a line of the body of a piece, or the piece."""
    found = re.match(rf"{re.escape(str(file))}:(\d+): ", note)
    if found is None:
        return False
    lines = [] if isinstance(piece.body, Foreign) else [line.at for line in piece.body]
    inside = bool(lines) and min(lines) <= int(found[1]) < _behind(piece, max(lines))
    return inside or note[found.end() :].startswith(f"{piece.name}: ")


def _behind(piece: Piece, last: int) -> int:
    """Return the first line behind a body whose last statement has the line `last`."""
    others = [part.head[0].at for part in piece.parts if part.head and part.head[0].at > last]
    return min([*others, *(line.at for line in piece.end if line.at > last)], default=last + 1)


def _pieces(piece: Piece) -> Iterator[Piece]:
    yield piece
    for part in piece.parts:
        yield from _pieces(part)


def _names(piece: Piece) -> list[str]:
    return [one.name for one in _pieces(piece)]


def _has(piece: Piece, name: str) -> bool:
    return any(one.upper() == name.upper() for one in _names(piece))


def _with_body(piece: Piece, name: str, text: Sequence[str]) -> Piece:
    """Return the POU with a body from the user's file.

    All other lines keep their numbers in the project file.
    """
    own = piece.name.upper() == name.upper()
    body = tuple(Line(line, at) for at, line in enumerate(text, 1)) if own else piece.body
    if not isinstance(body, Foreign) and not own:
        body = _elsewhere(body)
    return Piece(
        piece.name,
        _elsewhere(piece.head),
        body,
        _elsewhere(piece.end),
        tuple(_with_body(part, name, text) for part in piece.parts),
        None if own else piece.diagram,
    )


def _elsewhere(lines: Lines) -> Lines:
    """Mark lines as lines of the project file.

    The source has the path of the user's file; see `ELSEWHERE`.
    """
    return tuple(
        line if line.at > ELSEWHERE else replace(line, at=line.at + ELSEWHERE) for line in lines
    )
