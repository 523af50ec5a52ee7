"""Small L5X projects with ladder routines, for tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import VARIABLES
from structured_text.language.load import load
from structured_text.projects.model import Foreign, Piece, Project
from structured_text.projects.rockwell.read import read_l5x
from structured_text.projects.sources import source_files
from structured_text.projects.xml import read_xml

__all__ = ["TAGS", "main_body", "program", "read", "routine", "written"]

#: Tags of the program; a size in brackets makes an array.
TAGS = {
    **dict.fromkeys("abcdefgh", "BOOL"),
    **dict.fromkeys(("i", "j", "k"), "DINT"),
    **dict.fromkeys(("s", "t"), "SINT"),
    **dict.fromkeys(("v", "w"), "INT"),
    **dict.fromkeys(("x", "y"), "REAL"),
    "l": "LINT",
    "bits": "BOOL[32]",
    "list": "DINT[8]",
    "bytes": "SINT[4]",
}

_L5X = """<RSLogix5000Content><Controller Name="C">
<AddOnInstructionDefinitions>{aois}</AddOnInstructionDefinitions>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>{tags}</Tags>
<Routines>{routines}</Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""


def _tag(name: str, kind: str) -> str:
    plain, _, size = kind.rstrip("]").partition("[")
    dimensions = f' Dimensions="{size}"' if size else ""
    return f'<Tag Name="{name}" TagType="Base" DataType="{plain}"{dimensions}/>\n'


def routine(name: str, rungs: Sequence[str]) -> str:
    """Return the element of a ladder routine; `R|XIC(a);` is a rung of the type R."""
    texts = []
    for number, rung in enumerate(rungs):
        kind, mark, text = rung.partition("|")
        if not mark or len(kind) > len("IR"):
            kind, text = "N", rung
        texts.append(
            f'<Rung Number="{number}" Type="{kind}">\n<Text><![CDATA[{text}]]></Text></Rung>\n'
        )
    content = f"<RLLContent>{''.join(texts)}</RLLContent>"
    return f'<Routine Name="{name}" Type="RLL">{content}</Routine>\n'


def written(
    folder: Path,
    rungs: Sequence[str],
    *,
    tags: Mapping[str, str] | None = None,
    routines: Mapping[str, Sequence[str]] | None = None,
    aois: str = "",
) -> Path:
    """Write a project whose main routine has the rungs, and return its file."""
    all_tags = {**TAGS, **(tags or {})}
    parts = [routine("Main", rungs)]
    parts += [routine(name, some) for name, some in (routines or {}).items()]
    file = folder / "cell.L5X"
    text = _L5X.format(
        aois=aois,
        tags="".join(_tag(name, kind) for name, kind in all_tags.items()),
        routines="".join(parts),
    )
    file.write_text(text, encoding="utf-8")
    return file


def program(file: Path) -> BuiltinProgram:
    """Return the program of a project, for the built-in engine; its instance is `Main`."""
    return BuiltinProgram.build(load(list(source_files([file], None).all)))


def read(file: Path) -> Project:
    """Return the contents of a project."""
    return read_l5x(read_xml(file), file)


def main_body(file: Path) -> list[str] | Foreign:
    """Return the statements of the main routine without comments, or why they are not read."""
    pieces = [unit.piece for unit in read(file).units if unit.kind == "PROGRAM"]
    piece: Piece = pieces[0]
    if isinstance(piece.body, Foreign):
        return piece.body
    lines = [line.text[2:] for line in piece.body if not line.text.strip().startswith("(*")]
    return [line for line in lines if line != f"{VARIABLES}Prescan();"]
