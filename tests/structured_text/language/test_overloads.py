"""A call `Show(…)` chooses the method `Show__TYPE` by the types of its arguments."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_BLOCK = """FUNCTION_BLOCK Shower
METHOD Show__INT : STRING
VAR_INPUT a : INT; b : INT; END_VAR
Show__INT := 'INT';
END_METHOD
METHOD Show__BOOL : STRING
VAR_INPUT a : BOOL; b : BOOL; END_VAR
Show__BOOL := 'BOOL';
END_METHOD
METHOD Show__DINT : STRING
VAR_INPUT a : DINT; b : DINT; END_VAR
Show__DINT := 'DINT';
END_METHOD
{types}
END_FUNCTION_BLOCK
PROGRAM Main
VAR s : Shower; i : INT; x : BOOL; r : REAL; t : STRING; e : (Idle, Busy); END_VAR
t := s.Show({arguments});
END_PROGRAM
"""
_TYPES = """METHOD Show__TYPES : STRING
VAR_INPUT a : STRING; b : STRING; END_VAR
Show__TYPES := CONCAT(a, b);
END_METHOD"""


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ("i, i", "INT"),
        ("x, b := FALSE", "BOOL"),
        ("b := i, a := 5", "INT"),
        ("1, 2", "DINT"),
        ("Busy, e", "INT"),
        ("i, x", "(Type class = INT)(Type class = BOOL)"),
    ],
)
def test_the_types_of_the_arguments_choose_the_method(
    build: Callable[..., BuiltinProgram], arguments: str, expected: str
) -> None:
    """The argument types choose the method `Show__TYPE` that a call of `Show` runs.

    Source: the docstring of structured_text.language.overloads.
    """
    program = build(_BLOCK.format(types=_TYPES, arguments=arguments))
    program.scan(0)
    assert program.read("Main.t") == expected


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ("r, r", "Show takes no value of REAL"),
        ("i, x", "a INT is expected here, not a BOOL|a BOOL is expected here, not a INT"),
        ("i, i, i", "Shower.Show__INT takes 2 arguments, not 3"),
        ("i, c := i", "has no input c"),
    ],
)
def test_arguments_that_fit_no_method_are_refused(
    build: Callable[..., BuiltinProgram], arguments: str, message: str
) -> None:
    """A call whose arguments fit no method is refused.

    Source: the docstring of structured_text.language.overloads.
    """
    with pytest.raises(InputError, match=message):
        build(_BLOCK.format(types="", arguments=arguments))
