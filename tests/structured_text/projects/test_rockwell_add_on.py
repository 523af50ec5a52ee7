"""Add-On Instructions with ladder logic, and their calls in rungs.

Source: Rockwell 1756-PM010, scan modes and parameters.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from l5x_ladder import main_body, program, read, routine, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_PARAMETERS = """
<Parameter Name="EnableIn" DataType="BOOL" Usage="Input" Required="false"/>
<Parameter Name="EnableOut" DataType="BOOL" Usage="Output" Required="false"/>
<Parameter Name="Raw" DataType="DINT" Usage="Input" Required="true"/>
<Parameter Name="Extra" DataType="DINT" Usage="Input" Required="false"/>
<Parameter Name="Value" DataType="DINT" Usage="Output" Required="true"/>
<Parameter Name="Total" DataType="DINT" Usage="InOut" Required="true"/>
<Parameter Name="On" DataType="BOOL" Usage="Output" Required="false"/>
"""
_LOGIC = ["MUL(Raw,2,Value)ADD(Total,Value,Total);", "GRT(Raw,Extra)OTE(On);"]
_TAGS = {"m": "Scale", "total": "DINT"}


def _written(
    folder: Path,
    *rungs: str,
    logic: Sequence[str] = _LOGIC,
    false: Sequence[str] = (),
    attributes: str = "",
    tags: Mapping[str, str] | None = None,
) -> Path:
    routines = routine("Logic", logic) + (routine("EnableInFalse", false) if false else "")
    aoi = (
        f'<AddOnInstructionDefinition Name="Scale"{attributes}><Parameters>{_PARAMETERS}'
        f"</Parameters><Routines>{routines}</Routines></AddOnInstructionDefinition>"
    )
    return written(folder, rungs, tags={**_TAGS, **(tags or {})}, aois=aoi)


def _run(running: BuiltinProgram, **values: object) -> None:
    for name, value in values.items():
        running.write(f"Main.{name}", value)
    running.scan(0)


def test_a_call_passes_its_required_parameters(tmp_path: Path) -> None:
    """Raw gets 7, Value goes to j, and Total is the tag itself; the name On gets a suffix."""
    running = program(_written(tmp_path, "Scale(m,i,j,total)OTE(a);"))
    _run(running, i=7, total=100)
    found = [running.read(f"Main.{name}") for name in ("j", "total", "m.On_1", "a")]
    assert found == [14, 114, True, True]


def test_arguments_are_converted(tmp_path: Path) -> None:
    """An INT becomes the input's DINT, and the DINT output is written to a REAL and to an element.

    A REAL input of 2.5 is rounded to 2.
    """
    rungs = "Scale(m,v,x,total)Scale(m,x,list[i],total)Scale(m,2.5,bytes[1],total);"
    running = program(_written(tmp_path, rungs))
    _run(running, v=-3, i=2)
    assert [running.read(f"Main.{name}") for name in ("x", "list[2]")] == [-6.0, -12]
    assert running.read("Main.total") == -14


def test_without_power_the_logic_does_not_run(tmp_path: Path) -> None:
    """Without power outputs stay, and the coil behind the call is FALSE."""
    running = program(_written(tmp_path, "XIC(b)Scale(m,i,j,total)OTE(a);"))
    _run(running, i=7, j=3)
    assert [running.read(f"Main.{name}") for name in ("j", "total", "a")] == [3, 0, False]


def test_without_power_the_inputs_are_passed(tmp_path: Path) -> None:
    """Inputs get their values although the logic does not run; a later rung reads them.

    Source: 1756-PM010, scan mode False: input parameters are passed values.
    """
    running = program(_written(tmp_path, "XIC(b)Scale(m,i,j,total);", "MOV(m.Raw,k);"))
    _run(running, i=7)
    assert running.read("Main.k") == 7


def test_enable_in_false_runs_in_place_of_the_logic(tmp_path: Path) -> None:
    """Without power the routine EnableInFalse sets Value to -1, and passes it to j."""
    attributes = ' ExecuteEnableInFalse="true"'
    file = _written(
        tmp_path, "XIC(b)Scale(m,i,j,total)OTE(a);", false=["MOV(-1,Value);"], attributes=attributes
    )
    running = program(file)
    _run(running, i=7)
    assert [running.read(f"Main.{name}") for name in ("j", "total", "a")] == [-1, 0, False]
    _run(running, b=True)
    assert [running.read(f"Main.{name}") for name in ("j", "total", "a")] == [14, 14, True]


def test_enable_in_false_is_not_used_if_it_is_switched_off(tmp_path: Path) -> None:
    """A routine EnableInFalse runs only if the instruction says so."""
    file = _written(
        tmp_path,
        "XIC(b)Scale(m,i,j,total);",
        false=["MOV(-1,Value);"],
        attributes=' ExecuteEnableInFalse="false"',
    )
    running = program(file)
    _run(running, i=7, j=3)
    assert running.read("Main.j") == 3


def test_an_unread_enable_in_false_makes_the_instruction_unread(tmp_path: Path) -> None:
    """The instruction is not run with a half of its routines; the reason names the routine."""
    file = _written(
        tmp_path,
        "XIC(b)Scale(m,i,j,total);",
        false=["XYZ(1);"],
        attributes=' ExecuteEnableInFalse="true"',
    )
    (block,) = [unit.piece for unit in read(file).units if unit.name == "Scale"]
    assert isinstance(block.body, Foreign)
    assert "its routine EnableInFalse is not read: rung 0: the instruction XYZ" in block.body.why


def test_enable_out_decides_whether_power_passes(tmp_path: Path) -> None:
    """EnableOut is TRUE at first; the logic clears it if Raw is 5, and the coil has no power."""
    logic = ["EQU(Raw,5)OTU(EnableOut);"]
    running = program(_written(tmp_path, "Scale(m,i,j,total)OTE(a);", logic=logic))
    seen = []
    for value in (4, 5, 6):
        _run(running, i=value)
        seen.append(running.read("Main.a"))
    assert seen == [True, False, True]


def test_enable_in_is_true_while_the_logic_runs(tmp_path: Path) -> None:
    """The logic may read EnableIn."""
    running = program(
        _written(tmp_path, "Scale(m,i,j,total);", logic=["XIC(EnableIn)MOV(9,Value);"])
    )
    _run(running)
    assert running.read("Main.j") == 9


@pytest.mark.parametrize(
    ("rung", "why"),
    [
        ("Scale(m,i,j);", "rung 0: SCALE has 2 operands behind its instance, not 3: Raw, Value"),
        ("Scale(i,i,j,total);", "rung 0: i is not a SCALE"),
        ("Scale(m,?,j,total);", "rung 0: SCALE has no operand 2"),
        ("Scale(m,i,j,x);", "rung 0: x is not a DINT, as the in-out parameter of SCALE is"),
        ("Scale(m,i,j,5);", "rung 0: a tag is needed here, not '5'"),
    ],
)
def test_a_wrong_argument_is_named(tmp_path: Path, rung: str, why: str) -> None:
    """The reason has the rung and the instruction."""
    body = main_body(_written(tmp_path, rung))
    assert isinstance(body, Foreign)
    assert body.why.startswith(why)


def test_a_parameter_may_be_a_bit_of_a_local_tag(tmp_path: Path) -> None:
    """An alias of `Word.2` is a BOOL, and the call reads it behind the logic."""
    parameters = (
        '<Parameter Name="EnableIn" DataType="BOOL" Usage="Input" Required="false"/>'
        '<Parameter Name="Third" TagType="Alias" AliasFor="Word.2" Usage="Output"'
        ' Required="true"/>'
    )
    aoi = (
        f'<AddOnInstructionDefinition Name="Bits"><Parameters>{parameters}</Parameters>'
        '<LocalTags><LocalTag Name="Word" DataType="DINT"/></LocalTags>'
        f"<Routines>{routine('Logic', ['MOV(4,Word);'])}</Routines></AddOnInstructionDefinition>"
    )
    running = program(written(tmp_path, ["Bits(n,a);"], tags={"n": "Bits"}, aois=aoi))
    _run(running)
    assert running.read("Main.a") is True


def test_the_value_of_a_structure_does_not_set_enable_in(tmp_path: Path) -> None:
    """A member that is an instance begins with its values, but EnableIn is not among them."""
    file = _written(tmp_path, "Scale(u.inner,i,j,total);", tags={"u": "Outer"})
    types = (
        '<DataTypes><DataType Name="Outer"><Members><Member Name="inner" DataType="Scale"'
        ' Dimension="0"/></Members></DataType></DataTypes>'
    )
    value = (
        '<Data Format="Decorated"><Structure DataType="Outer"><StructureMember Name="inner"'
        ' DataType="Scale"><DataValueMember Name="EnableIn" DataType="BOOL" Value="1"/>'
        '<DataValueMember Name="Extra" DataType="DINT" Value="5"/></StructureMember>'
        "</Structure></Data>"
    )
    text = file.read_text(encoding="utf-8")
    text = text.replace('<Controller Name="C">', f'<Controller Name="C">{types}')
    tag = '<Tag Name="u" TagType="Base" DataType="Outer"'
    file.write_text(text.replace(f"{tag}/>", f"{tag}>{value}</Tag>"), encoding="utf-8")
    running = program(file)
    _run(running, i=4)
    assert [running.read(f"Main.{name}") for name in ("j", "u.inner.On_1")] == [8, False]
    _run(running, i=6)
    assert running.read("Main.u.inner.On_1") is True


def test_parameters_and_aliases_show_the_types_of_a_modules_tag(tmp_path: Path) -> None:
    """The file has no data of the module. Raw is a DINT, so Ch0 is one; an XIC shows a BOOL."""
    file = _written(tmp_path, "Scale(m,Card.Ch0,j,total);", "XIC(Ready)OTE(a);")
    text = file.read_text(encoding="utf-8")
    aliases = (
        '<Tag Name="Card" TagType="Alias" AliasFor="Rack:2:I"/>'
        '<Tag Name="Ready" TagType="Alias" AliasFor="Rack:2:I.Pt0.Data"/>'
        '<Tag Name="Spare" TagType="Alias" AliasFor="Rack:2:I.Ch7"/>'
    )
    file.write_text(text.replace("<Tags>", f"<Tags>{aliases}", 1), encoding="utf-8")
    notes = read(file).notes
    assert any("Rack:2:I" in note for note in notes)
    running = program(file)
    running.write("Rack_2_I.Ch0", 21)
    running.write("Rack_2_I.Pt0.Data", True)
    _run(running)
    assert [running.read(f"Main.{name}") for name in ("j", "a")] == [42, True]


def test_an_output_may_stand_for_a_member_of_a_local_tag(tmp_path: Path) -> None:
    """Lost is the member DN of the local timer; its type is that of the member, BOOL."""
    aoi = (
        '<AddOnInstructionDefinition Name="Watch"><Parameters><Parameter Name="Lost"'
        ' TagType="Alias" AliasFor="Timer.DN" Usage="Output" Required="false"/></Parameters>'
        '<LocalTags><LocalTag Name="Timer" DataType="TIMER"/></LocalTags><Routines>'
        f"{routine('Logic', ['TON(Timer,?,?);'])}</Routines></AddOnInstructionDefinition>"
    )
    rungs = ["Watch(w);", "XIC(w.Lost)OTE(b);"]
    running = program(written(tmp_path, rungs, tags={"w": "Watch"}, aois=aoi))
    running.scan(0)
    assert running.read("Main.b") is True


def test_an_output_may_be_that_of_the_instance(tmp_path: Path) -> None:
    """The call names Value of its own instance, which needs no assignment."""
    running = program(_written(tmp_path, "Scale(m,i,m.Value,total);"))
    _run(running, i=7)
    assert running.read("Main.m.Value") == 14


def test_rungs_of_enable_in_false_name_their_routine(tmp_path: Path) -> None:
    """The rung 0 of Logix and that of EnableInFalse are different rungs."""
    false, attributes = ["CLR(Value);"], ' ExecuteEnableInFalse="true"'
    file = _written(tmp_path, "Scale(m,i,j,total);", false=false, attributes=attributes)
    (unit,) = [one for one in read(file).units if one.name == "Scale"]
    body = unit.piece.body
    assert not isinstance(body, Foreign)
    networks = list(dict.fromkeys(line.network for line in body if line.network))
    assert networks == ["rung 0", "rung 1", "rung 0 of EnableInFalse"]
