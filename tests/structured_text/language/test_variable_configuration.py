"""VAR_CONFIG sets addresses of variables inside the instances of a program."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.errors import InputError
from structured_text.language.project import Project

_BLOCK = """\
FUNCTION_BLOCK Io
VAR xIn AT %I* : BOOL; xOut AT %Q* : BOOL; w AT %Q* : WORD; fixed AT %M* : INT; plain : INT; END_VAR
xOut := NOT xIn;
END_FUNCTION_BLOCK
PROGRAM PLC_PRG
VAR a : Io; b : ARRAY [1..2] OF Io; own AT %QX7.0 : BOOL; END_VAR
a(); b[1](); b[2]();
END_PROGRAM
"""


def test_each_instance_has_its_address(project_of: Callable[[str], Project]) -> None:
    """VAR_CONFIG gives a variable a different address in each instance.

    Source: help of CODESYS, variable configuration; %M* gets the first free place.
    """
    project = project_of(
        f"{_BLOCK}VAR_CONFIG\nPLC_PRG.a.xIn AT %IX1.0 : BOOL;\nplc_prg.A.XOUT AT %QX0.3 : BOOL;\n"
        "PLC_PRG.b[2].xIn AT %IX1.1 : BOOL;\nApplication.PLC_PRG.a.w AT %QW4 : WORD;\n"
        "PLC_PRG.a.plain AT %MW20 : INT;\nEND_VAR\n"
    )
    found = {one.path: one.address for one in project.located}
    assert found == {
        "Main.a.xIn": "%IX1.0",
        "Main.a.xOut": "%QX0.3",
        "Main.b[2].xIn": "%IX1.1",
        "Main.a.w": "%QW4",
        "Main.a.plain": "%MW20",
        "Main.a.fixed": "%MW0",
        "Main.own": "%QX7.0",
    }


def test_a_configuration_names_its_instance(project_of: Callable[[str], Project]) -> None:
    """A CONFIGURATION gives addresses by the name of its program instance.

    Source: IEC 61131-3, edition 3, 6.8.2.
    """
    project = project_of(
        "PROGRAM Main1 VAR x : BOOL; END_VAR END_PROGRAM\nCONFIGURATION C\n"
        "TASK T(INTERVAL := T#10ms, PRIORITY := 1);\nPROGRAM P WITH T : Main1;\n"
        "VAR_CONFIG P.x AT %IX0.0 : BOOL; END_VAR\nEND_CONFIGURATION\n"
    )
    assert [(one.path, one.address) for one in project.located] == [("P.x", "%IX0.0")]


_WRONG = [
    ("PLC_PRG.a.nope AT %IX1.0 : BOOL;", "Main.a has no variable nope"),
    ("PLC_PRG.a.xIn AT %QX1.0 : BOOL;", "Main.a.xIn is declared AT %I*, which %QX1.0 does not fit"),
    ("PLC_PRG.a.xIn AT %IW1 : WORD;", "Main.a.xIn is a BOOL, not a WORD"),
    ("PLC_PRG.a.w AT %QX1.0 : WORD;", "a WORD does not fit the address %QX1.0"),
    ("PLC_PRG.b[3].xIn AT %IX1.0 : BOOL;", "index 3 is outside 1..2"),
    ("Other.a AT %IX1.0 : BOOL;", "there is no program instance Other"),
    ("PLC_PRG.a.xIn : BOOL;", "an entry of VAR_CONFIG needs an address"),
    ("PLC_PRG.a.xIn AT %I* : BOOL;", "VAR_CONFIG needs a complete address"),
    ("PLC_PRG.a.xIn AT %IX0.0 : BOOL := TRUE;",
     "an initial value in VAR_CONFIG is not supported"),
    ("PLC_PRG.own AT %QX0.1 : BOOL;", "Main.own has the address %QX7.0 at its declaration"),
    ("PLC_PRG.a.w AT %QW1 : WORD; PLC_PRG.a.w AT %QW2 : WORD;",
     "Main.a.w has two addresses in VAR_CONFIG"),
]  # fmt: skip


@pytest.mark.parametrize(("entry", "message"), _WRONG, ids=[one[1] for one in _WRONG])
def test_a_wrong_entry_has_its_line(
    entry: str, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    (error,) = mistakes_of(f"{_BLOCK}VAR_CONFIG\n{entry}\nEND_VAR\n")
    assert (error.message, error.line) == (message, _BLOCK.count("\n") + 2)
