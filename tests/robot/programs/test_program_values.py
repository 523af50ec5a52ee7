"""Expressions of robot programs use numbers, texts, points and functions."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Point
from rcx_harness.robot.program.expressions import FUNCTIONS
from rcx_harness.robot.program.syntax import SIGNATURES
from robot_programs import POINTS, calculated, running


@pytest.mark.parametrize(
    ("expression", "value"),
    [
        ("1+2*3", 7),
        ("(1+2)*3", 9),
        ("2^3^2", 512),  # operators are evaluated from right to left
        ("-2^2", -4),
        ("7 MOD 3", 1),
        ("-7 MOD 3", -1),
        ("6/3", 2),
        ("7/2", 3.5),
        ("&H1F+&B101", 36),
        ("1.5E2", 150),
        ("5 AND 3", 1),
        ("5 & 3", 1),
        ("5 OR 3", 7),
        ("5 | 3", 7),
        ("5 XOR 3", 6),
        ("NOT 0", -1),
        ("~5", -6),
        ("1=1", -1),
        ("1<>1", 0),
        ("(2<=2)+(2>=3)+(1<2)+(2>1)", -3),
        ("1=1 AND 2=2", -1),
        ("ABS(-3)", 3),
        ("INT(-1.5)", -2),
        ("SQR(16)", 4),
        ("SIN(0)+COS(0)", 1),
        ("ATN(0)+ATN2(0,1)+TAN(0)", 0),
        ("RADDEG(DEGRAD(90))", 90),
        ("ORD(CHR$(66))", 66),
        ("LOC1(P1)+LOC2(P1)", 150),
        ('LEN("ABC")', 3),
        ('VAL("12")+VAL("&H10")', 28),
        ('ORD("A")', 65),
        ('VAL(LEFT$("123",2))', 12),
        ('VAL(MID$("12345",2,3))', 234),
        ('VAL(RIGHT$("123",2))', 23),
        ('VAL(STR$(7)+"1")', 71),
        ('"AB"<"AC"', -1),
        ("DIST(P1,P2)", 94.33981),  # sqrt(80^2 + 50^2)
        ("LOCX(P1)", 100),
        ("LOCY(P3)", 6000),  # in pulses
        ("LOCX(P1+P2)", 120),
        ("LOCX(P1-P2)", 80),
        ("UNKNOWN", 0),  # a variable without a value
    ],
)
def test_an_expression_has_its_value(expression: str, value: float) -> None:
    """Points 1 and 2 are at (100, 50) mm and (20, 0) mm, point 3 at (5000, 6000) pulses.

    Rule: robot-language.
    """
    assert calculated(expression) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    ("name", "value", "expected"),
    [
        ("A%", "2.5", 3),  # rounded, .5 away from 0 (guide 4.4.1)
        ("A%", "-2.5", -3),
        ("A!", "0.1", 0.1),
        ("A", "0.5", 0.5),  # a real number without a type character
        ("SGI5", "2.5", 3),
        ("SGR5", "0.5", 0.5),
    ],
)
def test_a_variable_converts_its_value(name: str, value: str, expected: float) -> None:
    """A value is converted to the type of the variable, as by the remote commands for variables.

    Rule: robot-language.
    Source: manual, remote command guide 4.4.1 (types of variables)
    """
    assert calculated(name, f"{name}={value}") == pytest.approx(expected)


def test_variables_without_a_type_character_can_be_integers() -> None:
    """A setting of the robot decides whether such a variable is an integer or real.

    Rule: robot-language.
    """
    assert calculated("A", "A=0.5", plain_variables="integer") == 1


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("A%=2147483647+1", "6.252"),
        ("A%=1/0", "6.203"),
        ("A!=1E38*1E38", "6.252"),
        ("A%=SQR(-1)", "5.999"),
        ("DIM A%(2)\nA%(3)=1", "5.999"),
        ("P9=P1+P3", "6.205"),
        ("MOVE P,P77", "6.204"),
        ("RESUME", "5.998"),
    ],
)
def test_an_impossible_value_gets_an_alarm(text: str, number: str) -> None:
    """The alarm numbers are those of the corresponding remote commands, if any.

    Rule: robot-language.
    """
    assert [alarm.number for alarm in running(text).robot.alarms.history] == [number]


@pytest.mark.parametrize(
    ("text", "point"),
    [
        (
            "P9= 100.0 -20.5 3.0 90.0 0.0 0.0",
            Point((100_000, -20_500, 3000, 90_000, 0, 0), mm=True),
        ),
        ("P9= 100 -20 3 0 0 0", Point((100, -20, 3, 0, 0, 0))),
        ("P9=100.0 0 0 0 0 0 2", Point((100_000, 0, 0, 0, 0, 0), mm=True, hand=2)),
        ("P9=100.0 5.0", Point((100_000, 5000, 0, 0, 0, 0), mm=True)),
        ("P9=P1", POINTS[1]),
        ("P9=P1+P2", Point((120_000, 50_000, 0, 0, 0, 0), mm=True)),
        ("A%=8\nP[A%+1]=P3", POINTS[3]),
        ("P9=P1\nLOCY(P9)=7.5", Point((100_000, 7_500, 0, 0, 0, 0), mm=True)),
        ("P9=WHERE", Point((0, 0, 0, 0, 0, 0))),
        ("P9=WHRXY", Point((0, 0, 0, 0, 0, 0), mm=True)),
    ],
)
def test_a_point_is_assigned(text: str, point: Point) -> None:
    """Numbers with a decimal point are in mm, others are in pulses.

    Rule: robot-language.
    Source: manual, remote command guide 4.3.1 (point data)
    """
    assert running(text).robot.points[9] == point


def test_shifts_hands_and_pallets_are_assigned() -> None:
    """The statements store the same data as the remote commands, in units of 0.001 mm.

    Rule: robot-language.
    Source: manual, remote command guide 4.3.3 to 4.3.5
    """
    text = "S1= 10.0 -20.0 5.0 -18.0\nH3= 10.0 -2.0 5.0 R\nPDEF(5)=2,3,1,P100\nLOCX(S1)=11.0"
    text += "\nH4=H3\nSGR0=LOCY(H3)"
    memory = running(text).robot.machine.memory
    assert memory.shift(1) == (11_000, -20_000, 5_000, -18_000)
    assert memory.hand(1, 3).data == memory.hand(1, 4).data == (10_000, -2_000, 5_000, 1)
    assert memory.variables.value(256) == -2
    pallet = memory.pallet(5)
    assert (pallet.nx, pallet.ny, pallet.nz, pallet.first) == (2, 3, 1, 100)


def test_time_and_date_functions_read_the_clock() -> None:
    """The clock shows 10:59:59, which is 39,599 s after midnight. The program starts within 1 s.

    Rule: robot-language.
    Source: manual, remote command guide 4.7.13 and 4.7.14 (date and time)
    """
    clock = "2014-03-02 10:59:50"
    master = running("SGI0=TIMER\nSGI1=VAL(LEFT$(DATE$,2))\nSGI2=VAL(MID$(TIME$,4,2))",
                     clock=clock)  # fmt: skip
    variables = master.robot.machine.memory.variables
    assert 39_590 <= variables.value(0) <= 39_592
    assert (variables.value(1), variables.value(2)) == (14, 59)


@pytest.mark.parametrize(("unit", "counted"), [(1, 300), (10, 30)])
def test_tcounter_counts_from_its_reset(unit: int, counted: int) -> None:
    """300 ms are counted in units of 1 ms or of 10 ms.

    Rule: robot-language.
    """
    text = "DELAY 50\nRESET TCOUNTER\nDELAY 300\nSGI0=TCOUNTER"
    variables = running(text, 400, tcounter_ms=unit).robot.machine.memory.variables
    assert counted <= variables.value(0) <= counted + 5


def test_every_function_declares_the_types_of_its_arguments() -> None:
    assert set(SIGNATURES) == set(FUNCTIONS)
