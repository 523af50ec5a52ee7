"""Compare, compute, move and logical instructions of ladder in an L5X.

Expected values are calculated by hand. Source: Rockwell 1756-RM003, compare, compute, move and
conversion instructions, and data conversions.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from l5x_ladder import main_body, program, written
from structured_text.projects.model import Foreign


def _result(folder: Path, rung: str, name: str, **values: object) -> object:
    """Return a tag after one scan of a rung that begins with some values."""
    running = program(written(folder, [rung]))
    for tag, value in values.items():
        running.write(f"Main.{tag}", value)
    running.scan(0)
    return running.read(f"Main.{name}")


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ("EQU EQ", (False, True, False)),
        ("NEQ NE", (True, False, True)),
        ("LES LT", (True, False, False)),
        ("LEQ LE", (True, True, False)),
        ("GRT GT", (False, False, True)),
        ("GEQ GE", (False, True, True)),
    ],
)
def test_comparisons_pass_power(tmp_path: Path, names: str, expected: tuple[bool, ...]) -> None:
    """An INT is compared with 4.0 as REAL; the old and the new name mean the same."""
    for name in names.split():
        found = tuple(
            _result(tmp_path, f"{name}(v,4.0)OTE(a);", "a", v=value) for value in (-3, 4, 5)
        )
        assert found == expected


def test_lim_passes_inside_its_limits_or_outside_of_reversed_ones(tmp_path: Path) -> None:
    """With the low limit above the high one, LIM passes at the limits and outside of them.

    Source: 1756-RM003, LIM.
    """
    inside = [False, True, True, True, False]
    for rung in ("LIM(2,i,4)OTE(a);", "LIMIT(j,i,k)OTE(a);"):
        found = [_result(tmp_path, rung, "a", i=value, j=2, k=4) for value in range(1, 6)]
        assert found == inside
    outside = [True, True, False, True, True]
    for rung in ("LIM(4,i,2)OTE(a);", "LIM(j,i,k)OTE(a);"):
        found = [_result(tmp_path, rung, "a", i=value, j=4, k=2) for value in range(1, 6)]
        assert found == outside


def test_meq_fills_short_integers_with_zeros(tmp_path: Path) -> None:
    """-1 as SINT is 16#000000FF, so it equals 255 under any mask; with its sign it would not.

    Source: 1756-RM003, MEQ: a SINT or INT tag converts to a DINT by zero-fill.
    """
    assert _result(tmp_path, "MEQ(s,16#FFFF_FFFF,255)OTE(a);", "a", s=-1) is True
    assert _result(tmp_path, "MEQ(i,16#F0,j)OTE(a);", "a", i=0x35, j=0x3A) is True
    assert _result(tmp_path, "MEQ(i,16#FF,j)OTE(a);", "a", i=0x35, j=0x3A) is False


def test_cmp_evaluates_its_expression(tmp_path: Path) -> None:
    """The newer signs && and || are AND and OR."""
    rung = "CMP((i + 1 > 3) && (j <> 2) || a)OTE(b);"
    assert _result(tmp_path, rung, "b", i=3, j=1) is True
    assert _result(tmp_path, rung, "b", i=3, j=2) is False
    assert _result(tmp_path, rung, "b", i=0, j=2, a=True) is True


@pytest.mark.parametrize(
    ("rung", "name", "values", "expected"),
    [
        ("ADD(i,7,j);", "j", {"i": 5}, 12),
        ("SUB(i,j,k);", "k", {"i": 5, "j": 7}, -2),
        ("MUL(i,j,x);", "x", {"i": 3, "j": 4}, 12.0),
        ("DIV(i,j,k);", "k", {"i": -7, "j": 2}, -3),
        ("DIV(i,2,x);", "x", {"i": 7}, 3.5),
        ("DIV(x,2,i);", "i", {"x": 5.0}, 2),
        ("DIV(x,2,i);", "i", {"x": 7.0}, 4),
        ("MOD(i,j,k);", "k", {"i": -7, "j": 3}, -1),
        ("MOD(x,2,y);", "y", {"x": 5.5}, 1.5),
        ("SQR(i,x);", "x", {"i": 9}, 3.0),
        ("SQRT(x,i);", "i", {"x": 6.25}, 2),
        ("NEG(s,i);", "i", {"s": -5}, 5),
        ("ABS(v,i);", "i", {"v": -30000}, 30000),
        ("CLR(x);", "x", {"x": 1.5}, 0.0),
        ("CLR(bytes[1])MOV(bytes[1],i);", "i", {"i": 5}, 0),
        ("MOV(-1,bytes[2])MOV(bytes[2],i);", "i", {}, -1),
        ("MOVE(3.5,i);", "i", {}, 4),
        ("MOV(2.5,i);", "i", {}, 2),
        ("MOV(i,s);", "s", {"i": 200}, -56),
        ("MOV(16#8000_0000,i);", "i", {}, -(2**31)),
        ("CPT(x,i/2);", "x", {"i": 7}, 3.0),
        ("CPT(x,i/2.0);", "x", {"i": 7}, 3.5),
        ("CPT(i,(j + 3) * 2 - SQR(16) ** 2);", "i", {"j": 10}, 10),
        ("CPT(i,s AND 16#FFF);", "i", {"s": -1}, 255),
        ("XPY(2,i,x);", "x", {"i": 10}, 1024.0),
        ("TRN(x,i);", "i", {"x": -2.75}, -2),
        ("TRUNC(x,y);", "y", {"x": 2.75}, 2.0),
        ("LOG(1000,x);", "x", {}, 3.0),
        ("TOD(v,i);", "i", {"v": -1234}, 0x1234),
        ("FRD(16#0987,i);", "i", {}, 987),
    ],
)
def test_an_instruction_calculates(
    tmp_path: Path, rung: str, name: str, values: dict[str, object], expected: float
) -> None:
    """Integers are cut, a REAL is rounded to the nearest even, a REAL destination makes REALs.

    Source: 1756-RM003, the instruction's name, and data conversions.
    """
    assert _result(tmp_path, rung, name, **values) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("rung", "values", "expected"),
    [
        ("AND(s,v,i);", {"s": -1, "v": -1}, 255),
        ("OR(s,16#100,i);", {"s": -1}, 0x1FF),
        ("XOR(v,-1,i);", {"v": -1}, -65536),
        ("NOT(s,i);", {"s": -1}, -256),
        ("NOT(bytes[0],i);", {}, -1),
        ("MVM(v,16#FF00,i);", {"v": -1, "i": 0x12345678}, 0x1234FF78),
    ],
)
def test_logical_instructions_fill_with_zeros(
    tmp_path: Path, rung: str, values: dict[str, object], expected: int
) -> None:
    """A SINT or INT becomes a DINT without its sign.

    Source: 1756-RM003, AND, OR, XOR, NOT, MVM: a SINT or INT tag converts to a DINT by zero-fill.
    """
    assert _result(tmp_path, rung, "i", **values) == expected


@pytest.mark.parametrize("name", ["SIN", "COS", "TAN", "ASN", "ACS", "ATN", "LN", "DEG", "RAD"])
def test_functions_of_reals(tmp_path: Path, name: str) -> None:
    """Angles are in radians. Source: 1756-RM003, trigonometric instructions."""
    expected = {
        "SIN": math.sin(0.5),
        "COS": math.cos(0.5),
        "TAN": math.tan(0.5),
        "ASN": math.asin(0.5),
        "ACS": math.acos(0.5),
        "ATN": math.atan(0.5),
        "LN": math.log(0.5),
        "DEG": math.degrees(0.5),
        "RAD": math.radians(0.5),
    }[name]
    found = _result(tmp_path, f"{name}(x,y);", "y", x=0.5)
    assert found == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(
    ("rung", "name", "expected"),
    [
        ("DIV(i,j,k);", "k", 7),
        ("DIV(i,0,k);", "k", 7),
        ("MOD(i,j,k);", "k", 7),
        ("CPT(k,i / j + 1);", "k", 8),
        ("DIV(i,j,x);", "x", math.inf),
    ],
)
def test_a_division_by_zero_does_not_end_the_run(
    tmp_path: Path, rung: str, name: str, expected: float
) -> None:
    """An integer divided by 0 gives the dividend (assumed), a REAL gives infinity."""
    assert _result(tmp_path, rung, name, i=7, j=0) == expected


def test_without_power_nothing_is_calculated(tmp_path: Path) -> None:
    """The destination keeps its value; power goes on to the coil behind the instruction."""
    rung = "XIC(a)ADD(i,1,i)OTE(b);"
    assert _result(tmp_path, rung, "i", i=5) == 5
    assert _result(tmp_path, rung, "i", i=5, a=True) == 6
    assert _result(tmp_path, rung, "b", a=True) is True


@pytest.mark.parametrize(
    ("rung", "why"),
    [
        ("ADD(1,?,i);", "rung 0: ADD has no Source B"),
        ("ADD(1,a,i);", "rung 0: a is a BOOL, Source B of ADD a number"),
        ("MOV(a,i);", "rung 0: a is a BOOL, and MOV moves numbers"),
        ("MOV(i,list);", "rung 0: list is not a tag for a single number"),
        ("MOV(1,2);", "rung 0: a tag is needed here, not '2'"),
        ("AND(x,1,i);", "rung 0: a whole number is needed here, not REAL"),
        ("CMP(i + 1)OTE(a);", "rung 0: the expression of CMP is a DINT, not a comparison"),
        ("CPT(i,j +);", "rung 0: a value is expected, not the end"),
        ("CPT(i,XPY(2));", "rung 0: the function XPY of DINT is not supported"),
    ],
)
def test_a_wrong_operand_is_named(tmp_path: Path, rung: str, why: str) -> None:
    """The reason has the rung, the operand and the instruction."""
    body = main_body(written(tmp_path, [rung]))
    assert isinstance(body, Foreign)
    assert body.why.startswith(why)
