"""The recording of a failed test opens at its end, and can be run backwards."""

from __future__ import annotations

import json
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from editor import Editor, RefusedError
from rcx_harness import Cell
from rcx_harness.verify.debug.recording import opened, write_recording
from structured_text.debug.recording import Recorded
from structured_text.engines.base import Program

LAMPS = Path(__file__).parent / "programs" / "Lamps.st"


def _cell(program: Path, **options: Any) -> tuple[Cell, Recorded]:
    made: list[Recorded] = []

    def through(program: Program) -> Program:
        made.append(Recorded(program))
        return made[-1]

    return Cell.build(program, engine="builtin", through=through, **options), made[0]


def _written(
    folder: Path, cell: Cell, recorded: Recorded, program: Path, failed: str = "assert False"
) -> Path:
    file = folder / "recording.jsonl"
    settings: Mapping[str, Any] = {"program": [program]}
    write_recording(file, recorded, cell, settings, folder, "test_it.py::test_it", failed)
    return file


def test_a_recording_gives_the_program_its_recorded_inputs(tmp_path: Path, editor: Editor) -> None:
    """A recording gives the program the values that it was given in the test.

    Go is FALSE in 3 of 10 scans, so Value is 7.
    """
    program = Path(shutil.copy(LAMPS, tmp_path))
    cell, recorded = _cell(program)
    with cell:
        cell.scan(4)
        cell["Main.Go"] = False
        cell.scan(3)
        cell["Main.Go"] = True
        cell.scan(3)
        cell["Main.Divisor"] = 5
    why = editor.start(recording=str(_written(tmp_path, cell, recorded, program, "assert 7 == 8")))
    assert (why["reason"], why["text"]) == ("exception", "assert 7 == 8")
    assert editor.value("C.Value") == "7"
    assert editor.value("Divisor") == "5", "set after the last scan"
    editor.say(".back Go")
    assert editor.event("stopped")["text"] == "Main.Go: FALSE -> TRUE"
    assert editor.value("C.Value") == "4"
    editor.go("continue")
    assert editor.value("C.Value") == "7"
    with pytest.raises(RefusedError, match="a recording has no robot"):
        editor.say(".inject link_down")


def test_a_recording_leaves_out_what_a_test_took_back(tmp_path: Path) -> None:
    program = Path(shutil.copy(LAMPS, tmp_path))
    cell, recorded = _cell(program)
    with cell:
        cell.scan(2)
        before = cell.snapshot()
        cell["Main.Go"] = False
        cell.scan(50)
        cell.restore(before)
        cell.scan(3)
        value = cell["Main.C.Value"]
    tape, _, _ = opened(_written(tmp_path, cell, recorded, program))
    assert tape.length == 5
    while not tape.ended:
        tape.scan()
    assert tape.program.read("Main.C.Value") == value == 5


def test_a_cell_repeats_its_areas_without_its_robot(tmp_path: Path, repository: Path) -> None:
    example = repository / "plc" / "examples" / "04_pick_and_place"
    cell, recorded = _cell(example, jitter="7ms", seed=3)
    with cell:
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        cell["Main.Start"] = True
        cell.run("2s")
        areas = [one.si for one in cell.trace.scans()]
    file = _written(tmp_path, cell, recorded, example)
    tape, _, _ = opened(file)
    again = []
    while not tape.ended:
        tape.scan()
        again.append(tape.telegrams[0].si)
    assert len(set(areas)) > 5
    assert again == areas
    assert file.stat().st_size < 40_000, "equal scans share a line, so the file is small"


def test_values_of_all_kinds_come_again(tmp_path: Path) -> None:
    program = tmp_path / "Kinds.st"
    program.write_text(
        "TYPE PAIR : STRUCT A : INT; B : REAL; END_STRUCT; END_TYPE\n"
        "PROGRAM Kinds\n  VAR\n    InputArea : RCX_IMAGE; OutputArea : RCX_IMAGE;\n"
        "    T : TIME; D : DATE; S : STRING; R : REAL; P : PAIR; F : ARRAY [0..2] OF INT;\n"
        "    N : INT;\n  END_VAR\n  N := N + 1;\nEND_PROGRAM\n"
    )
    cell, recorded = _cell(program)
    from datetime import date, timedelta

    given = {"T": timedelta(milliseconds=1500), "D": date(2024, 2, 29), "S": "it's", "R": -0.0,
             "P": {"A": 3, "B": 0.5}, "F": [1, 2, 3]}  # fmt: skip
    with cell:
        cell["Main.R"] = 0.0
        for name, value in given.items():
            cell[f"Main.{name}"] = value
        cell.scan()
    tape, _, _ = opened(_written(tmp_path, cell, recorded, program))
    tape.scan()
    assert {name: tape.program.read(f"Main.{name}") for name in given} == given
    assert str(tape.program.read("Main.R")) == "-0.0"


