"""The mutants of a file: changes by mutation operators that compile and alter the compiled code."""

from __future__ import annotations

import hashlib
import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import zip_longest
from pathlib import Path
from random import Random
from typing import TypeVar

from structured_text.engines.builtin.storage import Storage
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.parser import parse, parse_portable, parse_text
from structured_text.language.source import source_text
from structured_text.mutants.engine import Checked, bodies_of, load_checked, python_of, rechecked
from structured_text.mutants.operators import Change, changes
from structured_text.mutants.text import Edit, SourceText, Span, edited, whole_lines
from structured_text.mutants.walk import Body, statements
from structured_text.output.paths import real

__all__ = ["Counted", "Mutant", "Mutants", "in_rounds", "mutant_of"]

_Found = TypeVar("_Found")

_NO_PROGRAM = "PROGRAM NoProgram\n  VAR\n    x : BOOL;\n  END_VAR\n  x := TRUE;\nEND_PROGRAM\n"


@dataclass(frozen=True)
class Mutant:
    """One mistake in one file.

    Attributes:
        file: The path relative to the repository.
        line: The line of the first change.
        before: The original text of the changed lines.
        after: The new text of these lines; empty if they are removed.
        text: The whole file with the mistake.
        body: The statements of the POU with the mistake; None if the mistake is in a declaration.
        reach: The line of the innermost statement that contains the mistake; 0 for a mistake in a
            declaration. The mistake has an effect only if this statement is executed.
    """

    file: str
    pou: str
    operator: str
    line: int
    before: str
    after: str
    text: str
    body: tuple[s.Statement, ...] | None = field(compare=False, repr=False)
    reach: int = field(default=0, compare=False)

    @property
    def identity(self) -> str:
        """Return a hash of the mistake and the whole text of its file."""
        content = f"{self.file}\n{self.operator}\n{self.text}"
        return hashlib.sha256(content.encode()).hexdigest()[:16]


@dataclass
class Counted:
    """The numbers of discarded changes: rejected by the checker, or without effect."""

    refused: int = 0
    equal: int = 0


class Mutants:
    """The mutants of a library, or of a program.

    Paths of files are relative to `root`. With `portable`, a change that is not portable Structured
    Text is not a mutant.

    Raises:
        InputError: The sources have a mistake.
    """

    def __init__(self, root: Path, library: Sequence[Path], *, portable: bool = True) -> None:
        self._root = real(root)
        self._parse = parse_portable if portable else parse_text
        found = [node for file in library for node in parse(file).declarations]
        if any(isinstance(node, s.Pou) and node.kind == "PROGRAM" for node in found):
            self.checked: Checked = load_checked(list(library))
        else:
            with tempfile.TemporaryDirectory() as folder:
                program = Path(folder) / "NoProgram.st"
                program.write_text(_NO_PROGRAM, encoding="utf-8")
                self.checked = load_checked([*library, program])
        self.counted = Counted()

    def of(
        self, file: Path, order: Callable[[Iterable[Change]], Sequence[Change]] = list
    ) -> Iterator[Mutant]:
        """Yield the mutants of one file, in the order that `order` gives their changes.

        Changes that the checker refuses are skipped. A change is also skipped if its compiled code
        equals the code of the original or of an earlier mutant.
        """
        text = source_text(file)
        source = SourceText(text, file)
        for key, node in bodies_of(parse(file)).items():
            body = Body(node, source, self.checked.scopes[key])
            yield from self._of_pou(file, key, body, order(changes(body)))

    def _of_pou(
        self, file: Path, key: str, body: Body, found: Sequence[Change]
    ) -> Iterator[Mutant]:
        """Yield the mutants of a POU.

        A change is compared by its compiled code. If two changes have the same code, or a change
        has the code of the original, no test could tell them apart.
        """
        text, pou = body.source.text, body.scope.pou.name
        path = _named(file, self._root)
        seen = {"", self._initial(key, text, file)}
        checker = _Checker(self.checked, key, body, self._parse)
        reach = _Reach(body)
        for change in found:
            after = edited(text, change.edits)
            try:
                if change.operator == "default":
                    code, statements = self._initial(key, after, file), None
                else:
                    code, statements = checker.changed(change.edits)
            except InputError:
                self.counted.refused += 1
                continue
            if code in seen:
                self.counted.equal += 1
                continue
            seen.add(code)
            mutant = mutant_of(path, pou, change.operator, text, change.edits, statements)
            yield replace(mutant, reach=reach.of(change))

    def _initial(self, name: str, text: str, file: Path) -> str:
        """Return the initial values in the declarations of a POU, as text to compare."""
        scope = self.checked.scopes[name]
        found = []
        for section in bodies_of(self._parse(text, file))[name].sections:
            for declaration in section.variables:
                if isinstance(declaration.initial, (s.Literal, s.Name)):
                    kind = scope.pou.symbols[declaration.names[0].key].type
                    value = scope.declarations.initial_value(
                        declaration.initial, kind, scope.where, None
                    )
                    found.append(f"{declaration.names[0].text} = {value!r}")
        return "\n".join(found)


