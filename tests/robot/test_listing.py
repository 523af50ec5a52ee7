"""The trace contains the listing of the robot programs."""

from __future__ import annotations

from pathlib import Path

from rcx_harness.robot import Controller, RobotConfig, RobotProgram
from rcx_harness.robot.listing import Tasks, listings, task_places

_TEXT = RobotProgram(name="PLACE", file="cell/PLACE.PGM", text="*AGAIN:\n  DELAY 10\nGOTO *AGAIN\n")
_STEPS = RobotProgram(name="LAMP", steps=("DO(21)=1", "DELAY 10"))


def test_a_controller_without_a_text_has_no_listing() -> None:
    """A robot file with only steps and durations gives no listing, and its traces do not change."""
    assert listings(Controller(RobotConfig())) == []
    assert listings(Controller(RobotConfig(programs=(_STEPS,)))) == []


def test_beside_a_text_all_programs_have_their_lines() -> None:
    """If any program has a text, all programs have lines.

    A file is listed by its name only, because folders differ from computer to computer.
    """
    programs = (_TEXT, _STEPS, RobotProgram(name="IDLE"))
    assert listings(Controller(RobotConfig(programs=programs))) == [
        {"name": "PLACE", "file": "PLACE.PGM", "lines": ["*AGAIN:", "  DELAY 10", "GOTO *AGAIN"]},
        {"name": "LAMP", "lines": ["DO(21)=1", "DELAY 10"]},
        {"name": "IDLE", "lines": []},
    ]


def test_a_task_is_in_the_line_that_it_executes() -> None:
    """The main program is in task 1 from power-on.

    A second program is in a task once it is registered.

    Source: guide 4.2.8, the states of tasks.
    """
    robot = Controller(RobotConfig(programs=(_TEXT, _STEPS), booted=True))
    ready = {"task": 1, "program": "PLACE", "line": 1, "state": "ready"}
    assert task_places(robot) == (ready,)
    inputs = bytearray(48)
    inputs[32] = 0x41  # SI(00), SI(06)
    robot.program.main.go(0)
    robot.cycle(5_000, bytes(inputs))
    assert task_places(robot) == ({**ready, "line": 2, "state": "running"},)
    robot.program.register(robot.program.tasks[1], 3, 32)
    assert [task["task"] for task in task_places(robot)] == [1, 3]


def test_a_controller_that_is_off_has_no_tasks() -> None:
    robot = Controller(RobotConfig(programs=(_TEXT,), booted=True))
    robot.inject("power_off")
    robot.cycle(5_000, bytes(48))
    assert task_places(robot) == ()


def test_a_trace_gets_the_tasks_first_and_where_they_change() -> None:
    """The trace has the tasks in its first entry and at each change.

    Without a listing the trace contains no tasks.
    """
    robot = Controller(RobotConfig(programs=(_TEXT,), booted=True))
    tasks = Tasks(robot)
    first = tasks.changed()
    assert first is not None
    assert (first[0]["state"], tasks.changed()) == ("ready", None)
    robot.program.main.go(0)
    second = tasks.changed()
    assert second is not None
    assert (second[0]["state"], tasks.changed()) == ("running", None)
    tasks.forget()
    assert tasks.changed() == second
    assert Tasks(Controller(RobotConfig(programs=(_STEPS,)))).changed() is None


def test_a_program_of_a_file_with_all_data_counts_its_own_lines(tmp_path: Path) -> None:
    """Lines count from the line after NAME= in a file with all data, as the controller counts."""
    (tmp_path / "CELL.ALL").write_text("[PGM]\nNAME=PICK\nDELAY 10\nHALT\n[END]\n")
    (tmp_path / "robot.toml").write_text('data_file = "CELL.ALL"\n')
    robot = Controller(RobotConfig.load(tmp_path / "robot.toml"))
    assert listings(robot) == [{"name": "PICK", "lines": ["DELAY 10", "HALT"]}]
    assert task_places(robot)[0]["line"] == 1
