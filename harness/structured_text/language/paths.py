"""Paths such as `Main.Robot.SO.SO02_ServoOn` or `Main.Grid[1,2]`, resolved for every engine."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from structured_text.errors import InputError
from structured_text.language.project import Project
from structured_text.language.types import ArrayType, BlockType, StructType, Type, Variable, members
from structured_text.language.values import describe

__all__ = ["Resolved", "Step", "resolve", "walk"]

#: The declared name of a member, or the row-major position of an element, from 0.
Step = str | int


@dataclass(frozen=True)
class Resolved:
    """A variable found by its path.

    Attributes:
        path: The path with names as they are declared.
        root: Name of the program instance, or of the global variable.
        is_global: Whether `root` is a global variable.
        steps: The member names and element positions that lead from the root to the variable.
        address: Direct address of the variable, or of the located variable that contains it.
        inside: The steps that lead from the located variable to this variable.
    """

    path: str
    root: str
    is_global: bool
    steps: tuple[Step, ...]
    type: Type
    address: str | None = None
    inside: tuple[Step, ...] = ()


_PART = re.compile(r"\s*(?:(?P<dot>\.)?\s*(?P<name>[^\W\d]\w*)|\[(?P<indices>[^\[\]]*)\])\s*")


def resolve(project: Project, path: str) -> Resolved:
    """Find a variable.

    Names are compared without case. If the project has exactly one program instance, `Main` and the
    name of the program are accepted for it. The path of a global variable is its name, with or
    without the name of its list. A VAR_EXTERNAL leads to its global variable. A path begins with a
    program instance or a global variable; `.member` and `[index, index]` follow.

    Raises:
        InputError: There is no such variable (the message suggests similar names), an index is out
            of range, or the variable is a VAR_IN_OUT, which has no value outside a call.
    """
    first, *parts = _split(path)
    found = _root(project, str(first))
    if found is None and parts:
        found = _listed(project, str(first), str(parts.pop(0)))
    if found is None:
        raise _no_root(project, path, str(first))
    for part in parts:
        found = _member(project, found, part) if isinstance(part, str) else _element(found, part)
    return found


def _split(path: str) -> list[str | tuple[int, ...]]:
    parts: list[str | tuple[int, ...]] = []
    end = 0
    while end < len(path):
        part = _PART.match(path, end)
        if part is None or (part["name"] is not None and bool(part["dot"]) != bool(parts)):
            break
        if part["name"] is not None:
            parts.append(part["name"])
        else:
            try:
                parts.append(tuple(int(index) for index in part["indices"].split(",")))
            except ValueError:
                break
        end = part.end()
    if end != len(path) or not parts or not isinstance(parts[0], str):
        raise InputError(
            f"{path!r} is not a path of a variable",
            hint="write it as Main.Robot.Status or Main.A[3]",
        )
    return parts


def _near(name: str, known: Iterable[str]) -> str:
    names = {candidate.upper(): candidate for candidate in known}
    close = difflib.get_close_matches(name.upper(), names, n=3, cutoff=0.6)
    if close:
        return f"did you mean {' or '.join(names[key] for key in close)}?"
    return f"there are {', '.join(list(names.values())[:12])}" if names else ""


def _root(project: Project, name: str) -> Resolved | None:
    key = name.upper()
    for instance, block in project.instances.items():
        aliases = {"MAIN", block.name.upper()} if len(project.instances) == 1 else set()
        if key == instance.upper() or (key in aliases and key not in project.globals):
            return Resolved(instance, instance, False, (), block)
    if key in project.globals:
        return _global(project.globals[key])
    return None


def _listed(project: Project, name: str, variable: str) -> Resolved | None:
    """Return the global variable that is written with its list; None if there is no such list."""
    found = project.lists.get(name.upper())
    if found is None:
        return None
    if variable.upper() not in found:
        names = [project.globals[key].name for key in found.values()]
        raise InputError(f"the list {name} has no variable {variable}", hint=_near(variable, names))
    return _global(project.globals[found[variable.upper()]])


def _no_root(project: Project, path: str, name: str) -> InputError:
    known = [*project.instances, *(variable.name for variable in project.globals.values())]
    return InputError(f"{path}: there is no program instance {name}", hint=_near(name, known))


def _global(variable: Variable) -> Resolved:
    return Resolved(variable.name, variable.name, True, (), variable.type, variable.address)


def _member(project: Project, base: Resolved, name: str) -> Resolved:
    key = name.upper()
    if isinstance(base.type, StructType):
        for field, field_type in base.type.fields:
            if field.upper() == key:
                return _step(base, f"{base.path}.{field}", field, field_type)
        raise _no_member(base, name, [field for field, _ in base.type.fields])
    if isinstance(base.type, BlockType):
        for variable in base.type.variables:
            if variable.name.upper() == key:
                return _pin(project, base, variable)
        raise _no_member(base, name, [variable.name for variable in base.type.variables])
    raise InputError(f"{base.path} is of type {describe(base.type)} and has no member {name}")


def _no_member(base: Resolved, name: str, known: list[str]) -> InputError:
    return InputError(
        f"{base.path} of type {describe(base.type)} has no member {name}", hint=_near(name, known)
    )


def _pin(project: Project, base: Resolved, variable: Variable) -> Resolved:
    if variable.section == "VAR_EXTERNAL":
        return _global(project.globals[variable.name.upper()])
    path = f"{base.path}.{variable.name}"
    if variable.section == "VAR_IN_OUT":
        raise InputError(
            f"{path} is a VAR_IN_OUT and has no value of its own",
            hint="name the variable that is passed to it",
        )
    found = _step(base, path, variable.name, variable.type)
    return replace(found, address=variable.address, inside=())


def _step(base: Resolved, path: str, step: Step, kind: Type) -> Resolved:
    steps, inside = (*base.steps, step), (*base.inside, step)
    return Resolved(path, base.root, base.is_global, steps, kind, base.address, inside)


def _element(base: Resolved, indices: tuple[int, ...]) -> Resolved:
    kind = base.type
    if not isinstance(kind, ArrayType):
        raise InputError(f"{base.path} is of type {describe(kind)} and has no elements")
    if len(indices) != len(kind.bounds):
        raise InputError(
            f"{base.path} has {len(kind.bounds)} dimensions, not {len(indices)}",
            hint="write [1,2] for two dimensions",
        )
    position = 0
    for index, (low, high) in zip(indices, kind.bounds, strict=True):
        if not low <= index <= high:
            raise InputError(f"{base.path}: index {index} is outside {low}..{high}")
        position = position * (high - low + 1) + index - low
    text = ",".join(str(index) for index in indices)
    return _step(base, f"{base.path}[{text}]", position, kind.element)


def walk(project: Project) -> Iterator[tuple[str, Type]]:
    """Yield every variable of the program instances and every global, parents before children.

    An array is one item. Variables without storage in their block (VAR_IN_OUT, VAR_EXTERNAL) are
    left out.
    """
    for instance, block in project.instances.items():
        yield from _below(instance, block)
    for variable in project.globals.values():
        if variable.address is None:
            yield variable.name, variable.type
            yield from _below(variable.name, variable.type)


def _below(path: str, kind: Type) -> Iterator[tuple[str, Type]]:
    for name, member in members(kind):
        yield f"{path}.{name}", member
        yield from _below(f"{path}.{name}", member)
