"""The debugger shows robot programs beside the PLC, with breakpoints, threads, steps and values.

The PLC of Shake.st starts SHAKE.PGM in task 1 and requests work by SI(20). SHAKE.PGM starts
SIDE.PGM in task 2.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from editor import Editor, RefusedError
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.verify.debug.robot_programs import robot_programs

FOLDER = Path(__file__).parent / "programs"
PLC, MAIN, SIDE = FOLDER / "Shake.st", FOLDER / "SHAKE.PGM", FOLDER / "SIDE.PGM"
#: Numbers of the debugger's threads. The first thread is the program of the PLC.
TASK_1, TASK_2 = 2, 3

Start = Callable[..., Editor]


@pytest.fixture
def shaking(editor: Editor) -> Start:
    """Launch the cell with these breakpoints in its files, and run to the first stop."""

    def start(breakpoints: dict[str | Path, list[Any]]) -> Editor:
        editor.start(breakpoints, sources=[str(PLC)], robot=str(FOLDER / "shake.toml"))
        return editor

    return start


def _lines(editor: Editor, command: str, thread: int, times: int) -> list[int]:
    """Repeat a command (a step) in a thread, and return the lines where the thread stops."""
    found = []
    for _ in range(times):
        assert editor.go(command, thread)["threadId"] == thread
        found.append(editor.stack(thread)[0][1])
    return found


def test_a_breakpoint_stops_the_task_that_reaches_its_line(shaking: Start) -> None:
    """A breakpoint stops the task that reaches its line, and the PLC between two scans.

    SIDE has not been started.
    """
    editor = shaking({MAIN: [2]})
    assert editor.stack(TASK_1) == [("SHAKE", 2)]
    assert editor.stack(1)[0][0] == "Main (Shake), between two scans"
    names = [one["name"] for one in editor.request("threads")["threads"]]
    assert names == ["Main (task Cyclic, 10 ms)", "Robot task 1: SHAKE"]
    assert _lines(editor, "next", TASK_1, 1) == [4], "the label of line 3 is no statement"
    names = [one["name"] for one in editor.request("threads")["threads"]]
    assert names[1:] == ["Robot task 1: SHAKE", "Robot task 2: SIDE"]


def test_a_breakpoint_moves_to_the_next_statement(shaking: Start) -> None:
    """A breakpoint at a line without a statement moves to the next statement of the robot program.

    Line 1 is a comment, lines 3 and 10 are labels, and line 14 does not exist.
    """
    editor = shaking({MAIN: [2]})
    found = editor.set(MAIN, 1, 3, 4, 10, 14)
    assert [one.get("line") for one in found] == [2, 4, 4, 11, None]
    assert found[1]["message"] == "moved from line 3 to the next statement"
    assert "message" not in found[2]
    assert found[4]["message"] == "there is no statement from this line on"
    ways = editor.request("breakpointLocations", source={"path": str(MAIN)}, line=1, endLine=14)
    assert [one["line"] for one in ways["breakpoints"]] == [2, 4, 5, 6, 7, 8, 9, 11, 12, 13]


def test_what_cannot_be_a_breakpoint_is_refused(shaking: Start) -> None:
    editor = shaking({MAIN: [2]})
    for wanted, text in (
        ({"condition": "N% >"}, "'N% >' is not an expression of the robot language; write it as"),
        ({"condition": "ARM"}, "'ARM' is not an expression"),
        ({"condition": "SI(20)=1,500"}, "'SI(20)=1,500' is not an expression"),
        ({"logMessage": "here"}, "logpoints are possible in Structured Text only"),
        ({"hitCondition": "often"}, "'often' is not a count of hits"),
    ):
        (found,) = editor.set(MAIN, {"line": 5, **wanted})
        assert not found["verified"]
        assert found["message"].startswith(text)
    (elsewhere,) = editor.set(FOLDER / "OTHER.PGM", 2)
    assert not elsewhere["verified"]
    assert elsewhere["message"].endswith("OTHER.PGM, and no device of the cell runs it")


def test_a_condition_is_an_expression_of_the_robot_language(shaking: Start) -> None:
    """A condition of a breakpoint is an expression of the robot language.

    N% is 3 for the first time in the fourth request. Point 900 is not defined.
    """
    editor = shaking({MAIN: [{"line": 5, "condition": "n% = 3 and si(20)=1"}]})
    assert editor.value("N%", thread=TASK_1) == "3"
    editor.go("reverseContinue")
    assert editor.stack(1)[0][1] == 10, (
        "the start of the run, because the condition has not held before"
    )
    editor.set(MAIN, {"line": 4, "condition": "P900 = P901"})
    editor.go()
    assert editor.stack(TASK_1) == [("SHAKE", 4)]
    editor.request("threads")
    assert any(one.startswith("breakpoint: P900 = P901 has no value") for one in editor.output)


def test_hits_are_counted(shaking: Start) -> None:
    """A breakpoint can stop at its third hit. In the third request, N% is 2 before line 5."""
    editor = shaking({MAIN: [{"line": 5, "hitCondition": "3"}]})
    assert editor.value("N%", thread=TASK_1) == "2"


def test_steps_go_over_into_and_out_of_subroutines(shaking: Start) -> None:
    editor = shaking({MAIN: [{"line": 6, "hitCondition": "1"}]})
    assert _lines(editor, "stepIn", TASK_1, 2) == [11, 12]
    assert editor.stack(TASK_1) == [("*ANSWER", 12), ("SHAKE", 6)]
    assert _lines(editor, "stepOut", TASK_1, 1) == [7]
    assert _lines(editor, "next", TASK_1, 5) == [8, 9, 4, 5, 6]
    assert _lines(editor, "next", TASK_1, 1) == [7], "over the GOSUB"


def test_the_plc_continues_while_a_task_waits(shaking: Start) -> None:
    """While a task waits, the PLC continues: it must read SO(20) and turn SI(20) OFF."""
    editor = shaking({MAIN: [{"line": 7, "hitCondition": "1"}]})
    assert editor.value("Answered") == "0"
    assert _lines(editor, "next", TASK_1, 1) == [8]
    assert int(editor.value("Answered")) >= 1


def test_a_step_in_the_plc_ends_in_the_plc(shaking: Start) -> None:
    """A step in the PLC ends in the PLC, while both robot tasks continue to run.

    The stack shows the statement of the PLC program.
    """
    editor = shaking({MAIN: [{"line": 5, "hitCondition": "1"}]})
    assert editor.go("next", 1)["threadId"] == 1
    assert editor.stack(1) == [("Main (Shake)", 10)]
    assert editor.stack(TASK_1) == [("SHAKE", 7)]
    assert editor.go("stepBack", 1)["threadId"] == 1, (
        "the stop is not in a line of the robot in this scan"
    )
    assert editor.stack(1)[0][0] == "Main (Shake)"


def test_a_task_shows_its_variables(shaking: Start) -> None:
    """A task shows its variables, including the parameters of a call.

    SIDE has called COUNTED with M% passed as X%. Before line 7 of the second call, M% and Y% are 1.
    """
    editor = shaking({SIDE: [{"line": 7, "hitCondition": "2"}]})
    assert editor.stack(TASK_2) == [("COUNTED", 7), ("SIDE", 2)]
    inside, outside = (editor.scope(name, thread=TASK_2) for name in ("Variables", "Task"))
    assert {name: one["value"] for name, one in inside.items()} == {"Y%": "1"}
    assert outside["statement"]["value"] == "X%=Y%+1"
    program = editor.scope("Program variables", level=1, thread=TASK_2)
    assert {name: one["value"] for name, one in program.items()} == {"M%": "1"}
    ports = editor.scope("Ports", thread=TASK_1)
    assert set(ports) == {"SI(20)", "SO(20)"}
    assert "SGI3" in editor.scope("SGI, SGR", thread=TASK_1)
    number = editor.value("N%", thread=TASK_1)
    assert editor.value(" sgi3", thread=TASK_1) == number, "names are not case-sensitive"


def test_the_console_shows_plc_and_tasks_side_by_side(shaking: Start) -> None:
    """The console shows the lines of PLC and tasks at each stop, and after the command `.where`."""
    editor = shaking({MAIN: [{"line": 7, "hitCondition": "1"}]})
    shown = editor.say(".where")
    first, *tasks = shown.splitlines()
    assert first.endswith(": PLC: Main (Shake), between two scans")
    assert tasks == [
        "    Robot task 1: SHAKE, line 7, running: WAIT SI(20)=0",
        "    Robot task 2: SIDE, line 1, running: *AGAIN:",
    ]
    assert editor.output[-1] == shown
    with pytest.raises(RefusedError, match=r"^a device is in the middle of its cycle; go to"):
        editor.say(".inject emergency_stop")
    editor.go("next", 1)
    assert ": PLC: Main (Shake), line 10\n" in editor.say(".where")


def test_stepping_back_goes_through_the_lines_of_a_task(shaking: Start) -> None:
    """Stepping back goes through the lines of a task, here with the GOSUB of line 6.

    It includes scans in which the task waits.
    """
    editor = shaking({MAIN: [{"line": 8, "hitCondition": "2"}]})
    assert editor.value("N%", thread=TASK_1) == "2"
    assert _lines(editor, "stepBack", TASK_1, 6) == [7, 6, 5, 4, 9, 8]
    assert editor.value("N%", thread=TASK_1) == "1"
    assert editor.go("stepBack", 1)["threadId"] == 1, "the last statement of the PLC before it"


def test_back_to_a_breakpoint_of_a_robot_program(shaking: Start) -> None:
    editor = shaking({MAIN: [5]})
    editor.go()
    assert editor.value("N%", thread=TASK_1) == "1"
    editor.go("reverseContinue")
    assert editor.stack(TASK_1) == [("SHAKE", 5)]
    with pytest.raises(RefusedError, match=r"^N% has no value in SHAKE; in the PLC: "):
        editor.value("N%", thread=TASK_1)
    editor.say(".scan -1")
    assert editor.event("stopped")["threadId"] == 1
    editor.go()
    assert editor.stack(TASK_1) == [("SHAKE", 5)]


def test_programs_of_several_robots_and_of_an_all_file(tmp_path: Path) -> None:
    """Programs of several robots and of an ALL file are shown with their lines.

    MAIN begins in line 3 of the file. Each robot has its own tasks.
    """
    (tmp_path / "CELL.ALL").write_text("[PGM]\nNAME=MAIN\n*L:\nSGI0=2\nGOTO *L\n\n[END]\n")
    (tmp_path / "robot.toml").write_text('data_file = "CELL.ALL"\n')
    file = str(tmp_path / "CELL.ALL")
    config = RobotConfig.load(tmp_path / "robot.toml")
    programs = robot_programs([Controller(config), Controller(config)])
    assert programs is not None
    assert (list(programs.files), list(programs.lines(file))) == ([file], [4, 5])
    assert list(programs.tasks) == [(1, "Robot 1 task 1: MAIN"), (2, "Robot 2 task 1: MAIN")]
    assert [one[:3] for one in programs.stack(2)] == [("MAIN", file, 3)]
    assert robot_programs([Controller(RobotConfig())]) is None, "this program has no text"
