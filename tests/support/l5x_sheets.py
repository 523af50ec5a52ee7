"""Small L5X projects with function block diagrams, for tests."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from l5x_ladder import program, read
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign, Piece

__all__ = ["main", "running", "shown", "why", "written"]

_L5X = """<RSLogix5000Content><Controller Name="C">
<AddOnInstructionDefinitions>{aois}</AddOnInstructionDefinitions>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>{tags}</Tags>
<Routines><Routine Name="Main" Type="FBD"><FBDContent>{sheets}</FBDContent></Routine>
{routines}</Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""
_TAGS = {
    **dict.fromkeys("abcd", "BOOL"),
    **dict.fromkeys("ijk", "DINT"),
    **dict.fromkeys("xyz", "REAL"),
}


def _tag(name: str, kind: str) -> str:
    """Return a tag; `TYPE[3]` is an array, `TYPE(PRE=3)` has values in its data."""
    plain, _, values = kind.rstrip(")").partition("(")
    plain, _, size = plain.rstrip("]").partition("[")
    sizes = f' Dimensions="{size}"' if size else ""
    data = ""
    for value in values.split():
        member, _, number = value.partition("=")
        real = "REAL" if "." in number else "DINT"
        data += f'<DataValueMember Name="{member}" DataType="{real}" Value="{number}"/>'
    if data:
        data = f'<Structure DataType="{plain}">{data}</Structure>'
        data = f'<Data Format="Decorated">{data}</Data>'
    return f'<Tag Name="{name}" TagType="Base" DataType="{plain}"{sizes}>{data}</Tag>\n'


def _element(number: int, text: str) -> str:
    """Return an element: `IRef a`, `Block BAND b`, `Function ADD`, `OCon name`, `JSR Sub`.

    What follows `|` is written into the element.
    """
    plain, _, inner = text.partition("|")
    kind, *names = plain.split()
    first = {"IRef": "Operand", "ORef": "Operand", "Block": "Type", "Function": "Type"}
    first["JSR"] = "Routine"
    given = {first.get(kind, "Name"): names[0] if names else ""}
    if kind == "Function":
        given["Type"] += "__F"
    if len(names) > 1:
        given["Operand"] = names[1]
    texts = "".join(f' {key}="{value}"' for key, value in given.items())
    return f'<{kind} ID="{number}" X="{number}" Y="0"{texts}>{inner}</{kind}>\n'


def _wire(text: str) -> str:
    """Return a wire: `0 > 2.In1` or `2.Out > 3`; `>>` is marked Assume Data Available."""
    name, mark = ("FeedbackWire", ">>") if ">>" in text else ("Wire", ">")
    left, right = (part.strip() for part in text.split(mark))
    source, _, output = left.partition(".")
    target, _, pin = right.partition(".")
    shown = f' FromParam="{output}"' if output else ""
    shown += f' ToParam="{pin}"' if pin else ""
    return f'<{name} FromID="{source}" ToID="{target}"{shown}/>\n'


def written(
    folder: Path,
    *sheets: str,
    tags: Mapping[str, str] | None = None,
    routines: str = "",
    aois: str = "",
) -> Path:
    """Write a project whose main routine has the sheets, and return its file.

    A sheet has one element or wire in each line or behind a semicolon. The elements of all sheets
    are numbered from 0.
    """
    number, texts = 0, []
    for place, sheet in enumerate(sheets, 1):
        text = f'<Sheet Number="{place}">\n'
        for line in filter(None, map(str.strip, sheet.replace(";", "\n").splitlines())):
            if line[0].isdigit():
                text += _wire(line)
            elif line[0] == "<":
                text += line
            else:
                text += _element(number, line)
                number += 1
        texts.append(f"{text}</Sheet>\n")
    all_tags = {**_TAGS, **(tags or {})}
    file = folder / "cell.L5X"
    shown = "".join(_tag(name, kind) for name, kind in all_tags.items())
    content = _L5X.format(aois=aois, tags=shown, sheets="".join(texts), routines=routines)
    file.write_text(content, encoding="utf-8")
    return file


def running(
    folder: Path,
    *sheets: str,
    tags: Mapping[str, str] | None = None,
    routines: str = "",
    aois: str = "",
) -> BuiltinProgram:
    """Return the program of a project with the sheets; its instance is `Main`."""
    return program(written(folder, *sheets, tags=tags, routines=routines, aois=aois))


def main(file: Path) -> Piece:
    """Return the program of a project."""
    return next(unit.piece for unit in read(file).units if unit.kind == "PROGRAM")


def why(file: Path) -> str:
    """Return why the main routine is not read."""
    body = main(file).body
    assert isinstance(body, Foreign)
    return body.why


def shown(file: Path) -> Sequence[str]:
    """Return the statements of the main routine."""
    body = main(file).body
    assert not isinstance(body, Foreign)
    return [line.text.strip() for line in body]
