"""Types that an L5X uses without a definition, from their uses; other gaps of exported files.

Expected values are computed by hand from the rungs.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from l5x_ladder import main_body, program, read, written
from structured_text.engines.builtin import BuiltinProgram
from structured_text.projects.model import Foreign

_PAIR = """<DataTypes><DataType Name="Pair"><Members>
<Member Name="Left" DataType="DINT"/><Member Name="Right" DataType="REAL"/>
</Members></DataType></DataTypes><AddOnInstructionDefinitions>"""


def _file(
    folder: Path,
    rungs: Sequence[str],
    *,
    kind: str = "",
    shared: str = "",
    aois: str = "",
    pair: bool = False,
) -> Path:
    """Write a project with the tag `dev` of a type, and with tags of the controller."""
    file = written(folder, rungs, tags={"dev": kind} if kind else None, aois=aois)
    text = file.read_text(encoding="utf-8")
    text = text.replace("<Programs>", f"<Tags>{shared}</Tags><Programs>")
    if pair:
        text = text.replace("<AddOnInstructionDefinitions>", _PAIR)
    file.write_text(text, encoding="utf-8")
    return file


def _scanned(file: Path, **values: object) -> BuiltinProgram:
    running = program(file)
    for name, value in values.items():
        running.write(f"Main.{name}", value)
    running.scan(0)
    return running


def _notes(file: Path) -> list[str]:
    return [note.partition(": ")[2] for note in read(file).notes]


def test_an_unknown_type_has_the_members_of_its_uses(tmp_path: Path) -> None:
    """A contact shows a BOOL, and a bit shows a whole number. A note names the members."""
    rungs = ["XIC(dev.Go)OTE(a);", "XIC(a)OTE(dev.Word.3);"]
    file = _file(tmp_path, rungs, kind="AB:Thing:O:0")
    assert _notes(file) == [
        "the type AB_Thing_O_0 is not in the file; its members are made from their uses: Go, Word"
    ]
    running = program(file)
    running.write("Main.dev.Go", True)
    running.scan(0)
    assert running.read("Main.a") is True
    assert running.read("Main.dev.Word") == 8


def test_a_number_of_an_unknown_type_is_refused(tmp_path: Path) -> None:
    """Nothing shows whether `Speed` is a whole number. The routine is refused by name."""
    body = main_body(_file(tmp_path, ["MOV(dev.Speed,i);"], kind="AB:Thing:O:0"))
    assert isinstance(body, Foreign)
    assert "dev has no member Speed" in body.why


def test_a_member_with_two_uses_that_disagree_is_refused(tmp_path: Path) -> None:
    """`Go` cannot be a BOOL and have bits."""
    body = main_body(_file(tmp_path, ["XIC(dev.Go)OTE(dev.Go.1);"], kind="AB:Thing:O:0"))
    assert isinstance(body, Foreign)
    assert "dev has no member Go" in body.why


def test_an_unknown_type_that_nothing_reads_is_closed(tmp_path: Path) -> None:
    """The tag exists, and the program runs without it."""
    file = _file(tmp_path, ["XIC(b)OTE(a);"], kind="NULL")
    assert _notes(file) == ["the type NULL is not in the file; what needs its members is not read"]
    assert _scanned(file, b=True).read("Main.a") is True


def test_the_command_of_a_drive_is_a_whole_number(tmp_path: Path) -> None:
    """FreqCommand is an INT: 3.75 becomes 4. Source: decorated data in exports of this drive."""
    file = _file(tmp_path, ["MOV(x,dev.FreqCommand);"], kind="AB:PowerFlex525V_EENET_Drive:O:0")
    assert _scanned(file, x=3.75).read("Main.dev.FreqCommand") == 4


def test_the_reference_of_a_drive_is_a_real(tmp_path: Path) -> None:
    """Reference is a REAL: 3.75 stays. The word is reserved, so `_1` is added to the name.

    Source: decorated data in exports of this drive.
    """
    file = _file(tmp_path, ["MOV(x,dev.Reference);"], kind="AB:PowerFlex755_EENET_Drive:O:0")
    assert _scanned(file, x=3.75).read("Main.dev.Reference_1") == 3.75


def test_a_text_type_without_a_definition_has_the_length_of_its_name(tmp_path: Path) -> None:
    """A value shows that STRING_16 is a text, because its DATA has the type of the whole."""
    shared = """<Tag Name="label" DataType="STRING_16">
