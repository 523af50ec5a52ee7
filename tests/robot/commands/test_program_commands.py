"""Commands of category 5 register and run robot programs."""

from __future__ import annotations

import struct

import pytest

from for_each import for_each
from program_commands import (
    ALL,
    EXECUTE,
    FIRST,
    INFO,
    NAME,
    NEXT,
    NO_TASK,
    NUMBER,
    REGISTER,
    RESET,
    SKIP,
    STATES,
    STEP,
    TASK,
    info,
    lines,
    program_master,
    registered_master,
    states,
    telegram,
    text_words,
)
from rcx_harness.robot import RobotProgram
from robot_master import NORMAL_END, abnormal_end

# Registering


def test_the_main_program_is_in_task_1_from_power_on_and_no_other_is_in_a_task() -> None:
    """Rule: task-table."""
    master = program_master()
    assert states(master) == [0, *(NO_TASK,) * 7]
    assert info(master, 1) == (1, 1, 1, 32)


def test_task_number_0_is_the_lowest_vacant_task() -> None:
    """The main program is in task 1. If task 3 is used, the next vacant tasks are 2 and then 4.

    Rule: register-program.
    Source: remote command guide 4.6.1
    """
    programs = [RobotProgram(f"P{number}") for number in range(1, 5)]
    master = program_master(*programs)
    assert master.execute(*telegram(REGISTER, NUMBER, program=2, task=3, priority=1)) == NORMAL_END
    assert master.execute(*telegram(REGISTER, NUMBER, program=3, priority=1)) == NORMAL_END
    assert master.execute(*telegram(REGISTER, NUMBER, program=4, priority=64)) == NORMAL_END
    tasks = [info(master, number)[1] for number in (2, 3, 4)]
    assert tasks == [3, 2, 4]


def test_all_16_tasks_can_be_taken_and_then_no_task_is_vacant() -> None:
    """Rule: task-table. Source: remote command guide 4.6.1."""
    programs = [RobotProgram(f"P{number}") for number in range(1, 18)]
    master = program_master(*programs)
    for number in range(2, 17):
        assert master.execute(*telegram(REGISTER, NUMBER, program=number, priority=1)) == NORMAL_END
    assert master.execute(STATES, 0, 1)[2:10] == (0,) * 8
    last = telegram(REGISTER, NUMBER, program=17, priority=1)
    assert master.execute(*last) == abnormal_end("6.262")
    assert (
        master.execute(*telegram(REGISTER, NUMBER, program=17, task=16, priority=1)) == NORMAL_END
    )


def test_a_program_moves_to_the_task_where_it_is_registered_anew() -> None:
    """The program that was in the task leaves it.

    The new program is at its first line. Rule: task-table.
    """
    master = program_master()
    master.execute(*telegram(REGISTER, NUMBER, program=2, task=2, priority=5))
    master.execute(*telegram(SKIP, NUMBER, program=1))
    master.execute(*telegram(REGISTER, NUMBER, program=1, task=2, priority=6))
    assert lines(master) == [0, 1, 0, 0, 0, 0, 0, 0]
    assert info(master, 1) == (1, 2, 1, 6)
    assert master.execute(*telegram(INFO, NUMBER, program=2)) == abnormal_end("6.262")


def test_a_program_that_lost_its_task_can_be_started_by_another_program() -> None:
    """A second program has taken the task of the first program, and starts the first program.

    The first program had stopped in its second line. It starts at its first line, in the next
    vacant task.

    Rule: task-table.
    """
    second = RobotProgram("SECOND", steps=("START 1", "WAIT SI(21)=1"), loop=False)
    master = program_master(FIRST, second)
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    master.turn_and_wait("SI06", False)
    master.execute(*telegram(REGISTER, NUMBER, program=2, task=1, priority=1))
    master.turn_and_wait("SI06", True)
    master.execute(*telegram(EXECUTE, NUMBER, program=2))
    assert lines(master)[:2] == [2, 2]


def test_a_program_is_found_by_its_name() -> None:
    """The name may be filled with spaces, as in the text, or with zeros, as in the examples.

    Source: remote command guide 4.6.1
    """
    master = program_master()
    assert master.execute(*telegram(REGISTER, NAME, priority=9, name="SECOND")) == NORMAL_END
    assert info(master, 2) == (2, 2, 1, 9)
    zeros = tuple(b"SECOND"[k] | b"SECOND"[k + 1] << 8 for k in range(0, 6, 2))
    assert master.execute(REGISTER, NAME, 0, 5, 9, 0, *zeros) == NORMAL_END
    assert info(master, 2) == (2, 5, 1, 9)


def test_if_names_are_equal_in_16_characters_the_lowest_program_number_counts() -> None:
    """Rule: register-program. Source: remote command guide 4.6.1."""
    long = "ABCDEFGHIJKLMNOP"
    programs = [RobotProgram(name) for name in ("MAIN", f"{long}_3", f"{long}_2")]
    master = program_master(*programs)
    assert master.execute(*telegram(REGISTER, NAME, priority=1, name=long)) == NORMAL_END
    assert info(master, 2)[:2] == (2, 2)
    answer = master.execute(*telegram(INFO, NAME, name=long))
    assert answer[6:14] == text_words(long)


