"""The debugger steps forwards: by statement, over and out of calls, by scan, and to the end."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from editor import Editor, RefusedError

Start = Callable[..., Editor]


def test_each_statement_and_each_round_is_a_step(at_entry: Start) -> None:
    """Source: programs/Lamps.st, by hand."""
    editor = at_entry()
    lines = [editor.line]
    for _ in range(19):
        editor.go("stepIn")
        lines.append(editor.line)
    rounds = [29, 30, 31] * 3
    assert lines == [50, 25, 26, 28, *rounds, 29, 51, 10, 11, 52, 57, 58]
    editor.go("stepIn")
    assert editor.line == 50
    assert editor.value("C.Value") == "1"


def test_a_step_over_does_not_enter_calls(at_entry: Start) -> None:
    """Source: programs/Lamps.st, by hand."""
    editor = at_entry()
    lines = [editor.line]
    for _ in range(5):
        editor.go("next")
        lines.append(editor.line)
    assert lines == [50, 51, 52, 57, 58, 50]


def test_a_step_out_ends_after_the_call_or_in_the_next_scan(at_entry: Start) -> None:
    """Source: programs/Lamps.st, by hand."""
    editor = at_entry()
    editor.go("stepIn")
    assert editor.stack() == [("Main.C (Counter)", 25), ("Main (Lamps)", 50)]
    editor.go("stepOut")
    assert editor.stack() == [("Main (Lamps)", 51)]
    assert editor.value("C.Value") == "1"
    editor.go("stepOut")
    assert editor.line == 50
    editor.go("next")
    assert editor.value("C.Value") == "2"


def test_a_step_over_the_last_statement_of_a_block_comes_back_to_its_caller(stopped: Start) -> None:
    editor = stopped(11)
    assert editor.stack() == [("Twice()", 11), ("Main (Lamps)", 51)]
    editor.go("next")
    assert editor.stack() == [("Main (Lamps)", 52)]


def test_a_step_by_scans_stops_before_their_first_statement(at_entry: Start) -> None:
    editor = at_entry()
    editor.go("rcx/stepScan")
    assert (editor.line, editor.value("C.Value")) == (50, "1")
    editor.go("rcx/stepScan", scans=10)
    assert (editor.line, editor.value("C.Value")) == (50, "11")
    editor.go("rcx/stepScan", scans=-4)
    assert editor.value("C.Value") == "7"


def test_a_run_stops_at_its_end_so_that_the_user_can_go_back(editor: Editor, lamps: Path) -> None:
    """At its end a run stops, so that the user can go back.

    In 100 ms with a scan of 10 ms, ten scans run: at 0, 10, ... 90 ms.
    """
    why = editor.start(sources=[str(lamps)], for_="100ms")
    assert why["text"] == "the end of the run (100ms)"
    assert editor.value("C.Value") == "10"
    editor.go("stepBack")
    assert editor.line == 58
    editor.go("continue")
    editor.request("continue", threadId=1)
    editor.event("terminated")
    assert editor.event("exited") == {"exitCode": 0}


def test_a_pause_stops_between_two_scans(editor: Editor, lamps: Path) -> None:
    editor.request("initialize")
    editor.request("launch", sources=[str(lamps)], **{"for": "1000s"})
    editor.request("pause", threadId=1)
    editor.request("configurationDone")
    why = editor.event("stopped")
    assert why["reason"] == "pause"
    assert editor.stack() == [("Main (Lamps), between two scans", 50)]


def test_while_it_runs_what_needs_a_stop_is_refused(editor: Editor, lamps: Path) -> None:
    editor.request("initialize")
    editor.request("launch", sources=[str(lamps)])
    with pytest.raises(RefusedError, match="pause it first"):
        editor.request("stackTrace", threadId=1)


def test_two_programs_are_two_threads(editor: Editor, tmp_path: Path, lamps: Path) -> None:
    """Two programs are shown as two threads.

    Their intervals are 10 ms and 20 ms, so the second program runs in every second scan.
    """
    (tmp_path / "Slow.st").write_text(
        "PROGRAM Slow\n  VAR\n    Turns : INT;\n  END_VAR\n  Turns := Turns + 1;\nEND_PROGRAM\n"
    )
    (tmp_path / "Config.st").write_text(
        "CONFIGURATION Config0\n RESOURCE Res0 ON PLC\n"
        "  TASK Fast(INTERVAL := T#10ms, PRIORITY := 0);\n"
        "  TASK Lazy(INTERVAL := T#20ms, PRIORITY := 1);\n"
        "  PROGRAM Main WITH Fast : Lamps;\n  PROGRAM Second WITH Lazy : Slow;\n"
        " END_RESOURCE\nEND_CONFIGURATION\n"
    )
    why = editor.start({tmp_path / "Slow.st": [5]}, sources=[str(lamps), str(tmp_path)])
    assert why["threadId"] == 2
    threads = editor.request("threads")["threads"]
    assert [one["name"] for one in threads] == [
        "Main (task Fast, 10 ms)",
        "Second (task Lazy, 20 ms)",
    ]
    (frame,) = editor.request("stackTrace", threadId=2)["stackFrames"]
    assert (frame["name"], frame["line"]) == ("Second (Slow)", 5)
    (other,) = editor.request("stackTrace", threadId=1)["stackFrames"]
    assert other["name"] == "Main (Lamps), between two scans"
    editor.go()
    assert editor.value("Main.C.Value") == "3"
