"""Assertions in comments, `(* prove: NOT (Gripper AND Conveyor) *)`, made statements.

A statement that stands for one stops the program where the assertion does not hold: on an engine
with an error in that line, in a proof as something that must not happen.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Extract, origin, source_text

__all__ = ["STOPS", "VARIABLE", "Assertion", "Copies", "with_assertions"]

#: What a broken assertion is to a machine: no program shifts by a literal below 0 otherwise.
STOPS = "shift"
_COMMENT = re.compile(
    r"\(\*\s*prove\s*:(?P<block>.*?)\*\)|//\s*prove\s*:(?P<line>[^\n]*)", re.S | re.I
)
_HEAD = re.compile(
    r"^[ \t]*(?:(?:PROGRAM|FUNCTION_BLOCK)[ \t]+\w+|FUNCTION[ \t]+\w+[ \t]*:[ \t]*\w+)", re.M | re.I
)
VARIABLE = "HarnessProveHere"


@dataclass(frozen=True)
class Assertion:
    """One assertion: its file and line, and what it says."""

    file: str
    line: int
    text: str


@dataclass(frozen=True)
class Copies:
    """Copies of a program's files, with statements for its assertions.

    Attributes:
        files: The copies; lines are where they were.
        assertions: What is asserted.
        originals: The file that each copy is of.
    """

    files: tuple[Path, ...]
    assertions: tuple[Assertion, ...]
    originals: dict[str, str]

    def original(self, file: str | None) -> str:
        """The user's file; a file of the library is itself."""
        return self.originals.get(file or "", file or "")


def with_assertions(files: Sequence[Path], folder: Path) -> Copies:
    """Copy a program's files into a folder, with statements for its assertions.

    Raises:
        InputError: an assertion that is empty or outside of a program, block or function.
    """
    copies: list[Path] = []
    found: list[Assertion] = []
    for number, file in enumerate(files):
        text, assertions = _with_statements(file)
        copy = folder / str(number) / file.name
        copy.parent.mkdir(parents=True)
        copy.write_text(text, encoding="utf-8")
        lines = getattr(file, "lines", None)
        if lines is not None:  # taken out of a project: each line is where it was there
            changed = zip(lines, text.splitlines(), strict=True)
            copy = Extract.make(copy, tuple(replace(old, text=new) for old, new in changed))
        copies.append(copy)
        found += [Assertion(str(copy), origin(file, line, 1)[0], said) for line, said in assertions]
    originals = {str(copy): str(file) for copy, file in zip(copies, files, strict=True)}
    return Copies(tuple(copies), tuple(found), originals)


def _with_statements(file: Path) -> tuple[str, list[tuple[int, str]]]:
    text = source_text(file)
    assertions = []
    heads: set[int] = set()
    pieces: list[str] = []
    end = 0
    for one in _COMMENT.finditer(text):
        line = text.count("\n", 0, one.start()) + 1
        said = (one["block"] if one["block"] is not None else one["line"]).strip().rstrip(";")
        if not said:
            raise InputError("the assertion is empty", file=file, line=line, hint="(* prove: X *)")
        head = max((head.end() for head in _HEAD.finditer(text, 0, one.start())), default=0)
        if not head:
            hint = "write it between two statements of a body"
            raise InputError("this assertion stands in no body", file=file, line=line, hint=hint)
        heads.add(head)
        pieces.append(text[end : one.start()])
        statement = f"IF NOT ({said}) THEN {VARIABLE} := SHL({VARIABLE}, -1); END_IF;"
        # All in the line where the comment begins: that is where an engine stops.
        pieces.append(" ".join(statement.split()) + "\n" * one[0].count("\n"))
        assertions.append((line, " ".join(said.split())))
        end = one.end()
    body = "".join(pieces) + text[end:]
    return _declared(body, heads), assertions


def _declared(text: str, heads: set[int]) -> str:
    """The variable in each POU with assertions; heads are counted before any statement."""
    number = len(heads)
    if not number:
        return text
    found = [head.end() for head in _HEAD.finditer(text)]
    marked = re.compile(rf"\b{VARIABLE}\b")
    for begin, end in reversed(list(zip(found, [*found[1:], len(text)], strict=True))):
        if marked.search(text, begin, end):
            text = f"{text[:begin]} VAR {VARIABLE} : WORD; END_VAR{text[begin:]}"
    return text
