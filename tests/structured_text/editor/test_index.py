"""The index has each declared name, and each use in all files."""

from __future__ import annotations

from pathlib import Path

import pytest

from cursor import FOLDER, index_of
from structured_text.editor.index import Index, build
from structured_text.language.parser import read_text

_TYPES = "TYPE\n  Mode : (OFF, AUTO);\n  Point : STRUCT x : INT; END_STRUCT;\nEND_TYPE\n"
_PUMP = """FUNCTION_BLOCK Pump
VAR_INPUT Speed : INT; END_VAR
VAR_OUTPUT Busy : BOOL; END_VAR
METHOD Start : BOOL
VAR_INPUT How : Mode; END_VAR
Start := How = Mode#AUTO;
Busy := TRUE;
END_METHOD
END_FUNCTION_BLOCK
"""


def _uses(index: Index, key: str) -> list[tuple[str, int, int]]:
    """Return file, line and column of all uses of a name."""
    found = index.names.get(key)
    assert found is not None, key
    return [(Path(one.path).stem, *one.at) for one in index.uses([found])]


@pytest.mark.parametrize(
    ("body", "key", "uses"),
    [
        ("P.speed := 2;", "PUMP.SPEED", [("Main", 4, 3), ("Pump", 2, 11)]),
        ("P(Speed := 3);", "PUMP.SPEED", [("Main", 4, 3), ("Pump", 2, 11)]),
        ("P.Start(How := OFF);", "MODE.OFF", [("Main", 4, 16), ("Types", 2, 11)]),
        (
            "P.Start(How := OFF);",
            "PUMP.START.HOW",
            [("Main", 4, 9), ("Pump", 5, 11), ("Pump", 6, 10)],
        ),
        ("M := Mode.AUTO;", "MODE.AUTO", [("Main", 4, 11), ("Pump", 6, 21), ("Types", 2, 16)]),
        (
            "CASE M OF AUTO: ; END_CASE",
            "MODE.AUTO",
            [("Main", 4, 11), ("Pump", 6, 21), ("Types", 2, 16)],
        ),
        ("Q[1].x := 3;", "POINT.X", [("Main", 4, 6), ("Types", 3, 18)]),
        ("Level := 1;", "@GVL.LEVEL", [("Main", 4, 1), ("GVL", 1, 12)]),
        ("GVL.Level := 1;", "@GVL.LEVEL", [("Main", 4, 5), ("GVL", 1, 12)]),
        ("", "PUMP.BUSY", [("Pump", 3, 12), ("Pump", 7, 1)]),
        ("", "PUMP.START", [("Pump", 4, 8), ("Pump", 6, 1)]),
        ("", "PUMP", [("Main", 2, 9), ("Pump", 1, 16)]),
    ],
)
def test_uses_are_found_in_all_files(body: str, key: str, uses: list[tuple[str, int, int]]) -> None:
    """The places are counted by hand in the texts above."""
    declared = "P : Pump; M : Mode; Q : ARRAY [1..2] OF Point;"
    main = f"PROGRAM Main\nVAR {declared}\nEND_VAR\n{body}\nEND_PROGRAM\n"
    index = index_of(Main=main, Pump=_PUMP, GVL="VAR_GLOBAL Level : INT; END_VAR\n", Types=_TYPES)
    assert index.errors == []
    assert _uses(index, key) == uses


def test_an_inherited_pin_is_that_of_the_base() -> None:
    """Speed is declared in line 1 and used in lines 3 and 6."""
    text = """FUNCTION_BLOCK Base VAR_INPUT Speed : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK Pump EXTENDS Base
Speed := 2;
END_FUNCTION_BLOCK
PROGRAM Main VAR P : Pump; END_VAR
P(Speed := 1);
END_PROGRAM
"""
    index = index_of(Main=text)
    assert [place[1] for place in _uses(index, "BASE.SPEED")] == [1, 3, 6]