def test_a_recording_names_changed_sources(tmp_path: Path, editor: Editor) -> None:
    program = Path(shutil.copy(LAMPS, tmp_path))
    cell, recorded = _cell(program)
    with cell:
        cell.scan()
    file = _written(tmp_path, cell, recorded, program)
    program.write_text(program.read_text().replace("> 10", "> 12"))
    editor.request("initialize")
    with pytest.raises(RefusedError) as refused:
        editor.request("launch", recording=str(file))
    assert str(refused.value) == (
        f"{file}: Lamps.st changed since this was recorded; run the test again"
    )


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("", "not a recording of format rcx-recording/1"),
        ('{"format":"rcx-trace/1"}\n', "not a recording of format rcx-recording/1"),
        ('{"format":"rcx-recording/2"}\n', "not a recording of format rcx-recording/1"),
        ('{"format":"rcx-recording/1"}\n', "the recording is damaged; run the test again"),
        ('{"format":"rcx-recording/1",\n', "the recording is damaged; run the test again"),
    ],
)
def test_a_wrong_recording_is_refused(
    tmp_path: Path, editor: Editor, content: str, message: str
) -> None:
    file = tmp_path / "recording.jsonl"
    file.write_text(content)
    with pytest.raises(RefusedError) as refused:
        editor.request("launch", recording=str(file))
    assert str(refused.value) == f"{file}: {message}"


@pytest.mark.parametrize("line", [1, 2, -1])
def test_a_recording_with_a_hole_is_damaged(tmp_path: Path, editor: Editor, line: int) -> None:
    """Source: a defect report: every reader of recordings reports damage."""
    program = Path(shutil.copy(LAMPS, tmp_path))
    cell, recorded = _cell(program)
    with cell:
        cell.scan(4)
        cell["Main.Go"] = False
        cell.scan(3)
        cell["Main.Divisor"] = 5
    file = _written(tmp_path, cell, recorded, program)
    lines = file.read_text().splitlines()
    del lines[line]
    file.write_text("\n".join([*lines, ""]))
    with pytest.raises(RefusedError, match="the recording is damaged; run the test again"):
        editor.request("launch", recording=str(file))


def test_a_recording_excludes_other_options(tmp_path: Path, editor: Editor) -> None:
    with pytest.raises(RefusedError, match="scan cannot be combined with a recording"):
        editor.request("launch", recording="x.jsonl", scan="5ms")


def test_a_broken_rule_is_shown_at_its_scan(tmp_path: Path, editor: Editor) -> None:
    """A broken rule of a recording is shown at the scan that broke it.

    Bytes n+46 and n+47 are reserved (manual chapter 1, 4.1). They change in scan 20.
    """
    program = tmp_path / "Breaks.st"
    program.write_text(
        "PROGRAM Breaks\n  VAR\n    InputArea : RCX_IMAGE; OutputArea : RCX_IMAGE;\n"
        "    Scans : INT;\n  END_VAR\n  Scans := Scans + 1;\n"
        "  IF Scans = 20 THEN\n    OutputArea[46] := BYTE#16#01;\n  END_IF;\nEND_PROGRAM\n"
    )
    cell, recorded = _cell(program)
    with cell:
        cell.scan(40)
    editor.start(recording=str(_written(tmp_path, cell, recorded, program)))
    assert editor.go("reverseContinue")["text"].startswith("robot, cycle 41: reserved")
    assert editor.go("reverseContinue")["text"].startswith("plc, scan 19: reserved")
    assert editor.value("Scans") == "20", "scans are counted from 0 in messages of rules"


@pytest.mark.exhaustive
def test_a_failed_test_writes_a_recording(pytester: pytest.Pytester, editor: Editor) -> None:
    """A failed test writes a recording into the folder of the chart and the trace.

    A passing test writes none.
    """
    shutil.copy(LAMPS, pytester.path)
    pytester.makeini("[pytest]\nrcx_sources = Lamps.st\nrcx_artifacts = kept\n")
    pytester.makepyfile(
        test_it="def test_bad(cell):\n    cell.scan(5)\n"
        "    assert cell['Main.C.Value'] == 6\n"
        "def test_good(cell):\n    cell.scan(5)\n"
    )
    result = pytester.runpytest_subprocess("-p", "no:randomly")
    result.assert_outcomes(failed=1, passed=1)
    (file,) = (pytester.path / "kept").rglob("recording.jsonl")
    result.stdout.fnmatch_lines([f"*{file.relative_to(pytester.path)}"])
    head = json.loads(file.read_text().splitlines()[0])
    assert (head["test"], head["failed"]) == ("test_it.py::test_bad", "assert 5 == 6")
    why = editor.start(recording=str(file))
    assert why["text"] == "assert 5 == 6"
    assert editor.value("C.Value") == "5"
