"""A program whose statements were translated from a drawing, as readers of diagrams make it."""

from __future__ import annotations

from pathlib import Path

from structured_text.language.source import Extract, Line
from structured_text.projects.sources import SourceFiles

__all__ = ["drawing", "drawing_files"]

#: The file. Rung 1 has the elements of lines 3 and 4. Rung 2 has two coils and a counter, and its
#: statements all have line 6. Rung 3 executes the element of line 9 before that of line 8.
_FILE = """\
<program name="Main">
  <rung number="1">
    <contact name="Start"/> <contact name="Stop" negated="true"/>
    <coil name="Lamp"/>
  </rung>
  <rung number="2"> <contact name="Lamp"/> <coil name="Motor"/> <block name="Count"/> </rung>
  <rung number="3">
    <coil name="Last"/>
    <coil name="First"/>
  </rung>
</program>
"""

_LINES = (
    Line("PROGRAM Main", 1),
    Line("  VAR Start, Stop, Lamp, Motor, First, Last : BOOL; Count : INT; END_VAR", 1),
    Line("(* rung 1 *)", 2, network="rung 1"),
    Line("Lamp := (Start OR Lamp) AND NOT Stop;", 4, network="rung 1"),
    Line("(* rung 2 *)", 6, network="rung 2"),
    Line("Motor := Lamp;", 6, network="rung 2"),
    Line("IF Motor THEN", 6, network="rung 2"),
    Line("  Count := Count + 1;", 6, network="rung 2"),
    Line("END_IF;", 6, network="rung 2"),
    Line("IF Stop THEN", 6, network="rung 2"),
    Line("  Count := 0;", 6, network="rung 2"),
    Line("ELSIF Count > 100 THEN", 6, network="rung 2"),
    Line("  Count := 100;", 6, network="rung 2"),
    Line("END_IF;", 6, network="rung 2"),
    Line("First := Count > 1;", 9, network="rung 3"),
    Line("Last := First;", 8, network="rung 3"),
    Line("END_PROGRAM", 11),
)


def drawing(folder: Path, **changed: str) -> Extract:
    """Write the file, and return the source; `changed` has other texts for `rung_1` and so on.

    Such a text replaces the last statement of the rung.
    """
    file = folder / "main.xml"
    file.write_text(_FILE, encoding="utf-8")
    lines = list(_LINES)
    for rung, text in changed.items():
        name = rung.replace("_", " ")
        index = max(k for k, line in enumerate(lines) if line.network == name)
        lines[index] = Line(text, lines[index].at, network=name)
    return Extract.make(file, tuple(lines), "Main")


def drawing_files(folder: Path) -> SourceFiles:
    """Return the source as the files of a program."""
    return SourceFiles((drawing(folder),), (), None)
