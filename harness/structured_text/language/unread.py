"""Bodies in other languages: a program that executes one of them is refused before it runs."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from structured_text.errors import InputError
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.source import Unread
from structured_text.language.types import Type
from structured_text.language.walk import nodes

__all__ = ["not_executed", "refusal", "unread_bodies"]


def unread_bodies(paths: Iterable[object]) -> list[Unread]:
    """Return the bodies of some sources that are in other languages."""
    return [body for path in paths for body in getattr(path, "unread", ())]


def not_executed(project: Project, paths: Iterable[object]) -> Project:
    """Return the project if it executes no body in another language.

    If a program may call such bodies, raise InputError with the first body and the names of the
    others. A body counts as called if an executed body contains a call of it, even under a
    condition.
    """
    bodies = {body.name.upper(): body for body in unread_bodies(paths)}
    if bodies:
        called = {pou.name.upper() for pou in _executed(project)}
        found = [body for name, body in bodies.items() if name in called]
        if found:
            raise refusal(found)
    return project


def refusal(found: list[Unread]) -> InputError:
    """Return the error for bodies that are needed.

    The error has the file and line of the first body.
    """
    body = found[0]
    others = ", ".join(f"{one.name} ({one.language})" for one in found[1:])
    return InputError(
        f"the body of {body.name} {body.says}" + (f"; neither is {others}" if others else ""),
        file=body.file,
        line=body.at,
        hint=f"write it in Structured Text: --replace {body.name}=file.st",
    )


def _executed(project: Project) -> list[t.Pou]:
    """Return the POUs and methods that the instances of a project may execute."""
    blocks = project.instances.values()
    waiting = [project.pous[block.name.upper()] for block in blocks]
    found: dict[int, t.Pou] = {}
    while waiting:
        pou = waiting.pop()
        if id(pou) not in found:
            found[id(pou)] = pou
            waiting += _called(pou, project)
    return list(found.values())


def _called(pou: t.Pou, project: Project) -> Iterator[t.Pou]:
    """Yield the POUs and methods that a body calls, including all overrides of a called method."""
    objects = project.objects
    for node in nodes(pou.body):
        if isinstance(node, t.CallFunction):
            yield from _known(project, [node.function.upper()])
        elif isinstance(node, t.CallBase):
            yield from _known(project, [node.block.name.upper()])
        elif isinstance(node, t.CallBlock):
            key = node.block.name.upper()
            behind = isinstance(node.instance, t.Deref)
            yield from _known(project, [key, *(objects.derived(key) if behind else ())])
        elif isinstance(node, t.CallMethod):
            yield node.method
            if not node.final:
                part = node.method.name.partition(".")[2].upper()
                for key in _kinds(node.instance.type, project):
                    method = objects.all.get(key, {}).get(part)
                    if method is not None:
                        yield method


def _kinds(kind: Type, project: Project) -> list[str]:
    key = str(getattr(kind, "name", "")).upper()
    return [key, *project.objects.derived(key)] if key in project.objects.bases else [key]


def _known(project: Project, keys: Iterable[str]) -> Iterator[t.Pou]:
    """Yield the POUs with these names; standard blocks are left out, as they have no POU."""
    for key in keys:
        if key in project.pous:
            yield project.pous[key]
