"""Robot programs execute jumps, blocks, subroutines, error handlers and tasks in order."""

from __future__ import annotations

import pytest

from rcx_harness.robot import RobotProgram
from robot_programs import running, started


def trail(text: str, ms: float = 100, **config: object) -> int:
    """Return SGI0 after the program has run.

    The program appends a decimal digit to SGI0 at each line that it passes.
    """
    return int(running(text, ms, **config).robot.machine.memory.variables.value(0))


@pytest.mark.parametrize(
    ("text", "digits"),
    [
        ("SGI0=1\nGOTO *B\nSGI0=9\n*B:\nSGI0=SGI0*10+2", 12),
        ("GOSUB *S\nSGI0=SGI0*10+2\nEND\n*S: SGI0=1\nRETURN", 12),
        ("A%=2\nON A% GOTO *X,*Y\nSGI0=9\n*X: SGI0=1\nEND\n*Y: SGI0=2", 2),
        ("A%=3\nON A% GOTO *X,*Y\nSGI0=9\nEND\n*X: SGI0=1\nEND\n*Y: SGI0=2", 9),
        ("ON 1 GOSUB *X\nSGI0=SGI0*10+2\nEND\n*X: SGI0=1\nRETURN", 12),
        ("IF 1=1 THEN *X\nSGI0=9\nEND\n*X: SGI0=1", 1),
        ("IF 1=2 THEN *X ELSE *Y\n*X: SGI0=9\nEND\n*Y: SGI0=2", 2),
        ("IF 1=1 THEN SGI0=1\nIF 1=2 THEN SGI0=9 ELSE SGI0=SGI0*10+2", 12),
        ("A%=5\nIF A%=1 THEN\nSGI0=1\nELSEIF A%=5 THEN\nSGI0=2\nELSE\nSGI0=3\nENDIF", 2),
        ("A%=7\nIF A%=1 THEN\nSGI0=1\nELSEIF A%=5 THEN\nSGI0=2\nELSE\nSGI0=3\nENDIF", 3),
        ("FOR I%=1 TO 3\nSGI0=SGI0*10+I%\nNEXT I%", 123),
        ("FOR I%=5 TO 1 STEP -2\nSGI0=SGI0*10+I%\nNEXT", 531),
        ("FOR I%=1 TO 0\nSGI0=9\nNEXT\nSGI0=SGI0*10+1", 1),
        ("FOR I%=1 TO 9\nIF I%=3 THEN EXIT FOR\nSGI0=SGI0*10+I%\nNEXT\nSGI0=SGI0*10+7", 127),
        ("WHILE SGI0<50\nSGI0=SGI0*2+1\nWEND", 63),
        (
            "A%=2\nSELECT CASE A%\nCASE 1\nSGI0=1\nCASE 2,3\nSGI0=2\nCASE ELSE\nSGI0=3\nEND SELECT",
            2,
        ),
        ("A%=8\nSELECT A%\nCASE 1\nSGI0=1\nCASE ELSE\nSGI0=3\nEND SELECT", 3),
        ("A%=8\nSELECT A%\nCASE 1\nSGI0=1\nEND SELECT\nSGI0=SGI0*10+4", 4),
        ("B%=2\nCALL ADD(3,REF B%)\nSGI0=B%\nEND\nSUB ADD(X%,Y%)\nY%=Y%*10+X%\nEND SUB", 23),
        ("B%=2\nCALL ADD(B%)\nSGI0=B%\nEND\nSUB ADD(X%)\nX%=9\nEND SUB", 2),
        ("B%=4\nCALL S\nSGI0=B%\nEND\nSUB S\nSHARED B%\nB%=B%+1\nEND SUB", 5),
        ("B%=4\nCALL S\nSGI0=B%\nEND\nSUB S\nB%=9\nEND SUB", 4),
        ("CALL S\nSGI0=SGI0*10+2\nEND\nSUB S\nSGI0=1\nEXIT SUB\nSGI0=9\nEND SUB", 12),
        ("SUB S\nSGI0=9\nEND SUB\nSGI0=1", 1),
        ("SGI0=1 : SGI0=SGI0*10+2 ' a comment", 12),
        ("REM SGI0=9\nSGI0=1", 1),
        ("DIM A%(2)\nA%(0)=1\nA%(2)=2\nSGI0=A%(0)*10+A%(2)", 12),
        ("sgi0=1\ngoto *l\nsgi0=9\n*L:", 1),
    ],
)
def test_a_program_executes_its_statements_in_order(text: str, digits: int) -> None:
    """Each program writes digits in the order of its statements.

    Rule: robot-language.
    """
    assert trail(text) == digits