def test_a_var_external_is_the_global_itself() -> None:
    """The declaration in VAR_EXTERNAL and its use belong to the global variable."""
    text = """PROGRAM Main VAR_EXTERNAL Level : INT; END_VAR
Level := 1;
END_PROGRAM
"""
    index = index_of(Main=text, GVL="VAR_GLOBAL Level : INT; END_VAR\n")
    assert _uses(index, "@GVL.LEVEL") == [("Main", 1, 27), ("Main", 2, 1), ("GVL", 1, 12)]


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ("c := BOTH;", (3, 6)),
        ("IF BOTH = c THEN ; END_IF", (3, 4)),
        ("CASE c OF BOTH: ; END_CASE", (3, 11)),
        ("Twice(BOTH);", (3, 7)),
    ],
)
def test_a_member_of_two_enumerations_is_that_of_its_context(
    body: str, place: tuple[int, int]
) -> None:
    """Both enumerations have the member; the variable and the input are a Second."""
    types = """TYPE First : (BOTH, A); Second : (BOTH, B); END_TYPE
FUNCTION Twice : INT VAR_INPUT n : Second; END_VAR Twice := 1; END_FUNCTION
"""
    main = f"PROGRAM Main\nVAR c : Second; END_VAR\n{body}\nEND_PROGRAM\n"
    index = index_of(Main=main, Types=types)
    assert _uses(index, "SECOND.BOTH") == [("Main", *place), ("Types", 1, 35)]


def test_a_broken_statement_leaves_the_others_indexed() -> None:
    """Somebody is typing line 2; line 3 is still found."""
    index = index_of(Main="PROGRAM Main VAR a : INT; END_VAR\na := ;\na := 1;\nEND_PROGRAM\n")
    assert _uses(index, "MAIN.A") == [("Main", 1, 18), ("Main", 3, 1)]
    assert [error.line for error in index.errors] == [2]


def test_sources_without_a_body_are_indexed() -> None:
    """An enumeration member is the initial value of a variable in a list of globals."""
    index = index_of(GVL="VAR_GLOBAL M : Mode := AUTO; END_VAR\n", Types=_TYPES)
    assert _uses(index, "MODE.AUTO") == [("GVL", 1, 24), ("Types", 2, 16)]


def test_methods_that_override_each_other_are_a_family() -> None:
    """An interface, a block that implements it, and a block that extends that declare Run."""
    text = """INTERFACE Runs METHOD Run END_METHOD END_INTERFACE
FUNCTION_BLOCK One IMPLEMENTS Runs METHOD Run END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Two EXTENDS One METHOD Run END_METHOD END_FUNCTION_BLOCK
FUNCTION_BLOCK Other METHOD Run END_METHOD END_FUNCTION_BLOCK
"""
    index = index_of(Main=text)
    run = index.names.get("TWO.RUN")
    assert run is not None
    assert {one.key for one in index.family(run)} == {"RUNS.RUN", "ONE.RUN", "TWO.RUN"}


def test_the_index_knows_the_errors_of_the_check() -> None:
    """The undeclared variable is in line 2."""
    index = index_of(Main="PROGRAM Main VAR a : INT; END_VAR\na := b;\nEND_PROGRAM\n")
    assert [(error.file, error.line, error.message) for error in index.errors] == [
        (str(FOLDER / "Main.st"), 2, "b is not declared")
    ]


def test_an_index_after_a_change_of_a_body_uses_the_one_before() -> None:
    """Pump moves by one line; the uses in Main, which is unchanged, still lead to it."""
    main = "PROGRAM Main VAR P : Pump; END_VAR\nP(Speed := 1);\nEND_PROGRAM\n"
    block = "FUNCTION_BLOCK Pump VAR_INPUT Speed : INT; END_VAR\nEND_FUNCTION_BLOCK\n"
    texts = {FOLDER / "Main.st": main, FOLDER / "Pump.st": block}
    sources = {path: read_text(text, path) for path, text in texts.items()}
    before = build(list(texts), sources.__getitem__, texts.__getitem__)
    assert len(_uses(before, "PUMP.SPEED")) == 2
    newer = texts | {FOLDER / "Pump.st": f"\n{block}"}
    moved = [
        sources[path] if text == texts[path] else read_text(text, path)
        for path, text in newer.items()
    ]
    after = Index(moved, before.scopes, before.outside, [], newer.__getitem__, before, same=True)
    assert after.names.get("MAIN.P") is before.names.get("MAIN.P")
    assert _uses(after, "PUMP.SPEED") == [("Main", 2, 3), ("Pump", 2, 31)]


def test_a_pou_that_a_broken_text_hides_keeps_its_names() -> None:
    """The head of the program has a mistake, so that the parser does not see the program."""
    good = index_of(Main="PROGRAM Main VAR a : INT; END_VAR\na := 1;\nEND_PROGRAM\n")
    path = FOLDER / "Main.st"
    broken = "PROGRAM VAR a : INT; END_VAR\na := 1;\nEND_PROGRAM\n"
    source = read_text(broken, path)
    assert source.errors
    after = Index([source], {}, good.outside, [], lambda _: broken, good)
    assert after.scope("MAIN").symbol("A") is not None
