"""Function block diagrams of Logix: execution order, wires, references and refused parts.

Expected values are read from the drawn sheets. Source: Rockwell 1756-PM009E, chapter 1.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from l5x_ladder import program, read
from l5x_sheets import main, running, shown, why, written
from structured_text.coverage.measure import measure
from structured_text.coverage.parts import merge, part_of
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.projects.diagrams.networks.draw.text import network_text
from structured_text.projects.diagrams.networks.stored import stored_networks
from structured_text.projects.model import Foreign
from structured_text.projects.sources import source_files


def _scans(program: BuiltinProgram, count: int, *names: str) -> list[list[object]]:
    """Return the values of variables after each scan."""
    found = []
    for scan in range(count):
        program.scan(scan * 10_000)
        found.append([program.read(f"Main.{name}") for name in names])
    return found


def test_a_block_executes_after_the_blocks_that_feed_it(tmp_path: Path) -> None:
    """The BAND is drawn first and fed by the BNOT behind it; the ADD by a DIV on a later sheet.

    With a FALSE and b TRUE, d is TRUE in the first scan. x = 12 / 4 + 1 = 4.
    """
    program = running(
        tmp_path,
        "Block BAND and1; Function BNOT; IRef a; IRef b; ORef d;"
        "2 > 1.In; 1.Out > 0.In2; 3 > 0.In1; 0.Out > 4",
        "Function ADD; ICon quotient; IRef 1; ORef x; 6 > 5.SourceA; 7 > 5.SourceB; 5.Dest > 8",
        "IRef 12; IRef 4; Function DIV; OCon quotient; 9 > 11.SourceA; 10 > 11.SourceB;"
        "11.Dest > 12",
        tags={"and1": "FBD_BOOLEAN_AND"},
    )
    program.write("Main.b", True)
    assert _scans(program, 1, "d", "x") == [[True, 4.0]]
    program.write("Main.a", True)
    assert _scans(program, 1, "d") == [[False]]


def test_a_marked_wire_passes_the_value_of_the_last_scan(tmp_path: Path) -> None:
    """The ADD counts by its own output. The SUB gets it by a marked wire, so it is one scan late.

    Source: 1756-PM009E, create a one scan delay.
    """
    program = running(
        tmp_path,
        "IRef 1; Function ADD; ORef i; Block SUB sub; IRef 0; ORef x;"
        "0 > 1.SourceA; 1.Dest >> 1.SourceB; 1.Dest > 2;"
        "1.Dest >> 3.SourceA; 4 > 3.SourceB; 3.Dest > 5",
        tags={"sub": "FBD_MATH"},
    )
    assert _scans(program, 3, "i", "x") == [[1, 0.0], [2, 1.0], [3, 2.0]]


def test_a_marked_wire_resolves_a_loop(tmp_path: Path) -> None:
    """With x = 2 * y of the last scan, and y = x + 1, x is 0, 2, 6 and y is 1, 3, 7."""
    program = running(
        tmp_path,
        "Block ADD add; IRef 1; Block MUL mul; IRef 2; ORef x; ORef y;"
        "2.Dest > 0.SourceA; 1 > 0.SourceB; 0.Dest >> 2.SourceA; 3 > 2.SourceB;"
        "2.Dest > 4; 0.Dest > 5",
        tags={"add": "FBD_MATH", "mul": "FBD_MATH"},
    )
    assert _scans(program, 3, "x", "y") == [[0.0, 1.0], [2.0, 3.0], [6.0, 7.0]]


def test_references_are_latched_when_the_routine_begins(tmp_path: Path) -> None:
    """Two references that are written from each other change places in each scan.

    The second pair passes blocks: i - 0 is written to j, and j - 0 to i.
    Source: 1756-PM009E, latching data.
    """
    program = running(tmp_path, "IRef x; ORef y; IRef y; ORef x; 0 > 1; 2 > 3")
    program.write("Main.x", 1.5)
    assert _scans(program, 3, "x", "y") == [[0.0, 1.5], [1.5, 0.0], [0.0, 1.5]]
    program = running(
        tmp_path,
        "IRef i; IRef 0; Function SUB; ORef j; IRef j; Function SUB; ORef i;"
        "0 > 2.SourceA; 1 > 2.SourceB; 2.Dest > 3; 4 > 5.SourceA; 1 > 5.SourceB; 5.Dest > 6",
    )
    program.write("Main.i", 7)
    assert _scans(program, 3, "i", "j") == [[0, 7], [7, 0], [0, 7]]


def test_a_reference_to_a_block_is_latched_too(tmp_path: Path) -> None:
    """An input reference `flip.Out` is its value of the last scan, a wire that of this scan."""
    program = running(
        tmp_path,
        "IRef a; Block BNOT flip; IRef flip.Out; ORef b; Block BNOT second; ORef c;"
        "0 > 1.In; 2 > 4.In; 4.Out > 3; 1.Out > 5",
        tags={"flip": "FBD_BOOLEAN_NOT", "second": "FBD_BOOLEAN_NOT"},
    )
    assert _scans(program, 2, "b", "c") == [[True, True], [False, True]]


def test_a_routine_that_is_called_sees_no_output_of_this_scan(tmp_path: Path) -> None:
    """The sheet writes i = j + 1 behind all blocks, so behind the routine, which sets j to 5.

    So the routine copies i = 0 to k, and i is 0 + 1, in the next scan 5 + 1.
    """
    sub = (
        '<Routine Name="Sub" Type="ST"><STContent><Line Number="0">k := i; j := 5;</Line>'
        "</STContent></Routine>"
    )
    program = running(
        tmp_path,
        "IRef j; IRef 1; Function ADD; ORef i; 0 > 2.SourceA; 1 > 2.SourceB; 2.Dest > 3; JSR Sub",
        routines=sub,
    )
    assert _scans(program, 3, "i", "k") == [[1, 0], [6, 1], [6, 6]]


def test_numbers_are_converted_at_pins_and_references(tmp_path: Path) -> None:
    """A DINT of 5 is divided by 2 as a REAL in a block, which is 2.5 and rounds to the even 2.

    As a function, 5 / 2 of integers is 2; TRUNC of 2.5 is 2; an EQ of 2 and 2.0 is TRUE.
    """
    program = running(
        tmp_path,
        "IRef i; IRef 2; Block DIV div; ORef j; ORef x; Function DIV; ORef k;"
        "0 > 2.SourceA; 1 > 2.SourceB; 2.Dest > 3; 2.Dest > 4;"
        "0 > 5.SourceA; 1 > 5.SourceB; 5.Dest > 6",
        "Function TRUNC; Function EQ; IRef 2.0; ORef a;"
        "2.Dest > 7.Source; 7.Dest > 8.SourceA; 9 > 8.SourceB; 8.Dest > 10",
        tags={"div": "FBD_MATH"},
    )
    program.write("Main.i", 5)
    assert _scans(program, 1, "j", "x", "k", "a") == [[2, 2.5, 2, True]]


def test_a_sheet_calls_an_add_on_instruction(tmp_path: Path) -> None:
    """Its input is wired, its in-out parameter is written, and its output passes on.

    The instruction adds its input to its parameter: 3, then 6; the output is twice the sum.
    """
    aoi = """<AddOnInstructionDefinition Name="Total"><Parameters>
