"""Types of variables are found in the declarations of a project."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.projects.diagrams.networks.types import Declarations, Types
from structured_text.projects.model import Piece, Unit, made

_SOURCES = {
    "TYPE Point": """TYPE Point : STRUCT X, Y : REAL; (* Z : INT; *) Tags : ARRAY [0..3] OF BYTE;
      END_STRUCT; END_TYPE""",
    "TYPE Color": "TYPE Color : (Red, Green := 5); END_TYPE",
    "TYPE Count": "TYPE Count : UINT := 3; END_TYPE",
    "VAR_GLOBAL Gvl": "VAR_GLOBAL CONSTANT Limit : DINT := 10; END_VAR",
    "FUNCTION_BLOCK Base": "FUNCTION_BLOCK Base VAR_INPUT In1 : BOOL; END_VAR",
    "FUNCTION_BLOCK Fb": """FUNCTION_BLOCK Fb EXTENDS Base
      VAR_INPUT {attribute 'a: b;'} Set : INT; END_VAR
      VAR_OUTPUT Out1 : Point; END_VAR VAR Hidden : INT; END_VAR""",
    "FUNCTION Fun": "FUNCTION Fun : LREAL VAR_INPUT A : INT; END_VAR",
    "PROGRAM Main": """PROGRAM Main
      VAR P : Point; Ps : ARRAY [1..2] OF Point; F : Fb; S : STRING[20] := 'a : b;';
        N AT %MW3 : Count; D : TIME := T#1s; (* Old : INT; *) Ptr : POINTER TO Point;
        W : WORD; T1 : TON; END_VAR
      VAR_EXTERNAL Ext : LINT; END_VAR""",
}


@pytest.fixture(scope="module")
def types() -> Types:
    """Return the types as the program Main sees them."""
    units = []
    for title, text in _SOURCES.items():
        kind, name = title.split()
        units.append(Unit(kind, Piece(name, made(1, *text.splitlines())), Path("plc.xml")))
    return Declarations(units).types("Main", units[-1].piece.head)


@pytest.mark.parametrize(
    ("expression", "expected"),
    [
        ("P.X", "REAL"),
        ("p . y", "REAL"),
        ("Ps[N].Tags[Ps[1].X]", "BYTE"),
        ("F.Out1.X", "REAL"),
        ("F.In1", "BOOL"),
        ("F.Hidden", ""),
        ("S", "STRING[20]"),
        ("N", "Count"),
        ("D", "TIME"),
        ("Ptr^.X", "REAL"),
        ("W.3", "BOOL"),
        ("T1.ET", "TIME"),
        ("Ext", "LINT"),
        ("Limit", "DINT"),
        ("Gvl.Limit", "DINT"),
        ("Green", "Color"),
        ("Old", ""),
        ("TRUE", "BOOL"),
        ("-12", "ANY_INT"),
        ("16#FF", "ANY_INT"),
        ("1.5E3", "ANY_REAL"),
        ("T#5s", "TIME"),
        ("UINT#5", "UINT"),
        ("TIME_OF_DAY#1:2:3", "TOD"),
        ("'T#5s'", "STRING"),
        ("N + 1", ""),
    ],
)
def test_the_type_of_an_expression(types: Types, expression: str, expected: str) -> None:
    """Comments, texts and initial values are no declarations."""
    assert types.of(expression) == expected


def test_the_pins_of_a_block_begin_with_those_of_its_base(types: Types) -> None:
    """Variables that are not pins are left out."""
    callee = types.callee("FB")
    assert callee is not None
    pins = [(pin.name, pin.type, pin.section) for pin in callee.pins]
    assert pins == [
        ("In1", "BOOL", "VAR_INPUT"),
        ("Set", "INT", "VAR_INPUT"),
        ("Out1", "Point", "VAR_OUTPUT"),
    ]


def test_functions_standard_blocks_and_unknown_names(types: Types) -> None:
    """A function has a result; a standard block is known without a declaration."""
    function, timer = types.callee("Fun"), types.callee("TON")
    assert function is not None
    assert timer is not None
    assert (function.kind, function.result, function.standard) == ("FUNCTION", "LREAL", False)
    assert (timer.kind, timer.standard) == ("FUNCTION_BLOCK", True)
    assert types.callee("Nothing") is None


def test_variables_that_other_pous_can_change(types: Types) -> None:
    """Externals and globals are not the program's own."""
    assert [types.is_own(name) for name in ("P", "t1", "Ext", "Limit")] == [
        True,
        True,
        False,
        False,
    ]
    assert types.is_list("gvl")
    assert types.base("Count") == "UINT"


def test_actions_of_the_program_are_called_by_their_names() -> None:
    """An action of another program needs the name of that program."""
    action = Piece("Main.Act", made(1, "ACTION Act:"))
    head = made(1, "PROGRAM Main")
    units = [Unit("PROGRAM", Piece("Main", head, (), (), (action,)), Path("plc.xml"))]
    declared = Declarations(units)
    own, other = declared.types("Main", head), declared.types("Other", head)
    found = own.callee("act")
    assert found is not None
    assert (found.kind, found.pins) == ("ACTION", ())
    assert other.callee("Act") is None
    assert other.callee("Main.Act") == found
