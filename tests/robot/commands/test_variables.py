"""Static variables can be assigned, read and used in the four arithmetic operations."""

from __future__ import annotations

import struct
from typing import Any

import pytest

from robot_master import NORMAL_END, Master, abnormal_end
from stored_data import long_words, ready, real_words

ASSIGN, READ = 0x0200, 0x0214
VALUE = {"=": 0x0200, "+": 0x0204, "-": 0x0208, "*": 0x020C, "/": 0x0210}
VARIABLE = {"=": 0x0201, "+": 0x0205, "-": 0x0209, "*": 0x020D, "/": 0x0211}
SGI0, SGI31, SGR0, SGR31 = 0, 31, 256, 287
LOWEST, HIGHEST = -(2**31), 2**31 - 1
LARGEST_REAL = struct.unpack("<f", bytes.fromhex("FFFF7F7F"))[0]


def _words(number: int, value: float) -> tuple[int, ...]:
    return long_words(int(value)) if number < SGR0 else real_words(value)


def _with(values: dict[int, float], **config: Any) -> Master:
    """Return a controller in which commands have assigned these variables."""
    master = ready(**config)
    for number, value in values.items():
        assert master.execute(ASSIGN, 0, number, 0, *_words(number, value)) == NORMAL_END
    return master


def _read(master: Master, number: int) -> tuple[int, ...]:
    answer = master.execute(READ, 0, number)
    assert answer[:4] == (0x0200, 0, number, 0)
    assert answer[6:] == (0,) * 10
    return answer[4:6]


@pytest.mark.parametrize("number", [SGI0, 1, SGI31])
@pytest.mark.parametrize("value", [10000, 50, -1, LOWEST, HIGHEST])
def test_an_integer_variable_gives_back_what_was_assigned(number: int, value: int) -> None:
    """SGI0 to SGI31 have 32 bits with a sign.

    Rule: variable-types.
    Source: remote command guide 4.4.1.
    """
    assert _read(_with({number: value}), number) == long_words(value)


@pytest.mark.parametrize("number", [SGR0, SGR31])
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0x0000, 0x3F80), id="1.0"),
        pytest.param((0xCCCD, 0x3DCC), id="0.1"),
        pytest.param((0x0FDB, 0xC049), id="-3.14159274"),
        pytest.param((0x0000, 0x0000), id="0"),
        pytest.param((0x0000, 0x8000), id="-0"),
        pytest.param((0x0001, 0x0000), id="the smallest"),
        pytest.param((0xFFFF, 0x7F7F), id="the largest"),
        pytest.param((0xFFFF, 0xFF7F), id="the lowest"),
    ],
)
def test_a_real_variable_gives_back_the_same_bits(number: int, words: tuple[int, ...]) -> None:
    """SGR variables have single precision.

    Rule: variable-types.
    Source: remote command guide 4.4.1.
    """
    master = ready()
    assert master.execute(ASSIGN, 0, number, 0, *words) == NORMAL_END
    assert _read(master, number) == words


def test_variables_are_0_until_they_are_assigned_and_do_not_mix() -> None:
    """SGI1 and SGR1 are different variables.

    Rule: variable-types.
    Source: remote command guide 4.4.1.
    """
    master = _with({1: 7, 257: 2.5})
    assert _read(master, 1) == long_words(7)
    assert _read(master, 257) == real_words(2.5)
    assert [_read(master, n) for n in (0, 2, 256, 258)] == [(0, 0)] * 4


@pytest.mark.parametrize(("first", "second"), [(1, 2), (SGR0, SGR31)])
@pytest.mark.parametrize(
    ("operator", "integer", "real"),
    [("=", 6, 0.5), ("+", 26, 3.0), ("-", 14, 2.0), ("*", 120, 1.25), ("/", 3, 5.0)],
)
def test_variables_are_calculated_with_a_value_and_with_a_variable(
    operator: str, integer: int, real: float, first: int, second: int
) -> None:
    """The integers are 20 and 6, and the quotient 3.33 becomes 3.

    The real numbers are 2.5 and 0.5.

    Rule: mixed-arithmetic.
    Source: remote command guide 4.4.1
    """
    own, other, expected = (20, 6, integer) if first == 1 else (2.5, 0.5, real)
    for code, operand in ((VALUE, _words(second, other)), (VARIABLE, (second,))):
        master = _with({first: own, second: other})
        assert master.execute(code[operator], 0, first, 0, *operand) == NORMAL_END
        assert _read(master, first) == _words(first, expected)
        assert _read(master, second) == _words(second, other)


def test_a_variable_can_be_calculated_with_itself() -> None:
    """Source: remote command guide 4.4.1."""
    master = _with({5: -9})
    master.execute(VARIABLE["*"], 0, 5, 0, 5)
    assert _read(master, 5) == long_words(81)
    master.execute(VARIABLE["-"], 0, 5, 0, 5)
    assert _read(master, 5) == long_words(0)


def test_real_numbers_have_single_precision() -> None:
    """0.1 + 0.2 is 0x3E99999A; 2^24 + 1 equals 2^24.

    Rule: mixed-arithmetic.
    Source: remote command guide 4.4.1, caution on significant digits
    """
    master = _with({SGR0: 0.1, 257: 2.0**24, 1: 2**24 + 1})
    master.execute(VALUE["+"], 0, SGR0, 0, *real_words(0.2))
    assert _read(master, SGR0) == (0x999A, 0x3E99)
    master.execute(VALUE["+"], 0, 257, 0, *real_words(1.0))
    assert _read(master, 257) == real_words(2.0**24)
    master.execute(VARIABLE["="], 0, 258, 0, 1)
    assert _read(master, 258) == real_words(2.0**24)
    master.execute(VALUE["-"], 0, 258, 0, *real_words(2.0**24))
    assert _read(master, 258) == real_words(0.0)


