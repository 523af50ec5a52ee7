"""Structured Text is read from the project files of PLC tools, with the lines of these files.

The files in `data` are short files in the formats of CODESYS, Beremiz, TwinCAT 3, Studio 5000 and
TIA Portal. Their constructs occur in public projects.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from mistakes import check
from rcx_harness.cli.app import main
from structured_text.language.source import origin, source_text
from structured_text.projects.open import project_sources

_DATA = Path(__file__).parent / "data"


def _imported(source: Path, folder: Path) -> tuple[int, dict[str, str]]:
    code = main(["import", str(source), "-o", str(folder)])
    return code, {file.stem: file.read_text(encoding="utf-8") for file in folder.glob("*.st")}


def test_beremiz_types_programs_and_tasks(tmp_path: Path) -> None:
    """Types, programs and tasks are read from a Beremiz project. Source: PLCopen TC6 XML 2.01."""
    assert _imported(_DATA / "beremiz.xml", tmp_path) == (
        0,
        {
            "ROWS": "TYPE ROWS :\n  ARRAY [1..3] OF INT;\nEND_TYPE\n",
            "Counter": """\
PROGRAM Counter
  VAR
    Reset : BOOL; (* starts again *)
    Row : ROWS;
  END_VAR
IF Reset THEN
  Row[1] := 0;
ELSE
  Row[1] := Row[1] + 1;
END_IF;
END_PROGRAM
""",
            "config": """\
