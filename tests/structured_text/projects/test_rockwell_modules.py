"""Tags of modules in an L5X are variables, with the types that the file shows.

The modules are short versions of a digital input card, a rack with an adapter, and a drive.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.source import source_text
from structured_text.projects.open import Sources, project_sources
from structured_text.projects.rockwell.uses import Use, module_uses
from structured_text.projects.xml import read_xml

_L5X = """<RSLogix5000Content><Controller Name="C"><Modules>{modules}</Modules>
<Tags>{shared}</Tags>
<Programs><Program Name="P" MainRoutineName="Main"><Tags>{tags}</Tags>
<Routines><Routine Name="Main" Type="ST"><STContent>
<Line Number="0"><![CDATA[{code}]]></Line>
</STContent></Routine></Routines></Program></Programs>
<Tasks><Task Name="T" Type="PERIODIC" Rate="10" Priority="10">
<ScheduledPrograms><ScheduledProgram Name="P"/></ScheduledPrograms></Task></Tasks>
</Controller></RSLogix5000Content>
"""
_CARD = """<Module Name="Card" ParentModule="Local" ParentModPortId="1">
<Ports><Port Id="1" Address="3" Type="ICP" Upstream="true"/></Ports>
<Communications><ConfigTag><Data Format="Decorated"><Structure DataType="AB:1756_DI:C:0">
<DataValueMember Name="Filter" DataType="SINT" Value="9"/></Structure></Data></ConfigTag>
<Connections><Connection Name="In"><InputTag>
<Data Format="Decorated"><Structure DataType="AB:1756_DI:I:0">
<DataValueMember Name="Fault" DataType="DINT" Value="2#0000_0001"/>
<DataValueMember Name="Data" DataType="DINT" Value="8"/>
<StructureMember Name="Pt00" DataType="CHANNEL:I:0">
<DataValueMember Name="Data" DataType="BOOL" Value="0"/></StructureMember>
</Structure></Data></InputTag>
<OutputTag><Data Format="Decorated"><Structure DataType="AB:1756_DO:O:0">
<ArrayMember Name="Words" DataType="INT" Dimensions="4"/></Structure></Data></OutputTag>
</Connection></Connections></Communications></Module>
"""
_DRIVE = """<Module Name="Pump" ParentModule="Net" ParentModPortId="2">
<Ports><Port Id="2" Address="10.0.0.3" Type="Ethernet" Upstream="true"/></Ports>
<Communications><Connections><Connection Name="Io" InputTagSuffix="I1"><InputTag>
<Data Format="Decorated"><Structure DataType="AB:PF:I:0">
<DataValueMember Name="Speed" DataType="REAL" Value="0"/></Structure></Data></InputTag>
</Connection></Connections></Communications></Module>
"""
_RACK = """<Module Name="Rack" ParentModule="Net" ParentModPortId="2">
<Ports><Port Id="1" Address="0" Type="PointIO" Upstream="false"/>
<Port Id="2" Address="10.0.0.4" Type="Ethernet" Upstream="true"/></Ports>
<Communications><Connections><Connection Name="Rack"><InputTag><Data Format="Decorated">
<Structure DataType="AB:1734_3SLOT:I:0">
<DataValueMember Name="SlotStatusBits0_31" DataType="DINT" Value="0"/>
<ArrayMember Name="Data" DataType="SINT" Dimensions="3"/></Structure></Data></InputTag>
</Connection></Connections></Communications></Module>
<Module Name="Point" ParentModule="Rack" ParentModPortId="1">
<Ports><Port Id="1" Address="2" Type="PointIO" Upstream="true"/></Ports>
<Communications><RackConnection><InAliasTag/></RackConnection></Communications></Module>
"""


def _sources(folder: Path, code: str, *, modules: str = "", shared: str = "") -> Sources:
    tags = "".join(f'<Tag Name="{one}" DataType="BOOL"/>' for one in "abc")
    tags += '<Tag Name="n" DataType="DINT"/><Tag Name="r" DataType="REAL"/>'
    file = folder / "cell.L5X"
    text = _L5X.format(modules=modules, shared=shared, tags=tags, code=code)
    file.write_text(text, encoding="utf-8")
    return project_sources([file], {})


def _program(sources: Sources) -> BuiltinProgram:
    program = BuiltinProgram.build(load(list(sources.paths)))
    program.scan(0)
    return program


def test_inputs_of_a_card_have_the_name_of_their_slot(tmp_path: Path) -> None:
    """A card in slot 3 has the tag Local:3:I, and a test sets its inputs.

    Source: 1756-PM004, I/O tag addresses, Location:SlotNumber:Type.MemberName.Bit.
    """
    code = "a := Local:3:I.Data.3; b := Local:3:I.Pt00.Data; n := Local:3:O.Words[2];"
    program = _program(_sources(tmp_path, code, modules=_CARD))
    assert [program.read(f"Main.{one}") for one in ("a", "b")] == [False, False]
    program.write("Local_3_I.Data", 8)
    program.write("Local_3_I.Pt00.Data", True)
    program.scan(10_000)
    assert [program.read(f"Main.{one}") for one in ("a", "b")] == [True, True]


def test_outputs_of_a_card_are_written(tmp_path: Path) -> None:
    """The program sets an element of the card's outputs, and reads it as a signed number."""
    code = "Local:3:O.Words[2] := -5; n := Local:3:O.Words[2];"
    program = _program(_sources(tmp_path, code, modules=_CARD))
    assert program.read("Main.n") == -5


