"""TwinCAT 3: the objects of a PLC project (.TcPOU, .TcDUT, .TcGVL, .TcIO) and the .plcproj."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote

from structured_text.errors import InputError
from structured_text.projects.formats import OBJECTS, TASKS
from structured_text.projects.model import (
    Foreign,
    Library,
    Lines,
    Piece,
    Project,
    Unit,
    declared_kind,
    made,
    trimmed,
)
from structured_text.projects.numbers import priority_of, whole
from structured_text.projects.tasks import ToolTask, configuration
from structured_text.projects.xml import Element, read_xml

__all__ = ["read_object", "read_plcproj", "read_tasks"]

#: One day [µs]; no task of TwinCAT has a longer interval.
_LONGEST_US = 86_400_000_000
#: Libraries that need no reference: their blocks and types belong to the standard or are built in.
_KNOWN = ("TC2_STANDARD", "TC2_SYSTEM", "TC3_MODULE")


def read_object(file: Path) -> Project:
    """Read a POU, a type, a list of global variables or an interface, or raise InputError."""
    root = read_xml(file)
    if root.name != "TcPlcObject":
        raise InputError(f"is not an object of TwinCAT, its root is <{root.name}>", file=file)
    units = []
    for element in root.children:
        if element.name in ("POU", "DUT", "GVL", "Itf"):
            units.append(_unit(element, file))
    if not units:
        names = ", ".join(f"<{one.name}>" for one in root.children) or "nothing"
        raise InputError(f"has no POU, DUT, GVL or Itf, only {names}", file=file)
    return Project(tuple(units))


def _unit(element: Element, file: Path) -> Unit:
    name = element.get("Name") or file.stem
    head = _declaration(element, file)
    kind = declared_kind(head)
    if element.name == "GVL":
        return Unit("VAR_GLOBAL", Piece(name, head), file)
    if element.name == "DUT":
        return Unit("TYPE", Piece(name, head), file)
    if kind not in ("PROGRAM", "FUNCTION", "FUNCTION_BLOCK", "INTERFACE"):
        raise InputError(
            f"the declaration of {name} does not begin with PROGRAM, FUNCTION, FUNCTION_BLOCK "
            "or INTERFACE",
            file=file,
            line=element.at,
        )
    parts = tuple(_parts(element, name, file))
    end = made(element.end, f"END_{kind}")
    return Unit(kind, Piece(name, head, _body(element), end, parts), file)


def _declaration(element: Element, file: Path) -> Lines:
    found = element.first("Declaration")
    lines = trimmed(found.lines()) if found is not None else ()
    if not lines:
        name = element.get("Name")
        raise InputError(f"{name or element.name} has no declaration", file=file, line=element.at)
    return lines


def _body(element: Element) -> Lines | Foreign:
    """Return the statements of a POU, a method, an action or an accessor."""
    for implementation in element.all("Implementation"):
        for body in implementation.children:
            if body.name == "ST":
                return trimmed(body.lines())
            return Foreign(body.name, body.at)
    return ()


def _parts(element: Element, owner: str, file: Path) -> Iterator[Piece]:
    for one in element.children:
        name = f"{owner}.{one.get('Name')}"
        if one.name == "Method":
            end = made(one.end, "END_METHOD")
            yield Piece(name, _declaration(one, file), _body(one), end)
        elif one.name == "Property":
            accessors = tuple(_accessor(child, name) for child in one.all("Get") + one.all("Set"))
            end = made(one.end, "END_PROPERTY")
            yield Piece(name, _declaration(one, file), (), end, accessors)
        elif one.name == "Action":
            head, end = made(one.at, f"ACTION {one.get('Name')}:"), made(one.end, "END_ACTION")
            yield Piece(name, head, _body(one), end)


def _accessor(element: Element, owner: str) -> Piece:
    word = element.name.upper()
    found = element.first("Declaration")
    head = made(element.at, word) + (trimmed(found.lines()) if found is not None else ())
    end = made(element.end, f"END_{word}")
    return Piece(f"{owner}.{element.name}", head, _body(element), end)


# --- projects ---------------------------------------------------------------------------------


def read_plcproj(file: Path) -> Project:
    """Read a PLC project: the objects that it names, and its tasks.

    Raise InputError if the file cannot be read or is not such a project, or one of its objects is
    missing or invalid.
    """
    root = read_xml(file)
    if root.name != "Project":
        raise InputError(f"is not a project of TwinCAT, its root is <{root.name}>", file=file)
    found = Project()
    tasks = []
    for item in root.all("ItemGroup", "Compile"):
        named = unquote(item.get("Include"))
        suffix = PureWindowsPath(named).suffix.lower()
        excluded = item.first("ExcludeFromBuild")
        if excluded is not None and excluded.text().lower() == "true":
            continue
        if suffix not in (*OBJECTS, TASKS):
            continue
        place = _below(file.parent, PureWindowsPath(named))
        if place is None:
            raise InputError(
                f"names {named}, which does not exist",
                file=file,
                line=item.at,
                hint="copy the whole folder of the PLC project",
            )
        if suffix == TASKS:
            tasks.append(place)
        else:
            found = found.plus(read_object(place))
    found = found.plus(read_tasks(tasks))
    if not found.units:
        raise InputError("names no POU, type or list of variables", file=file)
    return replace(
        found,
        titles=_settings(root, "Title", "Name", "Placeholder") or (file.stem,),
        namespaces=_settings(root, "DefaultNamespace") or _settings(root, "Title", "Name"),
        libraries=tuple(_libraries(root, file)),
    )


def _settings(root: Element, *names: str) -> tuple[str, ...]:
    """Return the texts of these settings of the project; empty texts are left out."""
    texts = (one.text() for name in names for one in root.all("PropertyGroup", name))
    return tuple(dict.fromkeys(text for text in texts if text))


def _libraries(root: Element, file: Path) -> Iterator[Library]:
    """Yield the references to libraries, except those with blocks of the standard."""
    for kind in ("PlaceholderReference", "LibraryReference"):
        for one in root.all("ItemGroup", kind):
            name = one.get("Include").split(",")[0].strip().removeprefix("#")
            # TwinCAT writes a title with blanks as [My library].
            resolved = [
                part.text().split(",")[0].strip().removeprefix("[").removesuffix("]")
                for part in one.all("DefaultResolution")
            ]
            spaces = [part.text() for part in one.all("Namespace")]
            if name.upper() not in _KNOWN:
                title = next(filter(None, resolved), name)
                yield Library(title, next(filter(None, spaces), title), file, one.at)


def _below(folder: Path, named: PureWindowsPath) -> Path | None:
    """Return the file with this path in a folder, compared without case; None if there is none."""
    place = folder
    for part in named.parts:
        step = place / part
        if part != ".." and not step.exists():
            try:
                near = [one for one in place.iterdir() if one.name.lower() == part.lower()]
            except OSError:
                return None
            if not near:
                return None
            step = near[0]
        place = step
    return place if place.is_file() else None


def read_tasks(files: list[Path]) -> Project:
    """Read the tasks (.TcTTO) of a project, as a CONFIGURATION.

    Raise InputError if a file cannot be read, or its task has no cycle time.
    """
    tasks = []
    for file in files:
        root = read_xml(file)
        for element in root.all("Task"):
            time, priority = element.first("CycleTime"), element.first("Priority")
            name = element.get("Name") or file.stem
            if time is None:
                raise InputError("the task has no cycle time", file=file, line=element.at)
            what = f"the cycle time of the task {name} [us]"
            said = priority.text() if priority is not None else ""
            tasks.append(
                ToolTask(
                    name,
                    whole(time.text(), what, 1, _LONGEST_US, file, time.at),
                    priority_of(said, name, file, (priority or element).at),
                    tuple((one.text(), one.text()) for one in element.all("PouCall", "Name")),
                    file,
                    element.at,
                )
            )
    return configuration(tasks)
