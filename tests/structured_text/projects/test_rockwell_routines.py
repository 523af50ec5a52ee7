"""Routines with parameters in an L5X: JSR passes values, SBR receives them, RET returns values."""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import main_body, program, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.projects.model import Foreign
from structured_text.projects.open import project_sources

_L5X = """<RSLogix5000Content><Controller Name="C"><DataTypes>
<DataType Name="Point"><Members><Member Name="X" DataType="DINT" Dimension="0"/></Members>
</DataType></DataTypes>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>
<Tag Name="a" DataType="DINT"/><Tag Name="b" DataType="DINT"/><Tag Name="c" DataType="DINT"/>
<Tag Name="r" DataType="REAL"/><Tag Name="i" DataType="INT"/><Tag Name="p" DataType="Point"/>
<Tag Name="q" DataType="Point"/><Tag Name="w" DataType="DINT" Dimensions="3"/>
<Tag Name="v" DataType="DINT" Dimensions="3"/><Tag Name="small" DataType="INT" Dimensions="2"/>
<Tag Name="x" DataType="DINT"/><Tag Name="y" DataType="DINT"/>
</Tags><Routines>
<Routine Name="Main" Type="ST"><STContent><Line Number="0"><![CDATA[{main}]]></Line>
</STContent></Routine>
<Routine Name="Sub" Type="ST"><STContent><Line Number="0"><![CDATA[{sub}]]></Line>
</STContent></Routine></Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""


def _program(folder: Path, main: str, sub: str) -> BuiltinProgram:
    file = folder / "cell.L5X"
    file.write_text(_L5X.format(main=main, sub=sub), encoding="utf-8")
    return BuiltinProgram.build(load(list(project_sources([file], {}).paths)))


def _refused(folder: Path, main: str, sub: str) -> str:
    with pytest.raises(InputError) as failed:
        _program(folder, main, sub)
    return failed.value.message


def test_sbr_gets_the_inputs_and_jsr_the_values_of_ret(tmp_path: Path) -> None:
    """2 and a + 1 = 8 are copied to x and y; RET gives their sum and their product.

    Source: 1756-RM003, JSR, SBR and RET.
    """
    main = "a := 7; JSR(Sub, 2, 2, a + 1, b, c);"
    program = _program(tmp_path, main, "SBR(x, y); RET(x + y, x * y);")
    program.scan(0)
    assert [program.read(f"Main.{one}") for one in "xybc"] == [2, 8, 10, 16]


def test_ret_ends_the_routine(tmp_path: Path) -> None:
    """Statements behind a RET are not executed. A RET in an IF returns its own value."""
    sub = "SBR(x); IF x > 5 THEN RET(1); END_IF; y := y + 1; RET(2); y := 100;"
    program = _program(tmp_path, "a := a + 3; JSR(Sub, 1, a, b);", sub)
    seen = []
    for scan in range(3):
        program.scan(scan * 10_000)
        seen.append((program.read("Main.b"), program.read("Main.y")))
    assert seen == [(2, 1), (1, 1), (1, 1)]


def test_the_tags_of_sbr_keep_their_values_after_the_call(tmp_path: Path) -> None:
    """SBR copies to tags of the program, so another routine reads them. A RET needs no value."""
    program = _program(tmp_path, "JSR(Sub, 1, 5); a := x;", "SBR(x); RET();")
    program.scan(0)
    assert program.read("Main.a") == 5


def test_whole_structures_and_arrays_are_passed(tmp_path: Path) -> None:
    """A structure and an array are copied as a whole. Source: 1756-RM003, JSR, parameters."""
    main = "p.X := 4; w[2] := 9; JSR(Sub, 2, p, w, a);"
    program = _program(tmp_path, main, "SBR(q, v); RET(q.X + v[2]);")
    program.scan(0)
    assert program.read("Main.a") == 13


def test_an_element_of_an_array_of_int_is_a_parameter(tmp_path: Path) -> None:
    """An element of an array of INT is stored as a WORD, and passed with its sign."""
    main = "small[1] := -3; JSR(Sub, 1, small[1], a);"
    program = _program(tmp_path, main, "SBR(i); RET(i - 1);")
    program.scan(0)
    assert [program.read("Main.i"), program.read("Main.a")] == [-3, -4]


def test_more_inputs_than_sbr_has_are_ignored(tmp_path: Path) -> None:
    """Source: 1756-RM003, JSR: a fault needs fewer inputs than SBR; more are no fault."""
    program = _program(tmp_path, "JSR(Sub, 2, 5, a);", "SBR(x);")
    program.scan(0)
    assert program.read("Main.x") == 5


@pytest.mark.parametrize(
    ("main", "sub", "reason"),
    [
        ("JSR(Sub, 1, 5);", "SBR(x, y);", "JSR passes 1 inputs to Sub, whose SBR has 2"),
        ("JSR(Sub, 0, a);", "a := 1;", "JSR expects 1 or more values from Sub, whose RET has 0"),
        ("JSR(Sub, 1, r);", "SBR(x);", "JSR passes r, a REAL, to Sub, whose SBR has a DINT there"),
        ("JSR(Sub, 0, r);", "RET(x);", "JSR copies a DINT of Sub to r, a REAL"),
        ("JSR(Sub, a, r);", "RET(x);", "the second operand of JSR is 'a'"),
        ("JSR(Suc, 0);", "RET(x);", "there is no routine Suc in this program"),
    ],
)
def test_parameters_that_the_controller_refuses_are_named(
    tmp_path: Path, main: str, sub: str, reason: str
) -> None:
    """Source: 1756-RM003, JSR: fault 4:31, and equal types of related parameters."""
    assert reason in _refused(tmp_path, main, sub)


def test_parameters_of_ladder_routines(tmp_path: Path) -> None:
    """JSR passes 5 and i; RET returns their sum and leaves the routine. Without power, nothing.

    Source: 1756-RM003, JSR, SBR and RET.
    """
    routines = {"Sub": ["SBR(list[0],list[1]);", "ADD(list[0],list[1],list[2])RET(list[2]);"]}
    routines["Sub"].append("MOV(1,k);")
    running = program(written(tmp_path, ["XIC(a)JSR(Sub,2,5,i,j);"], routines=routines))
    running.write("Main.i", 37)
    running.scan(0)
    assert running.read("Main.j") == 0
    running.write("Main.a", True)
    running.scan(10_000)
    assert [running.read("Main.j"), running.read("Main.k")] == [42, 0]


@pytest.mark.parametrize(
    ("limits", "total", "index"),
    [("1,4,1", 10, 5), ("4,1,-2", 6, 0), ("3,2,1", 0, 3), ("1,j,k", 4, 5)],
)
def test_for_executes_a_routine_for_each_value(
    tmp_path: Path, limits: str, total: int, index: int
) -> None:
    """1 + 2 + 3 + 4 is 10; 4 + 2 is 6; nothing; 1 + 3 with tags for the limit and the step."""
    routines = {"Sub": ["CPT(v,v+i);"]}
    running = program(written(tmp_path, [f"FOR(Sub,i,{limits});"], routines=routines))
    running.write("Main.j", 4)
    running.write("Main.k", 2)
    running.scan(0)
    assert [running.read(f"Main.{name}") for name in ("v", "i")] == [total, index]


def test_brk_ends_the_for(tmp_path: Path) -> None:
    """The routine is left at the index 3, so that it adds 1 and 2."""
    routines = {"Sub": ["EQU(i,3)BRK();", "ADD(j,i,j);"]}
    running = program(written(tmp_path, ["FOR(Sub,i,1,9,1)ADD(k,1,k);"], routines=routines))
    running.scan(0)
    assert [running.read(f"Main.{name}") for name in "jik"] == [3, 3, 1]


def test_a_for_without_a_step_is_named(tmp_path: Path) -> None:
    body = main_body(written(tmp_path, ["FOR(Sub,i,1,9,0);"], routines={"Sub": ["NOP();"]}))
    assert isinstance(body, Foreign)
    assert "rung 0: the step of FOR is 0" in body.why


def test_a_program_may_have_the_name_of_a_tag(tmp_path: Path) -> None:
    """Tags and programs have names of their own on the controller. The program is renamed."""
    file = written(tmp_path, ["ADD(i,1,i);"])
    tags = '<Tags><Tag Name="P" TagType="Base" DataType="DINT"/></Tags><Programs>'
    file.write_text(file.read_text("utf-8").replace("<Programs>", tags, 1), encoding="utf-8")
    running = program(file)
    running.scan(0)
    assert running.read("Main.i") == 1
    assert running.read("P") == 0
