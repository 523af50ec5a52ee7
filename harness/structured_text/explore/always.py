"""Expressions that must hold after every scan, as assertions at the end of a program."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import source_text
from structured_text.prove.assertions import Copies, with_assertions

__all__ = ["with_always"]

_END = re.compile(r"^[ \t]*END_PROGRAM\b", re.M | re.I)
_MAIN = re.compile(r"\bMain\.", re.I)


def with_always(files: Sequence[Path], always: Sequence[str], folder: Path) -> Copies:
    """Copy a program's files into `folder`, with assertions at the end of the program.

    The assertions are the expressions in comments of the files, and the expressions in `always`. In
    `always`, `Main.` may be omitted.

    Raises:
        InputError: An expression is invalid, or the files do not declare exactly one program.
    """
    if not always:
        return with_assertions(files, folder)
    ends = {file: _END.findall(source_text(file)) for file in files}
    programs = [file for file, found in ends.items() if found]
    if len(programs) != 1 or len(ends[programs[0]]) != 1:
        told = f"there are {sum(map(len, ends.values()))} programs to check {always[0]!r} in"
        raise InputError(told, hint="give one PROGRAM in a file of Structured Text")
    for text in always:
        if "*)" in text or not text.strip():
            raise InputError(
                f"{text!r} is not an expression", hint='write --always "NOT (A AND B)"'
            )
    comments = "".join(f" (* prove: {_MAIN.sub('', text)} *)" for text in always)
    copy = folder / "always" / programs[0].name
    copy.parent.mkdir()
    text = _END.sub(lambda end: f"{comments} {end[0].lstrip()}", source_text(programs[0]))
    copy.write_text(text, encoding="utf-8")
    made = with_assertions([copy if one == programs[0] else one for one in files], folder)
    originals = {
        name: str(programs[0]) if file == str(copy) else file
        for name, file in made.originals.items()
    }
    return Copies(made.files, made.assertions, originals)
