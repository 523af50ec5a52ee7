"""Tests of CLASS, access specifiers, members after their block, and the start of derived blocks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[[str], BuiltinProgram]
Mistakes = Callable[[str], list[InputError]]

_CLASSES = """\
NAMESPACE Cell.Axes
INTERFACE IValue METHOD Value : INT END_METHOD END_INTERFACE
CLASS PUBLIC ABSTRACT Base IMPLEMENTS IValue
VAR PROTECTED n : INT := 3; END_VAR
VAR PRIVATE // hidden
  secret : INT; END_VAR
VAR PUBLIC open : INT := 9; private, final : INT; END_VAR
METHOD PUBLIC Value : INT
  secret := secret + 1; private := 1; Value := n + secret;
END_METHOD
METHOD PUBLIC ABSTRACT Add : INT VAR_INPUT k : INT; END_VAR END_METHOD
END_CLASS
CLASS FINAL Leaf EXTENDS Base
METHOD PUBLIC OVERRIDE Add : INT VAR_INPUT k : INT; END_VAR
  n := n + k; Add := n;
END_METHOD
END_CLASS
CLASS Plain
VAR own : INT; END_VAR
END_CLASS
END_NAMESPACE
"""


def _values(build: Build, text: str, names: str) -> list[Any]:
    program = build(text)
    program.scan(0)
    return [program.read(f"Main.{name}") for name in names.split()]


def test_a_class_has_methods_and_no_body(build: Build) -> None:
    """The methods of a CLASS give the expected values, and a CLASS has no body.

    Source: IEC 61131-3, edition 3, 6.6.5; values by hand.
    """
    text = (
        f"{_CLASSES}PROGRAM P1\nVAR a : Leaf; b : ARRAY [1..2] OF Leaf; i : IValue;"
        " x, y, z, u : INT; END_VAR\n"
        "x := a.Add(k := 2); i := a; y := i.Value(); z := a.open; u := b[2].Value();\n"
        "END_PROGRAM\n"
    )
    assert _values(build, text, "x y z u") == [5, 6, 9, 4]


def test_a_class_or_method_may_be_called_like_a_step(build: Build) -> None:
    """Keywords of Sequential Function Chart, such as STEP, may be names of classes and methods."""
    text = (
        "CLASS PUBLIC Transition\nMETHOD PUBLIC Step : INT\nStep := 3;\nEND_METHOD\nEND_CLASS\n"
        "PROGRAM P1\nVAR t : Transition; x : INT; END_VAR\nx := t.Step();\nEND_PROGRAM\n"
    )
    assert _values(build, text, "x") == [3]


_WRONG = [
    ("a();", "Leaf is a CLASS and has no body"),
    ("x := a.n;", "Base.n is PROTECTED"),
    ("a.n := 1;", "Base.n is PROTECTED"),
    ("x := a.secret;", "Base.secret is PRIVATE"),
    ("x := p.own;", "Plain.own is PROTECTED"),
]


@pytest.mark.parametrize(("body", "message"), _WRONG, ids=[body for body, _ in _WRONG])
def test_a_class_keeps_its_variables(body: str, message: str, mistakes_of: Mistakes) -> None:
    """A variable of a CLASS is PROTECTED by default, so a program cannot access it.

    Source: IEC 61131-3, edition 3, 6.6.5.
    """
    (error,) = mistakes_of(
        f"{_CLASSES}PROGRAM P1\nVAR a : Leaf; p : Plain; x : INT; END_VAR\n{body}\nEND_PROGRAM\n"
    )
    assert (error.message, error.line) == (message, _CLASSES.count("\n") + 3)


def test_a_private_variable_is_not_inherited(mistakes_of: Mistakes) -> None:
    (error,) = mistakes_of(
        "FUNCTION_BLOCK B1\nVAR PRIVATE hid : INT; END_VAR\nEND_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK B2 EXTENDS B1\nhid := 1;\nEND_FUNCTION_BLOCK\n"
    )
    assert (error.message, error.line) == ("B1.hid is PRIVATE", 5)


_MEMBERS = """\
FUNCTION_BLOCK Box
VAR n : INT; END_VAR
n := n + 1;
END_FUNCTION_BLOCK

