"""A unit-test framework: its Structured Text, which is added to the program under test.

The package that ships a framework describes it with `Framework`; this toolkit itself contains no
framework.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Extract, Line, in_dialect, source_text, title_of
from structured_text.output.paths import real
from structured_text.projects.model import without_comments
from structured_text.projects.needed import declared_names, needed
from structured_text.projects.sources import SourceFiles, not_declared, st_files
from structured_text.projects.tasks import ToolTask, configuration
from structured_text.testing.suites.test_files import TestFiles

__all__ = ["Framework"]

#: Matches comments and texts. A name inside a comment or text is not a namespace.
_APART = r"\(\*.*?(?:\*\)|\Z)|//[^\n]*|/\*.*?(?:\*/|\Z)|'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\""
_CONFIGURATION = re.compile(r"\bCONFIGURATION\b", re.IGNORECASE)
_PROGRAM = re.compile(r"\bPROGRAM\s+(\w+)(.*?)\bEND_PROGRAM\b", re.IGNORECASE | re.DOTALL)


@dataclass(frozen=True)
class Framework:
    """The Structured Text of a unit-test framework, and its names that the runner uses.

    Attributes:
        folder: Folder with the ST files of the framework; a program gets the files that it needs.
        namespace: Name of the library, which programs may write in front of its names.
        suite: The function block that suites extend.
        run: The functions that a program calls to run its suites.
        note: The function that reports an event: its kind, the name of the test, the expected and
            the actual value, and the message.
        selected: The function that returns whether a test of the current suite is to run.
        suites: The global array of pointers to the suites.
        count: The global variable with the number of suites.
        current: The global variable with the number of the suite that is called; 0 if none is
            called.
        started: The global variable that is TRUE after the first call of one of `run`.
        done: The global variable that is TRUE when all suites have finished.
        aborted: The global variable that is TRUE when a wrong call has ended the run.
        call: The function that calls a suite; FALSE if the suite has failed at run time.
        tests: The array of a suite with its tests, which have `Name` and `Skipped`.
        test: The global variable with the number of the test that is called; 0 before the first
            test.
        failed: The global variable that ends the current test after an error at run time.
        case: The function block that the tests of TEST files extend.
        words: The names that the tests of TEST files use, see `test_files.TestFiles`.
    """

    folder: Path
    namespace: str
    suite: str
    run: tuple[str, ...]
    note: str
    selected: str
    suites: str
    count: str
    current: str
    started: str
    done: str
    aborted: str
    call: str
    tests: str
    test: str
    failed: str
    case: str
    words: Mapping[str, str]

    @cached_property
    def files(self) -> frozenset[str]:
        """Return the paths of the framework's files; their statements belong to no test."""
        return frozenset(str(real(file)) for file in st_files(self.folder))

    def added_to(self, files: SourceFiles) -> tuple[SourceFiles, dict[str, str]]:
        """Return the sources of a program together with the files of the framework that it needs.

        The framework's declaration of a name is left out if the program declares the name itself.
        The second value gives the title of each suite of a TEST file, by the path of the suite.
        """
        given, titles = TestFiles(self.case, dict(self.words)).sources(files.own)
        own = tuple(self._without_namespace(file) for file in given)
        declared = files.declared.union(*(declared_names(file) for file in own))
        if self.suite.upper() in declared:
            raise InputError(
                f"the program declares {self.suite} itself",
                hint=f"leave the library {self.namespace} out: it is built in",
            )
        own = (*own, *self._started(own))
        if spoken := next(filter(None, (getattr(one, "dialect", "") for one in files.own)), ""):
            own = tuple(in_dialect(one, spoken) for one in own)
        parts = needed([*own, *files.lib], not_declared(st_files(self.folder), declared))
        return replace(files, own=own, lib=(*files.lib, *parts)), titles

    def _started(self, own: Sequence[Path]) -> list[Path]:
        """Return a configuration of all programs that run suites, if several lack a task."""
        programs: list[tuple[str, str, Path]] = []
        for file in own:
            try:
                text = without_comments(source_text(file))
            except InputError:
                continue
            if _CONFIGURATION.search(text):
                return []
            programs += [(found[1], found[2], file) for found in _PROGRAM.finditer(text)]
        if len(programs) < 2:
            return []
        calls = re.compile(rf"\b(?:{'|'.join(self.run)})\s*\(", re.IGNORECASE)
        names = [(name, name) for name, body, _ in programs if calls.search(body)]
        if not names:
            return []
        task = ToolTask("", 0, None, tuple(names), programs[0][2], 1)
        units = configuration([task]).units
        return [Extract.make(unit.file, unit.piece.lines(), unit.name) for unit in units]

    def _without_namespace(self, file: Path) -> Path:
        """Return a source with blanks in place of the namespace; all columns stay the same."""
        try:
            text = source_text(file)
        except InputError:
            return file  # the parser reports the error with its position
        qualifier = rf"{_APART}|(?<![\w.#])({self.namespace}\s*\.)(?=\s*[^\W\d])"
        plain = re.sub(
            qualifier,
            lambda found: re.sub(r"[^\n]", " ", found[0]) if found[1] else found[0],
            text,
            flags=re.DOTALL | re.IGNORECASE,
        )
        if plain == text:
            return file
        lines = getattr(file, "lines", None)
        texts = plain.split("\n")
        if lines is None:
            made = tuple(Line(one, number) for number, one in enumerate(texts, 1))
        else:
            made = tuple(replace(line, text=one) for line, one in zip(lines, texts, strict=False))
        project, unread = getattr(file, "project", ""), getattr(file, "unread", ())
        return Extract.make(file, made, title_of(file), project, unread)