class _Checker:
    """Checks and compiles a single statement of a body: the statement that contains the change."""

    def __init__(
        self, checked: Checked, name: str, body: Body, parsing: Callable[[str, Path], s.Source]
    ) -> None:
        self._checked = checked
        self._name = name
        self._node = node = body.pou
        self._source = body.source
        self._parse = parsing
        self._spans = [body.source.span(statement) for statement in node.body]
        self._as_it_is = [self._code(index, (one,)) for index, one in enumerate(node.body)]

    def changed(self, edits: tuple[Edit, ...]) -> tuple[str, tuple[s.Statement, ...]]:
        """Return the Python code of the changed statement, and the body with this statement.

        The code is empty if it equals the original code. Raise InputError if the statement is not
        correct.
        """
        start = min(edit.span.start for edit in edits)
        index = max(k for k, span in enumerate(self._spans) if span.start <= start)
        span = self._spans[index]
        moved = tuple(
            Edit(Span(edit.span.start - span.start, edit.span.end - span.start), edit.text)
            for edit in edits
        )
        text = edited(self._source.text[span.start : span.end], moved)
        statements: tuple[s.Statement, ...] = ()
        if text.strip():
            program = f"PROGRAM p\n{text}\nEND_PROGRAM\n"
            file = self._checked.project.files[0]
            (parsed,) = self._parse(program, file).declarations
            assert isinstance(parsed, s.Pou)
            statements = parsed.body
        code = self._code(index, statements)
        body = (*self._node.body[:index], *statements, *self._node.body[index + 1 :])
        return ("" if code == self._as_it_is[index] else code), body

    def _code(self, index: int, statements: tuple[s.Statement, ...]) -> str:
        pou = rechecked(self._checked, self._name, statements)
        return f"{index}: {python_of(self._checked.project, pou, Storage())}"


class _Reach:
    """A search for the statement that contains a change."""

    def __init__(self, body: Body) -> None:
        self._found: list[tuple[Span, int]] = [
            (body.source.span(node), node.at.line) for node in statements(body)
        ]

    def of(self, change: Change) -> int:
        """Return the line of the innermost statement that contains a change.

        If the change is after all statements, return the line of the first statement. If the change
        is in a declaration, return 0.
        """
        start = min(edit.span.start for edit in change.edits)
        if change.operator == "default" or not self._found:
            return 0
        around = [line for span, line in self._found if span.start <= start < span.end]
        return around[-1] if around else self._found[0][1]


def _named(file: Path, root: Path) -> str:
    """Return the path of a file relative to a folder, if it is inside."""
    file = real(file)
    return (file.relative_to(root) if file.is_relative_to(root) else file).as_posix()


def in_rounds(
    found: Iterable[_Found], operator: Callable[[_Found], str], chance: Random
) -> list[_Found]:
    """Return the changes shuffled in rounds; each round has at most one change per operator."""
    kinds: dict[str, list[_Found]] = {}
    for one in found:
        kinds.setdefault(operator(one), []).append(one)
    for one_kind in kinds.values():
        chance.shuffle(one_kind)
    return [one for each in zip_longest(*kinds.values()) for one in each if one is not None]


def mutant_of(
    file: str,
    pou: str,
    operator: str,
    text: str,
    edits: tuple[Edit, ...],
    body: tuple[s.Statement, ...] | None = None,
) -> Mutant:
    """Return the mutant that results from edits of a file's text.

    `Mutant` explains the other arguments.
    """
    start = min(edit.span.start for edit in edits)
    end = max(edit.span.end for edit in edits)
    lines = whole_lines(text, Span(start, end))
    changed = edited(text, edits)
    stop = len(changed) - (len(text) - lines.end)
    after = changed[lines.start : stop]
    if not after.strip():
        changed = changed[: lines.start] + changed[stop:]
    return Mutant(
        file=file,
        pou=pou,
        operator=operator,
        line=text.count("\n", 0, start) + 1,
        before=_plain(text[lines.start : lines.end]),
        after=_plain(after),
        text=changed,
        body=body,
    )


def _plain(text: str) -> str:
    """Return the text with each run of white space replaced by a single space."""
    return "\n".join(" ".join(line.split()) for line in text.splitlines() if line.strip())
