"""Commands of category 5 execute single lines, reset programs and read their state."""

from __future__ import annotations

import pytest

from program_commands import (
    ALL,
    EXECUTE,
    FIRST,
    INFO,
    NAME,
    NEXT,
    NUMBER,
    REGISTER,
    RESET,
    SKIP,
    STEP,
    TASK,
    info,
    lines,
    program_master,
    registered_master,
    states,
    telegram,
)
from rcx_harness.robot import RobotProgram
from robot_master import NORMAL_END, abnormal_end

#: A program whose line 1 calls the subroutine in lines 4 to 6.
CALLING = RobotProgram(
    "CALLING",
    steps=("GOSUB *SUB", "SO(31)=1", "END", "*SUB:", "SO(30)=1", "RETURN"),
    loop=False,
)


# Lines


def test_step_executes_one_line_and_enters_the_subroutine() -> None:
    """The program executes lines 1, 4, 5 and 6, then line 2.

    Rule: program-lines.
    Source: remote command guide 4.6.2.
    """
    master = program_master(CALLING)
    seen = []
    for _ in range(5):
        assert master.execute(*telegram(STEP, NUMBER, program=1)) == NORMAL_END
        seen.append((lines(master)[0], master.so[35]))
        assert not master.on("SO13")
    assert seen == [(5, 0), (6, 1), (2, 1), (3, 3), (1, 3)]


def test_next_executes_the_entire_subroutine() -> None:
    """The program executes line 1 with the subroutine in lines 4 to 6, then line 2.

    Rule: program-lines.
    Source: remote command guide 4.6.2
    """
    master = program_master(CALLING)
    seen = []
    for _ in range(3):
        assert master.execute(*telegram(NEXT, NUMBER, program=1)) == NORMAL_END
        seen.append((lines(master)[0], master.so[35]))
    assert seen == [(2, 1), (3, 3), (1, 3)]


def test_next_within_a_subroutine_executes_one_line_of_it() -> None:
    """Rule: program-lines."""
    master = program_master(CALLING)
    master.execute(*telegram(STEP, NUMBER, program=1))
    seen = []
    for _ in range(2):
        master.execute(*telegram(NEXT, NUMBER, program=1))
        seen.append(lines(master)[0])
    assert seen == [6, 2]


def test_skip_leaves_one_line_out() -> None:
    """Rule: program-lines. Source: remote command guide 4.6.2."""
    master = program_master(RobotProgram(steps=("SO(30)=1", "SO(31)=1", "SO(32)=1"), loop=False))
    master.pulse("SI15")
    assert master.execute(*telegram(SKIP, TASK, task=1)) == NORMAL_END
    assert (lines(master)[0], master.so[35], master.on("SO14")) == (2, 0, False)
    master.execute(*telegram(STEP, TASK, task=1))
    assert (lines(master)[0], master.so[35]) == (3, 0b010)
    master.execute(*telegram(SKIP, TASK, task=1))
    assert (lines(master)[0], master.so[35]) == (1, 0b010)


def test_a_program_goes_on_behind_a_line_that_was_skipped() -> None:
    """The program skips the wait in line 2 and then runs on. Rule: program-lines."""
    master = program_master(FIRST)
    master.execute(*telegram(STEP, NUMBER, program=1))
    master.execute(*telegram(SKIP, NUMBER, program=1))
    assert lines(master)[0] == 3
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    assert master.so[35] == 0b11


def test_a_step_in_a_line_that_waits_goes_on_until_it_is_done() -> None:
    """SO(13) is ON during the wait. The next line is not executed.

    Rule: program-lines, program-received.
    """
    master = program_master(FIRST)
    for _ in range(2):
        assert master.execute(*telegram(STEP, NUMBER, program=1)) == NORMAL_END
    assert master.on("SO13")
    assert lines(master)[0] == 2
    master.si[34] = 1
    master.run(10)
    assert not master.on("SO13")
    assert (lines(master)[0], master.so[35]) == (3, 1)


def test_a_program_that_begins_again_is_at_its_first_line_after_the_last_step() -> None:
    """Rule: program-lines."""
    master = program_master(RobotProgram(steps=("SO(30)=1", "SO(31)=1"), loop=True))
    for line in (2, 1, 2):
        master.execute(*telegram(STEP, NUMBER, program=1))
        assert (lines(master)[0], states(master)[0]) == (line, 0)


@pytest.mark.parametrize(("loop", "shown"), [(False, 0b110), (True, 0b111)])
def test_after_its_last_line_a_program_ends_or_begins_again(loop: bool, shown: int) -> None:
    """Running all programs does not start an ended program while another one is ready.

    Rule: program-lines, execute-programs.
    """
    once = RobotProgram("ONCE", steps=("SO(30)=1", "WAIT SI(20)=1"), loop=loop)
    other = RobotProgram("OTHER", steps=("SO(31)=1", "SO(32)=1", "WAIT SI(20)=1"))
    master = program_master(once, other)
    master.execute(*telegram(REGISTER, NUMBER, program=2, priority=32))
    for _ in range(2):
        master.execute(*telegram(SKIP, NUMBER, program=1))
    master.execute(*telegram(EXECUTE, ALL))
    assert master.so[35] == shown


