"""The reader of robot programs reports errors with their lines, and reads files."""

from __future__ import annotations

from pathlib import Path

import pytest
from lark import Lark

from rcx_harness.robot import Pallet, Point, RobotConfig
from rcx_harness.robot.controller_memory import Parameters
from rcx_harness.robot.program import read_program
from rcx_harness.robot.program.all_file import read_all
from rcx_harness.robot.program.checks import endless_loops, problems
from rcx_harness.robot.program.words import words
from structured_text.errors import InputError


def errors_of(text: str) -> list[str]:
    """Return all errors of a program as `line: message`."""
    program, errors = read_program(text)
    if program is not None:
        errors = problems(program, 48, ("MAIN", "SIDE"))
    return [f"{error.line}: {error.message}" for error in errors]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("PRINT A", "1: PRINT is not executed by the virtual controller"),
        ("MOOVE P,P1", "1: unknown statement MOOVE"),
        ("A=1\nMOVE P", "2: cannot read 'MOVE P': a target is missing after 'P'"),
        ("GOTO *X", "1: there is no label *X"),
        ("*A:\n*A:", "2: the label *A occurs twice"),
        ("IF A=1 THEN", "1: this IF has no ENDIF"),
        ("ELSE", "1: ELSE without IF"),
        ("WEND", "1: WEND without WHILE"),
        ("IF A THEN\nELSE\nELSEIF B THEN\nENDIF", "3: ELSEIF follows ELSE"),
        ("FOR I%=1 TO 2\nNEXT J%", "2: NEXT J% ends FOR I%"),
        ("EXIT FOR", "1: EXIT FOR is outside of FOR ... NEXT"),
        ("CALL X(1)", "1: there is no SUB X"),
        ("SUB A\nCALL A\nEND SUB", "2: SUB A calls itself"),
        ("IF A THEN B=1 : C=2", "1: a statement follows an IF on the same line; it could belong "
         "to the IF or not"),
        ("WAIT DI(99)=1", "1: DI(99) is not a port"),
        ("SOW(24)=1", "1: SOW(24) needs the extended area"),
        ("SI(20)=1", "1: SI(20) is an input of the robot"),
        ("DO()=1", "1: DO() names no port"),
        ("MOVE P,P1,FOO=3", "1: FOO is not an option of a movement"),
        ("MOVE C,P1", "1: MOVE C needs two points for each arc: a point on the way, and the "
         "target"),
        ("MOVE P,P1,SO(20)=1@10", "1: an output on the way needs a line or an arc"),
        ("PUSH(1,P1),(2,P1)", "1: PUSH has one axis"),
        ("PATH P,P1", "1: PATH P does not exist"),
        ("PATH L,P1,CONT", "1: this option cannot be used in a path"),
        ("PATH C,P1", "1: PATH C needs two points for each arc: a point on the way, and the "
         "target"),
        ("SERVO PWR", "1: SERVO PWR does not exist"),
        ("MOTOR FREE", "1: MOTOR FREE does not exist"),
        ("WAIT SI(20)=", "1: cannot read 'WAIT SI(20)=': a value is missing after '='"),
        ("WAIT SI(20)=1 AND", "1: cannot read 'WAIT SI(20)=1 AND': a value is missing after "
         "'AND'"),
        ("SO(20)", "1: cannot read 'SO(20)': '=' is missing after 'SO(20)'"),
        ("A%=(1+2", "1: cannot read 'A%=(1+2': ')' is missing after '2'"),
        ("FOR I%=1", "1: cannot read 'FOR I%=1': TO is missing after '1'"),
        ("GOSUB", "1: cannot read 'GOSUB': a label such as *LOOP is missing after 'GOSUB'"),
        ("DELAY", "1: cannot read 'DELAY': a value is missing after 'DELAY'"),
        ("DRIVE(1", "1: cannot read 'DRIVE(1': ',' is missing after '1'"),
        ('A%="1"', "1: a number is needed here, but this is a text"),
        ("A$=1", "1: a text is needed here, but this is a number"),
        ("A%=P1", "1: a number is needed here, but this is a point"),
        ("P1=5", "1: a point is needed here, but this is a number"),
        ("S1=P1+P2", "1: a shift is needed here, but this is a point"),
        ('WAIT "A"=1', "1: a text is compared with a number"),
        ('A$="A"+1', "1: a text and a number cannot be added"),
        ("A%=P1*2", "1: this operation is not possible with a point"),
        ("A%=SQR(1,2)", "1: SQR has 1 argument, and 2 are given"),
        ('A%=ABS("1")', "1: ABS needs a number, and this is a text"),
        ("A%=LOCX(5)", "1: LOCX needs a point or a shift or a hand, and this is a number"),
        ("A%(1)=1", "1: there is no array or function A%"),
        ("TIMER=5", "1: TIMER is a function; it cannot be assigned"),
        ("START <NONE>", "1: there is no program NONE"),
        ("START <SIDE>,T17", "1: there is no task T17"),
        ("MOVE[5] P,P1", "1: there is no robot 5"),
        ("A=" + "1+" * 200 + "1", "1: the line has 403 characters"),
    ],
)  # fmt: skip
def test_an_error_is_reported_with_its_line(text: str, expected: str) -> None:
    """Rule: robot-language."""
    assert errors_of(text) == [expected]


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("A%=B%+1*2", "A%=B%+7*30"),
        ("MOVE P,P1,S=50,ACC=3", "MOVE P,P30,S=7,ACC=4"),
        ("*A: IF A%=1 THEN *A ELSE *B\n*B:", "*C: IF A%=2 THEN *C ELSE *D\n*D:"),
        ("MOVE[2] P,P[3]", "MOVE[1] P,P[4]"),
        ("SO(20)=1", "SO(21)=0"),
        ("S1=1.0 2 3 4", "S2=1.0 2 3 5"),
        ("WAIT SIW(2)=12,500", "WAIT SIW(3)=5,10"),
        ("A%(1,2)=P1X", "A%(3,4)=P1X"),
        ("ON ERROR GOTO 0", "ON ERROR GOTO 7"),
        ("START 1,T2,10", "START 2,T3,20"),
        ("PMOVE(1,2),A3=10{1,2}", "PMOVE(3,4),A3=20{5,6}"),
        ("SGI1=1.5+2", "SGI2=2.5+3"),
        ("A%=&H1F+1", "A%=&H2F+2"),
    ],
)
def test_statements_that_differ_in_their_numbers_keep_them(text: str, other: str) -> None:
    """A statement keeps its own numbers, even if a similar statement was read before it.

    Rule: robot-language.
    """
    programs = [read_program(one)[0] for one in (other, text, f"{other}\n{text}")]
    first, second, both = (one.code for one in programs if one is not None)
    shown = [[(one.kind, one.args) for one in code] for code in (first, second, both)]
    assert shown[2] == shown[0] + shown[1]
    assert shown[0] != shown[1]