def test_the_configuration_of_a_card_has_its_values(tmp_path: Path) -> None:
    """Inputs and outputs begin with 0, because the connection writes them; C has its values."""
    code = "n := Local:3:C.Filter; a := Local:3:I.Fault.0;"
    program = _program(_sources(tmp_path, code, modules=_CARD))
    assert [program.read(f"Main.{one}") for one in ("n", "a")] == [9, False]


def test_a_module_of_a_network_has_its_own_name(tmp_path: Path) -> None:
    """A drive on Ethernet has no slot; its connection names the suffix I1."""
    program = _program(_sources(tmp_path, "r := Pump:I1.Speed;", modules=_DRIVE))
    program.write("Pump_I1.Speed", 12.5)
    program.scan(10_000)
    assert program.read("Main.r") == 12.5


def test_a_slot_of_a_rack_is_part_of_the_adapter_s_inputs(tmp_path: Path) -> None:
    """Rack:2:I is an alias of Rack:I.Data[2]."""
    program = _program(_sources(tmp_path, "a := Rack:2:I.1;", modules=_RACK))
    assert program.read("Main.a") is False
    program.write("Rack_I.Data[2]", 2)
    program.scan(10_000)
    assert program.read("Main.a") is True


def test_only_tags_that_the_program_uses_are_declared(tmp_path: Path) -> None:
    """Of a card only the inputs are declared if nothing uses its outputs."""
    sources = _sources(tmp_path, "a := Local:3:I.Data.3;", modules=_CARD + _DRIVE)
    text = "\n".join(source_text(path) for path in sources.paths)
    assert "Local_3_I : AB_1756_DI_I_0;" in text
    assert "_O" not in text.upper()
    assert "Pump" not in text


def test_an_alias_of_an_input_of_a_module(tmp_path: Path) -> None:
    """A tag of the controller stands for a bit of the card."""
    shared = '<Tag Name="Start" TagType="Alias" AliasFor="Local:3:I.Data.7"/>'
    program = _program(_sources(tmp_path, "a := Start;", modules=_CARD, shared=shared))
    program.write("Local_3_I.Data", 128)
    program.scan(10_000)
    assert program.read("Main.a") is True


def test_bits_show_the_type_of_a_module_without_data(tmp_path: Path) -> None:
    """Only bits are used, so that the width of the whole number does not matter. A note says so."""
    sources = _sources(tmp_path, "a := Local:1:I.Data.5; b := Local:1:I.Data.31;")
    assert [note.partition(": ")[2] for note in sources.notes] == [
        "the type of Local:1:I is made from its uses, because the file has no data of this module"
    ]
    program = _program(sources)
    program.write("Local_1_I.Data", 32)
    program.scan(10_000)
    assert [program.read(f"Main.{one}") for one in ("a", "b")] == [True, False]


@pytest.mark.parametrize(
    "code",
    ["n := Local:1:I.Data;", "a := Local:1:I.Data.5; n := Local:1:I.Data;", "a := X:I.D[n].1;"],
)
def test_a_number_of_a_module_without_data_is_refused(tmp_path: Path, code: str) -> None:
    """The width and sign of a number cannot be seen from its uses. The tag is named."""
    with pytest.raises(InputError, match=r"there is no tag (Local:1|X):I in this file") as failed:
        _sources(tmp_path, code)
    assert "decorated data" in failed.value.message


