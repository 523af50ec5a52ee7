"""Methods, properties, interfaces and inheritance give values that were calculated by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[[str], BuiltinProgram]
Mistakes = Callable[[str], list[InputError]]

_COUNTER = """
FUNCTION_BLOCK FB_Counter
  VAR_INPUT Stride : INT := 1; END_VAR
  VAR_OUTPUT Count : INT; END_VAR
  VAR Hidden : INT; Pair : ARRAY [1..2] OF INT; END_VAR
  METHOD Add : INT
    VAR_INPUT Amount : INT := 5; Twice : BOOL; END_VAR
    VAR Sum : INT := 100; END_VAR
    Sum := Sum + Amount;
    IF Twice THEN Sum := Sum + Amount; END_IF;
    Count := Count + Amount;
    Add := Sum;
  END_METHOD
  METHOD Split
    VAR_INPUT Value : INT; END_VAR
    VAR_OUTPUT Tens : INT; Ones : INT; END_VAR
    VAR_IN_OUT Calls : INT; END_VAR
    Tens := Value / 10;
    Ones := Value MOD 10;
    Calls := Calls + 1;
  END_METHOD
  METHOD Digits : INT
    VAR_INPUT Value : INT; END_VAR
    VAR T, O, C : INT; END_VAR
    Split(Value, Tens => T, Ones => O, Calls := C);
    Digits := T * 100 + O * 10 + C;
  END_METHOD
  METHOD Remember : INT
    VAR_INST Calls : INT := 10; END_VAR
    Calls := Calls + 1;
    Remember := Calls;
  END_METHOD
  METHOD Fill
    VAR_IN_OUT Into : ARRAY [1..2] OF INT; END_VAR
    Into[1] := Stride;
    Into[2] := Count;
  END_METHOD
  METHOD Largest : INT
    VAR_INPUT Items : ARRAY [1..3] OF INT; END_VAR
    VAR I : INT; END_VAR
    Items[1] := Items[1] + 1;
    FOR I := 1 TO 3 DO
      IF Items[I] > Largest THEN Largest := Items[I]; END_IF;
    END_FOR;
  END_METHOD
  METHOD Twice : INT
    Twice := Add(Amount := 1) + THIS^.Add(2);
  END_METHOD
  PROPERTY Half : INT
    GET
      Half := Count / 2;
    END_GET
    SET
      Count := Half * 2;
    END_SET
  END_PROPERTY
  METHOD UseHalf
    Half := Half + 3;
  END_METHOD
  METHOD Down : INT
    VAR_INPUT Start : INT; END_VAR
    IF Start > 0 THEN
      Down := Down(Start := Start - 1) + 1;
    END_IF;
  END_METHOD
  Count := Count + Stride;
