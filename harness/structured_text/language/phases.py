"""Programs of Automation Studio: `_INIT`, `_CYCLIC` and `_EXIT`, with variables in other files.

A task is a folder. Its `.st` files have the programs `_INIT`, which runs once before the first
scan, `_CYCLIC`, which runs in every scan, and `_EXIT`, which runs when the task is removed. Its
`.var` files have the variables that all three programs share, `.typ` files have types, and `.fun`
files the heads of functions whose bodies are in `.st` files.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from structured_text.language import syntax as s
from structured_text.language.constructs import Use
from structured_text.language.parser import SHELL

__all__ = ["joined"]

_INIT, _CYCLIC, _EXIT = _PHASES = ("_INIT", "_CYCLIC", "_EXIT")
_HEADS = ".fun"
#: Name of the variable that is TRUE as soon as `_INIT` has run.
_DONE = "_INIT_DONE"


def joined(sources: Sequence[s.Source]) -> list[s.Source]:
    """Return the sources with the programs of each task joined, and with its variables."""
    pous = [one for source in sources for one in source.declarations if isinstance(one, s.Pou)]
    names = {one.name.key for one in pous}
    if not names & {*_PHASES, SHELL} and not any(_is(source, _HEADS) for source in sources):
        return list(sources)
    heads = {
        one.name.key: one
        for source in sources
        if _is(source, _HEADS)
        for one in source.declarations
        if isinstance(one, s.Pou)
    }
    written = {
        one.name.key
        for source in sources
        if not _is(source, _HEADS)
        for one in source.declarations
        if isinstance(one, s.Pou)
    }
    tasks = {folder: _Task(sources, folder) for folder in {_folder(one) for one in sources}}
    result = []
    for source in sources:
        task = tasks[_folder(source)]
        kept: list[s.Declaration] = []
        for node in source.declarations:
            if not isinstance(node, s.Pou):
                kept.append(node)
            elif node.name.key == SHELL:
                kept += [] if task.phases else _globals(node, source.file)
            elif node.kind == "PROGRAM" and node.name.key in _PHASES:
                kept += [task.program()] if node is task.first else []
            elif _is(source, _HEADS):
                kept += [] if node.name.key in written else [node]
            elif node.name.key in heads and not node.sections:
                head = heads[node.name.key]
                kept.append(replace(node, sections=head.sections, result=head.result))
            else:
                kept.append(node)
        result.append(replace(source, declarations=tuple(kept), uses=task.uses(source)))
    return result


def _is(source: s.Source, suffix: str) -> bool:
    return source.file.suffix.lower() == suffix


def _folder(source: s.Source) -> Path:
    return Path(source.file).parent


class _Task:
    """The programs and variables of one folder."""

    def __init__(self, sources: Sequence[s.Source], folder: Path) -> None:
        self._folder = folder
        own = [one for one in sources if _folder(one) == folder]
        found = [
            (one, source)
            for source in own
            for one in source.declarations
            if isinstance(one, s.Pou) and one.kind == "PROGRAM"
        ]
        self.phases = {pou.name.key: pou for pou, _ in found if pou.name.key in _PHASES}
        self._shells = [pou for pou, _ in found if pou.name.key == SHELL]
        order = [self.phases[name] for name in (_CYCLIC, _INIT, _EXIT) if name in self.phases]
        self.first = order[0] if order else None
        self._file = next((source.file for pou, source in found if pou is self.first), folder)

    def uses(self, source: s.Source) -> tuple[Use, ...]:
        """Return the constructs of a source that are not portable, including the joined program."""
        if self.first is None or not any(one is self.first for one in source.declarations):
            return source.uses
        use = Use("a program of _INIT and _CYCLIC", source.file, self.first.at)
        return (*source.uses, use)

    def program(self) -> s.Pou:
        """Return the program of the task, named after its folder."""
        assert self.first is not None
        at, init = self.first.at, self.phases.get(_INIT)
        shown = self._folder.name
        name = shown if re.fullmatch(r"[A-Za-z_]\w*", shown) else Path(self._file).stem
        sections = [section for one in self.phases.values() for section in one.sections]
        sections += [section for one in self._shells for section in one.sections]
        body: list[s.Statement] = []
        if init is not None:
            flag = s.Name(_DONE, at)
            spec = s.NamedSpec(s.Name("BOOL", at), at)
            variable = s.VarDecl((flag,), spec, None, None, at)
            sections.append(s.Section("VAR", "", (variable,), at))
            then = (
                s.Assign(flag, s.Literal("BOOLEAN", "TRUE", at), at),
                s.CallStatement(s.Name(_INIT, at), (), at),
            )
            body.append(s.If(((s.Unary("NOT", flag, at), then),), (), at))
        if _CYCLIC in self.phases:
            body += self.phases[_CYCLIC].body
        members = tuple(
            s.Method(one.name, (), None, (), one.body, one.at)
            for key, one in self.phases.items()
            if key != _CYCLIC
        )
        inner = tuple(member for one in self.phases.values() for member in one.members)
        return s.Pou(
            "PROGRAM",
            s.Name(name, self.first.name.at),
            None,
            tuple(sections),
            tuple(body),
            at,
            members=(*members, *inner),
        )


def _globals(node: s.Pou, file: Path) -> list[s.GlobalList]:
    """Return the variables of a `.var` file outside of any task as global variables."""
    return [
        s.GlobalList(s.Name(file.stem, one.at), replace(one, kind="VAR_GLOBAL"), one.at)
        for one in node.sections
    ]
