"""The rungs of an L5X are drawn. The expected drawings were written by hand."""

from __future__ import annotations

from pathlib import Path

from l5x_ladder import read, written
from structured_text.projects.diagrams.networks.draw.layout import layout
from structured_text.projects.diagrams.networks.draw.text import network_text
from structured_text.projects.diagrams.networks.model import Diagram
from structured_text.projects.diagrams.networks.stored import as_data, from_data
from structured_text.projects.open import project_sources

_MOTOR = """<AddOnInstructionDefinition Name="Motor"><Parameters>
<Parameter Name="Go" TagType="Base" DataType="BOOL" Usage="Input" Required="true"/>
<Parameter Name="Run" TagType="Base" DataType="BOOL" Usage="Output" Required="true"/>
</Parameters><Routines><Routine Name="Logic" Type="RLL"><RLLContent>
<Rung Number="0" Type="N"><Text>XIC(Go)OTE(Run);</Text></Rung>
</RLLContent></Routine></Routines></AddOnInstructionDefinition>"""


def _diagrams(file: Path) -> dict[str, Diagram]:
    units = read(file).units
    return {name: diagram for unit in units for name, diagram in unit.piece.diagrams()}


def _drawn(folder: Path, *rungs: str, **tags: str) -> str:
    diagram = _diagrams(written(folder, rungs, tags=tags, aois=_MOTOR))["P"]
    found = [network_text(diagram, one.number, plain=True) for one in diagram.networks]
    return "\n" + "\n".join(found)


def test_contacts_branches_and_coils_are_drawn(tmp_path: Path) -> None:
    """Rungs count from 0. Legs of a branch at the end lead to the right rail."""
    drawn = _drawn(tmp_path, "[XIC(a),XIC(e)]XIO(b)[OTE(e),OTL(f),XIC(c)OTU(g)];")
    assert (
        drawn
        == """
Rung 0
|   a     b          e   |
|--| |-+-|/|-+------( )--|
|   e  |     |       f   |
|--| |-+     +------(S)--|
|            |  c    g   |
|            +-| |--(R)--|
"""
    )


def test_other_instructions_are_boxes_with_their_operands(tmp_path: Path) -> None:
    """An operand that is not known (`?`) is left out."""
    assert (
        _drawn(tmp_path, "EQU(i,3)TON(T,?,?);", T="TIMER")
        == """
Rung 0
|  +-------------+  +----------+  |
|--|     EQU     |--|   TON    |--|
|  | Source A  i |  | Timer  T |  |
|  | Source B  3 |  +----------+  |
|  +-------------+                |
"""
    )


def test_the_call_of_an_instruction_names_its_instance(tmp_path: Path) -> None:
    """The name of the Add-On Instruction is as in the rung, the instance is above the box."""
    assert (
        _drawn(tmp_path, "XIC(a)Motor(M1,b,c);", M1="Motor")
        == """
Rung 0
|           M1      |
|   a   +--------+  |
|--| |--| Motor  |--|
|       | Go   b |  |
|       | Run  c |  |
|       +--------+  |
"""
    )


def test_a_label_stands_above_its_rung(tmp_path: Path) -> None:
    assert (
        _drawn(tmp_path, "LBL(Here)XIC(a)OTE(b);", "JMP(Here);").partition("Rung 1")[0]
        == """
Rung 0
Here:
|   a    b   |
|--| |--( )--|

"""
    )


def test_routines_and_instructions_have_diagrams_of_their_own(tmp_path: Path) -> None:
    """The names are those that stand before the rungs in coverage and in the debugger."""
    file = written(tmp_path, ["JSR(Sub,0);"], routines={"Sub": ["OTE(a);"]}, aois=_MOTOR)
    assert sorted(_diagrams(file)) == ["Motor", "P", "P.Sub"]


def test_a_stored_rung_is_drawn_alike(tmp_path: Path) -> None:
    """A network passes from process to process as data for JSON."""
    diagram = _diagrams(written(tmp_path, ["XIC(a)MOV(1,i);", "OTE(b);"]))["P"]
    stored = from_data(as_data(diagram, 0))
    assert layout(stored, 0) == layout(diagram, 0)


def test_a_box_is_described_with_its_operands(tmp_path: Path) -> None:
    diagram = _diagrams(written(tmp_path, ["XIC(a)MOV(1,i);"]))["P"]
    words = "contact a from the left rail. MOV from contact a with Source 1, Destination i."
    assert layout(diagram, 0).words == words


def test_notes_and_diagrams_of_other_routines_stay_with_a_replacement(tmp_path: Path) -> None:
    """The routine Sub is replaced, with its note about GSV. Main keeps its note and its drawing."""
    gsv = "GSV(Module,{},EntryStatus,i);"
    routines = {"Sub": [gsv.format("Other")], "Last": [gsv.format("Third")]}
    file = written(tmp_path, ["JSR(Sub,0);", gsv.format("Card")], routines=routines)
    own = tmp_path / "Sub.st"
    own.write_text("i := 1;\n", encoding="utf-8")
    found = project_sources([file], {"P.Sub": own})
    names = [word for word in ("Card", "Other", "Third") if word in "\n".join(found.notes)]
    assert names == ["Card", "Third"]
    diagrams = [name for path in found.paths for name, _ in getattr(path, "diagrams", ())]
    assert diagrams == ["P", "P.Last"]
