"""The lines of statements, in the user's files and in the generated Python."""

from __future__ import annotations

import os
from bisect import bisect_left
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import CodeType
from typing import Any

from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.engines.builtin.statements import Writer
from structured_text.engines.builtin.storage import Storage, slot_name
from structured_text.language import tree as t
from structured_text.language.project import Project
from structured_text.language.source import NetworkLine
from structured_text.language.walk import statements

__all__ = ["Code", "Places", "real_path"]


def real_path(file: str) -> str:
    """Return the canonical path of a file for comparisons: absolute, without links, case folded."""
    return os.path.normcase(os.path.realpath(file))


class _Marking(Writer):
    """A writer of a POU that notes the lines of code at which statements begin.

    The code is identical to the engine's, line by line, so the line numbers are valid for both.

    Attributes:
        begins: The line of the source, by the index of the generated line at which a statement
            begins.
        rounds: For the generated line with the head of a loop, the first generated line of the
            loop. From the second round of the loop on, the head counts as a statement.
    """

    def __init__(self, project: Project, pou: t.Pou, storage: Storage) -> None:
        super().__init__(project, pou, storage)
        self.begins: dict[int, int] = {}
        self.rounds: dict[int, int] = {}
        self._pending = False
        self._last: Any = None

    def _statement(self, node: t.Statement) -> None:
        # An assignment with several targets becomes several statements with the same position.
        self._pending = node.at != self._last
        self._last = node.at
        super()._statement(node)
        self._pending = False

    def _emit(self, line: str) -> None:
        moved = len(self._code.parts)  # a line inserted in front moves all recorded lines
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
        pou: The checked POU.
        begins: The source line of each statement, by the line of the Python module where it begins.
        rounds: As in `_Marking`, but with line numbers of the module.
    """

    pou: t.Pou
    begins: Mapping[int, int]
    rounds: Mapping[int, int]
    lines: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    """The lines of the Python module at which the statements of a source line begin."""

    def first(self, lines: Iterable[int]) -> frozenset[int]:
        """Return the lines of the Python module at which a breakpoint stops.

        An element of a rung or network may become several statements. The run stops before the
        first of them.
        """
        found: dict[str, int] = {}
        plain: list[int] = []
        for line in sorted(lines):
            at = self.begins[line]
            if isinstance(at, NetworkLine):
                found.setdefault(at.network, line)
            else:
                plain.append(line)
        return frozenset((*plain, *found.values()))


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
        """Return the POU whose body is this Python code; None if the code is not a body."""
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
        """Return the upper-case name of the POU whose body is this Python code.

        The result is None if it is not a body.
        """
        self.of(code)
        return self._by_object[code]

    def code_lines(self, key: str, line: int) -> frozenset[int]:
        """Return the lines of the Python module for the statements in a source line of a POU."""
        code = self._code(key)
        return code.first(code.lines.get(line, ())) if code is not None else frozenset()

    def networks(self, key: str) -> dict[str, tuple[int, frozenset[int]]]:
        """Return the rungs or networks of a POU in the order of execution.

        Each has the line of its first statement, and the line of this statement in the Python
        module.
        """
        code = self._code(key)
        found: dict[str, tuple[int, frozenset[int]]] = {}
        if code is None:
            return found
        for line, at in sorted(code.begins.items()):
            if isinstance(at, NetworkLine) and line not in code.rounds:
                found.setdefault(at.network, (at, frozenset((line,))))
        return found

    def _code(self, key: str) -> Code | None:
        body = self._bodies.get(key)
        return self.of(body) if body is not None else None

    @cached_property
    def _bodies(self) -> dict[str, CodeType]:
        """Return the Python code of each POU's body.

        A function that counts calls may wrap a body; the code of the body itself is returned.
        """
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
        """Return the lines with statements of each file, sorted, with the POU of each line."""
        found: dict[str, set[tuple[int, str]]] = {}
        for key, pou in self.project.pous.items():
            lines = found.setdefault(real_path(pou.file), set())
            lines.update((one.at.line, key) for one in statements(pou.body))
        return {file: sorted(lines) for file, lines in found.items()}

    def is_source(self, file: str) -> bool:
        """Return whether a POU of the program is declared in this file."""
        return real_path(file) in self._files

    def line(self, file: str, line: int) -> tuple[int, tuple[str, ...]] | None:
        """Return the first line with a statement, from `line` on, and the POUs of this line."""
        lines = self._files.get(real_path(file), [])
        place = bisect_left(lines, (line, ""))
        if place == len(lines):
            return None
        found = lines[place][0]
        return found, tuple(key for at, key in lines if at == found)

    def lines(self, file: str, first: int, last: int) -> list[int]:
        """Return the lines of a file, within a range, that have statements."""
        found = self._files.get(real_path(file), [])
        return sorted({line for line, _ in found if first <= line <= last})

    def first_line(self, pou: t.Pou) -> int:
        """Return the line of the first statement of a body, or the POU's line if there are none.

        In a drawing, the first statement may be behind others in the file.
        """
        return next((one.at.line for one in statements(pou.body)), pou.at.line)

    def last_line(self, pou: t.Pou) -> int:
        """Return the line of the last statement of a body, or the POU's line if there are none."""
        return [pou.at.line, *(one.at.line for one in statements(pou.body))][-1]
