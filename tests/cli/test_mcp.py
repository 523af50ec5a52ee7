"""`rcx mcp` explains itself at a terminal, and reports a missing library and wrong options."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]


class _Input:
    """Standard input that is, or is not, a terminal."""

    def __init__(self, terminal: bool) -> None:
        self.isatty = lambda: terminal


@pytest.mark.parametrize("terminal", [True, False])
def test_only_at_a_terminal_it_says_how_it_is_started(
    terminal: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    """Source: docs/how-to/assistant.md."""
    from rcx_harness.assistant import server

    served: list[tuple[Any, ...]] = []
    monkeypatch.setattr(server, "serve", lambda *given: served.append(given))
    monkeypatch.setattr(sys, "stdin", _Input(terminal))
    assert main(["mcp", "--folder", str(tmp_path), "--limit", "5s", "--memory", "512"]) == 0
    folders, limits, entry = served[0]
    assert folders.roots == (tmp_path,)
    assert (limits.seconds, limits.megabytes) == (5.0, 512)
    assert entry == "rcx_harness.cli.mcp_child"
    said = capsys.readouterr()
    assert said.out == ""
    assert ('"mcpServers"' in said.err) == terminal


@pytest.mark.parametrize("library", ["mcp.server", "mcp_types"])
def test_a_missing_library_is_bad_input(
    library: str, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    for name in [name for name in sys.modules if name.startswith("rcx_harness.assistant.server")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)
    assert main(["mcp"]) == 2
    said = capsys.readouterr().err
    assert "rcx mcp needs the library mcp; pip install 'rcx-harness[assistant]'" in said


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--folder", "nowhere"], "nowhere: does not exist"),
        (["--limit", "0s"], "--limit of 0 s is too short"),
        (["--limit", "x"], "--limit: "),
    ],
)
def test_wrong_options_are_bad_input(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["mcp", *words]) == 2
    assert said in capsys.readouterr().err