def test_members_of_a_predefined_type_are_data(tmp_path: Path) -> None:
    """The bits of a MESSAGE and of an axis can be read; their values are not computed."""
    shared = '<Tag Name="M" DataType="MESSAGE"/><Tag Name="X" DataType="AXIS_CIP_DRIVE"/>'
    code = "a := M.DN; b := X.ServoActionStatus; r := X.ActualPosition;"
    program = _program(_sources(tmp_path, code, shared=shared))
    program.write("M.DN", True)
    program.write("X.ActualPosition", 2.5)
    program.scan(10_000)
    assert [program.read(f"Main.{one}") for one in ("a", "b", "r")] == [True, False, 2.5]


def test_an_unknown_member_of_a_predefined_type_is_named(tmp_path: Path) -> None:
    """A member that is not known is refused with its name."""
    with pytest.raises(InputError, match="M has no member Unknown"):
        _sources(tmp_path, "a := M.Unknown;", shared='<Tag Name="M" DataType="MESSAGE"/>')


def test_a_type_that_only_values_describe(tmp_path: Path) -> None:
    """The members of a structure that no declaration describes come from the values of its tag."""
    shared = (
        '<Tag Name="S" DataType="VENDOR:TYPE"><Data Format="Decorated">'
        '<Structure DataType="VENDOR:TYPE"><DataValueMember Name="Level" DataType="REAL"'
        ' Value="1.5"/></Structure></Data></Tag>'
    )
    program = _program(_sources(tmp_path, "r := S.Level;", shared=shared))
    assert program.read("Main.r") == 1.5


def test_a_module_of_a_network_with_numbers_has_its_own_name(tmp_path: Path) -> None:
    """The address 3 on ControlNet is not a slot."""
    drive = _DRIVE.replace('Address="10.0.0.3" Type="Ethernet"', 'Address="3" Type="ControlNet"')
    assert drive != _DRIVE
    program = _program(_sources(tmp_path, "r := Pump:I1.Speed;", modules=drive))
    assert program.read("Main.r") == 0.0


def test_bits_of_an_alias_show_the_type_of_a_module_without_data(tmp_path: Path) -> None:
    """The alias stands for the whole tag of the module; the program uses its bits."""
    shared = '<Tag Name="Panel" TagType="Alias" AliasFor="Net:2:O"/>'
    program = _program(_sources(tmp_path, "Panel.Data.5 := TRUE; a := TRUE;", shared=shared))
    assert program.read("Net_2_O.Data") == 32


def _uses(folder: Path, text: str) -> dict[str, Use]:
    file = folder / "uses.L5X"
    file.write_text(f"<A><Routine><Text>XIC(s:fs)OTE(a);</Text><Line>{text}</Line></Routine></A>")
    return module_uses(read_xml(file))


def test_an_assignment_that_is_not_retentive_is_not_an_index(tmp_path: Path) -> None:
    """The brackets of `[:=]`, in a chart of Logix, are not those of an element."""
    found = _uses(tmp_path, "Net:2:O.Data.6[:=]1;")["NET:2:O"].members["DATA"]
    assert found.shape() == "DINT"


def test_the_flag_of_the_first_scan_is_not_a_tag_of_a_module(tmp_path: Path) -> None:
    """It may be in small letters."""
    assert list(_uses(tmp_path, "X:1:I.Data.1 := TRUE;")) == ["X:1:I"]


def test_values_of_the_controller_are_left_to_the_test(tmp_path: Path) -> None:
    """GSV in Structured Text keeps its destination, SSV and EVENT do nothing; a note names each."""
    code = "GSV(Module, Card, EntryStatus, n); SSV(Task, THIS, Rate, n); EVENT(Fast); a := TRUE;"
    sources = _sources(tmp_path, code)
    assert [note.partition(": ")[2] for note in sources.notes] == [
        "GSV of Module Card, EntryStatus does not read it, and n keeps its value; "
        "a test can set it",
        "SSV of Task THIS, Rate does not set it",
        "EVENT does not start the task Fast, because a task of events does not run",
    ]
    program = _program(sources)
    program.write("Main.n", 7)
    program.scan(10_000)
    assert [program.read(f"Main.{name}") for name in ("n", "a")] == [7, True]


@pytest.mark.parametrize(
    ("code", "why"),
    [
        ("GSV(Axis, X, Y, n);", "GSV of Axis is not supported"),
        ("GSV(Module, X, n);", "GSV has 3 operands"),
        ("GSV(Module, X, Y, q);", "there is no tag q"),
    ],
)
def test_a_wrong_value_of_the_controller_is_named(tmp_path: Path, code: str, why: str) -> None:
    with pytest.raises(InputError, match=why):
        _sources(tmp_path, code)