<Parameter Name="Add" Usage="Input" DataType="DINT" Visible="true"/>
<Parameter Name="Sum" Usage="InOut" DataType="DINT" Required="true"/>
<Parameter Name="Twice" Usage="Output" DataType="DINT" Visible="true"/>
</Parameters><Routines><Routine Name="Logic" Type="ST"><STContent>
<Line Number="0">Sum := Sum + Add; Twice := 2 * Sum;</Line></STContent></Routine></Routines>
</AddOnInstructionDefinition>"""
    program = running(
        tmp_path,
        'IRef 3; AddOnInstruction Total total|<InOutParameter Name="Sum" Argument="i"/>;'
        "ORef j; 0 > 1.Add; 1.Twice > 2",
        tags={"total": "Total"},
        aois=aoi,
    )
    assert _scans(program, 2, "i", "j") == [[3, 6], [6, 12]]


def test_a_block_without_enable_in_keeps_its_outputs(tmp_path: Path) -> None:
    """While a is FALSE, ADD and BAND do nothing and clear EnableOut."""
    program = running(
        tmp_path,
        "IRef a; IRef y; IRef 1; Block ADD add; ORef x; ORef c;"
        "0 > 3.EnableIn; 1 > 3.SourceA; 2 > 3.SourceB; 3.Dest > 4; 3.EnableOut > 5",
        "Block BNOT flip; IRef b; ORef d; 0 > 6.EnableIn; 7 > 6.In; 6.Out > 8",
        tags={"add": "FBD_MATH", "flip": "FBD_BOOLEAN_NOT"},
    )
    program.write("Main.y", 2.0)
    assert _scans(program, 1, "x", "c", "d") == [[0.0, False, False]]
    program.write("Main.a", True)
    assert _scans(program, 1, "x", "c", "d") == [[3.0, True, True]]
    for name, value in {"a": False, "b": True, "y": 7.0}.items():
        program.write(f"Main.{name}", value)
    assert _scans(program, 1, "x", "c", "d") == [[3.0, False, True]]


def test_data_of_a_tag_disable_a_block_and_set_its_inputs(tmp_path: Path) -> None:
    """Unwired inputs of BAND are TRUE, unless the data of its tag say otherwise."""
    tags = {
        "plain": "FBD_BOOLEAN_AND",
        "off": "FBD_BOOLEAN_AND(EnableIn=0)",
        "third": "FBD_BOOLEAN_AND(EnableIn=1 In3=0)",
        "add": "FBD_MATH(EnableIn=0 SourceB=2.0)",
    }
    blocks = "".join(
        f"Block BAND {name}; ORef {out};"
        for name, out in (("plain", "a"), ("off", "b"), ("third", "c"))
    )
    sheet = f"{blocks} 0.Out > 1; 2.Out > 3; 4.Out > 5; Block ADD add; ORef x; 6.Dest > 7"
    program = running(tmp_path, sheet, tags=tags)
    assert _scans(program, 1, "a", "b", "c", "x") == [[True, False, False, 0.0]]


def test_lines_and_drawing_name_the_sheet(tmp_path: Path) -> None:
    """Each statement names its sheet, and each sheet is drawn with its blocks."""
    file = written(
        tmp_path,
        "<Description>Lamp *) </Description>; IRef a; Block BNOT flip; OCon on;0 > 1.In; 1.Out > 2",
        "ICon on; ORef b; 3 > 4",
        tags={"flip": "FBD_BOOLEAN_NOT"},
    )
    piece = main(file)
    assert not isinstance(piece.body, Foreign)
    assert [(line.text.strip(), line.network) for line in piece.body] == [
        ("(* Sheet 1: Lamp * ) *)", "sheet 1"),
        ("flip(In := a);", "sheet 1"),
        ("(* Sheet 2 *)", "sheet 2"),
        ("b := flip.Out;", "sheet 2"),
    ]
    assert piece.diagram is not None
    drawn = network_text(piece.diagram, 1)
    assert drawn.startswith("Sheet 1\nLamp *)")
    assert "a──│In   Out│──>on>" in drawn
    assert ">on>──b" in network_text(piece.diagram, 2)
    (source,) = (one for one in source_files([file], None).all if getattr(one, "diagrams", ()))
    assert list(stored_networks(source, {"P, sheet 2"})) == ["P, sheet 2"]


def test_coverage_counts_the_blocks_of_a_sheet_only(tmp_path: Path) -> None:
    """Two statements are counted and not those of HLL itself; the sheet is drawn."""
    file = written(tmp_path, "Block HLL f; ORef x; 0.Out > 1", tags={"f": "HL_LIMIT"})
    collector = Collector(tmp_path)
    with counting(collector):
        program(file).scan(0)
    (found,) = measure(merge([part_of(collector)]), tmp_path)
    assert [item.text for item in found.statements] == ["f();", "x := f.Out;"]
    assert list(found.drawings) == ["P, sheet 1"]


@pytest.mark.parametrize(
    ("sheet", "said"),
    [
        ("Block LPF f; IRef x; 1 > 0.In", "sheet 1: the block f (LPF): the instruction LPF is not"),
        ("IRef nix; ORef a; 0 > 1", "sheet 1: the input reference nix: there is no tag nix"),
        ("IRef a; ORef x; 0 > 1", "the output reference x: BOOL is not a value for REAL"),
        ("Function BAND; IRef a; 1 > 0.In1", "the function BAND: it needs two or more inputs"),
        ("Function ADD; IRef 1; 1 > 0.SourceA", "its input SourceB is not connected"),
        ("Function ADD; IRef 1; 1 > 0.Source", "SOURCE is not an input (the inputs are SourceA"),
        ("Function PID", "sheet 1: the function PID: the function PID is not supported"),
        ("Block BNOT i", "the block i (BNOT): i is not a FBD_BOOLEAN_NOT"),
        ("Block BNOT", "it has no tag (complete the block in its tool)"),
        ("Block BNOT f; IRef a; 1 > 0.Out", "Out is not an input of BNOT (the inputs are ENABLEIN"),
        ("Block BNOT f; Block BNOT F", "another block has the same tag"),
        ("IRef a; IRef b; ORef c; 0 > 2; 1 > 2", "two wires lead to the output reference c"),
        ("IRef a; 0 > 7", "a wire ends at the element '7'"),
        ("ORef a", "the output reference a: it is not connected"),
        ("IRef; ORef a; 0 > 1", "the input reference: it names no tag"),
        ("ICon far; ORef a; 0 > 1", "there is no output wire connector far"),
        ("ICon far; OCon far; ORef a; 0 > 1; 0 > 2", "output wire connector far is not connected"),
        ("OCon far; OCon far", "there are two output wire connectors far"),
        ("ORef a; ORef b; 0 > 1", "a wire begins at the output reference a"),
        ("Block BNOT f; Block BNOT g; 0.Out > 1.In; 1.Out > 0.In", "the blocks f, g are in a loop"),
        ("JSR Nix", "sheet 1: JSR Nix: there is no routine Nix in this program"),
        ("JSR Main; IRef a; 1 > 0.In", "parameters of JSR are not supported"),
        ("AddOnInstruction Nix f", "there is no instruction Nix in this file"),
        ("<Nix/>", "sheet 1: the element Nix is not known"),
        ('Block MAVE m|<Array Name="StorageArray"/>', "it has no StorageArray"),
        ('Block MAVE m|<Array Name="StorageArray" Operand="x"/>', "x is not an array of REAL"),
    ],
)
def test_a_sheet_is_refused_by_name(sheet: str, said: str, tmp_path: Path) -> None:
    """The message has the sheet, the element and what to do."""
    tags = dict.fromkeys("fg", "FBD_BOOLEAN_NOT") | {"m": "MOVING_AVERAGE"}
    assert said in why(written(tmp_path, sheet, tags=tags))


def test_the_rest_of_the_project_is_read(tmp_path: Path) -> None:
    """A routine in text behind a sheet with an unknown instruction is translated."""
    sub = (
        '<Routine Name="Sub" Type="ST"><STContent><Line Number="0">k := i;</Line></STContent>'
        "</Routine>"
    )
    (part,) = main(written(tmp_path, "Function PID", routines=sub)).parts
    assert not isinstance(part.body, Foreign)
    assert [line.text.strip() for line in part.body] == ["k := i;"]


def test_edits_that_are_not_accepted_are_left_out(tmp_path: Path) -> None:
    """The original sheets are read; a note names the pending ones."""
    file = written(tmp_path, "IRef a; ORef b; 0 > 1")
    pending = '<FBDContent OnlineEditType="Pending"><Sheet><IRef ID="0"/></Sheet></FBDContent>'
    text = file.read_text(encoding="utf-8")
    text = text.replace("</FBDContent>", f"</FBDContent>{pending}")
    file.write_text(text, encoding="utf-8")
    assert shown(file) == ["(* Sheet 1 *)", "b := a;"]
    (note,) = read(file).notes
    assert "Main has edits that are not accepted (Pending); they are left out" in note
