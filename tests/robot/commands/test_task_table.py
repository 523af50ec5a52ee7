"""Tasks have states, lines and programs, which commands read."""

from __future__ import annotations

from program_commands import (
    ALL,
    EXECUTE,
    NO_TASK,
    NUMBER,
    REGISTER,
    SECOND,
    STATES,
    info,
    lines,
    program_master,
    states,
    telegram,
)
from rcx_harness.robot import RobotProgram


def _only(**at: int) -> list[int]:
    """Return values of tasks 1 to 8 by `task1=…`; all other tasks are empty."""
    return [at.get(f"task{number}", NO_TASK) for number in range(1, 9)]


def test_task_states_are_read_by_a_command() -> None:
    """The states are stopped, running, suspended, standby and none.

    Another request returns tasks 9 to 16.

    Rule: task-states.
    Source: remote command guide 4.7.5
    """
    programs = (
        RobotProgram("P1", steps=("START 2", "START 3", "SUSPEND 2", "WAIT SI(20)=1")),
        RobotProgram("P2", steps=("DELAY 60000",)),
        RobotProgram("P3", steps=("DELAY 60000",)),
        RobotProgram("P4", steps=("SO(30)=1",)),
    )
    master = program_master(*programs)
    master.execute(*telegram(REGISTER, NUMBER, program=4, task=16, priority=1))
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    assert states(master) == _only(task1=3, task2=2, task3=1)
    assert master.execute(STATES, 0, 1) == (0x0200, 0, *(NO_TASK,) * 7, 0, *(0,) * 6)
    master.turn_and_wait("SI06", False)
    assert states(master) == _only(task1=0, task2=2, task3=0)


def test_a_task_that_waits_is_shown_running_where_the_controller_is_set_so() -> None:
    """Rule: task-states."""
    master = program_master(waiting_is_standby=False)
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    assert states(master)[0] == 1


def test_a_task_that_suspends_itself_goes_on_behind_that_line() -> None:
    """Rule: task-states."""
    programs = (
        RobotProgram("P1", steps=("START 2", "WAIT SI(20)=1", "RESTART 2", "WAIT SI(27)=1")),
        RobotProgram("P2", steps=("SO(31)=1", "SUSPEND 2", "SO(30)=1", "WAIT SI(27)=1")),
    )
    master = program_master(*programs)
    master.pulse("SI12")
    assert (states(master)[1], lines(master)[1], master.so[35]) == (2, 3, 2)
    master.si[34] = 1
    master.run(10)
    assert (states(master)[1], lines(master)[1], master.so[35]) == (3, 4, 3)


def test_the_time_of_several_stops_does_not_count_in_a_delay() -> None:
    """100 ms of a delay of 400 ms pass before each of two stops.

    Rule: program-stop, program-restart.
    """
    delay = RobotProgram("P1", steps=("DELAY 400", "SO(30)=1", "WAIT SI(27)=1"))
    master = program_master(delay, program_start_delay=0)
    for _ in range(2):
        master.turn("SI12", True)
        master.run(100)
        master.turn_and_wait("SI06", False)
        master.turn_and_wait("SI12", False)
        master.turn_and_wait("SI06", True)
    master.turn("SI12", True)
    master.run(150)
    assert master.so[35] == 0
    master.run(100)
    assert master.so[35] == 1


def test_a_program_that_another_starts_is_in_a_task_until_its_end_or_a_reset() -> None:
    """Rule: task-table."""
    starting = RobotProgram("P1", steps=("START 2", "WAIT SI(20)=1"), loop=False)
    master = program_master(starting, SECOND)
    master.pulse("SI12")
    assert info(master, 2) == (2, 2, 2, 32)
    master.si[34] = 2
    master.run(10)
    assert states(master) == _only(task1=3)
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    master.si[34] = 0
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    assert states(master) == _only(task1=3, task2=3)
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    assert states(master) == _only(task1=0)


def test_tasks_of_a_low_priority_number_go_first() -> None:
    """Both tasks write SO3().

    The task with the higher priority number runs last in a cycle, so its value remains.

    Rule: priorities.
    """
    programs = [RobotProgram(f"P{k}", steps=(f"SO3()={k}", "WAIT SI(20)=1")) for k in (1, 2)]
    for first, second, last in ((10, 20, 2), (20, 10, 1)):
        master = program_master(*programs)
        master.execute(*telegram(REGISTER, NUMBER, program=1, task=1, priority=first))
        master.execute(*telegram(REGISTER, NUMBER, program=2, task=2, priority=second))
        master.execute(*telegram(EXECUTE, ALL))
        assert master.so[35] == last


def test_the_main_program_is_that_in_task_1_else_program_1() -> None:
    """The test sets the key with which SO(13) shows only the main program.

    Rule: tasks, task-table.
    """
    for task, shown in ((1, True), (3, False)):
        master = program_master(running_shows_all_tasks=False)
        master.execute(*telegram(REGISTER, NUMBER, program=1, task=2, priority=32))
        master.execute(*telegram(REGISTER, NUMBER, program=2, task=task, priority=32))
        master.execute(*telegram(EXECUTE, NUMBER, program=2))
        assert master.on("SO13") is shown
        master.execute(*telegram(EXECUTE, NUMBER, program=1))
        assert master.on("SO13")


def test_registered_tasks_are_those_of_power_on_after_a_power_cycle() -> None:
    """Rule: task-table."""
    master = program_master()
    master.execute(*telegram(REGISTER, NUMBER, program=2, task=1, priority=5))
    master.robot.inject("power_cycle")
    master.run(500)
    assert info(master, 1) == (1, 1, 1, 32)
