"""A change that adds the missing call of FB_ReadArea or FB_WriteArea to a program."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types

from structured_text.language import syntax as s
from structured_text.language.parser import read_text

__all__ = ["area_edits", "missing_areas"]

#: The calls that a warning on a first mistake proposes.
_PROPOSED = re.compile(r"\b(FB_ReadArea|FB_WriteArea)\(Robot := ([\w.]+(?:\[[\w, ]+\])?)")
_END = re.compile(r"\s*END_(?:PROGRAM|FUNCTION_BLOCK)\b", re.IGNORECASE)
_OWNERS = ("PROGRAM", "FUNCTION_BLOCK")


@dataclass(frozen=True)
class _Area:
    """A kind of area block, and the variables that its call needs.

    Attributes:
        place: The pin with the first byte of the area, and its value.
        wired: Further pins, each with the name, the type and the comment of a variable.
    """

    block: str
    instance: str
    image: str
    image_comment: str
    place: str
    wired: tuple[tuple[str, str, str], ...]


_AREAS = {
    "FB_ReadArea": _Area(
        "FB_ReadArea",
        "ReadArea",
        "InputArea",
        "robot to PLC, filled by your scanner",
        "m := 0, Size := 48",
        (("Connected", "Connected", "your scanner's status"),),
    ),
    "FB_WriteArea": _Area(
        "FB_WriteArea",
        "WriteArea",
        "OutputArea",
        "PLC to robot, sent by your scanner",
        "n := 0, Size := 48",
        (
            ("EmergencyStopOk", "CellSafe", "status of your safety circuit: must be wired"),
            ("StopOk", "CellSafe", "status of your safety circuit: must be wired"),
        ),
    ),
}


def missing_areas(message: str) -> dict[str, str]:
    """Return the blocks that a warning proposes to call, each with its robot."""
    return {block: robot for block, robot in _PROPOSED.findall(message) if block in _AREAS}


def area_edits(path: Path, text: str, line: int, message: str) -> list[types.TextEdit]:
    """Return the edits that add the calls which a warning proposes.

    `line` is the line of the warning, from 1. The result is empty if the warning proposes none, or
    if the place of the calls is not clear.
    """
    wanted = missing_areas(message)
    if not wanted or path.suffix.lower() != ".st":
        return []
    lines = text.split("\n")
    owners = [
        one
        for one in read_text(text, path).declarations
        if isinstance(one, s.Pou) and one.kind in _OWNERS and one.at.line <= line
    ]
    if not owners or not owners[-1].body:
        return []
    owner = owners[-1]
    section = next((one for one in owner.sections if one.kind == "VAR" and not one.qualifier), None)
    end = next((k for k in range(line - 1, len(lines)) if _END.match(lines[k])), None)
    if section is None or not section.variables or end is None:
        return []
    return list(_Edits(owner, section, lines, end).all(wanted))


class _Edits:
    """The edits in one program or block; `end` is its last line, from 0."""

    def __init__(self, owner: s.Pou, section: s.Section, lines: list[str], end: int) -> None:
        self._owner, self._section, self._lines, self._end = owner, section, lines, end
        self._known = {
            name.key: variable
            for one in owner.sections
            for variable in one.variables
            for name in variable.names
        }
        self._new: dict[str, str] = {}

    def all(self, wanted: dict[str, str]) -> Iterator[types.TextEdit]:
        """Yield the edits for the blocks, each with its robot."""
        first = self._owner.body[0].at.line - 1
        indent = _indent(self._lines[first])
        for block, robot in wanted.items():
            call = f"{indent}{self._call(_AREAS[block], robot)}\n"
            line = first if block == "FB_ReadArea" else self._end
            yield _inserted(line, call)
        if self._new:
            variable = self._section.variables[-1]
            behind = _indent(self._lines[variable.at.line - 1])
            declared = "".join(f"{behind}{one}\n" for one in self._new.values())
            yield _inserted(self._end_of(self._section) - 1, declared)

    def _call(self, area: _Area, robot: str) -> str:
        instance = self._declared(area.block) or self._variable(area.instance, area.block, "")
        image = self._variable(area.image, "RCX_IMAGE", area.image_comment)
        wired = "".join(
            f", {pin} := {self._variable(name, 'BOOL', comment)}"
            for pin, name, comment in area.wired
        )
        return f"{instance}(Robot := {robot}, Image := {image}, {area.place}{wired});"

    def _declared(self, block: str) -> str:
        """Return a declared instance of a block, or an empty text."""
        for name, variable in self._known.items():
            spec = variable.spec
            if isinstance(spec, s.NamedSpec) and spec.name.key == block.upper():
                return next(one.text for one in variable.names if one.key == name)
        return ""

    def _variable(self, name: str, kind: str, comment: str) -> str:
        """Return the name of a variable of this type; declare it if there is none."""
        number, wanted = 1, name
        while (known := self._known.get(wanted.upper())) is not None:
            if isinstance(known.spec, s.NamedSpec) and known.spec.name.key == kind:
                return wanted
            number += 1
            wanted = f"{name}{number}"
        if wanted not in self._new:
            remark = f"  (* {comment} *)" if comment else ""
            self._new[wanted] = f"{wanted} : {kind};{remark}"
        return wanted

    def _end_of(self, section: s.Section) -> int:
        """Return the line of the END_VAR of a section, from 1."""
        line = section.variables[-1].at.line
        while "END_VAR" not in self._lines[line - 1].upper():
            line += 1
        return line


def _inserted(line: int, text: str) -> types.TextEdit:
    place = types.Position(line, 0)
    return types.TextEdit(types.Range(place, place), text)


def _indent(line: str) -> str:
    return line[: len(line) - len(line.lstrip())]
