"""The language server answers requests about names, in files and in a TwinCAT project."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from lsp_client import LspClient, LspError
from structured_text.editor.extras import Plain
from structured_text.editor.server import Server

MAIN = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="MAIN" Id="{00000000-0000-0000-0000-000000000001}">
    <Declaration><![CDATA[PROGRAM MAIN
VAR
    Front : FB_Drive; (* the drive in front *)
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[Front(Speed := 3);
Front.Stop();
]]></ST>
    </Implementation>
  </POU>
</TcPlcObject>
"""
DRIVE = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="FB_Drive" Id="{00000000-0000-0000-0000-000000000002}">
    <Declaration><![CDATA[FUNCTION_BLOCK FB_Drive
VAR_INPUT
    Speed : INT; (* in mm/s *)
END_VAR
VAR_OUTPUT
    Busy : BOOL;
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[Busy := Speed > 0;
]]></ST>
    </Implementation>
    <Method Name="Stop" Id="{00000000-0000-0000-0000-000000000003}">
      <Declaration><![CDATA[METHOD Stop : BOOL
]]></Declaration>
      <Implementation>
        <ST><![CDATA[Speed := 0;
Stop := TRUE;
]]></ST>
      </Implementation>
    </Method>
  </POU>
</TcPlcObject>
"""
PROJECT = """\
<Project xmlns="http://schemas.microsoft.com/developer/msbuild/2003">
  <PropertyGroup><Name>Line</Name></PropertyGroup>
  <ItemGroup>
    <Compile Include="MAIN.TcPOU" />
    <Compile Include="FB_Drive.TcPOU" />
  </ItemGroup>
</Project>
"""
#: Lines of the files, from 0.
CALL, STOP = 9, 10


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("line")
    files = {"MAIN.TcPOU": MAIN, "FB_Drive.TcPOU": DRIVE, "Line.plcproj": PROJECT}
    for name, text in files.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[LspClient]:
    client = LspClient(Server(Plain()), folder)
    client.open(folder / "MAIN.TcPOU")
    yield client
    client.close()


def _column(line: int, word: str) -> int:
    return MAIN.split("\n")[line].index(word)


def test_hover_shows_declaration_and_comment(client: LspClient, folder: Path) -> None:
    found = client.ask("hover", folder / "MAIN.TcPOU", CALL, _column(CALL, "Speed"))
    text = found["contents"]["value"]
    assert "Speed : INT" in text
    assert "in mm/s" in text


def test_definition_leads_to_another_file(client: LspClient, folder: Path) -> None:
    found = client.ask("definition", folder / "MAIN.TcPOU", CALL, _column(CALL, "Speed"))
    assert found["uri"] == (folder / "FB_Drive.TcPOU").as_uri()
    assert found["range"]["start"] == {"line": 5, "character": 4}


def test_references_are_in_all_files(client: LspClient, folder: Path) -> None:
    context = {"includeDeclaration": True}
    main = folder / "MAIN.TcPOU"
    found = client.ask("references", main, CALL, _column(CALL, "Speed"), context=context)
    places = [(Path(one["uri"]).name, one["range"]["start"]["line"]) for one in found]
    drive = "FB_Drive.TcPOU"
    assert sorted(places) == [(drive, 5), (drive, 12), (drive, 19), ("MAIN.TcPOU", CALL)]


def test_completion_knows_pins_and_methods(client: LspClient, folder: Path) -> None:
    found = client.ask("completion", folder / "MAIN.TcPOU", STOP, len("Front."))
    assert {"Busy", "Speed", "Stop"} <= {one["label"] for one in found}


def test_signature_help_shows_the_pins(client: LspClient, folder: Path) -> None:
    found = client.ask("signatureHelp", folder / "MAIN.TcPOU", CALL, _column(CALL, "Speed"))
    assert "Speed : INT" in found["signatures"][0]["label"]


def test_outline_has_the_methods(client: LspClient, folder: Path) -> None:
    drive = folder / "FB_Drive.TcPOU"
    client.open(drive)
    (block,) = client.ask("documentSymbol", drive)
    assert block["name"] == "FB_Drive"
    assert "Stop" in [one["name"] for one in block["children"]]


def test_folding_has_the_variables(client: LspClient, folder: Path) -> None:
    found = client.ask("foldingRange", folder / "MAIN.TcPOU")
    assert 4 in [one["startLine"] for one in found]


def test_colours_name_their_legend(client: LspClient, folder: Path) -> None:
    legend = client.capabilities["semanticTokensProvider"]["legend"]["tokenTypes"]
    data = client.ask("semanticTokens/full", folder / "MAIN.TcPOU")["data"]
    kinds = {legend[data[number]] for number in range(3, len(data), 5)}
    assert {"class", "variable", "method", "keyword", "comment", "number"} <= kinds


def test_hints_name_omitted_inputs(client: LspClient, folder: Path) -> None:
    main = folder / "MAIN.TcPOU"
    client.change(main, MAIN.replace("Front(Speed := 3)", "Front()"))
    lines = {"start": {"line": 0, "character": 0}, "end": {"line": 15, "character": 0}}
    (found,) = client.ask("inlayHint", main, range=lines)
    assert found["position"] == {"line": CALL, "character": _column(CALL, "(") + 1}
    assert "Speed" in str(found["label"])
    client.change(main, MAIN)


def _edits(found: dict[str, Any]) -> list[tuple[str, int, str]]:
    return sorted(
        (Path(uri).name, edit["range"]["start"]["line"], edit["newText"])
        for uri, edits in found["changes"].items()
        for edit in edits
    )


def test_rename_changes_all_files(client: LspClient, folder: Path) -> None:
    main = folder / "MAIN.TcPOU"
    found = client.ask("rename", main, CALL, _column(CALL, "Speed"), newName="Pace")
    drive = "FB_Drive.TcPOU"
    lines = [(drive, 5), (drive, 12), (drive, 19), ("MAIN.TcPOU", CALL)]
    assert _edits(found) == [(file, line, "Pace") for file, line in lines]


def test_a_refused_rename_says_why(client: LspClient, folder: Path) -> None:
    column = _column(CALL, "Speed")
    with pytest.raises(LspError, match="Busy"):
        client.ask("rename", folder / "MAIN.TcPOU", CALL, column, newName="Busy")


def test_answers_follow_a_change_at_once(client: LspClient, folder: Path) -> None:
    main = folder / "MAIN.TcPOU"
    client.change(main, MAIN.replace("Front", "First"))
    found = client.ask("hover", main, CALL, _column(CALL, "Front"))
    assert "First : FB_Drive" in found["contents"]["value"]
    client.change(main, MAIN)