END_FUNCTION_BLOCK
"""


def _run(build: Build, before: str, variables: str, body: str, want: str) -> Any:
    program = build(f"{before}\nPROGRAM P1\nVAR {variables} END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    values = tuple(program.read(f"Main.{name}") for name in want.split())
    return values[0] if len(values) == 1 else values


@pytest.mark.parametrize(
    ("body", "want", "expected"),
    [
        pytest.param("X := F.Add(3);", "X F.Count", (103, 3), id="positional"),
        pytest.param("X := F.Add(Twice := TRUE, Amount := 4);", "X", 108, id="named"),
        pytest.param("X := F.Add();", "X F.Count", (105, 5), id="defaults"),
        pytest.param("F.Add(2); F.Add(Amount := 3);", "F.Count", 5, id="as a statement"),
        pytest.param("F.Split(47, Tens => X, Ones => Y, Calls := Z);", "X Y Z", (4, 7, 1)),
        pytest.param("F.Split(Value := 47, Ones => A[2], Calls := A[1]);", "A", [1, 7],
                     id="to elements"),
        pytest.param("F.Split(5, X, Y, Z);", "X Y Z", (0, 5, 1), id="all positional"),
        pytest.param("X := F.Digits(47);", "X", 471, id="outputs to local variables"),
        pytest.param("X := F.Remember(); Y := F.Remember(); Z := G.Remember();", "X Y Z",
                     (11, 12, 11)),
        pytest.param("F(Stride := 4); F.Fill(Into := A);", "A", [4, 4],
                     id="an array as VAR_IN_OUT"),
        pytest.param("X := F.Largest(B); Y := B[1];", "X Y", (9, 8),
                     id="an array as input is a copy"),
        pytest.param("X := F.Twice();", "X F.Count", (203, 3), id="own methods"),
        pytest.param("F(Stride := 9); X := F.Half;", "X", 4, id="GET"),
        pytest.param("F.Half := 6;", "F.Count", 12, id="SET"),
        pytest.param("F.Half := F.Half + 1; F.Half := F.Half + 1;", "F.Count", 4),
        pytest.param("F.Half := 2; F.UseHalf();", "F.Count", 10, id="a property inside"),
        pytest.param("X := F.Down(5);", "X", 5, id="a method that calls itself"),
        pytest.param("B1 := F.Add(1) > 0 AND G.Add(2) < 0; X := F.Count; Y := G.Count;", "B1 X Y",
                     (False, 1, 2), id="AND calls both"),
        pytest.param("B1 := F.Add(1) < 0 AND G.Add(2) > 0; X := F.Count; Y := G.Count;", "B1 X Y",
                     (False, 1, 2), id="AND calls both, also behind FALSE"),
        pytest.param("WHILE F.Add(1) < 200 AND F.Count < 7 DO X := X + 1; END_WHILE;", "X", 6),
        pytest.param("X := F.Add(Amount := G.Add(1) - 100);", "X F.Count", (101, 1),
                     id="one in another"),
    ],
)  # fmt: skip
def test_a_method_runs_on_its_instance(body: str, want: str, expected: Any, build: Build) -> None:
    variables = "F, G : FB_Counter; X, Y, Z : INT; B1 : BOOL; A : ARRAY [1..2] OF INT;"
    variables += " B : ARRAY [1..3] OF INT := [8, 9, 7];"
    assert _run(build, _COUNTER, variables, body, want) == expected


_SHAPES = """
INTERFACE I_Named
  PROPERTY Name : STRING GET END_GET END_PROPERTY
END_INTERFACE
INTERFACE I_Shape EXTENDS I_Named
  METHOD Area : INT END_METHOD
  METHOD Scale VAR_INPUT Amount : INT; END_VAR END_METHOD
END_INTERFACE
FUNCTION_BLOCK ABSTRACT FB_Shape IMPLEMENTS I_Shape
  VAR_INPUT Size : INT := 2; END_VAR
  VAR_OUTPUT Runs : INT; END_VAR
  VAR Kind : STRING := 'shape'; END_VAR
  METHOD ABSTRACT Area : INT END_METHOD
  METHOD PUBLIC Scale VAR_INPUT Amount : INT; END_VAR
    Size := Size * Amount;
  END_METHOD
  PROPERTY Name : STRING GET Name := Kind; END_GET END_PROPERTY
  METHOD Double : INT
    Double := 2 * Area();
  END_METHOD
  METHOD PROTECTED Secret : INT Secret := 7; END_METHOD
  METHOD PRIVATE Own : INT Own := 8; END_METHOD
  Runs := Runs + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Square EXTENDS FB_Shape
  METHOD Area : INT Area := Size * Size; END_METHOD
  METHOD Tell : INT Tell := Secret() + SUPER^.Secret(); END_METHOD
  SUPER^();
  Runs := Runs + 10;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FINAL FB_Line EXTENDS FB_Square
  VAR Extra : INT := 1; END_VAR
  METHOD OVERRIDE Area : INT Area := SUPER^.Area() + Extra; END_METHOD
  METHOD FINAL Scale VAR_INPUT Amount : INT; END_VAR
    SUPER^.Scale(Amount := Amount + 1);
    THIS^.Size := Size + 100;
  END_METHOD
  PROPERTY Name : STRING GET Name := CONCAT('line of ', SUPER^.Name); END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_User
  VAR_INPUT Shape : I_Shape; END_VAR
  VAR_IN_OUT Any : FB_Shape; END_VAR
  VAR_OUTPUT Area : INT; Runs : INT; END_VAR
  Area := Shape.Area();
  Any();
  Runs := Any.Runs;