@pytest.mark.parametrize(
    "words",
    [
        telegram(REGISTER, NUMBER, program=3, priority=1),  # only programs 1 and 2 exist
        telegram(REGISTER, NUMBER, program=100, priority=1),
        telegram(REGISTER, NAME, priority=1, name="THIRD"),
        telegram(REGISTER, NAME, priority=1),
    ],
)
def test_a_program_that_is_not_there_cannot_be_registered(words: tuple[int, ...]) -> None:
    """Rule: task-table."""
    master = program_master(undefined_program_alarm="9.1")
    assert master.execute(*words) == abnormal_end("9.1")


@pytest.mark.parametrize(
    "words",
    [
        telegram(REGISTER, ALL, program=1, priority=1),
        telegram(REGISTER, TASK, program=1, task=1, priority=1),
        *[telegram(REGISTER, method, program=1, priority=1) for method in (3, 5, 6, 7)],
        telegram(REGISTER, NUMBER, program=0, priority=1),
        telegram(REGISTER, NUMBER, program=101, priority=1),
        telegram(REGISTER, NUMBER, program=1, task=17, priority=1),
        telegram(REGISTER, NUMBER, program=1, priority=0),
        telegram(REGISTER, NUMBER, program=1, priority=65),
        telegram(REGISTER, NAME, priority=1, name="second"),  # A name has upper case letters only.
        (REGISTER, 0x0100 | NAME, 0, 0, 1, 0, *text_words("FIRST")),
        (REGISTER, NUMBER, 1, 1, 1, 1),
    ],
)
def test_designation_method_numbers_and_priority_have_their_limits(words: tuple[int, ...]) -> None:
    """Source: remote command guide 4.6.1."""
    assert program_master().execute(*words) == abnormal_end("4.2")


def test_a_running_program_is_not_registered_anew_nor_its_task_given_away() -> None:
    """Rule: busy-programs."""
    master = program_master(busy_alarm="9.2")
    master.pulse("SI12")
    for words in (
        telegram(REGISTER, NUMBER, program=1, task=2, priority=1),
        telegram(REGISTER, NUMBER, program=2, task=1, priority=1),
    ):
        assert master.execute(*words) == abnormal_end("9.2")
    assert info(master, 1)[1] == 1


# Running


def test_the_printed_example_runs_program_1_and_so13_shows_it_later() -> None:
    """The normal end says only that the command was received.

    Rule: program-received.
    Source: remote command guide 4.6.2, 1.2
    """
    master = program_master(program_start_delay=100)
    master.send(0x0402, 1, 1, 0)
    assert master.finish() == NORMAL_END
    assert not master.on("SO13")
    master.run(95)
    assert not master.on("SO13")
    master.run(10)
    assert master.on("SO13")


@pytest.mark.parametrize(
    "words",
    [
        telegram(EXECUTE, NUMBER, program=2),
        telegram(EXECUTE, TASK, task=3),
        telegram(EXECUTE, NAME, name="SECOND"),
    ],
)
def test_one_program_runs_by_number_task_or_name(words: tuple[int, ...]) -> None:
    """Source: remote command guide 4.6.2."""
    master = registered_master(3)
    assert master.execute(*words) == NORMAL_END
    assert master.so[35] == 0b100
    assert lines(master) == [1, 0, 2, 0, 0, 0, 0, 0]


def test_all_programs_that_are_in_a_task_run_with_method_0() -> None:
    """Rule: execute-programs. Source: remote command guide 4.6.2."""
    master = registered_master(3)
    assert master.execute(*telegram(EXECUTE, ALL)) == NORMAL_END
    assert master.so[35] == 0b101
    assert master.on("SO13")


def test_the_auto_operation_start_input_runs_all_programs_in_a_task_too() -> None:
    """The start input and the command with method 0 do the same.

    Source: remote command guide 4.6.2.
    """
    master = registered_master(3)
    master.pulse("SI12")
    assert master.so[35] == 0b101


def test_the_start_input_has_no_effect_while_a_program_runs() -> None:
    """SI(12) does not start the other programs while one program runs. Rule: program-start."""
    master = registered_master(3)
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    master.pulse("SI12")
    assert master.so[35] == 0b001


def test_stopped_programs_go_on_and_ended_programs_stay_ended() -> None:
    """Rule: execute-programs."""
    master = registered_master(2)
    master.execute(*telegram(EXECUTE, ALL))
    master.si[34] = 1
    master.run(10)
    assert lines(master) == [1, 2, 0, 0, 0, 0, 0, 0]
    master.drop("SI06")
    master.robot.write_port("SO3()", 0)
    master.execute(*telegram(EXECUTE, ALL))
    master.general_on(21)
    assert master.so[35] == 0b1000
    master.si[34] = 0
    master.execute(*telegram(EXECUTE, ALL))
    assert master.so[35] == 0b1101


