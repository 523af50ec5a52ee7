"""A project as files of Structured Text, for users who continue without the PLC tool."""

from __future__ import annotations

import re
from dataclasses import replace

from structured_text.errors import InputError
from structured_text.projects.model import Foreign, Piece, Project, Unit, made

__all__ = ["st_texts"]

_NAME = re.compile(r"\w{1,200}")


def st_texts(project: Project) -> dict[str, str]:
    """Return the text of each declaration, by the name of its file.

    A body in another language becomes a comment that names the language. Raise InputError if two
    declarations have the same name, or a name cannot be a file name.
    """
    texts: dict[str, str] = {}
    units: dict[str, Unit] = {}
    for unit in project.units:
        name = unit.name or "Globals"
        at = unit.piece.head[0].at if unit.piece.head else 1
        if not _NAME.fullmatch(name):
            raise InputError(f"{name!r} is not a name for a file", file=unit.file, line=at)
        other = units.setdefault(name.upper(), unit)
        if other is not unit and unit.kind == "VAR_GLOBAL" and other.kind != unit.kind:
            name = f"{name}_Globals"
            other = units.setdefault(name.upper(), unit)
        if other is not unit:
            line = other.piece.head[0].at if other.piece.head else 1
            raise InputError(
                f"{name} is declared twice",
                file=unit.file,
                line=at,
                hint=f"remove this one or the one in {other.file}, line {line}",
            )
        lines = _commented(unit.piece).lines()
        text = "".join(f"{line.text.rstrip()}\n" for line in lines)
        texts[f"{name}.st"] = re.sub(r"\n{3,}", "\n\n", text)
    return texts


def _commented(piece: Piece) -> Piece:
    body = piece.body
    if isinstance(body, Foreign):
        said = f"(* The body {body.says}: write it here in Structured Text. *)"
        body = made(body.at, said)
    return replace(piece, body=body, parts=tuple(_commented(part) for part in piece.parts))