<Data Format="String" Length="2"><![CDATA['ok']]></Data><Data Format="Decorated">
<Structure DataType="STRING_16"><DataValueMember Name="LEN" DataType="DINT" Value="2"/>
<DataValueMember Name="DATA" DataType="STRING_16" Radix="ASCII"><![CDATA['ok']]>
</DataValueMember></Structure></Data></Tag>"""
    file = _file(tmp_path, ["XIC(b)OTE(a);"], shared=shared)
    assert _notes(file) == ["the text type STRING_16 is not in the file; its length is 16"]
    assert _scanned(file, b=True).read("label") == "ok"


def test_the_radix_of_an_alias_shows_a_real_of_a_module(tmp_path: Path) -> None:
    """The alias of a REAL has the radix Float: 2.5 is read as it is."""
    shared = '<Tag Name="Level" TagType="Alias" Radix="Float" AliasFor="Rack:2:I.Ch03.Data"/>'
    running = program(_file(tmp_path, ["MOV(Level,x);"], shared=shared))
    running.write("Rack_2_I.Ch03.Data", 2.5)
    running.scan(0)
    assert running.read("Main.x") == 2.5


def test_a_parameter_shows_the_type_of_a_module(tmp_path: Path) -> None:
    """The module's tag is passed as a Pair, so its member Left is a DINT."""
    aoi = """<AddOnInstructionDefinition Name="Use"><Parameters>
<Parameter Name="Io" TagType="Base" DataType="Pair" Usage="InOut" Required="true"/></Parameters>
<Routines><Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N">
<Text><![CDATA[MOV(7,Io.Left);]]></Text></Rung></RLLContent></Routine></Routines>
</AddOnInstructionDefinition>"""
    shared = '<Tag Name="call" DataType="Use"/>'
    file = _file(
        tmp_path,
        ["Use(call,Rack:2:O);", "MOV(Rack:2:O.Left,i);"],
        shared=shared,
        aois=aoi,
        pair=True,
    )
    assert _scanned(file).read("Main.i") == 7


def test_a_periodic_task_without_an_interval_has_10_ms(tmp_path: Path) -> None:
    """The default of the tool is assumed, and a note says so."""
    file = _file(tmp_path, ["XIC(b)OTE(a);"])
    text = file.read_text(encoding="utf-8").replace(' Rate="10"', "")
    file.write_text(text, encoding="utf-8")
    assert _notes(file) == ["the task T has no interval; it is 10 ms"]
    assert _scanned(file, b=True).read("Main.a") is True


def test_fll_with_0_clears_a_structure(tmp_path: Path) -> None:
    """All members become 0."""
    running = program(_file(tmp_path, ["FLL(0,dev,1);"], kind="Pair", pair=True))
    running.write("Main.dev.Left", 7)
    running.write("Main.dev.Right", 2.5)
    running.scan(0)
    assert (running.read("Main.dev.Left"), running.read("Main.dev.Right")) == (0, 0.0)


def test_a_number_may_begin_with_its_point(tmp_path: Path) -> None:
    """`.5` is a number, and `i.1` is still a bit."""
    running = _scanned(_file(tmp_path, ["CPT(x,y*.5);", "XIC(i.1)OTE(a);"]), y=3.0, i=2)
    assert (running.read("Main.x"), running.read("Main.a")) == (1.5, True)


_DRIVE = """<AddOnInstructionDefinition Name="Drive"><Parameters>
<Parameter Name="Card" TagType="Base" DataType="MODULE" Usage="InOut" Required="true"/>
<Parameter Name="Io" TagType="Base" DataType="AB:Drive:I:0" Usage="InOut" Required="true"/>
<Parameter Name="Runs" TagType="Base" DataType="BOOL" Usage="Output"/></Parameters>
<Routines><Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N">
<Text><![CDATA[XIC(Io.Active)OTE(Runs);]]></Text></Rung></RLLContent></Routine></Routines>
</AddOnInstructionDefinition>"""