@pytest.mark.parametrize(
    ("resume", "digits"),
    [
        ("RESUME NEXT", 172),
        ("RESUME *GO", 173),
        ("A%=1\nRESUME", 1712),  # RESUME repeats the statement, which no longer causes an error.
    ],
)
def test_an_error_handler_continues_where_resume_says(resume: str, digits: int) -> None:
    """The handler writes 7 at the division by 0.

    Rule: robot-language.
    """
    text = (
        "ON ERROR GOTO *E\nSGI0=1\nIF 1/A%=1 THEN SGI0=SGI0*10+1\nSGI0=SGI0*10+2\nEND\n"
        f"*GO: SGI0=SGI0*10+3\nEND\n*E: SGI0=SGI0*10+7\n{resume}"
    )
    assert trail(text) == digits


def test_an_error_without_a_handler_stops_the_program_and_is_in_the_history() -> None:
    """A division by 0 stops the program with alarm 6.203, as in the guide's variable operations.

    Rule: robot-language.
    """
    master = running("SGI0=1\nSGI0=1/A%\nSGI0=2")
    assert master.robot.machine.memory.variables.value(0) == 1
    assert not master.on("SO13")
    assert master.robot.program.tasks[0].line == 2
    assert [alarm.number for alarm in master.robot.alarms.history] == ["6.203"]


def test_err_and_erl_show_the_last_error() -> None:
    """Error 6.203 in line 2 is shown as 6 * 65536 + 203 = 393419.

    Rule: robot-language.
    """
    text = "ON ERROR GOTO *E\nA%=1/B%\nEND\n*E: SGI0=ERR(0)\nSGI1=ERL(0)\nRESUME NEXT"
    text = text.replace("ERR(0)", "ERR").replace("ERL(0)", "ERL")
    variables = running(text).robot.machine.memory.variables
    assert (variables.value(0), variables.value(1)) == (393_419, 2)


def test_an_endless_loop_without_a_wait_does_not_stop_the_controller() -> None:
    """A cycle of 5 ms executes 100 statements, so a loop of two statements runs 50 times.

    Rule: program-length.
    """
    master = started("*L: SGI0=SGI0+1\nGOTO *L")
    before = master.robot.machine.memory.variables.value(0)
    master.run(10)
    assert master.robot.machine.memory.variables.value(0) == before + 100


def test_the_number_of_statements_in_a_cycle_is_a_property_of_the_robot() -> None:
    """If a cycle of 5 ms executes 10 statements, a loop of two statements runs 5 times.

    Rule: program-length.
    """
    master = started("*L: SGI0=SGI0+1\nGOTO *L", program_statements=10)
    before = master.robot.machine.memory.variables.value(0)
    master.run(10)
    assert master.robot.machine.memory.variables.value(0) == before + 10


def test_a_gosub_without_end_gets_an_alarm() -> None:
    """The alarm comes at the limit that the key program_stack sets.

    Rule: robot-language.
    """
    master = running("*L: GOSUB *L")
    assert [alarm.number for alarm in master.robot.alarms.history] == ["5.998"]
    assert not master.on("SO13")


@pytest.mark.parametrize(
    ("text", "digits"),
    [
        ("START <SIDE>,T3,10\nDELAY 20\nSGI0=SGI0*10+2", 12),
        ("START <SIDE>\nDELAY 20\nSGI0=SGI0*10+2", 12),
        ("START <SIDE>,T3\nCUT T3\nDELAY 20\nSGI0=SGI0*10+2", 2),
        ("START <SIDE>,T3\nSUSPEND T3\nDELAY 20\nSGI0=5\nRESTART T3\nDELAY 20", 51),
    ],
)
def test_a_program_starts_and_stops_another_one(text: str, digits: int) -> None:
    """SIDE writes a digit 1. In each cycle it runs after MAIN.

    Rule: tasks.
    Source: manual, remote command guide 4.7.5 (states of tasks), 4.6.1 (priority)
    """
    side = RobotProgram("SIDE", text="SGI0=SGI0*10+1")
    master = started(text, side)
    master.run(200)
    assert master.robot.machine.memory.variables.value(0) == digits


def test_halt_ends_the_program_and_hold_stops_it() -> None:
    """After HOLD the next start continues with the next statement.

    After HALT it starts from the beginning.

    Rule: robot-language.
    """
    master = running("SGI0=SGI0*10+1\nHOLD\nSGI0=SGI0*10+2\nHALT\nSGI0=9")
    assert not master.on("SO13")
    assert master.robot.machine.memory.variables.value(0) == 1
    master.pulse("SI12")
    assert master.robot.machine.memory.variables.value(0) == 12
    master.pulse("SI12")
    assert master.robot.machine.memory.variables.value(0) == 121