def test_two_programs_started_in_a_row_both_run() -> None:
    """The second start command may come before the first program has started."""
    master = registered_master(2, program_start_delay=500)
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    master.execute(*telegram(EXECUTE, NUMBER, program=2))
    assert master.so[35] == 0
    master.run(500)
    assert master.so[35] == 0b101


def test_to_run_a_program_that_runs_is_a_normal_end_without_effect() -> None:
    """Rule: busy-programs."""
    master = program_master()
    for _ in range(2):
        assert master.execute(*telegram(EXECUTE, NUMBER, program=1)) == NORMAL_END
        assert lines(master)[0] == 2
    master.robot.write_port("SO3()", 0)
    master.execute(*telegram(EXECUTE, ALL))
    assert master.so[35] == 0


def test_a_program_that_is_in_no_task_cannot_run() -> None:
    """Rule: task-table."""
    master = program_master(undefined_task_alarm="9.3", undefined_program_alarm="9.1")
    for code in (EXECUTE, STEP, SKIP, NEXT, RESET, INFO):
        assert master.execute(*telegram(code, NUMBER, program=2)) == abnormal_end("9.3")
        assert master.execute(*telegram(code, TASK, task=2)) == abnormal_end("9.3")
        assert master.execute(*telegram(code, NUMBER, program=3)) == abnormal_end("9.1")
        assert master.execute(*telegram(code, NAME, name="THIRD")) == abnormal_end("9.1")


@pytest.mark.parametrize("code", [EXECUTE, STEP, NEXT])
def test_a_program_does_not_run_in_a_stop(code: int) -> None:
    """With SI(06) OFF the command ends in alarm 12.400.

    Rule: execute-programs.
    Source: manual chapter 4, 4.
    """
    master = program_master()
    master.turn_and_wait("SI06", False)
    assert master.execute(*telegram(code, NUMBER, program=1)) == abnormal_end("12.400")
    master.turn_and_wait("SI06", True)
    assert master.so[35] == 0


@pytest.mark.parametrize("code", [EXECUTE, STEP, NEXT])
def test_a_program_does_not_run_in_an_emergency_stop_nor_before_the_alarm_reset(code: int) -> None:
    """Rule: execute-programs. Source: remote command guide 1.2."""
    master = program_master()
    words = telegram(code, NUMBER, program=1)
    master.turn_and_wait("SI00", False)
    assert master.execute(*words) == abnormal_end("12.600")
    master.turn_and_wait("SI00", True)
    assert master.execute(*words) == abnormal_end("12.600")
    master.pulse("SI16")
    assert master.execute(*words) == NORMAL_END


@pytest.mark.parametrize("code", [EXECUTE, STEP, SKIP, NEXT, RESET])
def test_programs_are_run_and_reset_in_auto_mode_only(code: int) -> None:
    """Registering a program and the reference commands also work in MANUAL mode.

    Rule: execute-programs.
    """
    master = program_master(manual_mode_alarm="9.4")
    master.robot.inject("manual_mode")
    assert master.execute(*telegram(code, NUMBER, program=1)) == abnormal_end("9.4")
    assert info(master, 1) == (1, 1, 1, 32)
    register = telegram(REGISTER, NUMBER, program=1, task=1, priority=33)
    assert master.execute(*register) == NORMAL_END


def test_execute_program_needs_the_servos_if_programs_need_them() -> None:
    """Rule: execute-programs, program-servo."""
    master = program_master(program_needs_servo=True, servo_off_alarm="9.5")
    assert master.execute(*telegram(EXECUTE, ALL)) == abnormal_end("9.5")
    master.pulse("SI01")
    assert master.execute(*telegram(EXECUTE, ALL)) == NORMAL_END
    assert master.on("SO13")


@pytest.mark.parametrize("filled", [b"FIRST".ljust(16), b"FIRST".ljust(16, b"\0")])
def test_a_program_name_may_be_filled_with_spaces_or_with_zeros(filled: bytes) -> None:
    """Rule: name-filler.

    Source: remote command guide 4.6.4: spaces in the text, 0x00 in the examples.
    """
    master = program_master()
    words = struct.unpack("<8H", filled)
    assert master.execute(INFO, NAME, 0, 0, 0, 0, *words)[6:14] == text_words("FIRST")


@for_each(
    "name", [b"FIRST\0", b"FIRST \0", b"FIRST\0\0 A", b"FI RST", b" FIRST", b"first", b"FIR\0ST"]
)
@for_each("code", [REGISTER, 0x0402, 0x0403, 0x0404, 0x0405, 0x0406, INFO])
def test_a_name_with_an_inner_space_or_with_both_fillers_is_refused(code: int, name: bytes) -> None:
    """A name has upper case letters, digits and underscores, followed by one kind of filler.

    Rule: name-filler.
    Source: remote command guide 4.6.1 to 4.6.4.
    """
    master = program_master()
    words = struct.unpack("<8H", name.ljust(15) + b" " if b"\0" in name else name.ljust(16))
    priority = 1 if code == REGISTER else 0
    assert master.execute(code, NAME, 0, 0, priority, 0, *words) == abnormal_end("4.2")