def test_a_module_and_an_instance_have_the_same_name(tmp_path: Path) -> None:
    """The parameter of the type MODULE is the module Fan, not the instance of this name.

    The instruction and the program each use a member of the inputs: both are in their type.
    """
    shared = '<Tag Name="Fan" DataType="Drive"/>'
    rungs = ["Drive(Fan,Fan,Fan:I);", "XIC(Fan.Runs)OTE(a);", "XIC(Fan:I.Pt02)OTE(b);"]
    file = _file(tmp_path, rungs, shared=shared, aois=_DRIVE)
    text = file.read_text(encoding="utf-8")
    modules = '<Modules><Module Use="Reference" Name="Fan"/></Modules><Programs>'
    file.write_text(text.replace("<Programs>", modules), encoding="utf-8")
    running = program(file)
    running.write("Fan_I.Active", True)
    running.write("Fan_I.Pt02", True)
    running.scan(0)
    assert (running.read("Main.a"), running.read("Main.b")) == (True, True)


def test_a_module_that_the_file_does_not_name_is_refused(tmp_path: Path) -> None:
    """Without a module Fan, the operand is the instance, which is not a module."""
    shared = '<Tag Name="Fan" DataType="Drive"/>'
    body = main_body(_file(tmp_path, ["Drive(Fan,Fan,Fan:I);"], shared=shared, aois=_DRIVE))
    assert isinstance(body, Foreign)
    assert "Fan is not a MODULE" in body.why


_FIRST = """<AddOnInstructionDefinition Name="Begin"><Parameters>
<Parameter Name="Now" TagType="Base" DataType="BOOL" Usage="Output"/></Parameters>
<Routines><Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N">
<Text><![CDATA[XIC(S:FS)OTE(Now);]]></Text></Rung></RLLContent></Routine></Routines>
</AddOnInstructionDefinition>"""


def test_the_first_scan_in_an_instruction_is_that_of_its_program(tmp_path: Path) -> None:
    """The bit is TRUE in the first scan, and FALSE at a first call in the second scan."""
    shared = '<Tag Name="one" DataType="Begin"/><Tag Name="two" DataType="Begin"/>'
    rungs = ["Begin(one);", "XIC(c)Begin(two);", "XIC(one.Now)OTE(a);", "XIC(two.Now)OTE(b);"]
    running = program(_file(tmp_path, rungs, shared=shared, aois=_FIRST))
    seen = []
    for number in range(2):
        running.write("Main.c", number == 1)
        running.scan(10_000 * number)
        seen.append((running.read("Main.a"), running.read("Main.b")))
    assert seen == [(True, False), (False, False)]


def test_size_of_an_array_at_its_first_element(tmp_path: Path) -> None:
    """`list` has 8 elements in its dimension 0; another element is refused."""
    assert _scanned(_file(tmp_path, ["SIZE(list[0],0,i);"])).read("Main.i") == 8
    body = main_body(_file(tmp_path, ["SIZE(list[2],0,i);"]))
    assert isinstance(body, Foreign)
    assert "SIZE of list[2] is not supported" in body.why


_COUNT = """<AddOnInstructionDefinition Name="Count"><Parameters>
<Parameter Name="Row" TagType="Base" DataType="DINT" Dimensions="1" Usage="InOut"
 Required="true"/>
<Parameter Name="Found" TagType="Base" DataType="DINT" Usage="Output"/></Parameters>
<Routines><Routine Name="Logic" Type="RLL"><RLLContent><Rung Number="0" Type="N">
<Text><![CDATA[SIZE(Row,0,Found)MOV(9,Row[Found-1]);]]></Text></Rung></RLLContent></Routine>
</Routines></AddOnInstructionDefinition>"""


def test_an_array_parameter_has_the_size_of_its_arguments(tmp_path: Path) -> None:
    """The parameter declares 1 element, `list` has 8: SIZE gives 8, and the last one is set."""
    shared = '<Tag Name="one" DataType="Count"/>'
    running = _scanned(_file(tmp_path, ["Count(one,list);"], shared=shared, aois=_COUNT))
    assert (running.read("one.Found"), running.read("Main.list[7]")) == (8, 9)


def test_arguments_of_several_sizes_are_refused(tmp_path: Path) -> None:
    """A parameter cannot have the sizes 8 and 4."""
    shared = '<Tag Name="one" DataType="Count"/><Tag Name="few" DataType="DINT" Dimensions="4"/>'
    rungs = ["Count(one,list);", "Count(one,few);"]
    body = main_body(_file(tmp_path, rungs, shared=shared, aois=_COUNT))
    assert isinstance(body, Foreign)
    assert "list is not a DINT[1]" in body.why
