"""Where statements begin: lines of the user's files, and lines of the Python made of them."""

from __future__ import annotations

import os
from bisect import bisect_left
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import CodeType
from typing import Any

from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.engines.builtin.statements import Writer
from structured_text.engines.builtin.storage import Storage, slot_name
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.walk import statements

__all__ = ["Code", "Places", "real_path"]


def real_path(file: str) -> str:
    """A file as it is compared: whole, without links, in the case of the system."""
    return os.path.normcase(os.path.realpath(file))


class _Marking(Writer):
    """Writes a POU and notes at which of its lines statements begin.

    The code is what the engine has compiled, line by line: nothing is added to it.

    Attributes:
        begins: Index of a line of code to the line of the source.
        rounds: Index of the head of a loop, where it is not the first of its statement, to the
            first: it is a statement of its own from the second round on.
    """

    def __init__(self, project: Project, pou: t.Pou, storage: Storage) -> None:
        super().__init__(project, pou, storage)
        self.begins: dict[int, int] = {}
        self.rounds: dict[int, int] = {}
        self._pending = False
        self._last: Any = None

    def _statement(self, node: t.Statement) -> None:
        # Several statements are made of one of the source where it has several targets.
        self._pending = node.at != self._last
        self._last = node.at
        super()._statement(node)
        self._pending = False

    def _emit(self, line: str) -> None:
        moved = len(self._code.parts)  # these go before all statements
        if moved:
            self.begins = {index + moved: at for index, at in self.begins.items()}
            self.rounds = {index + moved: first + moved for index, first in self.rounds.items()}
        super()._emit(line)
        index = len(self.lines) - 1
        if self._pending:
            self.begins[index], self._pending = self._at, False
        elif line == "for _ in FUSE:":
            self.rounds[index] = max(self.begins)
            self.begins[index] = self._at


@dataclass(frozen=True)
class Code:
    """The code of a POU.

    Attributes:
        pou: What it was made of.
        begins: Line of the Python module to the line of the source whose statement begins there.
        rounds: See `_Marking`, in lines of the module.
    """

    pou: t.Pou
    begins: Mapping[int, int]
    rounds: Mapping[int, int]
    lines: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    """Line of the source to those of the module where it begins."""


class Places:
    """The statements of a program, by file and line."""

    def __init__(self, program: BuiltinProgram) -> None:
        self.project = program.module.project
        self._codes: dict[str, Code | None] = {}
        self._by_object: dict[CodeType, str | None] = {}
        names = self._names = program.module.names
        self._file = names["b_globals"].__init__.__code__.co_filename
        self._keys = {f"f_{slot_name(key)}": key for key in self.project.pous}

    @cached_property
    def _storage(self) -> Storage:
        storage = Storage()
        for pou in self.project.pous.values():
            if pou.block is not None:
                storage.block(pou)
        return storage

    def of(self, code: CodeType) -> Code | None:
        """The POU whose body this is; None for any other function."""
        if code not in self._by_object:
            own = code.co_filename == self._file
            self._by_object[code] = self._keys.get(code.co_name) if own else None
        key = self._by_object[code]
        if key is None:
            return None
        if key not in self._codes:
            self._codes[key] = self._made(self.project.pous[key], code.co_firstlineno)
        return self._codes[key]

    def key_of(self, code: CodeType) -> str | None:
        """The upper-case name of the POU whose body this is; None for any other function."""
        self.of(code)
        return self._by_object[code]

    def code_lines(self, key: str, line: int) -> frozenset[int]:
        """Lines of the module where the statements in this line of a POU begin."""
        body = self._bodies.get(key)
        code = self.of(body) if body is not None else None
        return frozenset(code.lines.get(line, ())) if code is not None else frozenset()

    @cached_property
    def _bodies(self) -> dict[str, CodeType]:
        """The code of each POU; functions whose calls are noted lie around it."""
        found: dict[str, CodeType] = {}
        for name, key in self._keys.items():
            function = self._names.get(name)
            while function is not None and function.__code__.co_name != name:
                cells = [cell.cell_contents for cell in function.__closure__ or ()]
                function = next((one for one in cells if callable(one)), None)
            if function is not None:
                found[key] = function.__code__
        return found

    def _made(self, pou: t.Pou, first: int) -> Code:
        writer = _Marking(self.project, pou, self._storage)
        writer.write()
        begins = {first + index: at for index, at in writer.begins.items()}
        rounds = {first + index: first + begin for index, begin in writer.rounds.items()}
        lines: dict[int, tuple[int, ...]] = {}
        for line, at in begins.items():
            if line not in rounds:
                lines[at] = (*lines.get(at, ()), line)
        return Code(pou, begins, rounds, lines)

    # --- files ---

    @cached_property
    def _files(self) -> dict[str, list[tuple[int, str]]]:
        """The lines with statements of each file, each with its POU, sorted."""
        found: dict[str, set[tuple[int, str]]] = {}
        for key, pou in self.project.pous.items():
            lines = found.setdefault(real_path(pou.file), set())
            lines.update((one.at.line, key) for one in statements(pou.body))
        return {file: sorted(lines) for file, lines in found.items()}

    def is_source(self, file: str) -> bool:
        """Is something of the program declared in this file?"""
        return real_path(file) in self._files

    def line(self, file: str, line: int) -> tuple[int, tuple[str, ...]] | None:
        """The next line from this one on that has a statement, and the POUs it is of."""
        lines = self._files.get(real_path(file), [])
        place = bisect_left(lines, (line, ""))
        if place == len(lines):
            return None
        found = lines[place][0]
        return found, tuple(key for at, key in lines if at == found)

    def lines(self, file: str, first: int, last: int) -> list[int]:
        """Every line of these that has a statement."""
        found = self._files.get(real_path(file), [])
        return sorted({line for line, _ in found if first <= line <= last})

    def first_line(self, pou: t.Pou) -> int:
        """Where a body begins, or what has none."""
        return min((one.at.line for one in statements(pou.body)), default=pou.at.line)

    def last_line(self, pou: t.Pou) -> int:
        """The line of the last statement of a body."""
        return max((one.at.line for one in statements(pou.body)), default=pou.at.line)