METHOD PUBLIC Reset : BOOL
VAR_INPUT to : INT; END_VAR
n := to; Reset := TRUE;
END_METHOD
PROPERTY Half : INT
GET PUBLIC
VAR k : INT; END_VAR
k := n / 2; Half := k;
END_GET
SET PRIVATE
n := Half * 2;
END_SET
END_PROPERTY
ACTION Twice: n := n * 2; END_ACTION
METHOD UseHalf
Half := Half + 1;
END_METHOD
INTERFACE IBox END_INTERFACE
METHOD Go : INT
END_METHOD
FUNCTION_BLOCK Other IMPLEMENTS IBox
END_FUNCTION_BLOCK
METHOD Go : INT
Go := 8;
END_METHOD
""".replace("to : INT", "start : INT").replace("n := to", "n := start")


def test_members_stand_behind_their_block(build: Build) -> None:
    """A METHOD after END_FUNCTION_BLOCK belongs to this block.

    Text exports of several tools have this form.
    """
    text = (
        f"{_MEMBERS}PROGRAM P1\nVAR b : Box; o : Other; i : IBox; x, y, z : INT; q : BOOL;"
        " END_VAR\nq := b.Reset(5); b(); b.Twice(); x := b.Half; b.UseHalf(); y := b.n;"
        " i := o; z := i.Go();\n"
        "END_PROGRAM\n"
    )
    assert _values(build, text, "q x y z") == [True, 6, 14, 8]


def test_a_private_set_is_called_inside_only(mistakes_of: Mistakes) -> None:
    """A PRIVATE accessor SET can be called only inside of its block.

    Source: help of TwinCAT, property.
    """
    (error,) = mistakes_of(
        f"{_MEMBERS}PROGRAM P1\nVAR b : Box; x : INT; END_VAR\nx := b.Half;\nb.Half := 3;\n"
        "END_PROGRAM\n"
    )
    assert (error.message, error.line) == ("Box.Half.Set is PRIVATE", _MEMBERS.count("\n") + 4)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ("METHOD M : INT\nM := 1;\nEND_METHOD\n", 1, "M belongs to no block"),
        ("TYPE T : INT; END_TYPE\nPROPERTY P : INT\nEND_PROPERTY\n", 2, "P belongs to no block"),
        ("FUNCTION F : INT\nVAR_INPUT i : INT; END_VAR\nF := i;\nEND_FUNCTION\nMETHOD M\n"
         "END_METHOD\n", 5, "a FUNCTION has no methods, properties or actions"),
        ("FUNCTION_BLOCK B\nMETHOD M\nEND_METHOD\nEND_FUNCTION_BLOCK\nMETHOD M\nEND_METHOD\n", 5,
         "M is declared twice"),
    ],
)  # fmt: skip
def test_a_member_without_its_block_is_refused(
    text: str, line: int, message: str, mistakes_of: Mistakes
) -> None:
    (error,) = mistakes_of(text)
    assert (error.message, error.line) == (message, line)


_START = """\
FUNCTION_BLOCK Base
VAR path, log : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; p : INT; END_VAR
path := p; log := log * 10 + 1;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Mid EXTENDS Base
VAR speed : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; p : INT; v : INT; END_VAR
speed := v + path; log := log * 10 + 2;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Last EXTENDS Mid
END_FUNCTION_BLOCK
FUNCTION_BLOCK Plain
VAR k : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
k := 5;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Sub EXTENDS Plain
VAR m : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; x : INT; END_VAR
m := k + x;
END_METHOD
END_FUNCTION_BLOCK
"""


def test_the_start_of_a_base_comes_first_and_has_the_first_arguments(build: Build) -> None:
    """FB_init of a base block runs first and takes the first arguments.

    Source: help of TwinCAT, behaviour with derived function blocks (5482088715).
    """
    text = (
        f"{_START}PROGRAM P1\nVAR a : Base(2); b : Mid(7, 30); c : Sub(x := 4);"
        " d : Last(p := 1, v := 2); END_VAR\nEND_PROGRAM\n"
    )
    names = "a.path a.log b.path b.speed b.log c.m d.speed d.log"
    assert _values(build, text, names) == [2, 1, 7, 37, 12, 9, 3, 12]


def test_a_start_must_begin_with_the_parameters_of_the_base(mistakes_of: Mistakes) -> None:
    """FB_init of a derived block must have the parameters of the base's FB_init first.

    Source: help of TwinCAT, behaviour with derived function blocks (5482088715).
    """
    wrong = (
        "FUNCTION_BLOCK Wrong EXTENDS Base\nMETHOD FB_init : BOOL\nVAR_INPUT bInitRetains : BOOL;"
        " bInCopyCode : BOOL; v : REAL; END_VAR\nEND_METHOD\nEND_FUNCTION_BLOCK\n"
    )
    (error,) = mistakes_of(_START + wrong)
    text = "Wrong.FB_init must begin with the parameters of Base.FB_init"
    assert (error.message, error.line) == (text, _START.count("\n") + 2)


def test_a_missing_base_is_one_message(mistakes_of: Mistakes) -> None:
    """A missing base block gives one message.

    `Drive EXTENDS Library.Drive` does not extend itself.
    """
    found = mistakes_of(
        "FUNCTION_BLOCK Drive EXTENDS Library.Drive\nVAR x : INT; END_VAR\n"
        "METHOD Go\ninherited := 1; x := Calculate(3); THIS^.speed := 4; Stop(); SUPER^.Go();\n"
        "END_METHOD\nEND_FUNCTION_BLOCK\n"
        "INTERFACE IDrive END_INTERFACE\n"
        "PROGRAM P1\nVAR d : Drive; i : IDrive; a : ARRAY [0..1] OF Drive; END_VAR\n"
        "d.base := 3; d(pin := 2); d.Start(); i := d; a[0].base := 1;\nEND_PROGRAM\n"
    )
    assert [(one.line, one.message) for one in found] == [(1, "there is no namespace Library")]


def test_a_missing_type_of_a_pin_is_one_message(mistakes_of: Mistakes) -> None:
    found = mistakes_of(
        "FUNCTION_BLOCK A1\nVAR_IN_OUT ax : AXIS_REF; END_VAR\nEND_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK A2 EXTENDS A1\nEND_FUNCTION_BLOCK\n"
        "TYPE S1 : STRUCT\nf : MISSING;\nEND_STRUCT END_TYPE\n"
        "TYPE S2 EXTENDS S1 : STRUCT g : INT; END_STRUCT END_TYPE\n"
        "PROGRAM P1\nVAR b : A1; c : A2; s : S2;\nm : AXIS_REF; END_VAR\n"
        "b(ax := m); c(ax := m); c.ax.x := 1; s.f := 1; m.Call(); m.y := 2;\nEND_PROGRAM\n"
    )
    assert [(one.line, one.message) for one in found] == [
        (2, "there is no type AXIS_REF"),
        (7, "there is no type MISSING"),
        (12, "there is no type AXIS_REF"),
    ]