@pytest.mark.parametrize(
    ("value", "rounded", "truncated"),
    [(2.4, 2, 2), (2.5, 3, 2), (3.5, 4, 3), (-2.4, -2, -2), (-2.5, -3, -2), (-0.4, 0, 0)],
)
def test_a_real_number_is_rounded_to_an_integer(value: float, rounded: int, truncated: int) -> None:
    """A key selects rounding or truncation of a real number that becomes an integer.

    Rule: real-to-integer.
    Source: remote command guide 4.4.1.
    """
    for knob, expected in (("round", rounded), ("truncate", truncated)):
        master = _with({SGR0: value}, real_to_integer=knob)
        assert master.execute(VARIABLE["="], 0, 3, 0, SGR0) == NORMAL_END
        assert _read(master, 3) == long_words(expected)


@pytest.mark.parametrize(
    ("divisor", "rounded", "truncated"), [(2, 4, 3), (-2, -4, -3), (4, 2, 1), (3, 2, 2)]
)
def test_the_quotient_of_integers_is_rounded(divisor: int, rounded: int, truncated: int) -> None:
    """The quotients are 7 / 2 = 3.5, 7 / 4 = 1.75 and 7 / 3 = 2.33.

    Rule: real-to-integer.
    Source: remote command guide 4.4.1
    """
    for knob, expected in (("round", rounded), ("truncate", truncated)):
        master = _with({3: 7}, real_to_integer=knob)
        assert master.execute(VALUE["/"], 0, 3, 0, *long_words(divisor)) == NORMAL_END
        assert _read(master, 3) == long_words(expected)


def test_an_integer_and_a_real_variable_are_calculated_with_each_other() -> None:
    """The result has the type of variable 1: 10 * 0.25 = 2.5 -> 3; 0.25 * 10 = 2.5.

    The integer is first converted to single precision: (2^24 + 1) * 1.0 = 2^24.

    Rule: mixed-arithmetic.
    Source: remote command guide 4.4.1
    """
    master = _with({1: 10, SGR0: 0.25})
    master.execute(VARIABLE["*"], 0, 1, 0, SGR0)
    assert _read(master, 1) == long_words(3)
    master = _with({1: 10, SGR0: 0.25})
    master.execute(VARIABLE["*"], 0, SGR0, 0, 1)
    assert _read(master, SGR0) == real_words(2.5)
    master = _with({1: 2**24 + 1, SGR0: 1.0})
    master.execute(VARIABLE["*"], 0, 1, 0, SGR0)
    assert _read(master, 1) == long_words(2**24)


@pytest.mark.parametrize(
    ("number", "own", "operator", "value"),
    [
        (1, HIGHEST, "+", 1),
        (1, LOWEST, "-", 1),
        (1, 65536, "*", 32768),
        (1, LOWEST, "/", -1),
        (SGR0, LARGEST_REAL, "*", 2.0),
        (SGR0, LARGEST_REAL, "+", LARGEST_REAL),
        (SGR0, -LARGEST_REAL, "-", LARGEST_REAL),
        (SGR0, 1.0, "/", 1e-44),
    ],
)
def test_an_overflow_changes_nothing(number: int, own: float, operator: str, value: float) -> None:
    """Rule: overflow. Source: remote command guide 4.4.1."""
    master = _with({number: own}, overflow_alarm="6.2")
    answer = master.execute(VALUE[operator], 0, number, 0, *_words(number, value))
    assert answer == abnormal_end("6.2")
    assert _read(master, number) == _words(number, own)


def test_a_real_number_that_an_integer_cannot_hold_changes_nothing() -> None:
    """2^31 is too large by 1; -2^31 is legal.

    Rule: overflow.
    Source: remote command guide 4.4.1.
    """
    master = _with({1: 5, SGR0: 2.0**31, 257: -(2.0**31)}, overflow_alarm="6.2")
    assert master.execute(VARIABLE["="], 0, 1, 0, SGR0) == abnormal_end("6.2")
    assert _read(master, 1) == long_words(5)
    assert master.execute(VARIABLE["="], 0, 1, 0, 257) == NORMAL_END
    assert _read(master, 1) == long_words(LOWEST)


@pytest.mark.parametrize("number", [1, SGR0])
def test_a_division_by_0_changes_nothing(number: int) -> None:
    """Rule: overflow. Source: remote command guide 4.4.1."""
    master = _with({number: 5}, division_alarm="6.3")
    assert master.execute(VALUE["/"], 0, number) == abnormal_end("6.3")
    assert master.execute(VARIABLE["/"], 0, number, 0, 2) == abnormal_end("6.3")
    assert master.execute(VARIABLE["/"], 0, number, 0, 257) == abnormal_end("6.3")
    assert _read(master, number) == _words(number, 5)


@pytest.mark.parametrize("high", [0x7F80, 0xFF80, 0x7FC0], ids=["infinite", "-infinite", "NaN"])
@pytest.mark.parametrize("operator", list("=+-*/"))
def test_a_value_that_is_no_number_is_refused(operator: str, high: int) -> None:
    """The bits of a NaN are refused for a real variable.

    An integer variable takes them as an integer.

    Rule: overflow.
    Source: remote command guide 4.4.1
    """
    master = _with({SGR0: 1.5}, format_alarm="6.4")
    assert master.execute(VALUE[operator], 0, SGR0, 0, 0, high) == abnormal_end("6.4")
    assert _read(master, SGR0) == real_words(1.5)
    assert master.execute(ASSIGN, 0, 1, 0, 0, high) == NORMAL_END
    assert _read(master, 1) == (0, high)