CONFIGURATION config
  RESOURCE resource1 ON PLC
    TASK plc_task(INTERVAL := T#50ms, PRIORITY := 1);
    PROGRAM Main WITH plc_task : Counter;
  END_RESOURCE
END_CONFIGURATION
""",
        },
    )


def test_codesys_declarations_as_plain_text_methods_lists_and_tasks(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The declaration is read from CODESYS's text, which has more details than the XML elements.

    Source: PLCopen TC6 XML 2.00, with what CODESYS adds.
    """
    code, texts = _imported(_DATA / "codesys.xml", tmp_path)
    assert code == 1
    assert (
        f"{_DATA}/codesys.xml:122: the body of FB_Lamp is in Continuous Function Chart (CFC)"
        in (capsys.readouterr().out)
    )
    assert (
        texts["FB_Step"]
        == """\
FUNCTION_BLOCK FB_Step
VAR_INPUT
    By : INT;
END_VAR
VAR
    Sum : INT;
END_VAR
METHOD PUBLIC Clear : BOOL
Sum := 0;
Clear := TRUE;
END_METHOD
IF By < 0 THEN
  RETURN;
END_IF;
Sum := Sum + By;
END_FUNCTION_BLOCK
"""
    )
    assert (
        texts["GVL"]
        == """\
{attribute 'qualified_only'}
VAR_GLOBAL
    Count : INT := 5;   // of parts
END_VAR
"""
    )
    assert (
        texts["E_Stage"] == "TYPE E_Stage :\n  (\n    Idle := 0,\n    Busy := 10\n  );\nEND_TYPE\n"
    )
    assert (
        texts["Tasks"]
        == """\
CONFIGURATION Tasks
  RESOURCE Plc ON PLC
    TASK MainTask(INTERVAL := T#10ms, PRIORITY := 1);
    PROGRAM PLC_PRG WITH MainTask : PLC_PRG;
  END_RESOURCE
END_CONFIGURATION
"""
    )
    assert "(* The body is in Continuous Function Chart (CFC) and is not read" in texts["FB_Lamp"]


@pytest.mark.parametrize("named", ["twincat", "twincat/Cell.plcproj"])
def test_twincat_objects_of_the_project_and_its_task(tmp_path: Path, named: str) -> None:
    """Objects of a TwinCAT project are read, except those that are excluded from the build.

    File names are compared without case.
    """
    code, texts = _imported(_DATA / named, tmp_path)
    assert code == 1  # an action in ladder
    assert sorted(texts) == ["FB_Valve", "GVL", "MAIN", "ST_Item", "Tasks"]
    assert (
        texts["FB_Valve"]
        == """\
// a valve
FUNCTION_BLOCK FB_Valve
VAR_INPUT
\tOpen : BOOL;
END_VAR
VAR
\tMoves : INT;
\tLast : BOOL;
END_VAR
METHOD PUBLIC Clear
Moves := 0;
END_METHOD
PROPERTY Worn : BOOL
GET
VAR
END_VAR
Worn := Moves > GVL.Limit;
END_GET
END_PROPERTY
IF Open <> Last THEN
\tMoves := Moves + 1;
END_IF
Last := Open;
END_FUNCTION_BLOCK
"""
    )
    assert "TASK PlcTask(INTERVAL := T#20ms, PRIORITY := 20);" in texts["Tasks"]
    assert "PROGRAM MAIN WITH PlcTask : MAIN;" in texts["Tasks"]


def test_rockwell_converts_as_logix_does(tmp_path: Path) -> None:
    """In Logix, the instance is the first argument of a call, and numbers are converted implicitly.

    Source: Rockwell 1756-PM007, assignment and data types; 1756-PM010, parameters.
    """
    code, texts = _imported(_DATA / "cell.L5X", tmp_path)
    assert code == 0
    assert (
        texts["MainProgram"]
        == """\
PROGRAM MainProgram
  VAR RETAIN
    Bytes : L5X_SINT_4;
    Item : Part;
    Rounded : DINT;
  END_VAR
  VAR
    Scaling : Scale;
  END_VAR
METHOD Spare
  (* Rung 0 *)
  Word.3 := Item.Good;
END_METHOD
  Scaling(Raw := Analog, Value => Item.Weight);
  Rounded := REAL_TO_DINT(Item.Weight);
  IF (Item.Weight > 3.0) AND NOT (Word.3) THEN
    Item.Good := TRUE;
    Bytes[1] := SINT_TO_BYTE(DINT_TO_SINT((-1)));
    Word := DWORD_TO_DINT(DINT_TO_DWORD(SINT_TO_DINT(BYTE_TO_SINT(Bytes[1]))) AND \
DINT_TO_DWORD(240));
  END_IF;
END_PROGRAM
"""
    )
    assert (
        texts["Controller"] == "VAR_GLOBAL RETAIN\n  Analog : INT := 7;\n  Word : DINT;\nEND_VAR\n"
    )
    assert "    Good : BOOL;\n" in texts["Part"]
    assert "ZZZ" not in texts["Part"]
    assert "    Factor : REAL := 0.5;\n" in texts["Scale"]
    assert "TASK Main(INTERVAL := T#10ms, PRIORITY := 10);" in texts["Tasks"]


def test_siemens_names_headers_regions_and_data_blocks(tmp_path: Path) -> None:
    """Names, headers, regions and data blocks are read from an SCL file.

    Source: TIA Portal, external source files; SCL of S7-1500.
    """
    code, texts = _imported(_DATA / "cell.scl", tmp_path)
    assert code == 0
    assert (
        texts["FB_Motor"]
        == """\
FUNCTION_BLOCK FB_Motor

   VAR_INPUT
      i_Start : Bool;
   END_VAR
   VAR
      t  : TON;
      t2 : TOF;
      n : DInt;
      w : Word;
      m : UDT_Motor;
   END_VAR

\tt(IN := i_Start, PT := T#3S);
\tt2(IN := i_Start, PT := T#1S_500MS);

\tIF t.Q AND DB_Data.a > 3 THEN
\t  n := n + ( 2 / 1); // It's
\tEND_IF;
\tw := WORD#16#FF;
\tm.Speed_Set := FC_Scale(x := 3);
END_FUNCTION_BLOCK
"""
    )
    words = {name: " ".join(text.split()) for name, text in texts.items()}
    assert words["DB_Data"] == (
        "VAR_GLOBAL DB_Data : STRUCT a : Int; s : Struct b : Bool; END_STRUCT; c : Int := 4; "
        "END_STRUCT := (a := 7, s := (b := TRUE)); END_VAR"
    )
    assert words["Inst"] == "VAR_GLOBAL Inst : FB_Motor := (n := 7); END_VAR"
    assert words["Main"].startswith("PROGRAM Main VAR_TEMP x : Int; END_VAR")
    assert words["UDT_Motor"].startswith("TYPE UDT_Motor : STRUCT Start : Bool;")
    assert words["FC_Scale"].startswith("FUNCTION FC_Scale : Real VAR_INPUT")


@pytest.mark.parametrize(
    ("file", "text", "place"),
    [
        ("codesys.xml", "Sum := Sum + By;", (62, 1)),
        ("codesys.xml", "    By : INT;", (88, 1)),
        ("beremiz.xml", "  Row[1] := Row[1] + 1;", (44, 1)),
        ("beremiz.xml", "IF Reset THEN", (41, 31)),
        ("twincat/POUs/FB_Valve.TcPOU", "IF Open <> Last THEN", (15, 20)),
        ("twincat/POUs/FB_Valve.TcPOU", "Moves := 0;", (24, 22)),
        ("cell.L5X", "  Rounded := REAL_TO_DINT(Item.Weight);", (65, 1)),
        ("cell.scl", "\tm.Speed_Set := FC_Scale(x := 3);", (43, 1)),
    ],
)
def test_each_line_has_its_place_in_the_project_file(
    file: str, text: str, place: tuple[int, int]
) -> None:
    """Messages have the line and column of the project file, which were counted by hand."""
    replaced = {"FB_Lamp": _DATA / "lamp.st"} if file == "codesys.xml" else {}
    for source in project_sources([_DATA / file], replaced).paths:
        lines = source_text(source).splitlines()
        if text in lines:
            assert origin(source, lines.index(text) + 1, 1) == place
            assert str(source) == str(_DATA / file)
            return
    raise AssertionError(text)


def test_codesys_arrays_of_open_length(tmp_path: Path) -> None:
    """An ARRAY[*], which CODESYS writes as a pointer, is read from CODESYS's additional data."""
    file = tmp_path / "open.xml"
    file.write_text(
        '<project xmlns="http://www.plcopen.org/xml/tc6_0200"><types><pous>'
        '<pou name="Total" pouType="function"><interface><returnType><DINT /></returnType>'
        '<inOutVars><variable name="Row"><type><pointer><baseType><INT /></baseType></pointer>'
        '</type><addData><data name="http://www.3s-software.com/plcopenxml/attributes"'
        ' handleUnknown="implementation"><Attributes><Attribute Name="variable_length_array"'
        ' Value="ARRAY[*] OF INT" /></Attributes></data></addData></variable></inOutVars>'
        '</interface><body><ST><xhtml xmlns="http://www.w3.org/1999/xhtml">'
        "Total := UPPER_BOUND(Row, 1);</xhtml></ST></body></pou></pous></types></project>",
        encoding="utf-8",
    )
    (source,) = project_sources([file], {}).paths
    assert "Row : ARRAY[*] OF INT;" in source_text(source)
    assert check([source]) == []


def test_codesys_writes_a_variable_of_open_length_as_an_input(tmp_path: Path) -> None:
    """An ARRAY[*] in the inputs is a VAR_IN_OUT if CODESYS's additional data say this."""
    scope = '<Attribute Name="variable_length_array_original_scope" Value="Inout" />'
    file = tmp_path / "open.xml"
    file.write_text(
        '<project xmlns="http://www.plcopen.org/xml/tc6_0200"><types><pous>'
        '<pou name="First" pouType="function"><interface><returnType><DINT /></returnType>'
        '<inputVars><variable name="N"><type><INT /></type></variable>'
        '<variable name="Row"><type><pointer><baseType><INT /></baseType></pointer>'
        '</type><addData><data name="http://www.3s-software.com/plcopenxml/attributes"'
        f' handleUnknown="implementation"><Attributes>{scope}<Attribute'
        ' Name="variable_length_array" Value="ARRAY[*] OF INT" /></Attributes></data></addData>'
        "</variable></inputVars></interface><body><ST>"
        '<xhtml xmlns="http://www.w3.org/1999/xhtml">Row[1] := N; First := 0;</xhtml></ST></body>'
        "</pou></pous></types></project>",
        encoding="utf-8",
    )
    (source,) = project_sources([file], {}).paths
    words = source_text(source).split()
    assert words.index("N") < words.index("VAR_IN_OUT") < words.index("Row")
    assert check([source]) == []