def test_a_program_without_steps_has_one_line_with_its_duration() -> None:
    """Rule: program-length, program-lines."""
    master = program_master(RobotProgram(duration=200))
    master.execute(*telegram(STEP, NUMBER, program=1))
    assert (master.on("SO13"), lines(master)[0]) == (True, 1)
    master.run(200)
    assert (master.on("SO13"), lines(master)[0]) == (False, 1)


def test_a_running_program_is_not_stepped_skipped_or_reset() -> None:
    """Rule: busy-programs."""
    master = program_master(busy_alarm="9.2")
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    for code in (STEP, SKIP, NEXT, RESET):
        assert master.execute(*telegram(code, NUMBER, program=1)) == abnormal_end("9.2")
    assert master.execute(*telegram(RESET, ALL)) == abnormal_end("9.2")
    assert lines(master)[0] == 2


# Reset


def test_so14_shows_that_all_programs_have_been_reset() -> None:
    """Rule: program-received. Source: remote command guide 4.6.3."""
    master = program_master(program_reset_delay=50)
    master.execute(*telegram(STEP, NUMBER, program=1))
    assert not master.on("SO14")
    master.send(*telegram(RESET, ALL))
    assert master.finish() == NORMAL_END
    assert not master.on("SO14")
    master.run(55)
    assert master.on("SO14")


def test_so14_turns_on_when_the_last_program_is_reset() -> None:
    """Rule: busy-programs."""
    master = registered_master(2)
    master.execute(*telegram(SKIP, NUMBER, program=1))
    master.execute(*telegram(SKIP, NUMBER, program=2))
    master.execute(*telegram(RESET, NUMBER, program=2))
    assert (lines(master)[:2], master.on("SO14")) == ([2, 1], False)
    master.execute(*telegram(RESET, TASK, task=1))
    assert (lines(master)[:2], master.on("SO14")) == ([1, 1], True)


def test_two_program_resets_in_a_row_both_take_effect() -> None:
    """Rule: program-received."""
    master = registered_master(2, program_reset_delay=300)
    for number in (1, 2):
        master.execute(*telegram(SKIP, NUMBER, program=number))
    for number in (1, 2):
        master.execute(*telegram(RESET, NUMBER, program=number))
    assert lines(master)[:2] == [2, 2]
    master.run(300)
    assert lines(master)[:2] == [1, 1]


def test_the_reset_input_still_resets_all_after_a_single_reset() -> None:
    """Source: manual chapter 5, 2, SI(15)."""
    master = registered_master(2)
    master.execute(*telegram(RESET, NUMBER, program=2))
    for number in (1, 2):
        master.execute(*telegram(SKIP, NUMBER, program=number))
    master.pulse("SI15")
    assert (lines(master)[:2], master.on("SO14")) == ([1, 1], True)


def test_a_running_program_is_reset_where_the_controller_allows_it() -> None:
    """Rule: program-reset-running."""
    master = program_master(reset_while_running=True)
    master.execute(*telegram(EXECUTE, NUMBER, program=1))
    assert master.execute(*telegram(RESET, NUMBER, program=1)) == NORMAL_END
    assert (lines(master)[0], master.on("SO13"), master.on("SO14")) == (1, False, True)


# Information


def test_the_line_of_the_program_common_is_shown_with_10000_more() -> None:
    """Rule: program-info, program-info-details. Source: remote command guide 4.6.4."""
    master = program_master(RobotProgram("COMMON", steps=("SO(30)=1", "SO(31)=1")))
    assert info(master, 1)[2] == 10001
    master.execute(*telegram(STEP, NUMBER, program=1))
    assert info(master, 1)[2] == 10002


def test_a_running_program_answers_unless_the_controller_refuses_it() -> None:
    """Rule: program-info-details."""
    for answers in (True, False):
        master = program_master(program_info_while_running=answers, busy_alarm="9.2")
        master.execute(*telegram(EXECUTE, NUMBER, program=1))
        answer = master.execute(*telegram(INFO, TASK, task=1))
        assert answer[:6] == ((0x0200, 0, 1, 1, 2, 32) if answers else (*abnormal_end("9.2")[:6],))


def test_a_program_name_is_checked_only_with_the_designation_by_name() -> None:
    """With designation by number, an illegal name is ignored.

    Source: remote command guide 4.6.4.
    """
    master = program_master()
    assert master.execute(INFO, NUMBER, 1, 0, 0, 0, 0x0100)[0] == 0x0200
    assert master.execute(INFO, NAME, 0, 0, 0, 0, 0x0100)[0] == 0x4000
