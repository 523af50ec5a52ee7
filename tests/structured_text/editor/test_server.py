"""The language server tells an editor about mistakes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from lsp_client import LspClient, LspError
from structured_text.editor.extras import Plain
from structured_text.editor.server import Server

MAIN = """\
PROGRAM Main
VAR
    Count : INT;
    Part : Counter;
END_VAR
Part(Up := TRUE);
Count := Part.Total;
END_PROGRAM
"""
COUNTER = """\
FUNCTION_BLOCK Counter
VAR_INPUT
    Up : BOOL;
END_VAR
VAR_OUTPUT
    Total : INT;
END_VAR
IF Up THEN
    Total := Total + 1;
END_IF;
END_FUNCTION_BLOCK
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "Main.st").write_text(MAIN, encoding="utf-8")
    (tmp_path / "Counter.st").write_text(COUNTER, encoding="utf-8")
    return tmp_path


@pytest.fixture
def client(folder: Path) -> Iterator[LspClient]:
    client = LspClient(Server(Plain()), folder)
    yield client
    client.close()


def test_a_mistake_has_the_range_of_its_word(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    client.open(main, MAIN.replace("Part.Total", "Part.Sum"))
    (found,) = client.diagnostics(main)
    assert found["message"] == "Counter has no member Sum"
    assert found["range"] == {
        "start": {"line": 6, "character": 14},
        "end": {"line": 6, "character": 17},
    }


def test_a_repaired_mistake_disappears(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    client.open(main, MAIN.replace("Part.Total", "Part.Sum"))
    assert client.diagnostics(main)
    client.change(main, MAIN)
    assert client.diagnostics(main) == []


def test_a_change_of_an_interface_shows_in_a_closed_file(client: LspClient, folder: Path) -> None:
    counter = folder / "Counter.st"
    client.open(counter)
    client.change(counter, COUNTER.replace("Up : BOOL", "Down : BOOL").replace("Up", "Down"))
    (found,) = client.diagnostics(folder / "Main.st")
    assert found["message"] == "Counter has no input Up; use Down"
    assert found["range"]["start"]["line"] == 5


def test_a_closed_document_counts_as_it_is_on_disk(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    client.open(main, MAIN.replace("Part.Total", "Part.Sum"))
    assert client.diagnostics(main)
    client.open(folder / "Counter.st")
    client.notify("textDocument/didClose", textDocument={"uri": main.as_uri()})
    assert client.diagnostics(main) == []


def test_a_file_that_another_program_writes_is_read_again(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    client.open(main, MAIN.replace("Part : Counter", "Part : Timer"))
    assert client.diagnostics(main)
    (folder / "Timer.st").write_text(COUNTER.replace("Counter", "Timer"), encoding="utf-8")
    client.notify("workspace/didChangeWatchedFiles", changes=[])
    assert client.diagnostics(main) == []


def test_columns_count_utf_16_units(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    client.open(main, MAIN.replace("Count := ", "(* \N{ROBOT FACE} *) Count := Wrong + "))
    (found,) = client.diagnostics(main)
    assert found["range"]["start"] == {"line": 6, "character": 18}
    assert found["range"]["end"] == {"line": 6, "character": 23}


def test_each_folder_with_a_program_is_a_program(tmp_path: Path) -> None:
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "Main.st").write_text(MAIN, encoding="utf-8")
        (tmp_path / name / "Counter.st").write_text(COUNTER, encoding="utf-8")
    client = LspClient(Server(Plain()), tmp_path)
    main = tmp_path / "two" / "Main.st"
    client.open(main, MAIN.replace("Part.Total", "Part.Sum"))
    assert [one["message"] for one in client.diagnostics(main)] == ["Counter has no member Sum"]
    client.close()


def test_settings_name_the_files_of_the_program(folder: Path) -> None:
    client = LspClient(Server(Plain()), folder, files=["Main.st"])
    client.open(folder / "Main.st")
    (found,) = client.diagnostics(folder / "Main.st")
    assert found["message"] == "there is no type Counter; name its file, too, or check the spelling"
    client.close()


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"file": "Main.st"}, "there is no setting file; did you mean files"),
        ({"for": "nothing"}, "for nothing: no such tool; use "),
        ({"pause": -1}, "the setting pause is not a number from 0 to 60000 [ms]"),
    ],
)
def test_a_wrong_setting_is_a_message(folder: Path, settings: dict[str, object], text: str) -> None:
    client = LspClient(Server(Plain()), folder, **settings)
    message = client.wait(lambda one: one.get("method") == "window/showMessage")
    assert message["params"]["message"].startswith(text)
    client.close()


def test_a_document_is_formatted_as_by_the_command(client: LspClient, folder: Path) -> None:
    main = folder / "Main.st"
    text = "PROGRAM Main\n  VAR\n    Count : INT;\n  END_VAR\n\n  Count:=Count+1;\nEND_PROGRAM\n"
    client.open(main, text)
    (edit,) = client.ask("formatting", main, options={"tabSize": 2, "insertSpaces": True})
    assert edit["newText"] == text.replace("Count:=Count+1", "Count := Count + 1")
    with_mistake = text.replace("END_VAR", "")
    client.change(main, with_mistake)
    with pytest.raises(LspError, match="END_VAR"):
        client.ask("formatting", main, options={"tabSize": 2, "insertSpaces": True})


POU = """\
<?xml version="1.0" encoding="utf-8"?>
<TcPlcObject Version="1.1.0.1">
  <POU Name="MAIN" Id="{00000000-0000-0000-0000-000000000001}">
    <Declaration><![CDATA[PROGRAM MAIN
VAR
    Count : INT;
END_VAR
]]></Declaration>
    <Implementation>
      <ST><![CDATA[Count := 1;
]]></ST>
    </Implementation>
  </POU>
</TcPlcObject>
"""


def test_a_project_file_has_its_mistakes_while_it_is_typed(tmp_path: Path) -> None:
    file = tmp_path / "MAIN.TcPOU"
    file.write_text(POU, encoding="utf-8")
    client = LspClient(Server(Plain()), tmp_path)
    client.open(file, POU.replace("Count := 1", "Count := Wrong"))
    (found,) = client.diagnostics(file)
    assert found["message"] == "Wrong is not declared"
    assert found["range"] == {
        "start": {"line": 9, "character": 28},
        "end": {"line": 9, "character": 33},
    }
    client.change(file, POU)
    assert client.diagnostics(file) == []
    client.close()


LADDER = POU.replace("<ST><![CDATA[Count := 1;\n]]></ST>", "<LD/>")


def test_a_body_in_another_language_is_named(tmp_path: Path) -> None:
    file = tmp_path / "MAIN.TcPOU"
    file.write_text(LADDER, encoding="utf-8")
    client = LspClient(Server(Plain()), tmp_path)
    client.open(file)
    (found,) = client.diagnostics(file)
    assert found["code"] == "unread-body"
    assert found["severity"] == 3
    assert found["message"].startswith("the body of MAIN ")
    client.close()