END_FUNCTION_BLOCK
FUNCTION FC_Total : INT
  VAR_INPUT First, Second : I_Shape; END_VAR
  FC_Total := First.Area() + Second.Area();
END_FUNCTION
"""


@pytest.mark.parametrize(
    ("body", "want", "expected"),
    [
        pytest.param("X := Square.Area(); Y := Line.Area();", "X Y", (4, 5), id="overridden"),
        pytest.param("X := Square.Double(); Y := Line.Double();", "X Y", (8, 10), id="virtual"),
        pytest.param("Line.Scale(2); X := Line.Size;", "X", 106, id="SUPER^ with an argument"),
        pytest.param("Square(); Square(Size := 5); X := Square.Runs;", "X", 22, id="SUPER^()"),
        pytest.param("Line(); X := Line.Runs;", "X", 0, id="a body is not inherited"),
        pytest.param("X := Square.Tell();", "X", 14, id="PROTECTED from below"),
        pytest.param("T := Line.Name;", "T", "line of shape", id="a property overridden"),
        pytest.param("S := Line; X := S.Area(); S := Square; Y := S.Area();", "X Y", (5, 4)),
        pytest.param("S := Square; S.Scale(3); X := Square.Size;", "X", 6, id="by an interface"),
        pytest.param("S := Square; N := S; T := N.Name;", "T", "shape", id="to a base interface"),
        pytest.param("B1 := S = 0; S := Square; B2 := S <> 0;", "B1 B2", (True, True)),
        pytest.param("S := Square; S2 := Square; B1 := S = S2; B2 := S <> S2;", "B1 B2",
                     (True, False)),
        pytest.param("S := Square; S := 0; B1 := S = 0;", "B1", True, id="taken away"),
        pytest.param("PI := ADR(All); All[2] := Line; X := PI[1].Area();", "X", 5, id="by pointer"),
        pytest.param(
            "All[1] := Square; All[2] := Line; FOR X := 1 TO 2 DO Y := Y + All[X].Area(); END_FOR;",
            "Y",
            9,
        ),
        pytest.param("User(Shape := Line, Any := Square); X := User.Area; Y := User.Runs;", "X Y",
                     (5, 11)),
        pytest.param("X := FC_Total(First := Square, Second := Line);", "X", 9,
                     id="given to a function"),
        pytest.param("R REF= Line; X := R.Area(); R(); Y := R.Runs;", "X Y", (5, 0),
                     id="by a reference"),
        pytest.param("P := ADR(Square); X := P^.Area(); P^(Size := 3); Y := P^.Size;", "X Y",
                     (4, 3)),
    ],
)  # fmt: skip
def test_a_call_runs_the_method_of_the_instance(
    body: str, want: str, expected: Any, build: Build
) -> None:
    variables = (
        "Square : FB_Square; Line : FB_Line; S, S2 : I_Shape; N : I_Named; User : FB_User;"
        "All : ARRAY [1..2] OF I_Shape; R : REFERENCE TO FB_Shape; P : POINTER TO FB_Shape;"
        "PI : POINTER TO I_Shape;"
        "X, Y : INT; T : STRING; B1, B2 : BOOL;"
    )
    assert _run(build, _SHAPES, variables, body, want) == expected


_STARTED = """
FUNCTION_BLOCK FB_Base
  VAR Trail : STRING; END_VAR
  METHOD FB_init : BOOL
    VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
    Trail := CONCAT(Trail, 'base;');
  END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Derived EXTENDS FB_Base
  METHOD FB_init : BOOL
    VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; END_VAR
    Trail := CONCAT(Trail, 'derived;');
  END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Axis
  VAR Number : INT; Name : STRING; END_VAR
  METHOD FB_init : BOOL
    VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; No : INT; Title : STRING; END_VAR
    Number := No;
    Name := Title;
  END_METHOD
  METHOD FB_exit : BOOL
    VAR_INPUT bInCopyCode : BOOL; END_VAR
    Number := -1;
  END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Machine
  VAR
    Axis : FB_Axis(No := 3, Title := 'turn');
    Inner : FB_Derived;
    Seen : INT;
    Here : POINTER TO INT := ADR(Seen);
  END_VAR
