"""Several tasks run at once, and SO(13) and SO(14) show their state."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import pytest

from rcx_harness.robot import RobotProgram
from robot_master import Master, powered_up, servos_on

#: A program that starts the second program and ends at SI(20). The second program ends at SI(21).
MAIN = RobotProgram("MAIN", steps=("START 2", "WAIT SI(20)=1"), loop=False)
SECOND = RobotProgram("SECOND", steps=("SO(30)=1", "WAIT SI(21)=1", "SO(31)=1"), loop=False)


def _running(**config: Any) -> Master:
    master = servos_on(programs=(MAIN, SECOND), **config)
    master.pulse("SI15")
    master.pulse("SI12")
    assert master.so[35] == 1
    return master


def _started(*programs: RobotProgram) -> Master:
    """Return a robot with these programs, after the start of the first program."""
    master = powered_up(programs=programs)
    master.pulse("SI12")
    return master


def _states(master: Master) -> list[str]:
    return [task.state for task in master.robot.program.tasks]


@pytest.mark.parametrize(
    ("knobs", "shown", "states"),
    [
        ({}, True, ["ended", "running"]),
        ({"running_shows_all_tasks": False}, False, ["ended", "running"]),
        ({"main_ends_tasks": True}, False, ["ended", "ended"]),
    ],
)
def test_so13_and_the_other_tasks_after_the_end_of_the_main_program(
    knobs: dict[str, bool], shown: bool, states: list[str]
) -> None:
    """Rule: tasks."""
    master = _running(**knobs)
    assert (master.on("SO13"), master.on("SO14")) == (True, False)
    master.general_on(20)
    assert master.on("SO13") is shown
    assert _states(master) == states


def test_so13_goes_off_with_the_last_task() -> None:
    """Rule: tasks."""
    master = _running()
    master.general_on(20)
    assert master.on("SO13")
    master.general_on(21)
    assert not master.on("SO13")
    assert master.so[35] == 3


def test_a_stop_stops_all_tasks_and_a_start_lets_all_go_on() -> None:
    """Rule: tasks, program-stop, program-restart."""
    master = _running()
    master.turn_and_wait("SI06", False)
    assert _states(master) == ["stopped", "stopped"]
    assert not master.on("SO13")
    master.si[34] |= 2
    master.turn_and_wait("SI06", True)
    assert master.so[35] == 1
    master.pulse("SI12")
    assert _states(master) == ["running", "ended"]
    assert master.so[35] == 3


def test_a_start_continues_stopped_tasks_even_if_the_main_program_has_ended() -> None:
    """Rule: tasks."""
    master = _running()
    master.general_on(20)
    master.drop("SI06")
    master.pulse("SI12")
    assert _states(master) == ["ended", "running"]


def test_a_program_reset_resets_all_tasks() -> None:
    """Rule: tasks, program-reset."""
    master = _running()
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    assert _states(master) == ["ready", "ready"]
    assert (master.on("SO13"), master.on("SO14")) == (False, True)
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    assert _states(master) == ["running", "running"]


def test_an_emergency_stop_stops_all_tasks() -> None:
    """Rule: tasks, program-emergency."""
    master = _running()
    master.turn_and_wait("SI00", False)
    assert _states(master) == ["stopped", "stopped"]


def test_halt_ends_all_tasks() -> None:
    """Rule: tasks."""
    halting = RobotProgram(steps=("START 2", "WAIT SI(20)=1", "HALT", "SO(20)=1"), loop=False)
    master = _started(halting, SECOND)
    master.general_on(20)
    assert _states(master) == ["ended", "ended"]
    assert not master.on("SO13")
    assert master.so[34] == 0


def test_a_task_that_was_started_by_a_later_one_begins_with_the_next_cycle() -> None:
    """A task that a later task starts begins in the next cycle, even if nothing else happens.

    Rule: tasks.
    """
    programs = (
        RobotProgram(steps=("START 3", "WAIT SI(27)=1")),
        RobotProgram(steps=("SO(30)=1", "WAIT SI(27)=1")),
        RobotProgram(steps=("START 2", "WAIT SI(27)=1")),
    )
    master = powered_up(programs=programs, program_start_delay=0)
    master.turn("SI12", True)
    image = bytes(master.si)
    first, second = (master.robot.cycle(master.now_us + k * 5000, image) for k in (0, 1))
    assert (first[35], second[35]) == (0, 1)


def test_tasks_that_so13_does_not_show_are_stopped_and_are_not_reset_while_they_run() -> None:
    """Rule: tasks, program-stop, program-reset-running, stop-alarm."""
    master = _running(running_shows_all_tasks=False)
    master.general_on(20)
    assert (master.on("SO13"), _states(master)) == (False, ["ended", "running"])
    master.pulse("SI15")
    assert (master.on("SO14"), _states(master)) == (False, ["ended", "running"])
    master.turn_and_wait("SI06", False)
    assert _states(master) == ["ended", "stopped"]
    assert [alarm.number for alarm in master.robot.alarms.history] == ["12.400"]
    master.pulse("SI15")
    assert (master.on("SO14"), _states(master)) == (True, ["ready", "ready"])


#: Program of a second task. MAIN suspends it at SI(20) and restarts it at SI(21).
HOLDER = RobotProgram(
    steps=("START 2", "WAIT SI(20)=1", "SUSPEND 2", "WAIT SI(21)=1", "RESTART 2", "WAIT SI(27)=1"),
    loop=False,
)


def test_a_suspended_task_goes_on_with_restart_only() -> None:
    """A stop or SI(12) does not change it, but a program reset does. Rule: tasks."""
    master = _started(HOLDER, SECOND)
    master.general_on(20)
    assert _states(master) == ["running", "suspended"]
    master.turn_and_wait("SI06", False)
    assert _states(master) == ["stopped", "suspended"]
    master.turn_and_wait("SI06", True)
    master.pulse("SI12")
    assert _states(master) == ["running", "suspended"]
    master.general_on(21)
    assert _states(master) == ["running", "ended"]
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    assert _states(master) == ["ready", "ready"]


@pytest.mark.parametrize("state", ["running", "stopped", "suspended"])
def test_start_and_restart_act_on_their_own_states_only(state: str) -> None:
    """START begins a ready or ended task. RESTART continues a suspended task.

    Rule: task-table, tasks.
    """
    first = RobotProgram(
        steps=("START 2", "WAIT SI(20)=1", "START 2", "RESTART 2", "SO(20)=1", "WAIT SI(27)=1"),
        loop=False,
    )
    second = RobotProgram(steps=("WAIT SI(21)=1", "DELAY 10000"), loop=False)
    master = _started(first, second)
    task = master.robot.program.tasks[1]
    master.general_on(21)
    assert task.line == 2
    if state != "running":
        task.pause(master.now_us, state)
    master.general_on(20)
    assert master.so[34] == 1
    assert task.line == 2
    assert task.state == ("running" if state == "suspended" else state)


def test_the_time_of_a_delay_stands_still_in_a_stop_and_that_of_out_does_not() -> None:
    """Rule: tasks."""
    steps = ("OUT SO(20),1000", "DELAY 1000", "SO(30)=1", "WAIT SI(27)=1")
    master = powered_up(programs=(RobotProgram(steps=steps, loop=False),), program_start_delay=0)
    master.turn("SI12", True)
    master.run(500)
    master.turn("SI12", False)
    assert (master.so[34], master.so[35]) == (1, 0)
    master.turn_and_wait("SI06", False, 450)
    assert master.so[34] == 1
    master.run(60)
    assert master.so[34] == 0
    master.turn_and_wait("SI06", True)
    master.turn("SI12", True)
    master.run(490)
    assert master.so[35] == 0
    master.run(20)
    assert master.so[35] == 1


def test_a_program_reset_ends_the_time_of_out_and_the_output_stays() -> None:
    """Rule: outputs-kept."""
    steps = ("OUT SO(20),1000", "WAIT SI(27)=1")
    master = powered_up(programs=(RobotProgram(steps=steps, loop=False),))
    master.pulse("SI12")
    master.turn_and_wait("SI06", False)
    master.pulse("SI15")
    assert master.so[34] == 1
    master.run(2000)
    assert master.so[34] == 1


@pytest.mark.parametrize("shown", [True, False])
def test_a_program_reset_during_a_task_is_not_executed_after_its_end(shown: bool) -> None:
    """A program reset that comes while a task runs is never executed later.

    Rule: program-reset-running, tasks.
    """
    master = _running(running_shows_all_tasks=shown, program_reset_delay=500)
    master.run(500)
    master.pulse("SI12")
    master.general_on(20)
    assert _states(master) == ["ended", "running"]
    master.pulse("SI15")
    master.si[34] |= 2
    master.run(600)
    assert _states(master) == ["ended", "ended"]
    assert not master.on("SO14")


def test_halt_ends_suspended_tasks_too() -> None:
    """Rule: tasks."""
    first = RobotProgram(steps=("START 2", "WAIT SI(20)=1", "SUSPEND 2", "HALT"), loop=False)
    master = _started(first, SECOND)
    master.general_on(20)
    assert _states(master) == ["ended", "ended"]


def test_a_program_that_loops_does_its_steps_again_and_again_at_the_same_pace() -> None:
    """The program switches the output ON for 100 ms and OFF for 200 ms.

    Each repetition takes one more cycle of 5 ms.

    Rule: tasks.
    """
    steps = ("SO(20)=1", "DELAY 100", "SO(20)=0", "DELAY 200")
    master = servos_on(programs=(RobotProgram(steps=steps, loop=True),))
    master.pulse("SI15")
    master.turn("SI12", True)
    seen = []
    for _ in range(300):
        master.run(5)
        seen.append(master.so[34] & 1)
    changes = [k for k in range(1, 300) if seen[k] != seen[k - 1]]
    lengths = [5 * (b - a) for a, b in pairwise(changes)]
    assert lengths[:7] in ([100, 200] * 3 + [100], [100, 205] * 3 + [100]), lengths