def test_ten_thousand_lines_need_the_parser_for_few_statements(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Reading a large program takes less than 1 s, because similar lines are parsed once."""
    text = "\n".join(
        f"*L{k}:\nA%=A%+{k}*2\nMOVE P,P{k},S=50,CONT\nIF SI(20)=1 AND A%>{k} THEN *L{k}"
        for k in range(2500)
    )
    calls = []
    explain = Lark.parse

    def counted(lark: object, statement: str) -> object:
        calls.append(statement)
        return explain(lark, statement)  # type: ignore[arg-type]

    monkeypatch.setattr(Lark, "parse", counted)
    program, errors = read_program(text)
    assert errors == []
    assert program is not None
    assert len(program.texts) == 10_000
    assert len(calls) <= 3


def test_all_errors_are_reported_at_once() -> None:
    """Rule: robot-language."""
    assert errors_of("PRINT A\nA=1\nGOTO *X\nNEXT") == [
        "1: PRINT is not executed by the virtual controller",
        "3: there is no label *X",
        "4: NEXT without FOR",
    ]


@pytest.mark.parametrize("word", [one for one in words().values() if one.instead],
                         ids=lambda word: word.name)  # fmt: skip
def test_a_statement_that_is_not_executed_is_refused_by_its_name(word: object) -> None:
    """Rule: robot-language."""
    name, instead = word.name, word.instead  # type: ignore[attr-defined]
    _, errors = read_program(f"{name} 1")
    assert [error.message for error in errors] == [
        f"{name} is not executed by the virtual controller"
    ]
    assert errors[0].hint == instead


@pytest.mark.parametrize(
    ("text", "lines"),
    [
        ("A=1\n*L:\nB=2\nGOTO *L", [3]),
        ("WHILE 1=1\nA=2\nWEND", []),  # the condition can become false
        ("*L: WAIT SI(20)=1\nGOTO *L", []),
        ("*L: MOVE P,P1\nGOTO *L", []),
        ("*L: IF SI(20)=1 THEN *E\nGOTO *L\n*E: A=1", []),
    ],
)
def test_an_endless_loop_without_a_wait_is_reported(text: str, lines: list[int]) -> None:
    """Rule: robot-language."""
    program, _ = read_program(text)
    assert program is not None
    assert endless_loops(program) == lines


ALL = """\
[PGM]
NAME=MAIN
MOVE P,P1
NAME=SIDE

SO(20)=1
[PNT]
P1   =  100.00   50.00  0.00 0.00 0.00 0.00
P2= 10 20 0 0 0 0 1
[PCM]
PC1=PICK
[SFT]
S1= 1.00 2.00 3.00 4.00
[HND]
H1= 0.00 150.00 15.00 R
[PLT]
PL3
NX=2
NY=3
NZ=1
PLP=100
PL4
NX=5 NY=6 NZ=7 PLP=200
[SGI]
SGI5=50
[SGR]
SGR5=0.5
[PRM]
/ACCEL/'Accel coefficient
A1=80 A2=300
M3=70
/WEIGHTG/
R1=1500
/PLMT+/
A1=100000
TOLE=50
[XYZ]
unknown
[END]
"""


def test_a_robot_file_takes_all_data_from_a_controller_file(tmp_path: Path) -> None:
    """If the robot file contains the same data, they replace those of the controller file.

    Rule: robot-language.
    """
    (tmp_path / "CELL.ALL").write_text(ALL)
    robot = tmp_path / "robot.toml"
    robot.write_text('data_file = "CELL.ALL"\n[points.2]\npulses = [7]\n')
    config = RobotConfig.load(robot)
    assert [(one.name, one.text) for one in config.programs] == [
        ("MAIN", "MOVE P,P1"),
        ("SIDE", "\nSO(20)=1"),
    ]
    assert config.points == {
        1: Point((100_000, 50_000, 0, 0, 0, 0), mm=True),
        2: Point((7, 0, 0, 0, 0, 0)),
    }
    assert config.comments == {1: "PICK"}
    assert config.shifts == {1: (1000, 2000, 3000, 4000)}
    assert config.hands[1, 1].data == (0, 150_000, 15_000, 1)
    assert config.pallets == {3: Pallet(2, 3, 1, 100), 4: Pallet(5, 6, 7, 200)}
    assert config.variables == {"SGI5": 50, "SGR5": 0.5}
    assert len(config.axes) == 4
    assert config.parameters == {
        "ACCEL": (80, 100, 70, 100),  # a value of 300 % is too large
        "WEIGHTG": (1500, 0, 0, 0),
        "TOLE": (50, 50, 50, 50),
    }


def test_what_a_controller_file_has_besides_is_named(tmp_path: Path) -> None:
    """The reader names a parameter that the guide does not have, and a value that is too large.

    Rule: robot-language.
    Source: manual, remote command guide 4.4.2 (ACCEL is 1 to 100)
    """
    (tmp_path / "CELL.ALL").write_text(ALL)
    content = read_all(tmp_path / "CELL.ALL")
    assert content.parameters["ACCEL"] == {1: 80, 3: 70}
    assert [text.partition(": ")[2] for text in content.passed_over] == [
        "A2=300",
        "parameter PLMT+",
        "section [XYZ]",
    ]


def test_a_line_that_is_not_an_entry_of_its_section_is_named(tmp_path: Path) -> None:
    """Rule: robot-language."""
    (tmp_path / "CELL.ALL").write_text("[PNT]\nP1= 1 2 3 4 5 6\nno point\nS1= 1 2 3 4\n[END]\n")
    content = read_all(tmp_path / "CELL.ALL")
    assert sorted(content.points) == [1]
    assert content.passed_over == ["line 3: no point", "line 4: S1= 1 2 3 4"]


def test_a_task_behind_the_last_statement_is_in_the_last_line() -> None:
    """A task that has executed all statements is in the last line, which is a comment here.

    Rule: robot-language.
    """
    program, errors = read_program("A%=1\nB%=2\n'end")
    assert program is not None
    assert not errors
    assert [program.line(at) for at in range(len(program.code) + 1)] == [1, 2, 3]


def test_a_long_statement_is_shortened_in_the_message() -> None:
    """The message shows the first 40 characters of a statement.

    Rule: robot-language.
    """
    texts = ["HALT " + "+" * length for length in (35, 36)]
    messages = [str(error) for text in texts for error in read_program(text)[1]]
    assert f"'{texts[0]}'" in messages[0]
    assert f"'{texts[1][:40]}...'" in messages[1]


def test_parameters_of_the_robot_file_override_those_of_the_controller_file(tmp_path: Path) -> None:
    """Rule: robot-language."""
    (tmp_path / "CELL.ALL").write_text("[PRM]\n/WEIGHTG/ R1=1500\nACCEL(2)=60\nDECEL=50")
    robot = tmp_path / "robot.toml"
    robot.write_text('data_file = "CELL.ALL"\n[parameters]\nWEIGHT = 3\nACCEL = [10, 20, 30, 40]\n')
    parameters = Parameters(RobotConfig.load(robot))
    assert parameters.get(1, "WEIGHTG") == 3000
    assert [parameters.get(1, "ACCEL", place) for place in (0, 1)] == [10, 20]
    assert [parameters.get(1, "DECEL", place) for place in (0, 1)] == [50, 50]


def test_a_robot_file_names_a_program_file(tmp_path: Path) -> None:
    """Rule: robot-language."""
    (tmp_path / "Pick 1.pgm").write_text("SO(20)=1\n")
    robot = tmp_path / "robot.toml"
    robot.write_text('[[programs]]\nfile = "Pick 1.pgm"\n')
    assert [one.name for one in RobotConfig.load(robot).programs] == ["PICK_1"]
    (tmp_path / "Pick 1.pgm").write_text("SO(21)=1\n")  # The file is read again after a change.
    assert RobotConfig.load(robot).programs[0].text == "SO(21)=1\n"


@pytest.mark.parametrize(
    ("name", "content", "robot", "message"),
    [
        ("A.PGM", "X=1\nGOTO *L", '[[programs]]\nfile = "A.PGM"', "A.PGM:2: there is no label *L"),
        ("A.PGM", "SOW(24)=1", '[[programs]]\nfile = "A.PGM"', "A.PGM:1: SOW(24) needs the"),
        ("A.ALL", "[PGM]\nNAME=A\n\nNEXT", 'data_file = "A.ALL"', "A.ALL:4: NEXT without FOR"),
        (
            "A.ALL",
            "MOVE P,P1",
            'data_file = "A.ALL"',
            "A.ALL: the file has no section such as [PGM]",
        ),
        (
            "A.ALL",
            "[PGM]\nNAME=A\nNAME=A",
            'data_file = "A.ALL"',
            "A.ALL:3: there are two programs",
        ),
        (
            "A.PGM",
            "X=1\0",
            '[[programs]]\nfile = "A.PGM"',
            "A.PGM:1: this is not a text: it contains the byte 00",
        ),
        ("A.PGM", "X=1\nY=\x07", '[[programs]]\nfile = "A.PGM"', "A.PGM:2: this is not a text"),
        ("A.PGM", " \n", '[[programs]]\nfile = "A.PGM"', "A.PGM: the program has no statement"),
        ("A.PGM", "", '[[programs]]\nfile = "B.PGM"', "B.PGM: cannot read it"),
        ("A.PGM", "", '[[programs]]\nfile = "A.PGM"\nsteps = []', "'steps' and 'file' exclude"),
        ("A.PGM", "", "data_file = 3", "'data_file' must be the name of a file"),
    ],
)
def test_a_wrong_program_file_is_refused_with_its_line(
    tmp_path: Path, name: str, content: str, robot: str, message: str
) -> None:
    """Rule: robot-language."""
    (tmp_path / name).write_text(content)
    (tmp_path / "robot.toml").write_text(robot)
    with pytest.raises(InputError) as caught:
        RobotConfig.load(tmp_path / "robot.toml")
    assert message in str(caught.value)
