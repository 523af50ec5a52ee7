"""Assertions in comments, `(* prove: NOT (Gripper AND Conveyor) *)`, translated into statements.

Each assertion becomes a statement in its line. If the assertion does not hold, the statement shifts
by a negative literal. An engine stops there with an error; a proof has an obligation for this line.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Extract, origin, source_text

__all__ = ["STOPS", "VARIABLE", "Assertion", "Copies", "with_assertions"]

#: The kind of the obligation for a broken assertion. A shift by a variable has the same kind, so
#: file and line distinguish them.
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
    """An assertion: its file, its line and its text."""

    file: str
    line: int
    text: str


@dataclass(frozen=True)
class Copies:
    """Copies of a program's files in which each assertion has become a statement.

    Attributes:
        files: The copies; each line has the same number as in the original.
        assertions: The assertions found.
        originals: The original file of each copy.
    """

    files: tuple[Path, ...]
    assertions: tuple[Assertion, ...]
    originals: dict[str, str]

    def original(self, file: str | None) -> str:
        """Return the user's file for a copy; a file of the library is returned as it is."""
        return self.originals.get(file or "", file or "")


def with_assertions(files: Sequence[Path], folder: Path) -> Copies:
    """Copy a program's files into a folder, with a statement for each assertion.

    Raise InputError if an assertion is empty, or outside a program, block or function.
    """
    copies: list[Path] = []
    found: list[Assertion] = []
    for number, file in enumerate(files):
        text, assertions = _with_statements(file)
        lines = getattr(file, "lines", None)
        # The text of an extract is Structured Text even if its file has another format, so its copy
        # ends in `.st`.
        copy = folder / str(number) / (file.name if lines is None else f"{file.name}.st")
        copy.parent.mkdir(parents=True)
        copy.write_text(text, encoding="utf-8")
        if lines is not None:  # each line keeps its number in the project file
            changed = zip(lines, text.splitlines(), strict=True)
            texts = tuple(replace(old, text=new) for old, new in changed)
            unread = getattr(file, "unread", ())
            copy = Extract.make(copy, texts, getattr(file, "title", ""), unread=unread)
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
            raise InputError(
                "this assertion is outside the body of a program or block",
                file=file,
                line=line,
                hint=hint,
            )
        heads.add(head)
        pieces.append(text[end : one.start()])
        statement = f"IF NOT ({said}) THEN {VARIABLE} := SHL({VARIABLE}, -1); END_IF;"
        # The statement is on the line where the comment begins, because an engine reports that
        # line.
        pieces.append(" ".join(statement.split()) + "\n" * one[0].count("\n"))
        assertions.append((line, " ".join(said.split())))
        end = one.end()
    body = "".join(pieces) + text[end:]
    return _declared(body, heads), assertions


def _declared(text: str, heads: set[int]) -> str:
    """Declare the helper variable `VARIABLE` in each POU that has assertions, and return the text.

    `heads` has the offsets of these POUs before any statement was inserted; it is empty without
    assertions.
    """
    number = len(heads)
    if not number:
        return text
    found = [head.end() for head in _HEAD.finditer(text)]
    marked = re.compile(rf"\b{VARIABLE}\b")
    for begin, end in reversed(list(zip(found, [*found[1:], len(text)], strict=True))):
        if marked.search(text, begin, end):
            text = f"{text[:begin]} VAR {VARIABLE} : WORD; END_VAR{text[begin:]}"
    return text
