"""Comparison of the sources with an export to a folder of bodies and variable tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from exported import shape
from structured_text.export.parts import Part, Sources
from structured_text.language import syntax as s
from structured_text.language.parser import parse_text

#: POUs that mask a BYTE. Their texts are compared with texts made by hand.
_MASKED = ("FC_RcxBitMask", "FC_RcxByteWithBit", "FC_RcxByteOfWord")


def declared(part: Part) -> Iterator[tuple[str, str, s.VarDecl, str]]:
    """Return name, section, declaration and one-line comment of each variable or field."""
    node = part.node
    if isinstance(node, s.Pou):
        for section in node.sections:
            constant = " CONSTANT" if section.qualifier == "CONSTANT" else ""
            for one in section.variables:
                for name in one.names:
                    note = " ".join(part.notes.get(name.key, "").split())
                    yield name.text, section.kind + constant, one, note
    else:
        for one in _fields(part):
            for name in one.names:
                yield name.text, "FIELD", one, " ".join(part.notes.get(name.key, "").split())


def _fields(part: Part) -> tuple[s.VarDecl, ...]:
    node = part.node
    if isinstance(node, s.TypeDecl) and isinstance(node.spec, s.StructSpec):
        return node.spec.fields
    return ()


def untyped(text: str) -> str:
    """Return a literal without its type: `16#1` for `WORD#16#1`; times are unchanged."""
    kind, mark, value = text.partition("#")
    return value if mark and kind.isalpha() and kind != "T" else text


def _statements(part: Part, body: str) -> list[Any]:
    text = f"{part.head}\n{body}\nEND_{part.kind}\n"
    (node,) = (one for one in parse_text(text, Path("body")).declarations if isinstance(one, s.Pou))
    return [shape(one) for one in node.body]


def differing(
    sources: Sources,
    files: Mapping[str, str],
    words: Mapping[str, str],
    renamed: Mapping[str, str],
    pins: Mapping[str, str],
) -> list[str]:
    """Return the POUs whose statements differ from the sources', according to the syntax trees.

    Args:
        sources: The library.
        files: Files of a tool without enumerations.
        words: For each type that the tool names differently, the tool's name.
        renamed: For each name that the tool refuses, the new name.
        pins: For each instance of an edge detector, the tool's name of its pin CLK.
    """
    wrong, changed = [], _changes(sources, words, renamed, pins)
    for part in sources.of("FUNCTION", "FUNCTION_BLOCK", "PROGRAM"):
        path = f"{part.folder}/{part.name}"
        if f"{path}.st" not in files or part.name in _MASKED:
            continue
        found = _statements(part, files[f"{path}.st"])
        wanted = [changed(one) for one in _statements(part, part.body)]
        first = len(found) - len(wanted)
        clears = all(one[0] == "Assign" and one[2][0] == "Literal" for one in found[:first])
        if found[first:] != wanted or not clears or (first and part.kind != "FUNCTION"):
            wrong.append(path)
    return wrong


def _changes(
    sources: Sources, words: Mapping[str, str], renamed: Mapping[str, str], pins: Mapping[str, str]
) -> Callable[[Any], Any]:
    """Return a function that maps a node of the sources' syntax to its expected export."""
    numbers = {
        member.text: str(value)
        for one in sources.of("TYPE")
        if isinstance(one.node, s.TypeDecl) and isinstance(one.node.spec, s.EnumSpec)
        for value, member in enumerate(one.node.spec.members)
    }
    parameters = {
        one.name: [
            name.text
            for section in one.node.sections
            if section.kind == "VAR_INPUT"
            for variable in section.variables
            for name in variable.names
        ]
        for one in sources.of("FUNCTION")
        if isinstance(one.node, s.Pou)
    }

    def changed(node: Any) -> Any:
        if isinstance(node, list):
            return [changed(one) for one in node]
        if not isinstance(node, tuple):
            return node
        if node[0] == "Name" and node[1] in numbers:
            return ("Literal", "INTEGER", numbers[node[1]], None)
        if node[0] == "Name":
            return ("Name", renamed.get(node[1], node[1]), None)
        if node[0] == "Literal" and node[1] == "TYPED":
            kind, _, value = node[2].partition("#")
            return ("Literal", "TYPED", f"{words.get(kind, kind)}#{value}", None)
        if node[0] == "CallStatement" and node[1][1] in pins:
            name = ("Name", pins[node[1][1]], None)
            (clock,) = (one for one in node[2] if one[1][1] == "CLK")
            return (*node[:2], [("Argument", name, *map(changed, clock[2:]))], *node[3:])
        if node[0] == "Call":
            return called(node[1][1], node[2])
        return tuple(changed(one) for one in node)

    def called(name: str, arguments: list[Any]) -> Any:
        by_name = {one[1][1]: one for one in arguments if one[1] is not None}
        order = parameters.get(name, list(by_name))
        given = [by_name[one] for one in order] if by_name else arguments
        values = [changed(one[2]) for one in given]
        source, mark, target = name.partition("_TO_")
        if mark:
            kinds = words.get(source, source), words.get(target, target)
            if kinds[0] == kinds[1]:
                return values[0]
            name = "_TO_".join(kinds)
        pieces = [("Argument", None, value, False, None) for value in values]
        return ("Call", ("Name", name, None), pieces, None)

    return changed


