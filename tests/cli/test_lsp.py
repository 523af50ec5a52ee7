"""`rcx lsp` adds the robot to the language server: warnings, changes, commands and facts."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from lsp_client import LspClient
from rcx_harness.cell.sources import source_files
from rcx_harness.editor.areas import area_edits
from rcx_harness.editor.extras import RobotExtras
from rcx_harness.watch.first_mistakes import first_mistakes
from structured_text.editor.server import Server
from structured_text.output.programs import environment
from structured_text.projects.sources import SourceFiles

EXAMPLE = Path(__file__).parents[2] / "plc" / "examples" / "01_power_up"

JOG = """\
PROGRAM Main
  VAR
    Robot   : RCX_REF;
    ServoOn : FB_ServoOn;
    Start   : BOOL;
  END_VAR

  ServoOn(Robot := Robot, Execute := Start);
END_PROGRAM
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("cell") / "power_up"
    shutil.copytree(EXAMPLE, made)
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> Iterator[LspClient]:
    client = LspClient(Server(RobotExtras()), folder)
    client.open(folder / "PowerUp.st")
    yield client
    client.close()


def _position(folder: Path, text: str) -> tuple[int, int]:
    lines = (folder / "PowerUp.st").read_text(encoding="utf-8").split("\n")
    line = next(number for number, one in enumerate(lines) if text in one)
    return line, lines[line].index(text)


@pytest.mark.exhaustive
def test_hover_on_a_block_lists_its_error_ids(client: LspClient, folder: Path) -> None:
    found = client.ask("hover", folder / "PowerUp.st", *_position(folder, "ServoOn(Robot"))
    text = found["contents"]["value"]
    assert "`16#8003` Emergency stop" in text
    assert "FB_ServoOn.md" in text


def test_hover_on_a_pin_shows_its_legal_values(client: LspClient, folder: Path) -> None:
    found = client.ask("hover", folder / "PowerUp.st", *_position(folder, "Size := 48, Conn"))
    assert "Legal values: 48, 256" in found["contents"]["value"]


def test_a_program_has_its_commands_above_it(client: LspClient, folder: Path) -> None:
    found = client.ask("codeLens", folder / "PowerUp.st")
    line, _ = _position(folder, "PROGRAM PowerUp")
    assert [one["command"]["title"] for one in found] == ["prove", "run", "sweep"]
    assert {one["range"]["start"]["line"] for one in found} == {line}


def test_a_missing_area_is_a_warning_with_a_change(tmp_path: Path) -> None:
    main = tmp_path / "Main.st"
    main.write_text(JOG, encoding="utf-8")
    client = LspClient(Server(RobotExtras()), tmp_path)
    client.open(main)
    found = client.diagnostics(main)
    warning = next(one for one in found if one["code"] == "first-mistake")
    assert warning["range"]["start"]["line"] == 7
    (action,) = client.ask(
        "codeAction", main, range=warning["range"], context={"diagnostics": [warning]}
    )
    assert action["title"] == "Add FB_ReadArea and FB_WriteArea"
    (edits,) = action["edit"]["changes"].values()
    client.change(main, _edited(JOG, edits))
    while found:  # the warning first moves with its line
        found = [one for one in client.diagnostics(main) if one["code"] == "first-mistake"]
    client.close()


def _edited(text: str, edits: list[dict[str, Any]]) -> str:
    """Return a text with insertions at beginnings of lines."""
    lines = text.split("\n")
    for edit in sorted(edits, key=lambda one: -one["range"]["start"]["line"]):
        lines.insert(edit["range"]["start"]["line"], edit["newText"].rstrip("\n"))
    return "\n".join(lines)


def test_the_change_declares_only_what_is_missing(tmp_path: Path) -> None:
    text = JOG.replace(
        "    Start ", "    Reader  : FB_ReadArea;\n    InputArea : RCX_IMAGE;\n    Start "
    )
    main = tmp_path / "Main.st"
    main.write_text(text, encoding="utf-8")
    files: SourceFiles = source_files(main)
    (mistake,) = [one for one in first_mistakes(*files.users) if "neither" in one.text]
    edits = area_edits(main, text, mistake.at.line, mistake.text)
    assert [edit.new_text for edit in edits] == [
        "  Reader(Robot := Robot, Image := InputArea, m := 0, Size := 48, "
        "Connected := Connected);\n",
        "  WriteArea(Robot := Robot, Image := OutputArea, n := 0, Size := 48, "
        "EmergencyStopOk := CellSafe, StopOk := CellSafe);\n",
        "    Connected : BOOL;  (* your scanner's status *)\n"
        "    WriteArea : FB_WriteArea;\n"
        "    OutputArea : RCX_IMAGE;  (* PLC to robot, sent by your scanner *)\n"
        "    CellSafe : BOOL;  (* status of your safety circuit: must be wired *)\n",
    ]


def test_the_tool_of_the_settings_refuses_constructs(tmp_path: Path) -> None:
    main = tmp_path / "Main.st"
    text = "PROGRAM Main\nVAR\n    P : POINTER TO INT;\nEND_VAR\nP := 0;\nEND_PROGRAM\n"
    main.write_text(text, encoding="utf-8")
    client = LspClient(Server(RobotExtras()), tmp_path, **{"for": "rockwell"})
    client.open(main)
    found = client.diagnostics(main)
    assert any(one["message"].startswith("rockwell refuses this: ") for one in found), found
    client.close()


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    ("action", "text"),
    [("prove", "prove: 3 of 3 properties proved"), ("run", "run: 5 s on the ")],
)
def test_a_result_stays_at_the_program(
    client: LspClient, folder: Path, action: str, text: str
) -> None:
    main = folder / "PowerUp.st"
    line, _ = _position(folder, "PROGRAM PowerUp")
    client.request(
        "workspace/executeCommand", command="rcx.perform", arguments=[action, str(main), line + 1]
    )
    while True:
        found = [one for one in client.diagnostics(main) if one["code"] == action]
        if found and found[0]["message"] != f"{action} ...":
            break
    assert found[0]["message"].startswith(text)
    assert found[0]["range"]["start"]["line"] == line


def test_the_command_speaks_the_protocol_only(folder: Path) -> None:
    messages: list[dict[str, Any]] = [
        {"id": 1, "method": "initialize", "params": {"processId": None, "capabilities": {}}},
        {"id": 2, "method": "shutdown"},
        {"method": "exit"},
    ]
    sent = b""
    for message in messages:
        data = json.dumps({"jsonrpc": "2.0", **message}).encode()
        sent += b"Content-Length: %d\r\n\r\n%s" % (len(data), data)
    done = subprocess.run(
        [sys.executable, "-m", "rcx_harness", "lsp"],
        input=sent,
        capture_output=True,
        cwd=folder,
        check=False,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith(b"Content-Length: ")
    assert done.stdout.count(b"Content-Length: ") == 2


@pytest.mark.exhaustive
def test_without_pygls_the_command_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "pygls.py").write_text(
        "raise ModuleNotFoundError(\"No module named 'pygls'\", name='pygls')", encoding="utf-8"
    )
    path = [str(tmp_path), *sys.path]
    done = subprocess.run(
        [
            sys.executable,
            "-c",
            "import sys; from rcx_harness.cli.start import main; sys.exit(main())",
            "lsp",
        ],
        capture_output=True,
        env=environment(PYTHONPATH=":".join(path)),
        check=False,
        timeout=120,
    )
    assert done.returncode == 2
    assert b"pip install 'rcx-harness[editor]'" in done.stderr
