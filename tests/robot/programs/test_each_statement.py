"""Each statement of the table in statements.toml has a program that shows its effect."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import pytest

from rcx_harness.robot import Axis, RobotProgram
from rcx_harness.robot.program.words import words
from robot_master import Master
from robot_programs import started

XY = (Axis(), Axis())
#: Program lines that define points 20 to 24 of a pallet (guide 4.2.5): 3 x 2 positions, 10 mm by 30
#: mm.
PALLET = (
    "P20=0 0 0 0 0 0\nP21=20000 0 0 0 0 0\nP22=0 30000 0 0 0 0\nP23=20000 30000 0 0 0 0\nP24=P20\n"
)


class Case(NamedTuple):
    """A program, its run time [ms], and the values that are expected after it, by name."""

    text: str
    expected: Mapping[str, Any]
    ms: float = 100


def _parameter(name: str) -> Callable[[Master], Any]:
    def read(master: Master) -> list[int]:
        return [master.robot.machine.memory.parameters.get(1, name, place) for place in (0, 1)]

    return read


PARAMETERS = (
    "ACCEL",
    "DECEL",
    "TOLE",
    "OUTPOS",
    "WEIGHT",
    "WEIGHTG",
    "ARCHP1",
    "ARCHP2",
    "AXWGHT",
    "PSHFRC",
    "PSHTIME",
    "PSHMTD",
    "PSHJGSP",
    "PSHSPD",
)  # fmt: skip / : Maps the name of a value that a case can check to its function.
SEEN: dict[str, Callable[[Master], Any]] = {
    "SGI0": lambda master: master.robot.machine.memory.variables.value(0),
    "SO2": lambda master: master.so[34],
    "at": lambda master: tuple(master.robot.positions),
    "states": lambda master: [task.state for task in master.robot.program.tasks],
    "alarms": lambda master: [alarm.number for alarm in master.robot.alarms.history],
    "servos": lambda master: master.robot.machine.servos.states,
    "motor": lambda master: master.on("SO02"),
    "speeds": lambda master: (
        master.robot.machine.arm(1).settings.auto_speed,
        master.robot.machine.arm(1).settings.program_speed,
    ),
    "settings": lambda master: (
        master.robot.machine.arm(1).settings.shift,
        master.robot.machine.arm(1).settings.hand,
        master.robot.machine.arm(1).settings.arm,
    ),
    "pallet": lambda master: master.robot.machine.memory.pallet(5).count,
    "moving": lambda master: master.robot.machine.motion.under_way,
    **{name: _parameter(name) for name in PARAMETERS},
}

#: A case for each word of the language. If a comment names a section, the values are from the
#: guide. SIDE is a second program: it adds 1 to SGI0 and waits for MO(20).
CASES: dict[str, Case] = {
    "GOTO": Case("GOTO *B\nSGI0=9\n*B: SGI0=SGI0+1", {"SGI0": 1}),
    "GOSUB": Case("GOSUB *S\nSGI0=SGI0*10+2\nEND\n*S: SGI0=1\nRETURN", {"SGI0": 12}),
    "RETURN": Case("GOSUB *S\nSGI0=SGI0+1\nEND\n*S:\nRETURN\nSGI0=9", {"SGI0": 1}),
    "IF": Case("IF 2 THEN SGI0=1 ELSE SGI0=2", {"SGI0": 1}),
    "ELSEIF": Case("IF 0 THEN\nSGI0=1\nELSEIF 1 THEN\nSGI0=2\nENDIF", {"SGI0": 2}),
    "ELSE": Case("IF 0 THEN\nSGI0=1\nELSE\nSGI0=2\nENDIF", {"SGI0": 2}),
    "ENDIF": Case("IF 0 THEN\nSGI0=1\nENDIF\nSGI0=SGI0+5", {"SGI0": 5}),
    "FOR": Case("B%=3\nFOR I%=1 TO B% STEP 2\nB%=9\nSGI0=SGI0*10+I%\nNEXT", {"SGI0": 13}),
    "NEXT": Case("FOR I%=1 TO 2\nFOR J%=1 TO 2\nSGI0=SGI0+1\nNEXT J%\nNEXT I%", {"SGI0": 4}),
    "EXIT": Case("FOR I%=1 TO 9\nIF I%=4 THEN EXIT FOR\nSGI0=I%\nNEXT", {"SGI0": 3}),
    "WHILE": Case("WHILE SGI0<3\nSGI0=SGI0+1\nWEND", {"SGI0": 3}),
    "WEND": Case("WHILE 0\nSGI0=1\nWEND\nSGI0=SGI0+2", {"SGI0": 2}),
    "SELECT": Case("SELECT CASE 3\nCASE 1,3\nSGI0=1\nCASE 3\nSGI0=2\nEND SELECT", {"SGI0": 1}),
    "CASE": Case("SELECT 9\nCASE 1\nSGI0=1\nCASE ELSE\nSGI0=2\nEND SELECT", {"SGI0": 2}),
    "ON": Case("ON 2 GOTO *A,*B\nEND\n*A: SGI0=1\nEND\n*B: SGI0=2", {"SGI0": 2}),
    "SUB": Case("CALL S(7)\nEND\nSUB S(A%)\nSGI0=A%\nEND SUB", {"SGI0": 7}),
    "CALL": Case("B%=1\nCALL S(REF B%)\nSGI0=B%\nEND\nSUB S(A%)\nA%=8\nEND SUB", {"SGI0": 8}),
    "SHARED": Case("B%=1\nCALL S\nSGI0=B%\nEND\nSUB S\nSHARED B%\nB%=6\nEND SUB", {"SGI0": 6}),
    "DECLARE": Case("DECLARE SUB S(A%)\nSGI0=1", {"SGI0": 1, "alarms": []}),
    "HALT": Case("SGI0=1\nHALT\nSGI0=2", {"SGI0": 1, "states": ["ended", "ready"]}),
    "HALTALL": Case("START <SIDE>\nDELAY 20\nHALTALL", {"states": ["ended", "ended"]}),
    "HOLD": Case("SGI0=1\nHOLD\nSGI0=2", {"SGI0": 1, "states": ["stopped", "ready"]}),
    "HOLDALL": Case("START <SIDE>\nDELAY 20\nHOLDALL", {"states": ["stopped", "stopped"]}),
    "END": Case("SGI0=1\nEND\nSGI0=2", {"SGI0": 1, "states": ["ended", "ready"]}),
    "RESUME": Case(
        "ON ERROR GOTO *E\nA%=1/0\nSGI0=SGI0*10+2\nEND\n*E: SGI0=1\nRESUME NEXT", {"SGI0": 12}
    ),
    # guide 4.7.5: RUN, STOP and so on are the states of tasks
    "START": Case("START <SIDE>,T2\nWAIT SI(20)=1", {"SGI0": 1, "states": ["running", "running"]}),
    "SUSPEND": Case(
        "START <SIDE>,T2\nDELAY 20\nSUSPEND T2\nWAIT SI(20)=1", {"states": ["running", "suspended"]}
    ),
    "RESTART": Case(
        "START <SIDE>,T2\nDELAY 20\nSUSPEND T2\nRESTART T2\nWAIT SI(20)=1",
        {"states": ["running", "running"]},
    ),
    "CUT": Case(
        "START <SIDE>,T2\nDELAY 20\nCUT T2\nWAIT SI(20)=1", {"states": ["running", "ended"]}
    ),
    # chapter 1, 4.1: SO2() is byte m+34; chapter 3, 2: ports
    "SET": Case("SET SO(23)", {"SO2": 8}),
    "RESET": Case("SO2()=&HFF\nRESET SO(20)", {"SO2": 0xFE}),
    "OUT": Case("OUT SO(20),60000\nSO(21)=1", {"SO2": 3}),
    "DELAY": Case("SO(20)=1\nDELAY 60000\nSO(21)=1", {"SO2": 1}),
    "WAIT": Case("SO(20)=1\nWAIT SI(20)=1,60000\nSO(21)=1", {"SO2": 1}),
    # guide 4.2.1 to 4.2.5, 4.2.21, 4.2.23: 1000 pulses are 1 mm here
    "MOVE": Case("MOVE P,P1\nMOVE L,P2", {"at": (20_000, 0), "alarms": []}, 1500),
    "MOVEI": Case("MOVEI P,P2\nMOVEI P,P2", {"at": (40_000, 0), "alarms": []}, 1500),
    "MOVET": Case("MOVET P,P2", {"at": (20_000, 0), "alarms": []}, 1000),
    "DRIVE": Case("DRIVE(2,777)", {"at": (0, 777), "alarms": []}, 500),
    "DRIVEI": Case("DRIVEI(2,5.0)\nDRIVEI(2,-1.0)", {"at": (0, 4_000), "alarms": []}, 500),
    "PMOVE": Case(PALLET + "PDEF(1)=3,2,1,P20\nPMOVE(1,5)", {"at": (10_000, 30_000)}, 1000),
    "PUSH": Case("PUSH(1,10.0)", {"at": (10_000, 0), "alarms": []}, 1000),
    "PATH": Case(
        "PATH SET\nPATH L,P2\nPATH L,P1\nPATH END\nPATH START", {"at": (100_000, 50_000)}, 2000
    ),
    # guide 4.2.16, 4.2.17 (speeds), 4.4.2 (table of parameters; its example is TOLE of axis 3)
    "SPEED": Case("SPEED 40", {"speeds": (100, 40)}),
    "ASPEED": Case("ASPEED 30", {"speeds": (30, 100)}),
    "ACCEL": Case("ACCEL 100\nACCEL(2)=1", {"ACCEL": [100, 1], "alarms": []}),
    "DECEL": Case("DECEL 1\nDECEL(1)=100", {"DECEL": [100, 1], "alarms": []}),
    "TOLE": Case("TOLE(2)=1000\nTOLE(1)=16384", {"TOLE": [16384, 1000], "alarms": []}),
    "OUTPOS": Case("OUTPOS(1)=9999999\nOUTPOS(2)=1", {"OUTPOS": [9_999_999, 1], "alarms": []}),
    "WEIGHT": Case("WEIGHT 2", {"WEIGHT": [2, 2], "WEIGHTG": [2000, 2000]}),
    "WEIGHTG": Case("WEIGHTG 3560", {"WEIGHTG": [3560, 3560], "WEIGHT": [3, 3]}),
    "ARCHP1": Case("ARCHP1(2)=9999999", {"ARCHP1": [2000, 9_999_999], "alarms": []}),
    "ARCHP2": Case("ARCHP2(2)=1", {"ARCHP2": [2000, 1], "alarms": []}),
    "AXWGHT": Case("AXWGHT(2)=3", {"AXWGHT": [0, 3], "alarms": []}),
    "PSHFRC": Case("PSHFRC(2)=-1000", {"PSHFRC": [100, -1000], "alarms": []}),
    "PSHTIME": Case("PSHTIME(2)=32767", {"PSHTIME": [1000, 32767], "alarms": []}),
    "PSHMTD": Case("PSHMTD(2)=1", {"PSHMTD": [0, 1], "alarms": []}),
    "PSHJGSP": Case("PSHJGSP(2)=100", {"PSHJGSP": [0, 100], "alarms": []}),
    "PSHSPD": Case("PSHSPD(2)=1", {"PSHSPD": [100, 1], "alarms": []}),
    # guide 4.2.15, 4.2.18, 4.2.19: shift, hand, arm designation (0 right-handed, 1 left-handed)
    "SHIFT": Case("SHIFT S3", {"settings": (3, 0, 0)}),
    "CHANGE": Case("CHANGE H2", {"settings": (0, 2, 0)}),
    "RIGHTY": Case("LEFTY\nRIGHTY", {"settings": (0, 0, 0), "alarms": []}),
    "LEFTY": Case("LEFTY", {"settings": (0, 0, 1), "alarms": []}),
    "ARMSEL": Case("ARMSEL 1", {"settings": (0, 0, 1), "alarms": []}),
    # guide 4.2.12, 4.2.13, 4.2.20: 0 motor OFF, 1 servo ON, 2 servo free
    "SERVO": Case("SERVO FREE(2)", {"servos": [1, 2], "alarms": []}, 500),
    "MOTOR": Case("MOTOR OFF", {"motor": False, "alarms": []}, 500),
    "ORIGIN": Case("MOVE P,P2\nWAIT ARM\nORIGIN\nSO(20)=1", {"SO2": 1, "alarms": []}, 2000),
    "PDEF": Case("PDEF(5)=2,3,4,P10", {"pallet": 24}),
    "DIM": Case("DIM A%(2)\nA%(0)=1\nA%(2)=4\nSGI0=A%(0)+A%(1)+A%(2)", {"SGI0": 5}),
    "LET": Case("LET A%=3\nSGI0=A%", {"SGI0": 3}),
    "REM": Case("SGI0=1 ' SGI0=2\nREM SGI0=3", {"SGI0": 1}),
}
#: Further forms of a statement.
FORMS: dict[str, Case] = {
    "EXIT TASK": Case("SGI0=1\nEXIT TASK\nSGI0=2", {"SGI0": 1, "states": ["ended", "ready"]}),
    # Without a handler the error stops the program, and its alarm is in the history.
    "ON ERROR GOTO 0": Case(
        "ON ERROR GOTO *E\nON ERROR GOTO 0\nSGI0=1\nSGI0=1/0\nEND\n*E: SGI0=3",
        {"SGI0": 1, "states": ["stopped", "ready"]},
    ),
    "ON GOSUB": Case("ON 2 GOSUB *A,*B\nSGI0=SGI0*10+5\nEND\n*A: RETURN\n*B: SGI0=2\nRETURN",
                     {"SGI0": 25}),
    "RESUME": Case("ON ERROR GOTO *E\nSGI0=6/A%\nEND\n*E: A%=2\nRESUME", {"SGI0": 3}),
    "RESUME *L": Case("ON ERROR GOTO *E\nSGI0=1/0\n*L: SGI0=SGI0+4\nEND\n*E: SGI0=1\nRESUME *L",
                      {"SGI0": 5}),
}  # fmt: skip
EXECUTED = [word.name for word in words().values() if not word.instead]


@pytest.mark.parametrize("word", EXECUTED)
def test_the_program_of_each_statement_shows_its_effect(word: str) -> None:
    """Expected values come from the guide if it gives them. The others are calculated by hand.

    Rule: robot-language.
    Source: manual, remote command guide 4.2, 4.4.2, 4.7.5; chapter 1, 4.1; chapter 3, 2
    """
    text, expected, ms = CASES[word]
    side = RobotProgram("SIDE", text="SGI0=SGI0+1\nWAIT MO(20)=1")
    master = started(text, side, axes=XY)
    master.run(ms)
    assert {name: SEEN[name](master) for name in expected} == expected


@pytest.mark.parametrize("form", FORMS)
def test_the_program_of_each_form_shows_its_effect(form: str) -> None:
    """Rule: robot-language. Source: remote command guide 4.7.5 for the states of tasks."""
    text, expected, ms = FORMS[form]
    master = started(text, RobotProgram("SIDE", text="SGI0=9"), axes=XY)
    master.run(ms)
    assert {name: SEEN[name](master) for name in expected} == expected


def test_each_statement_has_a_program_that_uses_it() -> None:
    """Every statement in the table occurs in the program of a case."""
    assert list(CASES) == EXECUTED
    unused = [word for word, case in CASES.items() if word not in case.text and word != "REM"]
    assert unused == []
