"""In projects of TwinCAT, positions are those of the files, and edits are made in them."""

from __future__ import annotations

from pathlib import Path

import pytest
from lsprotocol import types as lsp

from cursor import edited
from structured_text.editor.features.completion import completion
from structured_text.editor.features.definition import definition
from structured_text.editor.features.hover import hover
from structured_text.editor.features.references import references
from structured_text.editor.features.rename import rename
from structured_text.editor.index import Index, build
from structured_text.errors import InputError
from structured_text.language.load import read_file
from structured_text.projects.open import project_sources

_MAIN = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="Main" Id="{1}">
    <Declaration><![CDATA[PROGRAM Main
VAR
  P : Pump; // a pump
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[P(Speed := Level);
P.Start(Fast := TRUE);
Go();
]]></ST>
    </Implementation>
    <Action Name="Go" Id="{2}">
      <Implementation>
        <ST><![CDATA[P.Speed := 2;]]></ST>
      </Implementation>
    </Action>
  </POU>
</TcPlcObject>
"""
_PUMP = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="Pump" Id="{3}">
    <Declaration><![CDATA[FUNCTION_BLOCK Pump
VAR_INPUT
  Speed : INT; (* [1/min] *)
END_VAR]]></Declaration>
    <Implementation>
      <ST><![CDATA[]]></ST>
    </Implementation>
    <Method Name="Start" Id="{4}">
      <Declaration><![CDATA[METHOD Start
VAR_INPUT Fast : BOOL; END_VAR]]></Declaration>
      <Implementation>
        <ST><![CDATA[Speed := 1;]]></ST>
      </Implementation>
    </Method>
    <LineIds Name="Pump.Start">
      <LineId Id="1" Count="0" />
    </LineIds>
  </POU>
</TcPlcObject>
"""
_GVL = """<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <GVL Name="Globals" Id="{5}">
    <Declaration><![CDATA[VAR_GLOBAL
  Level : INT;
END_VAR]]></Declaration>
  </GVL>
</TcPlcObject>
"""


@pytest.fixture
def project(tmp_path: Path) -> Index:
    """Return the index of a project of three files."""
    texts = {"Main.TcPOU": _MAIN, "Pump.TcPOU": _PUMP, "Globals.TcGVL": _GVL}
    for name, text in texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    paths = project_sources([tmp_path / name for name in texts], {}).paths
    return build(paths, read_file)


def _at(index: Index, name: str, word: str) -> tuple[Index, str, str, lsp.Position]:
    """Return the arguments of a feature for the first place of a word in a file."""
    file = next(one for one in index.files if Path(one).name == name)
    text = index.text(file).text
    before = text[: text.index(word)]
    line = before.rpartition("\n")[2]
    return index, file, text, lsp.Position(before.count("\n"), len(line))


def _place(found: lsp.Location | None) -> tuple[str, int, int] | None:
    if found is None:
        return None
    return found.uri.rpartition("/")[2], found.range.start.line, found.range.start.character


@pytest.mark.parametrize(
    ("word", "place"),
    [
        ("Speed := Level", ("Pump.TcPOU", 5, 2)),
        ("Level", ("Globals.TcGVL", 4, 2)),
        ("Start(", ("Pump.TcPOU", 11, 35)),
        ("Go()", ("Main.TcPOU", 14, 18)),
        ("P(", ("Main.TcPOU", 5, 2)),
    ],
)
def test_a_definition_is_at_its_place_in_the_file(
    project: Index, word: str, place: tuple[str, int, int]
) -> None:
    """Lines and columns are counted in the XML; an action has its name in its start tag."""
    assert project.errors == []
    assert _place(definition(*_at(project, "Main.TcPOU", word))) == place


def test_references_cross_the_files(project: Index) -> None:
    """The pin is used in the call, in the action, and in the method of the block."""
    found = references(*_at(project, "Pump.TcPOU", "Speed : INT"))
    assert [_place(one) for one in found or []] == [
        ("Main.TcPOU", 9, 21),
        ("Main.TcPOU", 16, 23),
        ("Pump.TcPOU", 5, 2),
        ("Pump.TcPOU", 14, 21),
    ]


def test_hover_finds_the_comment_in_the_file(project: Index) -> None:
    """The comment stands behind the pin in the block's file."""
    found = hover(*_at(project, "Main.TcPOU", "Speed := Level"))
    assert found is not None
    assert isinstance(found.contents, lsp.MarkupContent)
    assert found.contents.value == "```iecst\nVAR_INPUT\nSpeed : INT\n```\n\n[1/min]"


def test_a_pin_is_renamed_inside_of_the_files(project: Index) -> None:
    """Only the name changes; the XML around it remains."""
    edit = rename(*_at(project, "Pump.TcPOU", "Speed : INT"), "Pace")
    for file, text in zip(project.files, (_MAIN, _PUMP, _GVL), strict=True):
        assert edited(project, edit, file) == text.replace("Speed", "Pace")


@pytest.mark.parametrize(
    ("word", "old", "name"), [("Start(", "Start", "Begin"), ("Go()", "Go", "Run")]
)
def test_a_method_and_an_action_are_renamed_in_the_xml_too(
    project: Index, word: str, old: str, name: str
) -> None:
    """The start tag and the numbers of the lines have the name as well."""
    edit = rename(*_at(project, "Main.TcPOU", word), name)
    for file, text in zip(project.files, (_MAIN, _PUMP, _GVL), strict=True):
        assert edited(project, edit, file) == text.replace(old, name)


def test_a_pou_is_not_renamed_because_its_file_has_its_name(project: Index) -> None:
    """The project file mentions the file."""
    with pytest.raises(InputError, match="the file of Pump has the same name"):
        rename(*_at(project, "Main.TcPOU", "Pump"), "Other")


@pytest.mark.parametrize(
    ("typed", "labels"),
    [
        (_MAIN.replace("P.Start(Fast := TRUE);", "P.|"), ["Speed", "Start"]),
        (_MAIN.replace("P.Speed := 2;", "P(|"), ["Speed"]),
        (_MAIN.replace("<Action", "<|Action"), []),
    ],
)
def test_completion_works_in_the_text_of_a_file(
    project: Index, typed: str, labels: list[str]
) -> None:
    """The text is in a CDATA section; nothing fits best in the XML itself."""
    _, file, text, position = _at_mark(project, typed)
    found = completion(project, file, text, position) or []
    assert sorted(one.label for one in found if (one.sort_text or "")[0] == "0") == labels


def _at_mark(index: Index, typed: str) -> tuple[Index, str, str, lsp.Position]:
    before, _, behind = typed.partition("|")
    file = next(one for one in index.files if Path(one).name == "Main.TcPOU")
    line = before.rpartition("\n")[2]
    return index, file, before + behind, lsp.Position(before.count("\n"), len(line))
