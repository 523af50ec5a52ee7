"""The built-in engine with exchangeable POUs: compile a program once, then insert mutants.

It would take long to compile each program again for each mutant. Therefore the main process
compiles each program once, and each child process replaces only the code of the mutated POU.
`Workshop.install` replaces the functions by which this process loads and compiles programs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from inspect import isfunction
from pathlib import Path
from typing import Any

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.module import Module
from structured_text.engines.builtin.storage import Storage
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.parser import parse, parse_text
from structured_text.language.project import Project
from structured_text.language.source import source_text
from structured_text.mutants.engine import Checked, load_checked, python_of, rechecked
from structured_text.output.paths import real

# The modules are imported by name, because their packages contain functions with the same names.
front: Any = import_module("structured_text.language.load")
chooser: Any = import_module("structured_text.engines.load")
compiling: Any = import_module("structured_text.engines.builtin.compile")

__all__ = ["Workshop"]


@dataclass(frozen=True)
class _Change:
    """The change that a mutant makes (see `Workshop.put_in`)."""

    file: Path
    text: str
    pou: str
    body: tuple[s.Statement, ...] | None


@dataclass
class _Compiled:
    """A compiled program. `swapped` says whether it already contains the current mutant."""

    checked: Checked
    module: Module
    storage: Storage
    swapped: bool = False


@dataclass
class Workshop:
    """A replacement for the loader and the compiler of Structured Text in this process.

    Attributes:
        seen: Upper-case names of the POUs that have run since the last call of `watch`.
    """

    seen: set[str] = field(default_factory=set)
    _compiled: dict[tuple[str, ...], _Compiled] = field(default_factory=dict)
    _by_project: dict[int, _Compiled] = field(default_factory=dict)
    _watched: list[tuple[dict[str, Any], str, Any]] = field(default_factory=list)
    _watching: bool = False
    _changed: _Change | None = None

    def install(self) -> None:
        """Replace the loader and the compiler of this process by this object."""
        chooser.load = self.load
        chooser.BuiltinProgram = _Builder(self)
        chooser.find_matiec = lambda *_: None
        front.read_file = self._parse

    # --- the mutant of a child process ---

    def put_in(self, file: Path, text: str, pou: str, body: tuple[s.Statement, ...] | None) -> None:
        """Change the text of a file for every program that is built from now on.

        Args:
            file: File of the library.
            text: Changed text of the file.
            pou: Upper-case name of the changed POU.
            body: Changed statements of the POU; None if a declaration is changed as well.
        """
        self._changed = _Change(real(file), text, pou, body)

    def _parse(self, file: Path) -> s.Source:
        if self._changed is not None and self._changed.file == real(file):
            return parse_text(self._changed.text, file)
        return parse(file)

    # --- record of the POUs that run ---

    def watch(self) -> None:
        """Clear `seen`, and record the POUs that run from now on."""
        self.seen = set()
        self._watching = True
        for names, key, function in self._watched:
            names[key] = self._noting(names, key, function)
        self._watched = []

    def unwatch(self) -> None:
        """Stop recording. Every program then runs as it was compiled."""
        self.watch()
        self._watching = False
        for compiled in self._compiled.values():
            for key, value in compiled.module.names.items():
                if isfunction(value):
                    compiled.module.names[key] = getattr(value, "noted", value)

    def _noting(self, names: dict[str, Any], key: str, function: Any) -> Callable[..., Any]:
        """Return a wrapper that records the first call of a POU and then removes itself."""

        def first(*arguments: Any) -> Any:
            self.seen.add(key[2:])
            names[key] = function
            self._watched.append((names, key, function))
            return function(*arguments)

        first.noted = function  # type: ignore[attr-defined]
        return first

    # --- loading and compiling ---

    @property
    def programs(self) -> int:
        """Return the number of programs that have been compiled."""
        return len(self._compiled)

    def load(self, paths: Sequence[Path]) -> Project:
        """Return a checked project. For the same sources return the same object.

        If a mutant is set, its body is inserted into the compiled program. If a declaration is
        changed, the program cannot take the mutant and is compiled again.
        """
        key = tuple(source_text(path) for path in paths)
        found = self._compiled.get(key)
        if found is None or not self._fits(found):
            found = self._compile(paths)
            if found is None:  # The sources contain an error, which the loader raises.
                project: Project = front.load(paths)
                return project
            self._compiled[key] = found
            self._by_project[id(found.checked.project)] = found
        self._swap(found)
        return found.checked.project

    def _fits(self, compiled: _Compiled) -> bool:
        """Return whether a compiled program can take the mutant, or does not contain its POU."""
        if self._changed is None or compiled.swapped:
            return True
        return self._changed.body is not None or not self._has(compiled)

    def _has(self, compiled: _Compiled) -> bool:
        """Return whether a program contains the changed POU."""
        assert self._changed is not None
        scope = compiled.checked.scopes.get(self._changed.pou)
        return scope is not None and real(scope.where.file) == self._changed.file

    def _compile(self, paths: Iterable[Path]) -> _Compiled | None:
        try:
            checked = load_checked(list(paths), self._parse)
        except InputError:
            return None
        storages: list[Storage] = []

        def storage() -> Storage:
            storages.append(Storage())
            return storages[-1]

        compiling.Storage = storage
        try:
            module = Module(checked.project)
        finally:
            compiling.Storage = Storage
        compiled = _Compiled(checked, module, storages[0], swapped=self._changed is not None)
        if self._watching:
            blocks = [key for key, scope in checked.scopes.items() if scope.pou.kind != "PROGRAM"]
            for key in [f"f_{name}" for name in blocks]:
                function = module.names[key]
                module.names[key] = self._noting(module.names, key, function)
        return compiled

    def _swap(self, compiled: _Compiled) -> None:
        """Insert the current mutant into a compiled program, if it is not there yet.

        Only the body of the changed POU is checked and compiled again. Executing its code in the
        namespace of the module replaces the old function, so that all callers use the new function.
        """
        if self._changed is None or compiled.swapped:
            return
        compiled.swapped = True
        body = self._changed.body
        if body is None or not self._has(compiled):
            return
        pou = rechecked(compiled.checked, self._changed.pou, body)
        before = len(compiled.storage.lines)
        code = python_of(compiled.checked.project, pou, compiled.storage)
        more = "\n".join([*compiled.storage.lines[before:], code])
        exec(compile(more, f"<{pou.name}, changed>", "exec"), compiled.module.names)

    def program(self, project: Project) -> BuiltinProgram:
        """Return a program of a project.

        A project that came from `load` is compiled already. Any other project is compiled by the
        engine.
        """
        found = self._by_project.get(id(project))
        if found is None:
            return BuiltinProgram.build(project)
        return BuiltinProgram(found.module)


class _Builder:
    """A replacement for the class BuiltinProgram, used where programs are built."""

    def __init__(self, workshop: Workshop) -> None:
        self._workshop = workshop

    def build(self, project: Project) -> BuiltinProgram:
        """Return a program that the workshop has compiled."""
        return self._workshop.program(project)