#: Declarations of every kind that can have an initial value or a qualifier.
WITH_INITIAL_VALUES = """\
TYPE
  MINE_COLOUR : (RED, GREEN, BLUE) := GREEN;
  MINE_ALIAS  : DINT := 16#7F;
  MINE_FEW    : ARRAY [1..4] OF INT := [1, 2(7), -3];
  MINE_PAIR   : STRUCT
    Low, Top : INT := 3;
    Tint     : MINE_COLOUR;
    Raw      : WORD := WORD#16#00FF;
  END_STRUCT;
  MINE_GRID   : ARRAY [0..1, 1..2] OF MINE_PAIR;
END_TYPE
TYPE
  MINE_SET : STRUCT
    Few  : MINE_FEW;
    Pair : MINE_PAIR := (Low := 9);
    Text : STRING := 'it$'s';
    Wait : TIME := T#1500ms;
    Part : REAL := 0.25;
  END_STRUCT := (Wait := T#2s);
END_TYPE
FUNCTION FC_Mine : DINT
  VAR_INPUT
    x : DINT := 5;
    y : MINE_ALIAS;
  END_VAR
  VAR
    Rows : MINE_FEW;
    c    : MINE_COLOUR;
  END_VAR
  Rows[1] := Rows[1] + 1;
  FC_Mine := x + y + INT_TO_DINT(Rows[1] + Rows[2]);
END_FUNCTION
FUNCTION_BLOCK FB_Mine
  VAR CONSTANT
    Most  : INT := 5;
    Table : MINE_FEW := [10, 20, 30];
  END_VAR
  VAR RETAIN
    Kept  : MINE_PAIR := (Low := 1, Top := 2);
    Count : INT := 4;
  END_VAR
  VAR NON_RETAIN
    Lost  : INT;
  END_VAR
  VAR_TEMP
    Short : MINE_ALIAS;
    Line  : MINE_FEW;
  END_VAR
  VAR_INPUT
    Pace  : INT := 2;
    Setup : MINE_PAIR;
  END_VAR
  VAR_OUTPUT
    Tint  : MINE_COLOUR;
    Shown : MINE_PAIR;
  END_VAR
  VAR_OUTPUT RETAIN
    Total : DINT := 100;
  END_VAR
  VAR
    All   : MINE_SET;
    Grid  : MINE_GRID;
    Alias : MINE_ALIAS;
    Plain : ARRAY [0..3] OF BOOL := [TRUE, 2(FALSE), TRUE];
    Timed : TIME;
  END_VAR
  Total := Total + INT_TO_DINT(Pace + Kept.Low + All.Few[2] + All.Pair.Low + Grid[1, 2].Top);
  Total := Total + INT_TO_DINT(Line[1] + Line[4] + Table[2] + Table[4] + Most) + Alias + Short;
  Total := Total + FC_Mine(x := 1);
  Line[1] := Line[1] + 1;
  Short := Short + 1;
  Count := Count + 1;
  Kept.Low := Kept.Low + 1;
  All.Few[2] := All.Few[2] + 1;
  Timed := All.Wait;
  IF Plain[3] AND Tint = GREEN AND All.Text = 'it$'s' AND All.Part = 0.25 THEN
    Shown.Top := Shown.Top + 1;
  END_IF;
END_FUNCTION_BLOCK
PROGRAM Mine
  VAR
    It    : FB_Mine;
    Sum   : DINT := 1;
  END_VAR
  VAR RETAIN
    Old   : FB_Mine;
    Hours : DINT := 7;
  END_VAR
  It();
  Old(Pace := 3);
  Sum := It.Total + Old.Total + INT_TO_DINT(It.Shown.Low + It.Shown.Top);
END_PROGRAM
"""