END_FUNCTION_BLOCK
"""


def test_fb_init_runs_once_before_the_first_scan(build: Build) -> None:
    """FB_init of the base runs first, with the arguments of the declaration.

    FB_exit is never called in a simulation.
    """
    program = build(
        _STARTED + "PROGRAM P VAR M : FB_Machine; END_VAR ; END_PROGRAM".replace(" ;", "")
    )
    assert program.read("Main.M.Axis.Number") == 3
    assert program.read("Main.M.Axis.Name") == "turn"
    assert program.read("Main.M.Inner.Trail") == "base;derived;"
    assert program.read("Main.M.Here") == "Main.M.Seen"
    program.scan(0)
    program.scan(10_000)
    assert program.read("Main.M.Inner.Trail") == "base;derived;"
    assert program.read("Main.M.Axis.Number") == 3


#: Wrong declarations: the text between FUNCTION_BLOCK and END_FUNCTION_BLOCK.
_REFUSED = [
    ("A EXTENDS B", "B is not a function block"),
    ("A EXTENDS TON", "TON is not a function block"),
    ("A EXTENDS A", "A uses A"),
    ("A EXTENDS FB_Square, FB_Line", "one block only"),
    ("A EXTENDS FB_Line", "FB_Line is FINAL"),
    ("A EXTENDS FB_Square VAR Kind : INT; END_VAR", "Kind is declared twice"),
    ("A IMPLEMENTS I_None", "there is no interface I_None"),
    ("A IMPLEMENTS FB_Line", "there is no interface FB_Line"),
    ("A IMPLEMENTS I_Shape", "missing in A: I_Named.Name.Get, I_Shape.Area"),
    ("A EXTENDS FB_Shape", "missing in A: FB_Shape.Area"),
    ("A EXTENDS FB_Square METHOD Area : DINT END_METHOD", "other parameters"),
    ("A METHOD OVERRIDE M END_METHOD", "no such method to override"),
    ("A METHOD M END_METHOD METHOD M END_METHOD", "M is declared twice"),
    ("A VAR M : INT; END_VAR METHOD M END_METHOD", "M is declared twice"),
    ("ABSTRACT A METHOD ABSTRACT M RETURN; END_METHOD", "has statements"),
    ("A PROPERTY P : INT END_PROPERTY", "neither GET nor SET"),
    ("A VAR S : FB_Shape; END_VAR", "FB_Shape is ABSTRACT"),
    ("A VAR S : FB_Square; END_VAR S.Area := 1;", "no member Area; call it"),
    ("A VAR S : FB_Square; END_VAR S.None();", "has no method None"),
    ("A VAR S : FB_Square; X : INT; END_VAR X := S.Secret();", "FB_Shape.Secret is PROTECTED"),
    ("A VAR S : FB_Square; X : INT; END_VAR X := S.Own();", "FB_Shape.Own is PRIVATE"),
    ("A EXTENDS FB_Square METHOD Q : INT Q := Own(); END_METHOD", "FB_Shape.Own is PRIVATE"),
    ("A VAR S : FB_Square; X : INT; END_VAR X := S.Scale(1);", "has no result"),
    ("A VAR S : FB_Square; END_VAR S.Scale(1, 2);", "takes 1 arguments, not 2"),
    ("A VAR S : FB_Square; END_VAR S.Scale(Into := 2);", "has no input Into; use Amount"),
    ("A VAR S : FB_Square; END_VAR S.Name := 'x';", "the property Name has no SET"),
    ("A VAR S : I_Shape; B : TON; END_VAR S := B;", "let it IMPLEMENT I_Shape"),
    ("A VAR N : I_Named; S : I_Shape; END_VAR S := N;", "I_Named does not implement it"),
    ("A VAR S : I_Shape; B : BOOL; END_VAR B := __QUERYINTERFACE(S, S);",
     "__QUERYINTERFACE cannot query I_Shape"),
    ("A SUPER^();", "A does not"),
    ("A EXTENDS FB_Shape METHOD Area : INT Area := SUPER^.Area(); END_METHOD",
     "is ABSTRACT and has no body"),
    ("A METHOD FB_init VAR_INPUT r, c : BOOL; n : INT; END_VAR END_METHOD "
     "END_FUNCTION_BLOCK FUNCTION_BLOCK B VAR X : A; END_VAR",
     "gives FB_init of A no arguments; write A(n := ...)"),
    ("A VAR X : FB_Square(n := 1); END_VAR", "no FB_init that takes arguments"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("source", "message"),
    [
        *((f"FUNCTION_BLOCK {text} END_FUNCTION_BLOCK", message) for text, message in _REFUSED),
        (
            "FUNCTION F : INT VAR_INPUT X : INT; END_VAR F := THIS^.X; END_FUNCTION",
            "belong to function blocks",
        ),
    ],
)
def test_a_mistake_is_reported(source: str, message: str, mistakes_of: Mistakes) -> None:
    errors = mistakes_of(_SHAPES + source)
    assert errors, "nothing was refused"
    assert message in str(errors[0])
    assert errors[0].line is not None
    assert errors[0].line >= len(_SHAPES.splitlines())


def test_an_interface_without_a_block_is_one_message(build: Build) -> None:
    program = build(
        _SHAPES + "PROGRAM P VAR S : I_Shape; X : INT; END_VAR\nX := S.Area();\nEND_PROGRAM"
    )
    with pytest.raises(InputError, match="no block has been assigned") as caught:
        program.scan(0)
    assert caught.value.line == len(_SHAPES.splitlines()) + 2


def test_methods_that_never_end_are_one_message(build: Build) -> None:
    program = build(
        "FUNCTION_BLOCK A\nMETHOD M\nM();\nEND_METHOD\nEND_FUNCTION_BLOCK\n"
        "PROGRAM P VAR X : A; END_VAR X.M(); END_PROGRAM"
    )
    with pytest.raises(InputError, match="too deep"):
        program.scan(0)


@pytest.mark.parametrize(
    ("before", "variables", "body", "want", "values"),
    [
        pytest.param(
            "FUNCTION_BLOCK FB_Cell VAR_INPUT V : INT := 1; END_VAR END_FUNCTION_BLOCK\n"
            "FUNCTION_BLOCK FB_Taker VAR_INPUT Held : FB_Cell; END_VAR\n"
            "METHOD Take : INT VAR_INPUT Given : FB_Cell; END_VAR\n"
            "Given.V := Given.V + 1; Take := Given.V; END_METHOD\nEND_FUNCTION_BLOCK\n",
            "C : FB_Cell; T : FB_Taker; X, Y, Z : INT;",
            "C.V := 5; T(Held := C); C.V := 7; X := T.Take(C); Y := T.Held.V; Z := C.V;",
            "X Y Z", (8, 5, 7), id="a block as an input is a copy"),
        pytest.param(
            "", "Final, Override, Internal, Public, Get, Set, Abstract : INT;",
            "Final := 1; Override := Final + 1; Internal := 3; Public := 4; Get := 5; Set := 6;",
            "Override Get Set", (2, 5, 6), id="words of methods stay names elsewhere"),
        pytest.param(
            "TYPE Base : STRUCT A : INT := 1; END_STRUCT; END_TYPE\n"
            "TYPE Longer EXTENDS Base : STRUCT B : INT := 2; END_STRUCT; END_TYPE\n",
            "L : Longer; X : INT;", "X := L.A * 10 + L.B;",
            "X L", (12, {"A": 1, "B": 2}), id="a structure extends another"),
    ],
)  # fmt: skip
def test_a_program_has_these_values(
    build: Build, before: str, variables: str, body: str, want: str, values: tuple[Any, ...]
) -> None:
    assert _run(build, before, variables, body, want) == values


@pytest.mark.parametrize("data", ["Data", "THIS^.Data"])
def test_a_method_works_on_the_in_out_of_its_block(data: str, build: Build) -> None:
    """A call of the method in the body gives 1 + 2.

    A later call from outside uses the VAR_IN_OUT of the block's last call: 3 + 3.
    """
    block = (
        "FUNCTION_BLOCK A VAR_IN_OUT Data : INT; END_VAR VAR Seen : INT; END_VAR\n"
        "METHOD Raise : INT VAR_INPUT By1 : INT; END_VAR\n"
        f"{data} := {data} + By1; Raise := {data};\nEND_METHOD\n"
        "Seen := THIS^.Raise(2);\nEND_FUNCTION_BLOCK\n"
    )
    body = "X(Data := I); J := I; K := X.Raise(3);"
    found = _run(build, block, "X : A; I : INT := 1; J, K : INT;", body, "J X.Seen K")
    assert found == (3, 3, 6)


@pytest.mark.parametrize(
    ("body", "want", "expected"),
    [
        ("Delay(IN := TRUE);", "Delay.IN", True),
        ("X := Drives.Servo.FC_Twice(4);", "X", 8),
        ("X := Servo.FC_Twice(In := 5) + FC_Twice(1);", "X", 12),
        ("X := Standard.LEN('four');", "X", 4),
        ("M.Set(); X := M.Get();", "X", 5),
    ],
)
def test_a_namespace_before_a_name_is_accepted(
    body: str, want: str, expected: Any, build: Build
) -> None:
    spaces = (
        "NAMESPACE Drives.Servo\n"
        "FUNCTION FC_Twice : INT VAR_INPUT In : INT; END_VAR FC_Twice := 2 * In; END_FUNCTION\n"
        "FUNCTION_BLOCK FB_Words VAR V : INT; END_VAR\n"
        "METHOD Set;\nVAR_INPUT n : INT := 5; END_VAR\nV := n;\nEND_METHOD\n"
        "METHOD Get : INT; Get := V; END_METHOD\nEND_FUNCTION_BLOCK\n"
        "END_NAMESPACE\nUSING Drives.Servo;\n"
    )
    assert (_run(build, spaces, "Delay : Tc2_Standard.TON; M : Drives.Servo.FB_Words; X : INT;",
                 body, want) == expected)  # fmt: skip


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("USING Nowhere;", "there is no namespace Nowhere"),
        (
            "FUNCTION_BLOCK A VAR X : Nowhere.TON; END_VAR END_FUNCTION_BLOCK",
            "no namespace Nowhere",
        ),
        (
            "FUNCTION_BLOCK A VAR X : INT; END_VAR X := Nowhere.LEN('a'); END_FUNCTION_BLOCK",
            "Nowhere",
        ),
    ],
)
def test_a_namespace_that_is_not_there_is_named(
    source: str, message: str, mistakes_of: Mistakes
) -> None:
    (error,) = mistakes_of(source)
    assert message in str(error)
