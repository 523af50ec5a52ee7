"""`rcx run --panel` serves the page as long as the program runs in real time."""

from __future__ import annotations

import json
import re
import urllib.request
from functools import partial
from pathlib import Path
from typing import Any

import pytest

from rcx_harness.cell import Cell
from rcx_harness.cli.app import main
from rcx_harness.serve.panel import plate

_LIVE = ["--link", "enip", "--realtime", "--engine", "builtin", "--panel", "0"]

Captured = pytest.CaptureFixture[str]


def test_the_page_shows_and_presses_the_keys_of_the_running_program(
    repository: Path, tmp_path: Path, capsys: Captured, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page shows and presses the keys of the running program.

    The page is requested between two slices of the run. Ctrl-C ends the run with all its files.
    """
    example, trace = repository / "plc/examples/15_panel", tmp_path / "trace.jsonl"
    run, answers = Cell.run, list[dict[str, Any]]()
    # The time-out for silent pages is not reached, because the test uses a clock that stands still.
    monkeypatch.setattr(plate, "plates_of", partial(plate.plates_of, now=lambda: 0.0))
    printed = ""

    def asked(cell: Cell, duration: Any) -> None:
        nonlocal printed
        run(cell, "50ms")
        printed += capsys.readouterr().out
        address = re.search(r"panel: (http://127.0.0.1:\d+/[\w-]+/)", printed)
        assert address
        api = f"{address[1]}api/panels/0"
        message = {"page": "test", "beat": 1, "keys": ["Stop"]}
        origin = address[1].rpartition("/")[0].rpartition("/")[0]
        press = urllib.request.Request(
            f"{api}/keys", json.dumps(message).encode(), {"Origin": origin}
        )
        urllib.request.urlopen(press).close()
        run(cell, "50ms")
        with urllib.request.urlopen(api) as answer:
            answers.append(json.load(answer))
        raise KeyboardInterrupt

    monkeypatch.setattr(Cell, "run", asked)
    files = [str(example / name) for name in ("OperatorPanel.st", "Config.st")]
    assert main(["run", *files, *_LIVE, "--trace", str(trace), "--for", "1m"]) == 0
    (shown,) = answers
    assert (shown["name"], shown["Key"]["Stop"]) == ("Main.Panel", True)
    assert "0.1 s on the builtin engine: 10 scans" in capsys.readouterr().out
    assert trace.is_file()


@pytest.mark.exhaustive
def test_a_program_without_a_panel_is_one_line_and_exit_code_2(
    repository: Path, capsys: Captured
) -> None:
    example = repository / "plc/examples/01_power_up"
    files = [str(example / name) for name in ("PowerUp.st", "POWER_STAGE.st", "Config.st")]
    assert main(["run", *files, *_LIVE, "--for", "100ms"]) == 2
    error = capsys.readouterr().err
    assert "the program has no variable of the type RCX_PANEL; declare Panel : RCX_PANEL" in error
    assert "Traceback" not in error
